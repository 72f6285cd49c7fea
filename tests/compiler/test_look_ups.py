"""Look-ups between rows: values, derivatives, intervals, sessions, against independent formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicHermiteSpline
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

import arael
from arael.diagnostics.records import AraelError
from arael.model import Model
from arael.runtime.failures import SolveError
from arael.solving import problem_of
from tests.compiler.test_kernels import check_against_differences
from tests.interpreted import loader

Floats = NDArray[np.float64]

TRACK = """
struct Fix {
    key t
    t: real
    x: real = 0
    pos: vec2 = [0, 0]
    yaw: real = 0
    turn: quat = [1, 0, 0, 0]
    pose: transform = [0, 0, 0, 1, 0, 0, 0]
    inner: Inner
}
struct Inner { y: real = 0 }
struct Probe {
    at: real
    param late: real = 0
    constraint c { VALUE }
}
root Table : PRECISION { fixes: list of Fix; probes: list of Probe }
"""

T = np.array([0.0, 0.5, 0.8, 1.7, 2.0, 3.1, 3.3])
X = np.array([1.0, -0.5, 2.0, 0.3, 0.9, -1.0, 0.2])
EVEN = np.linspace(-1, 2, 7)
TURNS = Rotation.from_rotvec(np.array([
    [0.1, 0.2, -0.3], [0.5, -0.4, 0.2], [1.5, 0.3, 0.4], [1.0, 1.0, -1.2], [0.2, 0.4, 0.5],
    [-0.5, 0.2, 0.1], [-1.5, 0.9, 0.2],
]))  # fmt: skip
INSIDE = np.array([0.0, 0.2, 0.5, 0.6, 1.7, 1.9, 2.0, 3.05, 3.3])


def quats(turns: Rotation) -> Floats:
    return np.roll(turns.as_quat(), 1, axis=1)  # scalar first


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return loader(tmp_path_factory.mktemp("models"))


def table(load: Any, value: str, precision: str = "f64") -> Any:
    return load(TRACK.replace("VALUE", value).replace("PRECISION", precision))


def values(load: Any, value: str, at: Floats, rows: dict[str, Any], n: int = 1) -> Floats:
    """What a look-up gives at each of the arguments, (probes, n)."""
    model = table(load, value)()
    model.fixes.extend(**rows)
    model.probes.extend(at=at)
    return np.asarray(problem_of(model).evaluation.group_rows(0)[0]).reshape(len(at), n)


def slopes(t: Floats, x: Floats) -> Floats:
    """Slopes of the parabolas through three rows, of the intervals at the ends."""
    h, d = np.diff(t), np.diff(x) / np.diff(t)
    inner = (d[:-1] * h[1:] + d[1:] * h[:-1]) / (h[:-1] + h[1:])
    return np.concatenate([d[:1], inner, d[-1:]])


def test_linear_interpolation(load: Any) -> None:
    found = values(load, "root.fixes.at(at + late, x)", INSIDE, {"t": T, "x": X})
    assert found[:, 0] == pytest.approx(np.interp(INSIDE, T, X), abs=1e-14)


def test_cubic_interpolation_has_the_slopes_of_parabolas(load: Any) -> None:
    found = values(load, "root.fixes.at(at + late, x, cubic)", INSIDE, {"t": T, "x": X})
    expected = CubicHermiteSpline(T, X, slopes(T, X))
    assert found[:, 0] == pytest.approx(expected(INSIDE), abs=1e-13)


def test_cubic_interpolation_of_a_parabola_is_exact_inside(load: Any) -> None:
    at = np.linspace(0.5, 3.1, 40)
    found = values(load, "root.fixes.at(at + late, x, cubic)", at, {"t": T, "x": 3 * T**2 - T})
    assert found[:, 0] == pytest.approx(3 * at**2 - at, abs=1e-12)


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_a_row_of_a_spline_acts_around_its_key(load: Any, order: int) -> None:
    h = EVEN[1] - EVEN[0]
    knots = EVEN[0] + h * (np.arange(len(EVEN) + order) - order / 2)
    expected = BSpline(knots, X, order - 1)
    at = np.linspace(knots[order - 1], knots[len(EVEN)], 31)
    found = values(load, f"root.fixes.at(at + late, x, bspline({order}))", at, {"t": EVEN, "x": X})
    assert found[:, 0] == pytest.approx(expected(at), abs=1e-12)
    rate = f"root.fixes.rate(at + late, x, bspline({order}))"
    found = values(load, rate, at[:-1], {"t": EVEN, "x": X})
    assert found[:, 0] == pytest.approx(expected.derivative()(at[:-1]), abs=1e-11)


def test_vectors_and_fields_of_structs(load: Any) -> None:
    pos = np.stack([X, X[::-1] ** 2], axis=1)
    value = "[root.fixes.at(at + late, pos), root.fixes.at(at + late, inner.y)]"
    inner = [{"y": y} for y in X]
    model = table(load, value)()
    for t, p, i in zip(T, pos, inner, strict=True):
        model.fixes.append(t=t, pos=p, inner=i)
    model.probes.extend(at=INSIDE)
    found = problem_of(model).evaluation.group_rows(0)[0]
    expected = [np.interp(INSIDE, T, column) for column in (*pos.T, X)]
    assert found == pytest.approx(np.stack(expected, axis=1), abs=1e-13)


def test_angles_take_the_short_way(load: Any) -> None:
    yaw = np.array([3.0, -3.0, -2.8, 3.1, 2.9, -3.1, 3.0])
    found = values(load, "root.fixes.at(at + late, yaw, wrapped)", INSIDE, {"t": T, "yaw": yaw})
    expected = np.interp(INSIDE, T, np.unwrap(yaw))
    assert np.cos(found[:, 0] - expected) == pytest.approx(1, abs=1e-14)


def test_turns_are_interpolated_along_great_circles(load: Any) -> None:
    rows = {"t": T, "turn": quats(TURNS) * np.array([1, -1, 1, 1, -1, 1, 1])[:, None]}
    found = values(load, "root.fixes.at(at + late, turn).rotation_matrix() * [1, 2, 3]", INSIDE,
                   rows, 3)  # fmt: skip
    assert found == pytest.approx(Slerp(T, TURNS)(INSIDE).apply([1, 2, 3]), abs=1e-13)
    rate = values(load, "root.fixes.rate(at + late, turn)", INSIDE[:-1], rows, 3)
    steps = (TURNS[:-1].inv() * TURNS[1:]).as_rotvec() / np.diff(T)[:, None]
    interval = np.searchsorted(T, INSIDE[:-1], side="right") - 1
    assert rate == pytest.approx(steps[interval], abs=1e-12)


def cumulative_spline(turns: Rotation, u: float) -> Rotation:
    """Cubic cumulative B-spline on SO(3) of four turns, Kim, Kim and Shin (1995)."""
    weights = (
        1,
        (5 + 3 * u - 3 * u**2 + u**3) / 6,
        (1 + 3 * u + 3 * u**2 - 2 * u**3) / 6,
        u**3 / 6,
    )
    found = turns[0]
    for j in (1, 2, 3):
        step = (turns[j - 1].inv() * turns[j]).as_rotvec()
        found = found * Rotation.from_rotvec(weights[j] * step)
    return found


def test_splines_of_turns_are_cumulative_and_so_is_their_rate(load: Any) -> None:
    rows = {"t": EVEN, "turn": quats(TURNS)}
    at = np.linspace(EVEN[1], EVEN[-2] - 1e-9, 23)
    h = EVEN[1] - EVEN[0]

    def expected(t: float) -> Rotation:
        i = min(int((t - EVEN[1]) / h + 1e-12), len(EVEN) - 4)
        return cumulative_spline(TURNS[i : i + 4], (t - EVEN[1]) / h - i)

    value = "root.fixes.at(at + late, turn, bspline(4)).rotate([1, 2, 3])"
    found = values(load, value, at, rows, 3)
    assert found == pytest.approx(np.array([expected(t).apply([1, 2, 3]) for t in at]), abs=1e-12)
    rate = values(load, "root.fixes.rate(at + late, turn, bspline(4))", at, rows, 3)
    eps = 1e-6
    away = at[np.abs((at - EVEN[0]) / h - np.round((at - EVEN[0]) / h)) > 1e-4]
    numeric = [(expected(t - eps).inv() * expected(t + eps)).as_rotvec() / (2 * eps) for t in away]
    assert rate[np.isin(at, away)] == pytest.approx(np.array(numeric), abs=1e-7)


def test_cubic_turns_pass_through_the_rows_and_stay_near_a_smooth_curve(load: Any) -> None:
    t = np.linspace(0, 3, 40)
    smooth = RotationSpline(T, TURNS)
    rows = {"t": t, "turn": quats(smooth(t))}
    at = np.concatenate([t[3:6], np.linspace(0.2, 2.8, 31)])
    value = "root.fixes.at(at + late, turn, cubic).rotate([1, 2, 3])"
    found = values(load, value, at, rows, 3)
    error = np.abs(found - smooth(at).apply([1, 2, 3]))
    assert error[:3].max() < 1e-12
    assert error.max() < 0.02
    linear = values(load, value.replace("cubic", "linear"), at, rows, 3)
    assert error.mean() < 0.1 * np.abs(linear - smooth(at).apply([1, 2, 3])).mean()


def test_transforms_interpolate_translation_and_turn(load: Any) -> None:
    pose = np.concatenate([np.stack([X, X**2, -X], axis=1), quats(TURNS)], axis=1)
    found = values(load, "root.fixes.at(at + late, pose) * [1, 2, 3]", INSIDE,
                   {"t": T, "pose": pose}, 3)  # fmt: skip
    moved = np.stack([np.interp(INSIDE, T, c) for c in pose[:, :3].T], axis=1)
    assert found == pytest.approx(moved + Slerp(T, TURNS)(INSIDE).apply([1, 2, 3]), abs=1e-13)


# --- derivatives and kernels ----------------------------------------------------------------------

ALL = """[root.fixes.at(at + late, x, cubic), root.fixes.at(at * (1 + late), x),
    root.fixes.rate(at + sin(late), x, cubic), root.fixes.at(at + late, turn, cubic).log(),
    root.fixes.at(at + late, pose) * [1, 2, 3], root.fixes.at(at + late, pos, bspline(4), clamp),
    root.fixes.at(at - late, yaw, wrapped), root.fixes.rate(at + late, turn, bspline(3))]"""


def full(model: Any, at: Floats) -> Any:
    x = np.sin(3 * EVEN)
    model.fixes.extend(
        t=EVEN, x=x, pos=np.stack([x, x**2], axis=1), yaw=2 * x, turn=quats(TURNS),
        pose=np.concatenate([np.stack([x, -x, x], axis=1), quats(TURNS)], axis=1),
    )  # fmt: skip
    model.probes.extend(at=at, late=np.linspace(-0.02, 0.03, len(at)))
    return model


AWAY = np.array([-0.4, -0.35, 0.1, 0.15, 0.3, 0.61, 0.7, 0.9, 1.1, 1.2, 1.38])


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_kernels_agree_with_the_expression_machine_and_differences(
    tmp_path: Path, precision: Any
) -> None:
    path = tmp_path / "table.arael"
    path.write_text(TRACK.replace("VALUE", ALL).replace("PRECISION", precision))
    kernels = full(arael.load(path)(), AWAY)
    machine = full(arael.load(path, interpret=True)(), AWAY)
    tolerance = 1e-12 if precision == "f64" else 2e-5
    for one, other in zip(
        problem_of(kernels).evaluation.group_rows(0), problem_of(machine).evaluation.group_rows(0),
        strict=True,
    ):  # fmt: skip
        assert one == pytest.approx(other, rel=tolerance, abs=tolerance)
    linearised = [problem_of(one).evaluation.linearised() for one in (kernels, machine)]
    for one, other in zip(*linearised, strict=True):
        assert one == pytest.approx(other, rel=10 * tolerance, abs=100 * tolerance)
    if precision == "f64":
        check_against_differences(kernels)


@pytest.mark.parametrize("side", [-1e-4, 0.0, 1e-4])
def test_derivatives_before_at_and_behind_rows(load: Any, side: float) -> None:
    """At a row, that of the interval behind it; of a cubic they are the same on both sides."""
    at = EVEN[1:-1]
    model = table(load, "root.fixes.at(at + late, x, cubic)")()
    model.fixes.extend(t=EVEN, x=X)
    model.probes.extend(at=at, late=side)
    derivative = problem_of(model).evaluation.group_rows(0)[1][:, 0]
    spline = CubicHermiteSpline(EVEN, X, slopes(EVEN, X))
    assert derivative == pytest.approx(spline.derivative()(at + side), abs=1e-10)


@pytest.mark.parametrize("kind", ["linear", "cubic", "bspline(5)"])
def test_gradients_are_checked_within_the_interval(load: Any, kind: str) -> None:
    model = table(load, f"root.fixes.at(at + late, x, {kind})")()
    model.fixes.extend(t=EVEN, x=X)
    model.probes.extend(at=EVEN[2:-2])
    assert all(one.agrees for one in model.check_gradients())


# --- arguments that move ----------------------------------------------------------------------

WALK = """
struct Fix { key t; t: real; pos: vec2 }
struct Sight {
    time: real
    seen: vec2
    constraint near { root.track.at(time + root.offset, pos, KIND) - seen }
}
root Walk : PRECISION { track: list of Fix; sights: list of Sight; param offset: real = 0 }
"""


def path_at(t: Floats) -> Floats:
    return np.stack([np.sin(t), np.cos(0.7 * t)], axis=1)


def walk(load: Any, kind: str = "cubic", precision: str = "f64") -> Any:
    model = load(WALK.replace("KIND", kind).replace("PRECISION", precision))()
    t = np.arange(0, 10, 0.02)
    model.track.extend(t=t, pos=path_at(t))
    times = np.arange(1, 8, 0.05)
    model.sights.extend(time=times, seen=path_at(times + 0.4321))
    return model


@pytest.mark.parametrize(("kind", "precision", "tolerance"), [
    ("cubic", "f64", 1e-7), ("linear", "f64", 1e-4), ("cubic", "f32", 1e-5),
])  # fmt: skip
def test_an_offset_of_many_intervals_is_found(
    load: Any, kind: str, precision: str, tolerance: float
) -> None:
    """Costs are those of the intervals that the arguments lie in, at every trial state."""
    model = walk(load, kind, precision)
    result = model.solve()
    assert result.converged
    assert float(model.offset.value) == pytest.approx(0.4321, abs=tolerance)
    assert model.cost() == pytest.approx(result.cost, rel=1e-9)  # that of the intervals at the end


def test_the_cost_is_that_of_the_present_argument(load: Any) -> None:
    model = walk(load)
    model.offset.value = 0.4321
    assert model.cost() == pytest.approx(0, abs=1e-9)
    model.offset.value = 0.0
    seen = model.sights.seen
    expected = np.sum((path_at(np.arange(1, 8, 0.05)) - seen) ** 2)
    assert model.cost() == pytest.approx(expected, rel=1e-5)


def test_rows_may_be_appended_and_changed_between_solves(load: Any) -> None:
    model = walk(load)
    model.solve()
    late = model.track.append(t=20, pos=[0, 0])
    assert late is not None
    model.sights.extend(time=[15.0], seen=[[0.0, 0.0]])
    first = model.solve()
    model.track.pos[:] = path_at(np.asarray(model.track.t) - 0.1)
    model.sights.clear()
    times = np.arange(1, 8, 0.05)
    model.sights.extend(time=times, seen=path_at(times + 0.4321))
    model.solve()
    assert first.converged
    assert float(model.offset.value) == pytest.approx(0.5321, abs=1e-6)


def test_order_of_rows_does_not_matter(load: Any) -> None:
    model, shuffled = walk(load), load(WALK.replace("KIND", "cubic").replace("PRECISION", "f64"))()
    order = np.random.default_rng(2).permutation(len(model.track))
    shuffled.track.extend(
        t=np.asarray(model.track.t)[order], pos=np.asarray(model.track.pos)[order]
    )
    shuffled.sights.extend(time=model.sights.time, seen=model.sights.seen)
    assert shuffled.cost() == model.cost()


NESTED = """
struct Fix { key t; t: real; x: real }
struct Car {
    track: list of Fix
    param late: real = 0
    seen: real
    at: real
    constraint c { track.at(at + late, x, OPTIONS) - seen }
}
root Cars { cars: list of Car }
"""


def test_each_owner_has_a_table_of_its_own(load: Any) -> None:
    model = load(NESTED.replace("OPTIONS", "cubic"))()
    for k in range(3):
        car = model.cars.append(seen=0, at=1.3 + k)
        t = np.arange(5.0) + k
        car.track.extend(t=t, x=(k + 1) * t**2)
    at = 1.3 + np.arange(3)
    found = problem_of(model).evaluation.group_rows(0)[0][:, 0]
    assert found == pytest.approx((1 + np.arange(3)) * at**2)


def test_clamped_arguments_have_the_value_at_the_end_and_no_derivative(load: Any) -> None:
    model = load(NESTED.replace("OPTIONS", "linear, clamp"))()
    for at in (-5.0, 0.5, 9.0):
        model.cars.append(seen=0, at=at).track.extend(t=[0, 1, 2], x=[3, 4, 6])
    residuals, entries = problem_of(model).evaluation.group_rows(0)
    assert residuals[:, 0].tolist() == [3, 3.5, 6]
    assert entries[:, 0].tolist() == [0, 1, 0]


def test_steps_that_lead_outside_are_not_accepted(load: Any) -> None:
    model = load(NESTED.replace("OPTIONS", "cubic"))()
    t = np.linspace(0, 2, 9)
    model.cars.append(seen=1.9, at=1).track.extend(t=t, x=np.arctan(8 * (t - 1)))
    result = model.solve()
    assert result.status != "failed"
    assert 0 <= 1 + float(model.cars[0].late.value) <= 2


def test_a_table_without_rows_that_nothing_reads_is_no_error(load: Any) -> None:
    for kind in ("cubic", "bspline(4)"):
        model = load(WALK.replace("KIND", kind).replace("PRECISION", "f64"))()
        assert model.cost() == 0


def test_sensitivities_go_through_the_argument_and_not_by_the_rows(load: Any) -> None:
    """Times that are all later make the offset as much smaller."""
    model = walk(load)
    result = model.solve()
    found = result.sensitivity("offset", to="sights.time")
    assert np.asarray(found["sights.time"]).sum() == pytest.approx(-1, abs=1e-6)
    with pytest.raises(AraelError, match="read by a look-up"):
        result.sensitivity("offset", to="track.pos")


def test_a_certificate_says_that_look_ups_have_none(load: Any) -> None:
    model = load(
        """
struct Fix { key t; t: real; pos: vec2 }
struct Probe { param x: vec2; time: real; constraint c { x - root.fixes.at(time, pos) } }
root Table { fixes: list of Fix; probes: list of Probe }
"""
    )()
    model.fixes.extend(t=[0, 1, 2], pos=[[0, 0], [1, 2], [2, 0]])
    model.probes.append(x=[0, 0], time=1.5)
    result = model.solve()
    assert model.probes[0].x.value == pytest.approx([1.5, 1])
    with pytest.raises(AraelError, match=r"E1061.*root.fixes.at\(time, pos\)"):
        result.certificate()


def guarded(load: Any) -> Any:
    return load(
        """
struct Fix { key t; t: real; x: real }
struct Probe {
    at: real
    param late: real = 0
    constraint c when root.fixes.at(at + late, x) > 0 { root.fixes.at(at + late, x) - 1 }
}
root Table { fixes: list of Fix; probes: list of Probe }
"""
    )()


def test_a_guard_may_read_a_look_up(load: Any) -> None:
    model = guarded(load)
    model.fixes.extend(t=[0, 1, 2], x=[-1, 0.5, 3])
    model.probes.extend(at=[0.1, 1.5])
    assert model.cost() == pytest.approx((1.75 - 1) ** 2)


# --- messages of a solve ----------------------------------------------------------------------


def failure(model: Any) -> str:
    with pytest.raises(SolveError) as caught:
        model.solve()
    return str(caught.value)


def test_an_argument_outside_names_the_instance_and_the_table(load: Any) -> None:
    model = walk(load)
    model.sights.append(time=12.5, seen=[0, 0])
    message = failure(model)
    assert "E1018" in message
    assert "`sights[140]`: 12.5 is outside of `track`, which reaches from 0 to 9.98" in message
    assert "clamp" in message


@pytest.mark.parametrize(("rows", "kind", "message"), [
    ({"t": [0, 1, 1, 3], "pos": np.zeros((4, 2))}, "linear",
     "`track[1]` and `track[2]` have the same key, `t` = 1"),
    ({"t": [0], "pos": [[0, 0]]}, "linear", "`track` has 1 row, fewer than the 2"),
    ({"t": [0, 1, 2], "pos": np.zeros((3, 2))}, "bspline(4)", "has 3 rows, fewer than the 4"),
    ({"t": [0, 1, 2.5, 3], "pos": np.zeros((4, 2))}, "bspline(3)",
     "`track[2]` is 1.5 after the row before it, where rows are 1 apart on average"),
  ])  # fmt: skip
def test_rows_that_cannot_be_looked_up_are_named(
    load: Any, rows: dict[str, Any], kind: str, message: str
) -> None:
    model = load(WALK.replace("KIND", kind).replace("PRECISION", "f64"))()
    model.track.extend(**rows)
    model.sights.append(time=1, seen=[0, 0])
    said = failure(model)
    assert "E1019" in said
    assert message in said


def test_a_key_that_is_not_finite_is_named(load: Any) -> None:
    model = walk(load)
    model.track.t[3] = np.nan
    message = failure(model)
    assert "E1019" in message
    assert "`track[3].t` is nan" in message


def test_the_sigma_of_a_prior_has_no_look_up(load: Any) -> None:
    with pytest.raises(AraelError, match="E0622"):
        load(
            """
struct Fix { key t; t: real; width: real }
root Walk {
    track: list of Fix
    param offset: real
    at: real
    prior offset ~ normal(0, track.at(self.at, width))
}
"""
        )


def test_models_with_look_ups_are_typed_models(load: Any) -> None:
    assert issubclass(load(WALK.replace("KIND", "cubic").replace("PRECISION", "f64")), Model)
