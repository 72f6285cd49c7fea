"""Residuals by own code: what functions may return, what fails, and what else sees them."""

from __future__ import annotations

import ctypes
import functools
import pickle
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.runtime.failures import FunctionError, SolveError
from tests import optional

Array = Any

MODEL = """
struct Point {
    param pos: vec2
    size: real = 1
    constraint weak { (pos - pos.value) * 1e-3 }
}
root Plane {
    points: list of Point
    param scale: real = 1
    constraint unit { (scale - 1) * 0.5 }
}
"""
FIRST = np.arange(5)


def distance(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
    """Distance of two points, measured in units of `scale`, with its Jacobians."""
    v = b - a
    n = np.linalg.norm(v, axis=1)
    u = v / n[:, None]
    return n - scale * d, [-u, u, -d]


def distance_alone(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
    return distance(a, b, scale, d=d)[0]


@pytest.fixture(scope="module")
def plane() -> Any:
    return arael.loads(MODEL, name="plane", interpret=True)


@pytest.fixture
def model(plane: Any) -> Any:
    found = plane()
    found.points.extend(pos=np.random.default_rng(0).normal(size=(6, 2)) * 3)
    return found


def pairs(model: Any) -> list[Any]:
    return [model.points[FIRST].pos, model.points[FIRST + 1].pos, model.scale]


def add(model: Any, function: Any = distance, **more: Any) -> Any:
    more.setdefault("data", {"d": np.ones(5)})
    more.setdefault("name", "distance")
    return model.add_residuals(function, pairs(model), **more)


def moved(model: Any) -> Any:
    """The state of a model as comparable numbers."""
    return model.serialize().copy()


def test_a_model_without_constraints_is_no_mistake(recwarn: pytest.WarningsRecorder) -> None:
    curve = arael.loads("root Curve { param a: real = 1; param b: real = 0 }", interpret=True)()
    assert not list(recwarn)
    x = np.linspace(0, 1, 9)
    curve.add_residuals(
        lambda a, b, x, y: (a * np.exp(b * x) - y, [np.exp(b * x), a * x * np.exp(b * x)]),
        [curve.a, curve.b],
        data={"x": x, "y": 2 * np.exp(-x)},
        name="fit",
    )
    assert curve.solve().converged
    np.testing.assert_allclose([curve.a.value, curve.b.value], [2, -1], atol=1e-6)


# --- what else sees them ----------------------------------------------------------------------


def test_cost_table_jacobian_covariance_and_names(model: Any) -> None:
    code = add(model)
    assert model.cost_table().instances["distance"] == 5
    assert model.cost_table()["distance"] == pytest.approx(code.cost)
    assert model.jacobian().shape == (12 + 1 + 5, 13)
    assert model.covariance().sigma().shape == (13,)
    values = model.residual_values("distance")
    np.testing.assert_allclose(values.raw, code.residuals)
    assert len(values.rows) == 5
    assert "distance" in repr(model.residuals)
    model.residuals.remove("distance")
    assert "distance" not in model.cost_table()


def test_tangent_problem_sees_them(model: Any) -> None:
    add(model)
    problem = model.problem()
    delta = np.random.default_rng(1).normal(size=problem.size) * 0.1
    step = 1e-6
    numeric = [
        (problem.cost(delta + step * e) - problem.cost(delta - step * e)) / (2 * step)
        for e in np.eye(problem.size)
    ]
    np.testing.assert_allclose(problem.gradient(delta), numeric, atol=1e-6)


def test_gradients_that_are_right_and_wrong(model: Any) -> None:
    add(model)
    assert all(check.agrees for check in model.check_gradients())
    model.residuals.remove("distance")

    def wrong(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
        residuals, jacobians = distance(a, b, scale, d=d)
        jacobians[1][3, 1] += 0.5
        return residuals, jacobians

    add(model, wrong)
    (check,) = (one for one in model.check_gradients() if not one.agrees)
    assert check.worst.startswith("distance[3]")
    assert check.parameter == "points[4].pos.y"


def test_gradients_where_jacobians_are_not_finite_elsewhere(model: Any) -> None:
    """A check moves parameters, and evaluates residuals alone there."""
    calls = []

    def slopes(scale: Array) -> Any:
        calls.append(1)
        return np.where(scale == 1, 3.0, np.nan)

    model.add_residuals(lambda s: 3 * s, [model.scale], jacobian=slopes, name="line")
    assert all(check.agrees for check in model.check_gradients())
    assert len(calls) == 1


def test_copies_and_pickles(model: Any) -> None:
    add(model)
    for other in (model.copy(), pickle.loads(pickle.dumps(model))):
        assert other.cost() == pytest.approx(model.cost(), rel=1e-14)
        other.solve()
        assert other.cost() < 0.1 * model.cost()


def test_functions_that_cannot_be_pickled(model: Any) -> None:
    add(model, lambda *x, d: distance(*x, d=d))
    model.copy()
    with pytest.raises(AraelError, match=r"E0773.*cannot pickle the function of `distance`"):
        pickle.dumps(model)


def test_warm_solves_with_new_data(model: Any) -> None:
    code = add(model)
    model.solve()
    counts = model.session.counts
    before = counts.problems, counts.analyses
    code.set_data(d=np.full(5, 2.0))
    assert code.cost > 1
    model.solve()
    assert (counts.problems, counts.analyses) == before
    assert code.cost < 1e-3


def test_rows_that_were_removed(plane: Any) -> None:
    model = arael.loads(MODEL.replace("list of", "arena of"), name="p2", interpret=True)()
    model.points.extend(pos=np.random.default_rng(0).normal(size=(6, 2)) * 3)
    add(model)
    model.points.remove(model.points[4])
    with pytest.raises(AraelError, match=r"E0765.*`distance` reads `points.pos` of a row"):
        model.cost()


def test_frozen_and_fixed_parameters(model: Any) -> None:
    add(model)
    model.points[0].pos.fixed = True
    before = model.points[0].pos.value.copy()
    result = model.solve(freeze="scale")
    assert result.converged
    np.testing.assert_array_equal(model.points[0].pos.value, before)
    assert model.scale.value == 1


def test_both_parameters_are_one_row(model: Any) -> None:
    """The blocks of a pair fall onto one diagonal block."""

    def product(a: Array, b: Array) -> Any:
        residuals = (a * b).sum(axis=1) - 1
        return residuals, [b, a]

    model.add_residuals(product, [model.points[[1, 2]].pos, model.points[[1, 3]].pos])
    jacobian = model.jacobian()
    np.testing.assert_allclose(
        model.hessian(), 2 * jacobian.dense().T @ jacobian.dense(), atol=1e-9
    )
    assert all(check.agrees for check in model.check_gradients())


# --- second-order terms -----------------------------------------------------------------------


def circle(pos: Array, *, triplets: bool) -> Any:
    """``|pos|^2 - 1`` with the term ``2 r * Hessian(r)`` that Gauss-Newton leaves out."""
    residuals = (pos**2).sum(axis=1) - 1
    n = len(pos)
    second = 4 * residuals[:, None, None] * np.eye(2)
    if triplets:
        instance = np.repeat(np.arange(n), 2)
        axis = np.tile([0, 1], n)
        return residuals, 2 * pos, (instance, axis, axis, second[instance, axis, axis])
    return residuals, 2 * pos, second


@pytest.mark.parametrize("triplets", [True, False])
def test_triplets_of_the_hessian(model: Any, triplets: bool) -> None:
    model.add_residuals(
        functools.partial(circle, triplets=triplets), [model.points.pos], name="circle"
    )
    problem = model.problem()
    step = 1e-5
    numeric = np.stack(
        [
            (problem.gradient(step * e) - problem.gradient(-step * e)) / (2 * step)
            for e in np.eye(problem.size)
        ]
    )
    np.testing.assert_allclose(model.hessian(), numeric, atol=1e-4 * np.abs(numeric).max())


def test_triplets_between_parameters(model: Any) -> None:
    def bilinear(a: Array, b: Array) -> Any:
        residuals = (a * b).sum(axis=1)
        n = len(a)
        rows, columns = np.tile([0, 1], n), np.tile([2, 3], n)
        instance = np.repeat(np.arange(n), 2)
        return residuals, [b, a], (instance, rows, columns, 2 * residuals[instance])

    pairs_ = [model.points[[0, 4, 5]].pos, model.points[[3, 1, 5]].pos]
    model.add_residuals(bilinear, pairs_)
    problem = model.problem()
    step = 1e-5
    numeric = np.stack(
        [
            (problem.gradient(step * e) - problem.gradient(-step * e)) / (2 * step)
            for e in np.eye(problem.size)
        ]
    )
    np.testing.assert_allclose(model.hessian(), numeric, atol=1e-4 * np.abs(numeric).max())


def test_second_order_terms_keep_the_optimum(model: Any) -> None:
    start = model.points.pos.value.copy()

    def anchor(pos: Array, *, at: Array) -> Any:
        return pos - at, np.broadcast_to(np.eye(2), (len(pos), 2, 2))

    model.add_residuals(anchor, [model.points.pos], 2, data={"at": start})
    other = model.copy()
    model.add_residuals(functools.partial(circle, triplets=True), [model.points.pos], name="circle")
    other.add_residuals(lambda p: circle(p, triplets=True)[:2], [other.points.pos], name="circle")
    newton, gauss = model.solve(rel_precision=1e-12), other.solve(rel_precision=1e-12)
    assert newton.converged
    assert newton.end_cost == pytest.approx(gauss.end_cost, rel=1e-9)
    np.testing.assert_allclose(moved(model), moved(other), atol=1e-5)


# --- before a linearisation -------------------------------------------------------------------


def test_matches_are_updated(model: Any) -> None:
    """Points move to the nearest corner of a square, chosen again before each linearisation."""
    corners = np.array([[1.0, 1], [1, -1], [-1, 1], [-1, -1]])
    calls = []

    def to_goal(pos: Array, *, goal: Array) -> Any:
        return (pos - goal) * 0.7, np.broadcast_to(0.7 * np.eye(2), (len(pos), 2, 2))

    code = model.add_residuals(to_goal, [model.points.pos], 2, data={"goal": np.zeros((6, 2))})

    def nearest(pos: Array) -> None:
        calls.append(pos.copy())
        distances = np.linalg.norm(pos[:, None] - corners, axis=2)
        code.set_data(goal=corners[distances.argmin(axis=1)])

    model.before_linearisation(nearest, [model.points.pos])
    start = model.points.pos.value.copy()
    result = model.solve()
    assert result.converged
    assert len(calls) >= 2
    np.testing.assert_array_equal(calls[0], start)
    np.testing.assert_allclose(np.abs(model.points.pos.value), 1, atol=1e-5)
    np.testing.assert_array_equal(np.sign(model.points.pos.value), np.sign(start))
    chosen = np.sign(start)
    assert result.start_cost == pytest.approx(0.49 * ((start - chosen) ** 2).sum(), rel=1e-6)
    model.residuals.remove("nearest")
    count = len(calls)
    model.solve()
    assert len(calls) == count


def test_an_update_that_raises(model: Any) -> None:
    def broken() -> None:
        raise ValueError("no matches")

    model.before_linearisation(broken)
    with pytest.raises(FunctionError, match=r"E0771.*`broken`.*ValueError: no matches"):
        model.solve()


# --- mistakes of functions --------------------------------------------------------------------


def test_an_exception_names_the_instance(model: Any) -> None:
    def picky(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
        if (d > 6).any():
            raise ArithmeticError("too far")
        return distance(a, b, scale, d=d)

    add(model, picky, data={"d": [1, 1, 1, 7, 1]})
    with pytest.raises(FunctionError) as caught:
        model.solve()
    text = str(caught.value)
    assert "E0771" in text
    assert "ArithmeticError: too far for instance 3 (`points[3].pos`, `points[4].pos`" in text
    cause = caught.value.__cause__
    assert isinstance(cause, ArithmeticError)
    assert cause.__traceback__ is not None
    assert cause.__traceback__.tb_frame.f_code.co_name == "picky"


def test_an_exception_of_all_instances(model: Any) -> None:
    add(model, lambda a, b, scale, d: a @ np.zeros((9, 9)))
    with pytest.raises(FunctionError, match=r"E0771") as caught:
        model.cost()
    assert "for instance" not in str(caught.value)


@pytest.mark.parametrize("after", [1, 3, 6])
def test_the_model_keeps_its_best_state(model: Any, after: int) -> None:
    calls = []

    def failing(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
        calls.append(1)
        if len(calls) > after:
            raise RuntimeError("lost")
        return distance(a, b, scale, d=d)

    start = model.cost()
    add(model, failing)
    start = moved(model)
    with pytest.raises(SolveError, match="RuntimeError: lost") as caught:
        model.solve()
    if after > 1:
        assert caught.value.best is not None
        np.testing.assert_array_equal(moved(model), caught.value.best.x)
        assert caught.value.best.end_cost < caught.value.best.start_cost
    else:
        np.testing.assert_array_equal(moved(model), start)


def test_an_interrupt_keeps_the_best_state(model: Any) -> None:
    calls = []

    def interrupted(a: Array, b: Array, scale: Array, *, d: Array) -> Any:
        calls.append(1)
        if len(calls) > 4:
            raise KeyboardInterrupt
        return distance(a, b, scale, d=d)

    add(model, interrupted)
    result = model.solve()
    assert result.status == "aborted"
    assert result.end_cost < result.start_cost
    np.testing.assert_array_equal(moved(model), result.x)


WRONG = {
    "shape": (lambda a, b, s, d: np.zeros(4), "returned residuals of shape 4", "expected 5 x 1"),
    "dtype": (lambda a, b, s, d: np.zeros(5, complex), "complex128", "real numbers"),
    "none": (lambda a, b, s, d: None, "NoneType", "real numbers"),
    "text": (lambda a, b, s, d: ["a"] * 5, "<U1", "real numbers"),
    "ragged": (lambda a, b, s, d: [[1], [1, 2], 1, 1, 1], "list", "real numbers"),
    "tuple": (lambda a, b, s, d: (1, 2, 3, 4), "a tuple of 4", "jacobians"),
    "too few": (lambda a, b, s, d: (np.zeros(5), [a]), "1 as Jacobians of 3", "one array for each"),
    "jacobian": (
        lambda a, b, s, d: (np.zeros(5), [a, b, a]),
        "returned Jacobian by `scale` of shape 5 x 2",
        "expected 5 x 1 x 1",
    ),
    "not finite": (
        lambda a, b, s, d: (np.zeros(5), [a, np.where(d[:, None] == 2, np.nan, b), s]),
        "is nan for instance 2 (`points[2].pos`, `points[3].pos`, `scale`)",
        "residual 0 by coordinate 0 of `points[3].pos`",
    ),
    "triplets": (
        lambda a, b, s, d: (np.zeros(5), [a, b, s], ([9], [0], [0], [1.0])),
        "with instance 9",
        "expected 0 .. 4",
    ),
    "negative": (
        lambda a, b, s, d: (np.zeros(5), [a, b, s], ([0, 1], [0, -2], [0, 0], [1.0, 1.0])),
        "with row -2",
        "expected 0 .. 4",
    ),
    "fractions": (
        lambda a, b, s, d: (np.zeros(5), [a, b, s], ([0], [0.5], [0], [1.0])),
        "returned float64 as rows of the Hessian",
        "expected whole numbers",
    ),
    "names": (
        lambda a, b, s, d: (np.zeros(5), [a, b, s], ([0], ["x"], [0], [1.0])),
        "as rows of the Hessian",
        "expected whole numbers",
    ),
}


@pytest.mark.parametrize("which", WRONG)
def test_wrong_results(model: Any, which: str) -> None:
    function, *parts = WRONG[which]
    add(model, function, data={"d": np.arange(5.0)})
    with pytest.raises(FunctionError) as caught:
        model.solve()
    text = str(caught.value)
    assert "E0772" in text
    for part in parts:
        assert part in text


def test_no_jacobian_of_a_single_parameter(model: Any) -> None:
    model.add_residuals(lambda p: (p[:, 0], []), [model.points.pos], name="x")
    with pytest.raises(FunctionError, match="returned 0 as Jacobians of 1 parameters"):
        model.solve()


def test_a_residual_that_is_nan_at_the_start(model: Any) -> None:
    add(model, lambda a, b, s, d: np.where(d == 2, np.nan, 1.0), data={"d": np.arange(5.0)})
    with pytest.raises(SolveError, match=r"E1001.*`distance\[2\]`: residual 0 is nan") as caught:
        model.solve()
    assert "points[2].pos" in str(caught.value)


def test_nan_on_the_way_is_a_rejected_step(model: Any) -> None:
    def root(scale: Array) -> Any:
        with np.errstate(invalid="ignore"):
            return np.sqrt(scale - 0.9) * 3, 1.5 / np.sqrt(np.maximum(scale - 0.9, 1e-300))

    model.add_residuals(root, [model.scale])
    result = model.solve()
    assert np.isfinite(model.cost())
    assert result.end_cost <= result.start_cost


def test_ambient_coordinates_need_jacobians(model: Any) -> None:
    add(model, distance_alone, coordinates="ambient")
    with pytest.raises(FunctionError, match=r"E0772.*returned no Jacobians"):
        model.solve()


# --- mistakes of the call ---------------------------------------------------------------------

ARGUMENTS = {
    "no list": (lambda m: (distance, m.scale), {}, "`parameters` is a list of parameters"),
    "values": (lambda m: (distance, [m.points.pos[FIRST]]), {}, "choose rows before the parameter"),
    "rows": (lambda m: (distance, [m.points]), {}, "name a parameter of these rows"),
    "none": (lambda m: (distance, []), {}, "the residuals have no parameters"),
    "lengths": (
        lambda m: (distance, [m.points.pos, m.points[FIRST].pos]),
        {},
        "`points.pos` has 6, `points.pos` has 5",
    ),
    "data": (
        lambda m: (distance, [m.points.pos]),
        {"data": {"d": np.zeros(4)}},
        "`points.pos` has 6, `d` has 4",
    ),
    "text": (lambda m: (distance, [m.points.pos]), {"data": {"d": "x"}}, "expected numbers"),
    "size": (lambda m: (distance, [m.points.pos]), {"size": 0}, "whole number above 0"),
    "kind": (lambda m: (distance, [m.points.pos]), {"coordinates": "polar"}, "'tangent' or"),
    "function": (lambda m: ("a*x", [m.points.pos]), {}, "expected a function, found str"),
    "name": (lambda m: (distance, [m.points.pos]), {"name": "a b"}, "cannot be a name"),
    "large": (lambda m: (distance, [m.points.pos]), {"size": 4000}, "4000 x 2 entries"),
    "scale": (lambda m: (distance, [m.scale]), {"loss": "cauchy(scale.value)"}, "not a constant"),
    "loss": (lambda m: (distance, [m.scale]), {"loss": "cauchi(2)"}, "cauchy"),
}


@pytest.mark.parametrize("which", ARGUMENTS)
def test_wrong_arguments(model: Any, which: str) -> None:
    make, more, part = ARGUMENTS[which]
    function, parameters = make(model)
    with pytest.raises(AraelError) as caught:
        model.add_residuals(function, parameters, **more)
    assert part in str(caught.value)
    assert not model.residuals.code


def test_names_are_taken_once(model: Any) -> None:
    add(model)
    with pytest.raises(AraelError, match=r"E0760.*`distance`"):
        add(model)
    with pytest.raises(AraelError, match=r"E0760.*`distance`"):
        model.residuals.add("scale", label="distance")
    with pytest.raises(AraelError, match=r"E0770.*another model instance"):
        model.copy().add_residuals(distance, pairs(model), name="other")


def test_constants_of_all_instances(model: Any) -> None:
    add(model, data={"d": 1.5})
    assert model.cost_table().instances["distance"] == 5
    one = model.add_residuals(
        lambda s, x: s * x - x, [model.scale], data={"x": [1, 2, 3]}, name="x"
    )
    assert one.residuals.shape == (3, 1)


# --- C functions ------------------------------------------------------------------------------

C_SOURCE = """
#include <math.h>
#include <stdint.h>
int distance(int64_t n, const double **p, const double **data, double *r, double **j)
{
    for (int64_t i = 0; i < n; i++) {
        const double *a = p[0] + 2 * i, *b = p[1] + 2 * i;
        double x = b[0] - a[0], y = b[1] - a[1], l = sqrt(x * x + y * y);
        if (data[0][i] < 0) return 1 + (int)i;
        r[i] = l - p[2][i] * data[0][i];
        if (j) {
            j[0][2 * i] = -x / l; j[0][2 * i + 1] = -y / l;
            j[1][2 * i] = x / l; j[1][2 * i + 1] = y / l;
            j[2][i] = -data[0][i];
        }
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def c_distance(tmp_path_factory: pytest.TempPathFactory) -> Any:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("needs a C compiler: apt install gcc")
    folder: Path = tmp_path_factory.mktemp("c")
    (folder / "d.c").write_text(C_SOURCE, encoding="utf-8")
    subprocess.run(
        [compiler, "-O1", "-shared", "-fPIC", "d.c", "-o", "d.so", "-lm"], cwd=folder, check=True
    )
    function = ctypes.CDLL(str(folder / "d.so")).distance
    function.restype = ctypes.c_int
    function.argtypes = [ctypes.c_int64] + [ctypes.c_void_p] * 4
    return function


@pytest.mark.parametrize("jacobian", [None, False])
def test_a_c_function(model: Any, c_distance: Any, jacobian: Any) -> None:
    other = model.copy()
    add(model)
    code = add(other, c_distance, jacobian=jacobian)
    tolerance = 1e-12 if jacobian is None else 1e-7
    np.testing.assert_allclose(other.gradient(), model.gradient(), atol=tolerance)
    np.testing.assert_allclose(other.hessian(), model.hessian(), atol=tolerance)
    assert code.derivatives == ("given" if jacobian is None else "differences")
    assert other.solve().converged


def test_a_c_function_that_fails(model: Any, c_distance: Any) -> None:
    add(model, c_distance, data={"d": [1, 1, -1, 1, 1]})
    with pytest.raises(FunctionError, match=r"E0771.*returned 3.*instance 2 \(`points\[2\]"):
        model.solve()


def test_a_c_function_of_another_signature(model: Any, c_distance: Any) -> None:
    other = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(lambda x: x)
    with pytest.raises(AraelError, match=r"E0770.*a C function of another signature"):
        add(model, other)


def test_a_numba_cfunc(model: Any) -> None:
    numba = optional.require("numba")
    types = numba.types
    rows = types.CPointer(types.CPointer(types.double))

    @numba.cfunc(types.int32(types.int64, rows, rows, types.CPointer(types.double), rows))
    def unit(n: Any, p: Any, data: Any, r: Any, j: Any) -> Any:
        for i in range(n):
            r[i] = p[0][i] - 2
        return 0

    model.add_residuals(unit, [model.scale], jacobian=False, name="unit_c")
    assert model.cost_table()["unit_c"] == pytest.approx(1)


def test_every_code_has_a_page() -> None:
    from arael.diagnostics.explain import explain

    for code in ("E0770", "E0771", "E0772", "E0773"):
        assert re.match(rf"# {code}: ", explain(code))
