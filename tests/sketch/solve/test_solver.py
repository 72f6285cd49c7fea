"""Solving after an edit: sides, scale, components, failures, continuation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from arael.sketch.commands.session import Session
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount
from arael.sketch.layout.operands import operands
from arael.sketch.layout.quantities import measure
from arael.sketch.solve.solver import Drag
from tests.sketch.solving import Drawing, python_calls


def rectangle(scale: float = 1.0, dx: float = 0.0, dy: float = 0.0) -> Drawing:
    """A dimensioned rectangle with a hole, slightly off."""
    d = Drawing()
    corners = [(0, 0), (5, 0.2), (5.1, 3), (0, 3.1)]
    places = [(dx + scale * x, dy + scale * y) for x, y in corners]
    for k in range(4):
        d.add("line", *places[k], *places[(k + 1) % 4])
    for k in range(4):
        d.constrain("coincident", f"L{k}.p2", f"L{(k + 1) % 4}.p1")
        d.constrain("vertical" if k % 2 else "horizontal", f"L{k}")
    d.constrain("lock", "L0.p1", numbers=(dx, dy))
    d.add("circle", dx + 1.1 * scale, dy + 0.9 * scale, 0.8 * scale)
    d.dimension("length", "L0", value=5 * scale)
    d.dimension("length", "L1", value=3 * scale)
    d.dimension("radius", "A0", value=scale)
    d.dimension("hdistance", "L0.p1", "A0.center", value=2 * scale)
    d.dimension("distance", "A0.center", "L0", value=1.5 * scale)
    return d


def test_rectangle_with_a_hole() -> None:
    d = rectangle()
    outcome = d.solver.solve()
    assert outcome.solved
    assert outcome.moved == ("L0", "L1", "L2", "L3", "A0")
    assert outcome.residual < 1e-12
    expected = [(0, 0), (5, 0), (5, 3), (0, 3)]
    for k in range(4):
        assert np.allclose(d.line(f"L{k}"), [expected[k], expected[(k + 1) % 4]], atol=1e-12)
    assert np.allclose(d.numbers("A0"), [2, 1.5, 1], atol=1e-12)


def test_a_satisfied_sketch_keeps_its_bits() -> None:
    d = rectangle()
    d.solver.solve()
    before, done = d.document.values.tobytes(), len(d.document.history.done)
    for _ in range(5):
        outcome = d.solver.solve()
        assert outcome.solved
        assert outcome.moved == ()
    assert d.document.values.tobytes() == before
    assert len(d.document.history.done) == done


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("far", [0.0, 1e6])
def test_scale_and_place_do_not_matter(scale: float, far: float) -> None:
    d = rectangle(scale, far * scale, -far * scale)
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    reference = rectangle()
    reference.solver.solve()
    found = (d.document.values - _shift(d, far * scale)) / scale
    rounding = 1e-9 if far else 1e-12
    assert np.allclose(found, reference.document.values, rtol=0, atol=rounding)


def _shift(d: Drawing, far: float) -> np.ndarray:
    shift = np.zeros(len(d.document.values))
    for name, entity in d.document.entities.items():
        count = 4 if name.startswith("L") else 2
        shift[entity.at : entity.at + count : 2] = far
        shift[entity.at + 1 : entity.at + count : 2] = -far
    return shift


def test_only_what_was_touched_moves() -> None:
    d = rectangle()
    d.add("line", 20.0, 20.0, 21.0, 22.0)
    name = d.dimension("length", "L4", value=3.0)
    d.solver.solve()
    before = d.document.values.copy()
    d.set(name, 3.1)
    outcome = d.solver.solve()
    assert outcome.moved == ("L4",)
    at = d.document.entities["L4"].at
    assert d.document.values[:at].tobytes() == before[:at].tobytes()


def test_a_failure_leaves_the_document_and_names_what_stays_open() -> None:
    d = Drawing()
    for k, (a, b) in enumerate([((0, 0), (3, 0)), ((3, 0), (1, 2)), ((1, 2), (0, 0))]):
        d.add("line", *map(float, a), *map(float, b))
        d.dimension("length", f"L{k}", value=(1.0, 1.0, 3.0)[k])
    for k in range(3):
        d.constrain("coincident", f"L{k}.p2", f"L{(k + 1) % 3}.p1")
    before, done = d.document.values.tobytes(), len(d.document.history.done)
    outcome = d.solver.solve()
    assert outcome.status == "stalled"
    assert outcome.fraction < 1
    assert set(outcome.open) <= {"d0", "d1", "d2"}
    assert outcome.row in outcome.open
    assert d.document.values.tobytes() == before
    assert len(d.document.history.done) == done
    assert set(d.solver.open_candidates("d2")) == {"d0", "d1", "d2"}
    assert not d.solver.feasible(("d0", "d1", "d2"))
    for left in ("d0", "d1", "d2"):
        assert d.solver.feasible(tuple(n for n in ("d0", "d1", "d2") if n != left))
    d.layout.check()


def test_a_failed_value_can_be_taken_back() -> None:
    d = rectangle()
    d.dimension("distance", "L0.p1", "L1.p2", value=math.hypot(5, 3))
    assert d.solver.solve().solved
    before = d.document.values.tobytes()
    d.set("d0", 9.0)
    assert not d.solver.solve().solved
    d.document.undo()
    assert d.solver.solve().solved
    assert d.document.values.tobytes() == before
    d.layout.check()


# --- sides ----------------------------------------------------------------------------------


@pytest.mark.parametrize("side", [1, -1])
def test_a_point_stays_on_its_side_of_a_line(side: int) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 10.0, 0.0)
    d.add("point", 4.0, 0.5 * side)
    d.constrain("fix", "L0")
    name = d.dimension("distance", "P0", "L0", value=0.5)
    for value in (5.0, 0.01, 3.0):
        d.set(name, value)
        assert d.solver.solve().solved
        assert d.point("P0")[1] == pytest.approx(side * value)


@pytest.mark.parametrize("side", [1, -1])
def test_a_tangent_circle_stays_on_its_side(side: int) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 10.0, 1.0)
    d.add("circle", 4.0, 3.0 * side, 2.0)
    d.constrain("fix", "L0")
    d.constrain("tangent", "L0", "A0")
    name = d.dimension("radius", "A0", value=2.0)
    for value in (8.0, 0.1, 4.0):
        d.set(name, value)
        assert d.solver.solve().solved
        center, r = d.circle("A0")
        a, b = d.line("L0")
        u = (b - a) / np.linalg.norm(b - a)
        off = u[0] * (center - a)[1] - u[1] * (center - a)[0]
        assert off == pytest.approx(side * value)
        assert r == pytest.approx(value)


def test_horizontal_lines_do_not_reverse() -> None:
    d = rectangle()
    d.solver.solve()
    for value in (0.05, 20.0, 0.5):
        d.set("d0", value)
        d.set("d3", value / 2)
        assert d.solver.solve().solved
        assert d.line("L0")[1][0] == pytest.approx(value)
        assert d.line("L2")[1][0] < d.line("L2")[0][0]


@pytest.mark.parametrize("steps", [(170.0, 5.0, 120.0), (10.0, 175.0, 60.0)])
def test_angles_keep_their_sector(steps: tuple[float, ...]) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 5.0, 0.0)
    d.add("line", 0.0, 0.0, 2.0, 3.0)
    d.constrain("fix", "L0")
    d.constrain("coincident", "L1.p1", "L0.p1")
    d.dimension("length", "L1", value=3.0)
    name = d.dimension("angle", "L0", "L1", value=60.0)
    for value in steps:
        d.set(name, value)
        outcome = d.solver.solve()
        assert outcome.solved, outcome
        u = d.direction("L1")
        assert math.degrees(math.atan2(u[1], u[0])) == pytest.approx(value)


@pytest.mark.parametrize("turned", [100.0, 170.0, -120.0])
def test_a_line_put_far_off_its_angle_comes_back_to_it(turned: float) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 5.0, 0.0)
    d.add("line", 0.0, 0.0, 3.0, 0.0)
    d.constrain("fix", "L0")
    d.constrain("coincident", "L1.p1", "L0.p1")
    d.dimension("length", "L1", value=3.0)
    d.dimension("angle", "L0", "L1", value=60.0, side=1)
    assert d.solver.solve().solved
    angle = math.radians(60.0 + turned)
    at = d.document.point_at("L1.p2")
    with d.document.transaction("place"):
        d.document.set_values([at, at + 1], [3 * math.cos(angle), 3 * math.sin(angle)])
    assert d.solver.solve().solved
    u = d.direction("L1")
    assert math.degrees(math.atan2(u[1], u[0])) == pytest.approx(60.0)


def test_an_arc_may_grow_past_half_a_turn_bit_by_bit() -> None:
    d = Drawing()
    d.arc(0.0, 0.0, 2.0, 0.0, 100.0)
    d.constrain("lock", "A0.center", numbers=(0.0, 0.0))
    d.constrain("lock", "A0.start", numbers=(2.0, 0.0))
    at = d.document.point_at("A0.end")
    drag = Drag(d.solver, [at])
    for degrees in [*range(110, 351, 10), *range(340, 9, -10)]:
        t = math.radians(degrees)
        assert drag.move([(2 * math.cos(t), 2 * math.sin(t))]).solved
        if degrees % 60 == 0:
            drag = Drag(d.solver, [at])
        assert np.allclose(d.point("A0.end"), [2 * math.cos(t), 2 * math.sin(t)], atol=1e-6)


def test_ends_joined_from_far_away_are_joined() -> None:
    d = Drawing()
    d.arc(6.0, 6.0, 2.0, 20.0, 130.0)
    d.earc(8.0, 12.0, 2.0, 1.1, -0.2, 10.0, 150.0)
    d.constrain("coincident", "A0.end", "EA0.start")
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    assert d.point("A0.end").tobytes() == d.point("EA0.start").tobytes()


def test_sweeps_stay_between_nothing_and_a_whole_turn() -> None:
    d = Drawing()
    d.arc(0.0, 0.0, 2.0, 10.0, 100.0)
    d.dimension("radius", "A0", value=2.0)
    name = d.dimension("sweep", "A0", value=90.0)
    for value in (350.0, 10.0, 181.0, 179.0, 5.0):
        d.set(name, value)
        outcome = d.solver.solve()
        assert outcome.solved, outcome
        v = d.numbers("A0")
        u, w = v[2:4] - v[:2], v[4:6] - v[:2]
        turn = math.atan2(w[1], w[0]) - math.atan2(u[1], u[0])
        assert math.degrees(turn % (2 * math.pi)) == pytest.approx(value)


def test_radii_do_not_turn_inside_out() -> None:
    d = Drawing()
    d.add("circle", 0.0, 0.0, 1.0)
    d.add("point", 5.0, 0.0)
    d.constrain("point_on", "P0", "A0")
    d.solver.solve()
    d.perturb(0.5, 3)
    assert d.solver.solve().solved
    assert d.circle("A0")[1] > 0


# --- ranges ---------------------------------------------------------------------------------


def test_ranges_hold_exactly_and_take_no_freedom() -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 5.0, 0.0)
    name = d.dimension("length", "L0", low=2.0, high=4.0)
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    a, b = d.line("L0")
    assert np.linalg.norm(b - a) == pytest.approx(4.0, abs=1e-9)
    assert len(d.layout.linearisation(ranges=False).owners) == 0
    before = d.document.values.tobytes()
    d.change("dimensions", name, low=Amount("3", 3.0))
    assert d.solver.solve().solved
    assert d.document.values.tobytes() == before
    d.change("dimensions", name, low=Amount("6", 6.0), high=Amount("8", 8.0))
    assert d.solver.solve().solved
    a, b = d.line("L0")
    assert np.linalg.norm(b - a) == pytest.approx(6.0, abs=1e-9)
    d.layout.check()


@pytest.mark.parametrize("kind", ["angle", "xangle", "sweep", "area", "total_length", "radius"])
def test_ranges_of_every_quantity(kind: str) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 5.0, 0.5)
    d.add("line", 5.0, 0.5, 2.0, 3.0)
    d.add("line", 2.0, 3.0, 0.0, 0.0)
    for k in range(3):
        d.constrain("coincident", f"L{k}.p2", f"L{(k + 1) % 3}.p1")
    d.arc(9.0, 0.0, 2.0, 0.0, 80.0)
    args, low, high = {
        "angle": (("L0", "L1"), 100.0, 110.0),
        "xangle": (("L0",), 20.0, 30.0),
        "sweep": (("A0",), 120.0, 200.0),
        "area": (("L0", "L1", "L2"), 9.0, 12.0),
        "total_length": (("L0", "L1"), 12.0, 14.0),
        "radius": (("A0",), 3.0, 4.0),
    }[kind]
    d.dimension(kind, *args, low=low, high=high)
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    found = measure(kind, operands(d.document, args), d.document.values)
    if DIMENSIONS[kind].quantity == "angle":
        found = math.degrees(found)
    assert low - 1e-6 <= found <= high + 1e-6
    d.layout.check()


# --- dragging -------------------------------------------------------------------------------


def test_a_fully_defined_sketch_does_not_move() -> None:
    d = rectangle()
    d.solver.solve()
    before = d.document.values.tobytes()
    outcome = d.solver.drag([d.document.point_at("L1.p2")], [(9.0, 9.0)])
    assert outcome.solved
    assert outcome.moved == ()
    assert d.document.values.tobytes() == before


def test_a_point_follows_the_cursor_as_far_as_it_can() -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 3.0, 0.0)
    d.constrain("lock", "L0.p1", numbers=(0.0, 0.0))
    d.dimension("length", "L0", value=3.0)
    outcome = d.solver.drag([d.document.point_at("L0.p2")], [(4.0, 4.0)])
    assert outcome.solved
    assert np.allclose(d.point("L0.p2"), 3 / math.sqrt(2), atol=1e-7)


def test_a_line_is_moved_by_its_body() -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 3.0, 1.0)
    at = [d.document.point_at("L0.p1"), d.document.point_at("L0.p2")]
    drag = Drag(d.solver, at)
    assert drag.shift(1.0, 2.0).solved
    assert drag.shift(2.0, 2.5).solved
    assert np.allclose(d.numbers("L0"), [2.0, 2.5, 5.0, 3.5], atol=1e-9)
    with pytest.raises(ValueError, match=r"expected a finite vector, found nan, 0\.0"):
        drag.shift(math.nan, 0.0)


def test_an_arc_keeps_its_shape_when_moved_by_its_body() -> None:
    d = Drawing()
    d.arc(0.0, 0.0, 2.0, 10.0, 100.0)
    before = d.numbers("A0")
    drag = Drag(d.solver, [d.document.point_at(f"A0.{p}") for p in ("center", "start", "end")])
    assert drag.shift(3.0, -1.0).solved
    assert np.allclose(d.numbers("A0") - before, [3, -1, 3, -1, 3, -1, 0], atol=1e-9)


def test_a_chain_dragged_out_and_back_is_where_it_was() -> None:
    d = Drawing()
    for k in range(12):
        d.add("line", float(k), 0.3 * (k % 2), k + 1.0, 0.3 * ((k + 1) % 2))
        d.dimension(
            "length", f"L{k}", value=float(np.linalg.norm(np.diff(d.line(f"L{k}"), axis=0)))
        )
    for k in range(11):
        d.constrain("coincident", f"L{k}.p2", f"L{k + 1}.p1")
    d.constrain("lock", "L0.p1", numbers=(0.0, 0.0))
    d.solver.solve()
    before = d.document.values.copy()
    at = d.document.point_at("L11.p2")
    home = before[at : at + 2]
    drag = Drag(d.solver, [at])
    for t in [*np.linspace(0, 1, 12), *np.linspace(1, 0, 12)]:
        outcome = drag.move([home + t * np.array([-3.0, 2.5])])
        assert outcome.solved, outcome
    assert np.abs(d.document.values - before).max() < 1e-9


def test_a_point_is_dragged_along_a_spline_of_several_pieces() -> None:
    d = Drawing()
    d.add("bspline", 0, 0, 1, 1, 3, 1, 5, 0, 7, 1, 9, 1, 10, 0)
    d.constrain("fix", "S0")
    d.add("point", 0.5, 0.5)
    d.constrain("point_on", "P0", "S0")
    assert d.solver.solve().solved
    curve = BSpline(np.r_[[0.0] * 3, np.arange(5), [4.0] * 3], d.numbers("S0").reshape(-1, 2), 3)
    drag = Drag(d.solver, [d.document.point_at("P0")])
    for u in [*np.linspace(0.3, 3.9, 60), *np.linspace(3.9, 0.2, 60)]:
        for _ in range(2):
            assert drag.move([curve(u)]).solved
        assert np.allclose(d.point("P0"), curve(u), atol=1e-6)


def test_a_value_takes_a_point_across_the_knots_of_a_spline() -> None:
    d = Drawing()
    d.add("bspline", 0, 0, 1, 1, 3, 1, 5, 0, 7, 1, 9, 1, 10, 0)
    d.constrain("fix", "S0")
    d.add("point", 0.5, 0.5)
    d.constrain("point_on", "P0", "S0")
    name = d.dimension("hdistance", "S0.p1", "P0", value=0.5)
    for value in (1.0, 9.0, 0.2, 5.0):
        d.set(name, value)
        outcome = d.solver.solve()
        assert outcome.solved, outcome
        assert d.point("P0")[0] == pytest.approx(value)
    d.layout.check()


def test_a_locked_point_is_not_dragged() -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 3.0, 1.0)
    d.constrain("lock", "L0.p1", numbers=(0.0, 0.0))
    before = d.document.values.tobytes()
    outcome = d.solver.drag([d.document.point_at("L0.p1")], [(4.0, 4.0)])
    assert outcome.solved
    assert d.document.values.tobytes() == before


# --- undo -----------------------------------------------------------------------------------


def test_undo_is_bit_identical_with_a_layout_attached() -> None:
    d = rectangle()
    states = [d.document.values.tobytes()]
    marks = [len(d.document.history.done)]
    for k in range(8):
        d.set("d0", 5.0 + 0.3 * k)
        assert d.solver.solve().solved
        states.append(d.document.values.tobytes())
        marks.append(len(d.document.history.done))
    for state, mark in zip(reversed(states), reversed(marks), strict=True):
        while len(d.document.history.done) > mark:
            d.document.undo()
        assert d.document.values.tobytes() == state
        d.layout.check()


def test_a_far_chain_of_ten_thousand_constraints_solves() -> None:
    d = Drawing()
    with d.document.transaction("many"):
        for k in range(1250):
            d.add("line", float(k), 0.01 * (k % 3), k + 1.0, 0.01 * ((k + 1) % 3))
            if k:
                d.constrain("coincident", f"L{k - 1}.p2", f"L{k}.p1")
            d.dimension("length", f"L{k}", value=1.0)
            d.constrain("horizontal", f"L{k}")
        d.constrain("lock", "L0.p1", numbers=(0.0, 0.0))
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    assert d.line("L1249")[1].tolist() == pytest.approx([1250.0, 0.0])
    calls = python_calls(lambda: (d.set("d3", 1.5), d.solver.solve()))
    few = Drawing()
    few.add("line", 0.0, 0.0, 1.0, 0.0)
    few.dimension("length", "L0", value=1.0)
    few.solver.solve()
    assert calls < 2 * python_calls(lambda: (few.set("d0", 1.5), few.solver.solve())) + 200


@pytest.mark.parametrize(
    ("end", "low", "high", "found"),
    [
        ((5.0, -3.0), -60.0, -10.0, math.degrees(math.atan2(-3.0, 5.0))),
        ((5.0, -3.0), -10.0, 20.0, -10.0),
        ((5.0, 3.0), -20.0, 10.0, 10.0),
        ((-5.0, 0.5), 170.0, 190.0, math.degrees(math.atan2(0.5, -5.0))),
        ((-5.0, -0.5), 170.0, 190.0, math.degrees(math.atan2(-0.5, -5.0))),
        ((0.1, 5.0), 100.0, 260.0, 100.0),
    ],
)
def test_a_range_of_directions_does_not_wrap_around_inside(
    end: tuple[float, float], low: float, high: float, found: float
) -> None:
    session = Session()
    session.run(f"add_line 0,0 {end[0]},{end[1]}; lock L0.p1 0,0; xangle L0 {low} to {high}")
    x, y = session.document.numbers_of("L0")[2:].tolist()
    assert math.degrees(math.atan2(y, x)) == pytest.approx(found, abs=1e-7)
