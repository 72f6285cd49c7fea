"""Derivatives of solutions by data, against differences of solutions of changed data."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import arael
from arael.analysis.normal import NormalEquations
from arael.diagnostics.records import AraelError
from tests.examples.scripts import script
from tests.interpreted import Load, loader

Floats = NDArray[np.float64]
Read = Callable[[Any], float]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("sensitivities"))


def column(model: Any, path: str) -> Floats:
    """Live values of a column of data."""
    tables = model._store.tables
    table = max((t for t in tables if t == "" or path.startswith(f"{t}.")), key=len)
    found: Floats = tables[table].column(path.removeprefix(f"{table}."))
    return found


def solved(model: Any) -> Any:
    """Solve to rounding: a solve ends at a tolerance of the cost, whose root is that of values."""
    model.solve(max_iters=300)
    problem = model._problem()
    for _ in range(60):
        step = NormalEquations(problem, hold_bounds=True).newton_step()
        problem.evaluation.moved_by(step)
        if np.abs(step).max() < 1e-13:
            break
    problem.write_back()
    return model.solve()


def difference(model: Any, read: Read, path: str, entry: tuple[int, ...], step: float) -> float:
    """Central difference of a solved quantity by one number of the data, extrapolated."""

    def at(change: float) -> float:
        changed = model.copy()
        values = column(changed, path)
        values[entry] += change
        solved(changed)
        return read(changed)

    def central(h: float) -> float:
        return (at(h) - at(-h)) / (2 * h)

    return (4 * central(step / 2) - central(step)) / 3


def agrees(
    model: Any, result: Any, of: str, read: Read, path: str, step: float, count: int = 2
) -> None:
    """The largest derivatives by a column, and one other, are those of solutions to 1e-6."""
    found = np.atleast_1d(result.sensitivity(of, path, exact=True)[path])
    whole = found.reshape(column(model, path).shape)
    order = np.argsort(-np.abs(whole).ravel())
    chosen = [*order[: count - 1], order[len(order) // 2]]
    scale = np.abs(whole).max()
    assert scale > 0, path
    for flat in chosen:
        entry = tuple(int(k) for k in np.unravel_index(int(flat), whole.shape))
        expected = difference(model, read, path, entry, step)
        assert whole[entry] == pytest.approx(expected, rel=1e-6, abs=1e-6 * scale), (path, entry)


# --- problems of the gallery ------------------------------------------------------------------


@pytest.fixture
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


@pytest.mark.usefixtures("interpreted")
def test_camera_calibration() -> None:
    module = script("camera_calibration")
    rig = module.problem(module.simulate(views=4))
    result = solved(rig)

    def focal(rig: Any) -> float:
        return float(rig.cameras[0].f.value[0])

    for path, step in (("corners.pixel", 0.05), ("corners.on", 1e-4)):
        agrees(rig, result, "cameras[0].f.x", focal, path, step)
    found = result.sensitivity("cameras[0].f.x", "sigma", exact=True)
    assert abs(float(found["sigma"])) < 1e-6  # a common factor of all residuals


@pytest.mark.usefixtures("interpreted")
def test_hand_eye() -> None:
    module = script("hand_eye")
    model = module.hand_eye(module.simulate(shots=8))
    result = solved(model)

    def along(model: Any) -> float:
        return float(model.X.translation[0])

    for path in ("motions.a_t", "motions.b_q", "motions.whiten"):
        step = 1.0 if path == "motions.whiten" else 1e-4
        agrees(model, result, "(X * [0, 0, 0]).x", along, path, step)


@pytest.mark.usefixtures("interpreted")
def test_arm_calibration_with_priors() -> None:
    module = script("arm_calibration")
    model = module.with_priors(module.simulate(shots=15))
    result = solved(model)

    def length(arm: Any) -> float:
        return float(arm.joints[2].d.value)

    for path, step in (
        ("shots.q", 1e-3),
        ("shots.seen", 1e-3),
        ("joints.drawing.d", 1e-4),
        ("joints.drawing.length_sigma", 1e-5),
        ("sigma", 1e-6),
    ):
        agrees(model, result, "joints[2].d", length, path, step)


@pytest.mark.usefixtures("interpreted")
def test_range_slam_with_robust_losses() -> None:
    module = script("range_slam")
    model = module.problem(module.make_field(poses=40))
    result = solved(model)

    def beacon(model: Any) -> float:
        return float(model.beacons[1].pos.value[0])

    for path, step in (("ranges.range", 0.01), ("steps.moved", 1e-3), ("range_sigma", 1e-3)):
        agrees(model, result, "beacons[1].pos.x", beacon, path, step)


# --- each way that a constraint reads data ----------------------------------------------------

SUMS = """
extern fn bent(x) derivs [cos(x)]
struct Weight {
    kg: real
    arm: real
}
struct Link { param angle: real
    length: real
    prior angle ~ normal(0.3, 0.5) }
struct Knee { x: real
    y: real
    constraint knee when root.slope * x < 3 { bent(root.slope * x) + root.offset - y } }
root Scales {
    param pivot: real = 0.5
    param slope: real = 0.6
    param offset: real = 0
    param held: real = 1.5
    param top: real in .. 2 = 1
    weights: list of Weight
    links: list of Link
    knees: list of Knee
    seen: real = 0.3
    far: vec2 = [2, 1]
    constraint balance { sum(w in weights) { w.kg * (w.arm - pivot) } - seen }
    constraint chain { (sum(k in links) { k.length * [cos(k.angle), sin(k.angle)] } - far) / 0.1 }
    constraint pulled { (top - 3 * held) * seen + 0.1 * (slope - top) }
    constraint level loss huber(0.1) { [pivot - held * far.x, slope * held - far.y] }
}
"""


@pytest.fixture(scope="module")
def scales(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("scales") / "scales.arael"
    path.write_text(SUMS, encoding="utf-8")
    with pytest.warns(Warning, match="Python function"):
        model = arael.load(path, interpret=True, functions={"bent": np.sin})()
    model.weights.extend(kg=[1.0, 2.0, 0.5], arm=[0.3, 0.8, -0.4])
    model.links.extend(angle=[0.2, 0.6, 0.1], length=[1.0, 0.8, 0.6])
    x = np.array([0.2, 1.0, 2.0, 4.0, 9.0])
    model.knees.extend(x=x, y=np.sin(0.5 * x) + 0.05 * np.cos(7 * x))
    model.held.fixed = True
    solved(model)
    return model


@pytest.mark.parametrize(
    ("of", "path"),
    [
        ("pivot", "weights.kg"),  # through sums over rows of data
        ("pivot", "weights.arm"),
        ("links[1].angle", "links.length"),  # through sums evaluated term by term
        ("links[1].angle", "far"),
        ("slope", "knees.x"),  # behind a guard over parameters, through a native function
        ("slope", "knees.y"),
        ("offset", "seen"),
    ],
)
def test_ways_of_data(scales: Any, of: str, path: str) -> None:
    result = scales.solve()
    row, _, name = of.rpartition(".")

    def read(model: Any) -> float:
        owner = model.links[1] if row else model
        return float(getattr(owner, name).value)

    agrees(scales, result, of, read, path, 1e-3)


def test_rows_that_nothing_reads_have_zeros(scales: Any) -> None:
    found = scales.solve().sensitivity("slope", "knees.x")["knees.x"]
    assert found[-1] == 0 and np.all(found[:3] != 0)  # its guard is false


def test_fixed_parameters_and_active_bounds(scales: Any) -> None:
    """What does not move counts as data: its value, and the bound it stands on."""
    result = scales.solve()
    assert float(scales.top.value) == 2
    found = result.sensitivity("slope", exact=True)

    def slope(value: float, high: float) -> float:
        changed = scales.copy()
        changed.held.value, changed.top.value, changed.top.high = value, 1.0, high
        solved(changed)
        return float(changed.slope.value)

    h = 1e-4
    by_held = (slope(1.5 + h, 2) - slope(1.5 - h, 2)) / (2 * h)
    by_high = (slope(1.5, 2 + h) - slope(1.5, 2 - h)) / (2 * h)
    assert found["held"].item() == pytest.approx(by_held, rel=1e-6)
    assert found["top.high"].item() == pytest.approx(by_high, rel=1e-6)
    assert "top.low" not in found and "pivot" not in found
    # A quantity that reads them directly.
    direct = result.sensitivity("slope + 10 * top + 100 * held + seen", exact=True)
    assert direct["held"].item() == pytest.approx(by_held + 100, rel=1e-6)
    assert direct["top.high"].item() == pytest.approx(by_high + 10, rel=1e-6)
    assert float(direct["seen"]) == pytest.approx(float(found["seen"]) + 1, rel=1e-9)


# --- lines ------------------------------------------------------------------------------------

LINE = """
const STEP = 2
struct Point {
    x: real
    y: real [m]
    sigma: real [m] = 0.1
    constraint fit { (root.a * x * STEP + root.b - y + root.bias) / sigma }
}
root Line {
    param a: real = 0
    param b: real = 0
    param c: real = 1
    bias: real = 0
    points: list of Point
    constraint apart { root.c - 2 }
    solve { pass first { freeze b } pass second { } }
}
"""
X = np.array([0.0, 1.0, 2.0, 3.0, 7.0])
NOISE = np.array([0.05, -0.1, 0.02, 0.08, -0.04])


def line(load: Load, **values: Any) -> Any:
    model = load(LINE)(**values)
    model.points.extend(x=X, y=1 + 0.5 * X + NOISE)
    return model


def design() -> tuple[Floats, Floats]:
    """Columns of a and b, and the covariance of both."""
    a = np.stack([2 * X, np.ones(5)], axis=1)
    return a, np.linalg.inv(a.T @ a) * 0.1**2


def test_a_linear_fit_has_the_rows_of_its_pseudo_inverse(load: Load) -> None:
    result = line(load).solve()
    a, covariance = design()
    expected = covariance @ a.T / 0.1**2
    for exact in (False, True):  # the same: a linear fit has no second derivatives by parameters
        found = result.sensitivity("a", "points.y", exact)
        assert found["points.y"] == pytest.approx(expected[0], rel=1e-9)
        assert np.asarray(found) == pytest.approx(expected[0], rel=1e-9)
        assert found.hessian == ("exact" if exact else "Gauss-Newton")
        assert found.hessian in str(found) and "points.y" in str(found)
    both = result.sensitivity("[a, b]", ["points.y", "bias"])
    assert both["points.y"] == pytest.approx(expected, rel=1e-9)
    assert both["bias"] == pytest.approx(-expected.sum(axis=1), rel=1e-9)
    assert both.names == ("[a, b][0]", "[a, b][1]")
    kept = pickle.loads(pickle.dumps(both.to_dict()))
    assert kept["by"]["bias"] == both["bias"].tolist()


def test_weights_matter_as_they_do_in_a_weighted_fit(load: Load) -> None:
    """Of a standard deviation, also with the Hessian of Gauss-Newton: its own term is exact."""
    model = line(load)
    found = model.solve().sensitivity("a", "points.sigma")["points.sigma"]

    def slope(change: float) -> float:
        w = np.full(5, 0.1)
        w[1] += change
        return float(np.polyfit(2 * X, 1 + 0.5 * X + NOISE, 1, w=1 / w)[0])

    assert found[1] == pytest.approx((slope(1e-5) - slope(-1e-5)) / 2e-5, rel=1e-6)


def test_a_result_of_passes_and_frozen_parameters(load: Load) -> None:
    """Asked is the last pass: what it froze counts as data."""
    model = line(load)
    frozen = model.solve(passes=["first"])
    found = frozen.sensitivity("a")
    x = 2 * X
    assert found["points.y"] == pytest.approx(x / (x @ x), rel=1e-9)
    assert found["b"] == pytest.approx(-x.sum() / (x @ x), rel=1e-9)
    with pytest.raises(AraelError, match=r"no residual reads.*`b`.*\n.*solved for"):
        model.solve().sensitivity("a", "b")


def test_a_changed_model_is_not_asked(load: Load) -> None:
    model = line(load)
    before = model.solve()
    first = np.asarray(before.sensitivity("a", "points.y"))
    model.points[0].y = 4.0
    with pytest.raises(AraelError, match=r"E1060.*other data"):
        before.sensitivity("a", "points.y")
    after = model.solve()
    with pytest.raises(AraelError, match=r"E1060.*other values"):
        before.sensitivity("a", "points.y")
    assert np.asarray(after.sensitivity("a", "points.y")) == pytest.approx(first, rel=1e-9)
    with pytest.raises(AraelError, match=r"E1060.*no model"):
        pickle.loads(pickle.dumps(after)).sensitivity("a")
    with pytest.raises(AraelError, match=r"E1060.*no model"):
        after.passes[0].sensitivity("a")


def test_free_directions_are_refused(load: Load) -> None:
    model = load("root R { param a: real; param b: real; d: real = 1; constraint c { a + b - d } }")
    result = model(a=0, b=0).solve()
    with pytest.raises(AraelError, match="E1008"):
        result.sensitivity("a")


def test_no_minimum_has_no_exact_sensitivity(load: Load) -> None:
    """At a saddle the exact Hessian has a negative curvature that J'J does not have."""
    model = load("root R { param a: real = 0; d: real = 1; constraint c { [a^2 - d, 0.1 * a] } }")
    result = model().solve()
    assert float(np.asarray(result.sensitivity("a", "d"))) == pytest.approx(0, abs=1e-12)
    with pytest.raises(AraelError, match=r"E1060.*no strict minimum"):
        result.sensitivity("a", "d", exact=True)


@pytest.mark.parametrize(
    ("of", "to", "message"),
    [
        ("a", "points.yy", "did you mean `points.y`"),
        ("points[0].y", "nothing", "E1060"),
        ("q", None, "E0301|unknown"),
        ("a", 3, "E0828.*paths of columns"),
        (3, None, "E0828.*a parameter or a formula"),
    ],
)
def test_wrong_questions(load: Load, of: Any, to: Any, message: str) -> None:
    result = line(load).solve()
    with pytest.raises(AraelError) as raised:
        result.sensitivity(of, to)
    assert re.search(message, str(raised.value))


def test_residuals_by_own_code_take_part(load: Load) -> None:
    """They read no data of the model, but change what its data does."""
    model = line(load)
    model.add_residuals(
        lambda a: (a - 0.3) / 0.01, [model.a], jacobian=lambda a: np.full((1, 1, 1), 100.0)
    )
    result = model.solve()
    a, covariance = design()
    information = np.linalg.inv(covariance) + np.diag([1e4, 0])
    expected = np.linalg.solve(information, a.T / 0.1**2)
    for exact in (False, True):
        found = np.asarray(result.sensitivity("a", "points.y", exact))
        assert found == pytest.approx(expected[0], rel=1e-6)


def test_single_precision(load: Load) -> None:
    model = load(LINE, "f32")()
    model.points.extend(x=X, y=1 + 0.5 * X + NOISE)
    a, covariance = design()
    found = np.asarray(model.solve().sensitivity("a", "points.y"))
    assert found == pytest.approx((covariance @ a.T / 0.1**2)[0], rel=1e-4)


# --- uncertain data, influence ------------------------------------------------------------------


def test_propagation_of_a_linear_fit(load: Load) -> None:
    result = line(load).solve()
    a, covariance = design()
    k = covariance @ a.T / 0.1**2
    found = result.propagate({"bias": 0.3, "points.y": np.full(5, 0.2)}, of=["a", "b"])
    assert found.names == ("a", "b")
    assert found.measured == pytest.approx(covariance, rel=1e-9)
    assert found.by["points.y"] == pytest.approx(0.04 * k @ k.T, rel=1e-9)
    shift = 0.3 * k.sum(axis=1)
    assert found.by["bias"] == pytest.approx(np.outer(shift, shift), rel=1e-9, abs=1e-12)
    assert found.covariance == pytest.approx(
        found.measured + found.by["bias"] + found.by["points.y"]
    )
    assert "bias" in str(found) and found.to_dict()["sigma"] == found.sigma().tolist()
    assert result.propagate({}).names == ("a", "b", "c")
    for wrong in ({"points.y": np.ones(4)}, {"bias": -1.0}, {"bias": np.nan}):
        with pytest.raises(AraelError, match=r"E1060"):
            result.propagate(wrong)
    with pytest.raises(AraelError, match="E0828"):
        result.propagate("bias")


def test_propagation_against_monte_carlo(load: Load) -> None:
    """Of a curve with an uncertain constant and abscissae, over 400 solves."""
    text = """
    struct Point { x: real
        y: real
        constraint fit { (root.v * x / (root.k + x) + root.bias - y) / 0.1 } }
    root Curve { param v: real = 3
        param k: real = 2
        bias: real = 0
        points: list of Point }
    """
    x, v, k = np.linspace(0.5, 9, 12), 4.0, 1.5
    model = load(text)()
    model.points.extend(x=x, y=v * x / (k + x))
    found = model.solve().propagate({"bias": 0.02, "points.x": 0.03}, of=["v", "k"])
    rng = np.random.default_rng(5)
    seen = []
    for _ in range(400):
        model.points.y[:] = v * x / (k + x) + rng.normal(0, 0.1, 12)
        model.points.x[:] = x + rng.normal(0, 0.03, 12)
        model.bias = rng.normal(0, 0.02)
        model.v.value, model.k.value = v, k
        model.solve()
        seen.append([float(model.v.value), float(model.k.value)])
    scatter = np.cov(np.array(seen).T)
    assert np.diag(scatter) == pytest.approx(np.diag(found.covariance), rel=0.25)
    assert np.all(np.diag(found.measured) < np.diag(found.covariance))


def test_influence_is_that_of_a_linear_regression(load: Load) -> None:
    """Leverage, Cook's distance and changes by removal, by their formulas and by doing it."""
    model = line(load)
    result = model.solve()
    found = result.influence("a", scale="residual")
    a, covariance = design()
    hat = np.diag(a @ covariance @ a.T) / 0.1**2
    of_points = np.array(
        [k for k in range(len(found)) if found.observation(k).label == "Point.fit"]
    )
    assert found.leverage[of_points] == pytest.approx(hat, rel=1e-9)
    assert found.leverage.sum() == pytest.approx(3)
    assert found.share.sum() == pytest.approx(1)
    y = 1 + 0.5 * X + NOISE
    residual = a @ np.linalg.lstsq(a, y, rcond=None)[0] - y
    variance = residual @ residual / (6 - 3)
    cook = residual**2 * hat / (3 * variance * (1 - hat) ** 2)
    assert found.cook[of_points] == pytest.approx(cook, rel=1e-9)
    for k in range(5):
        rest = np.arange(5) != k
        without = np.polyfit(2 * X[rest], y[rest], 1)[0] - np.polyfit(2 * X, y, 1)[0]
        assert found.change[of_points[k]] == pytest.approx(without, rel=1e-6)
    # Nothing else determines c: without that residual there is no solution.
    alone = next(k for k in range(len(found)) if k not in of_points)
    assert found.leverage[alone] == pytest.approx(1) and np.isinf(found.cook[alone])
    assert found.change[alone] == 0
    assert [one.place for one in found.deciding(1)] == ["points[4]"]
    assert len(result.influence().deciding()) == 0 and "Cook" in str(result.influence())
    assert "decide a" in str(found) and found.to_dict()["deciding"][0]["place"] == "points[4]"
    with pytest.raises(AraelError, match=r"E1060.*2 scalars"):
        result.influence("[a, b]")


@pytest.mark.usefixtures("interpreted")
def test_leverages_of_a_map_sum_to_its_parameters() -> None:
    module = script("range_slam")
    model = module.problem(module.make_field(poses=40))
    found = model.solve().influence("beacons[1].pos.x")
    assert found.leverage.sum() == pytest.approx(len(model.parameter_names()), rel=1e-6)
    assert found.share.sum() == pytest.approx(1, rel=1e-6)
