"""Look-ups of parameters: control points of splines and rows that are estimated themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicHermiteSpline
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import arael
from arael.diagnostics.records import AraelError
from arael.runtime.failures import SolveError
from arael.solving import problem_of
from tests.compiler.test_kernels import check_against_differences
from tests.compiler.test_look_ups import TURNS, T, X, cumulative_spline, quats, slopes
from tests.interpreted import loader

Floats = NDArray[np.float64]

TABLE = """
struct Knot {
    key t
    t: real
    param x: real = 0
    param pos: vec2 = [0, 0]
    param yaw: angle = 0
    param turn: rotation = [1, 0, 0, 0]
    param pose: transform = [0, 0, 0, 1, 0, 0, 0]
}
struct Probe {
    at: real
    param late: real = 0
    constraint c { VALUE }
}
root Table : PRECISION { knots: list of Knot; probes: list of Probe }
"""

EVEN = np.linspace(-1, 2, 7)
STEP = EVEN[1] - EVEN[0]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return loader(tmp_path_factory.mktemp("models"))


def values(load: Any, value: str, at: Floats, rows: dict[str, Any], n: int = 1) -> Floats:
    """What a look-up gives at each of the arguments, (probes, n); by cost as well."""
    model = load(TABLE.replace("VALUE", value).replace("PRECISION", "f64"))()
    model.knots.extend(**rows)
    model.probes.extend(at=at)
    problem = problem_of(model)
    found = np.asarray(problem.evaluation.group_rows(0)[0]).reshape(len(at), n)
    assert problem.cost() == pytest.approx((found**2).sum())
    return found


def spline(order: int, x: Floats) -> BSpline:
    return BSpline(EVEN[0] + STEP * (np.arange(len(EVEN) + order) - order / 2), x, order - 1)


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_control_points_and_derivatives(load: Any, order: int) -> None:
    pos = np.stack([X, X[::-1] ** 2], axis=1)
    expected = spline(order, pos)
    at = np.linspace(expected.t[order - 1], expected.t[len(EVEN)] - 1e-9, 31)
    rows = {"t": EVEN, "pos": pos}
    for number, name in enumerate(["at", "rate", "acceleration"]):
        found = values(load, f"root.knots.{name}(at + late, pos, bspline({order}))", at, rows, 2)
        wanted = expected.derivative(number)(at) if number < order else 0 * found
        assert found == pytest.approx(wanted, abs=1e-9)


def test_rows_are_interpolated(load: Any) -> None:
    at, rows = np.array([0.0, 0.2, 0.5, 0.6, 1.7, 1.9, 2.0, 3.05, 3.3]), {"t": T, "x": X}
    assert values(load, "root.knots.at(at + late, x)", at, rows)[:, 0] == pytest.approx(
        np.interp(at, T, X), abs=1e-14
    )
    found = values(load, "root.knots.at(at + late, x, cubic)", at, rows)[:, 0]
    assert found == pytest.approx(CubicHermiteSpline(T, X, slopes(T, X))(at), abs=1e-12)


def test_angles_take_the_short_way(load: Any) -> None:
    yaw = np.array([3.0, -3.0, -2.8, 3.1, 2.9, -3.1, 3.0])
    at = np.linspace(EVEN[1], EVEN[-2] - 1e-9, 23)
    expected = spline(4, np.unwrap(yaw))
    rows = {"t": EVEN, "yaw": yaw}
    found = values(load, "root.knots.at(at + late, yaw, bspline(4))", at, rows)[:, 0]
    assert np.cos(found - expected(at)) == pytest.approx(1, abs=1e-13)
    rate = values(load, "root.knots.rate(at + late, yaw, bspline(4))", at, rows)[:, 0]
    assert rate == pytest.approx(expected.derivative()(at), abs=1e-9)


def test_rotations_and_transforms(load: Any) -> None:
    moved = np.stack([X, X**2, -X], axis=1)
    rows = {
        "t": EVEN,
        "turn": quats(TURNS),
        "pose": np.concatenate([moved, quats(TURNS)], axis=1),
    }
    at = np.linspace(EVEN[1] + 0.01, EVEN[-2] - 0.01, 19)

    def expected(t: float) -> Rotation:
        i = int((t - EVEN[1]) / STEP)
        return cumulative_spline(TURNS[i : i + 4], (t - EVEN[1]) / STEP - i)

    value = "root.knots.at(at + late, turn, bspline(4)).rotate([1, 2, 3])"
    turned = np.array([expected(t).apply([1, 2, 3]) for t in at])
    assert values(load, value, at, rows, 3) == pytest.approx(turned, abs=1e-12)
    value = "root.knots.at(at + late, pose, bspline(4)) * [1, 2, 3]"
    place = spline(4, moved)(at)
    assert values(load, value, at, rows, 3) == pytest.approx(turned + place, abs=1e-12)
    rate = values(load, "root.knots.rate(at + late, turn, bspline(4))", at, rows, 3)
    eps = 1e-6
    numeric = [(expected(t - eps).inv() * expected(t + eps)).as_rotvec() / (2 * eps) for t in at]
    assert rate == pytest.approx(np.array(numeric), abs=1e-7)


# --- derivatives and kernels ----------------------------------------------------------------------

ALL = """[root.knots.at(at + late, x, cubic), root.knots.at(at * (1 + late), x),
    root.knots.at(at + late, pos, bspline(4), clamp), root.knots.rate(at + late, pos, bspline(4)),
    root.knots.at(at - late, yaw, bspline(3)), root.knots.at(at + late, turn, bspline(4)).log(),
    root.knots.rate(at + late, turn, cubic), root.knots.at(at + late, pose) * [1, 2, 3]]"""


def full(model: Any) -> Any:
    x = np.sin(3 * EVEN)
    model.knots.extend(
        t=EVEN, x=x, pos=np.stack([x, x**2], axis=1), yaw=2 * x, turn=quats(TURNS),
        pose=np.concatenate([np.stack([x, -x, x], axis=1), quats(TURNS)], axis=1),
    )  # fmt: skip
    at = np.array([-0.4, -0.35, 0.1, 0.15, 0.3, 0.61, 0.7, 0.9, 1.1, 1.2, 1.38])
    model.probes.extend(at=at, late=np.linspace(-0.02, 0.03, len(at)))
    return model


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_kernels_agree_with_the_expression_machine_and_differences(
    tmp_path: Path, precision: Any
) -> None:
    path = tmp_path / "table.arael"
    path.write_text(TABLE.replace("VALUE", ALL).replace("PRECISION", precision))
    kernels = full(arael.load(path)())
    machine = full(arael.load(path, interpret=True)())
    tolerance = 1e-11 if precision == "f64" else 5e-5
    pairs = [
        (problem_of(one).evaluation.group_rows(0) for one in (kernels, machine)),
        (problem_of(one).evaluation.linearised() for one in (kernels, machine)),
    ]
    for pair in pairs:
        for one, other in zip(*pair, strict=True):
            assert one == pytest.approx(other, rel=10 * tolerance, abs=100 * tolerance)
    if precision == "f64":
        check_against_differences(kernels)
        assert all(one.agrees for one in machine.check_gradients())


@pytest.mark.parametrize("side", [-1e-4, 0.0, 1e-4])
def test_derivatives_before_at_and_behind_rows(load: Any, side: float) -> None:
    value = "root.knots.at(at + late, x, bspline(4))"
    model = load(TABLE.replace("VALUE", value).replace("PRECISION", "f64"))()
    model.knots.extend(t=EVEN, x=X)
    model.probes.extend(at=EVEN[2:-2], late=side)
    group = problem_of(model).layout.groups[0]
    late = [k for k, (_, use, _) in enumerate(group.jacobian) if group.slots[
        group.uses[use].slot].table == "probes"]  # fmt: skip
    found = problem_of(model).evaluation.group_rows(0)[1][:, late[0]]
    assert found == pytest.approx(spline(4, X).derivative()(EVEN[2:-2] + side), abs=1e-9)


# --- arguments that move --------------------------------------------------------------------------

WALK = """
struct Knot { key t; t: real; param pos: vec2 }
struct Fix {
    time: real
    seen: vec2
    constraint near { (root.track.at(time, pos, bspline(4)) - seen) / 0.01 }
}
struct Sight {
    time: real
    seen: vec2
    constraint near { (root.track.at(time + root.offset, pos, bspline(4)) - seen) / 0.01 }
}
root Walk {
    track: list of Knot
    fixes: list of Fix
    sights: list of Sight
    param offset: real = 0
}
"""
KNOTS = np.arange(-0.5, 6, 0.25)


def path_at(t: Floats) -> Floats:
    return np.stack([np.sin(t), np.cos(0.7 * t)], axis=1)


def walk(load: Any, text: str = WALK, late: float = 0.8) -> Any:
    model = load(text)()
    noise = np.random.default_rng(4).normal(0, 0.01, (400, 2))
    model.track.extend(t=KNOTS, pos=path_at(KNOTS))
    times = np.arange(-0.25, 5.45, 0.05)
    model.fixes.extend(time=times, seen=path_at(times) + noise[: len(times)])
    times = np.arange(1, 4, 0.04)
    model.sights.extend(time=times, seen=path_at(times + late) + noise[-len(times) :])
    return model


def reference(model: Any, late: float) -> Any:
    """The same by SciPy's solver and splines."""
    knots = KNOTS[0] + 0.25 * (np.arange(len(KNOTS) + 4) - 2)

    def residuals(v: Floats) -> Floats:
        s = BSpline(knots, v[1:].reshape(-1, 2), 3)
        first = s(np.asarray(model.fixes.time)) - model.fixes.seen
        second = s(np.asarray(model.sights.time) + v[0]) - model.sights.seen
        return np.concatenate([first, second]).ravel() / 0.01

    start = np.concatenate([[late], path_at(KNOTS).ravel()])
    return least_squares(residuals, start, xtol=1e-14, ftol=1e-14)


def test_an_offset_of_many_intervals_is_found_with_the_control_points(load: Any) -> None:
    model = walk(load)
    expected = reference(model, 0.8)
    result = model.solve()
    assert result.converged
    assert result.cost == pytest.approx(2 * expected.cost, rel=1e-9)
    assert model.cost() == pytest.approx(result.cost, rel=1e-9)
    assert float(model.offset.value) == pytest.approx(expected.x[0], abs=1e-7)
    assert np.asarray(model.track.pos.value).ravel() == pytest.approx(expected.x[1:], abs=1e-5)
    covariance = np.linalg.inv(expected.jac.T @ expected.jac)
    sigma = float(np.asarray(model.covariance().marginal("offset")).squeeze()) ** 0.5
    assert sigma == pytest.approx(covariance[0, 0] ** 0.5, rel=1e-3)


def test_costs_are_those_of_the_present_argument(load: Any) -> None:
    """Within one problem, and within a session that another offset was solved in before."""
    model = walk(load)
    at = {}
    for offset in (0.8, 0.0, 0.31):
        model.offset.value = offset
        at[offset] = walk(load)
        at[offset].offset.value = offset
        assert model.cost() == pytest.approx(at[offset].cost(), rel=1e-12)
    model.solve()
    model.offset.value, model.track.pos.value[:] = 0.31, path_at(KNOTS)
    assert model.cost() == pytest.approx(at[0.31].cost(), rel=1e-12)


def test_a_solve_again_takes_changed_data_and_rows(load: Any) -> None:
    model = walk(load)
    model.solve()
    model.sights.clear()
    times = np.arange(2, 3, 0.02)
    model.sights.extend(time=times, seen=path_at(times - 0.4))
    model.track.append(t=float(KNOTS[-1] + 0.25), pos=[0, 0])
    model.fixes.append(time=float(KNOTS[-1] - 0.1), seen=path_at(KNOTS[-1:] - 0.1)[0])
    model.solve()
    assert float(model.offset.value) == pytest.approx(-0.4, abs=2e-3)


def test_limits_and_observers_hold_over_all_parts(load: Any) -> None:
    model = walk(load)
    result = model.solve(max_iters=2)
    assert result.iterations == 2
    assert result.status == "max_iterations"
    seen: list[float] = []

    def observer(record: Any) -> bool:
        seen.append(float(record["trial_cost"]))
        return len(seen) < 3

    model = walk(load)
    result = model.solve(observer=observer)
    assert result.status == "observer_terminated"
    assert len(result.history) == len(seen) == 3
    assert result.start_cost == pytest.approx(walk(load).cost())


def test_limits_that_must_hold_and_threads(load: Any) -> None:
    """An offset that may not be as large as the data says ends at its limit."""
    text = WALK.replace(
        "offset: real = 0\n", "offset: real = 0\n    require late { offset <= 0.61 }\n"
    )
    model = walk(load, text)
    assert model.solve().converged
    assert float(model.offset.value) == pytest.approx(0.61, abs=1e-6)
    free, threaded = walk(load), walk(load)
    free.solve()
    threaded.solve(num_threads=2)
    assert float(threaded.offset.value) == pytest.approx(float(free.offset.value), abs=1e-9)


NESTED = """
struct Knot { key t; t: real; param x: real }
struct Sight {
    at: real
    seen: real
    constraint c { parent.track.at(at + 0.1 * cos(parent.tilt), x) - seen }
}
struct Car { param tilt: angle = 0; track: list of Knot; sights: list of Sight }
root Cars { cars: list of Car }
"""


def test_rows_of_each_owner_and_arguments_with_cosines(load: Any) -> None:
    model = load(NESTED)()
    for k in range(3):
        car = model.cars.append(tilt=0.5 * k)
        car.track.extend(t=np.arange(5.0)[::-1], x=(k + 1) * np.arange(5.0)[::-1])
        car.sights.extend(at=[0.95, 2.95], seen=[0, 0])
    found = problem_of(model).evaluation.group_rows(0)[0][:, 0].reshape(3, 2)
    at = np.array([0.95, 2.95]) + 0.1 * np.cos(0.5 * np.arange(3))[:, None]
    assert found == pytest.approx((1 + np.arange(3))[:, None] * at)


def test_an_argument_outside_is_named(load: Any) -> None:
    model = walk(load)
    model.sights.append(time=5.9, seen=[0, 0])
    with pytest.raises(SolveError, match=r"E1018.*`sights\[75\]`: 5.9 is outside of `track`"):
        model.solve()


@pytest.mark.parametrize("param", ["euler", "direction"])
def test_parameters_without_values_in_between_are_refused(load: Any, param: str) -> None:
    text = f"""
struct Knot {{ key t; t: real; param d: {param} }}
struct Sight {{ at: real; constraint c {{ root.knots.at(at + root.late, d) }} }}
root Table {{ knots: list of Knot; sights: list of Sight; param late: real }}
"""
    with pytest.raises(AraelError, match="E0623"):
        load(text)
