"""Layouts follow their documents: aliases, constants, edits in place, undo."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.records import Amount, Dimension, Parameter
from arael.sketch.expressions.evaluation import number
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.operands import operands
from arael.sketch.layout.quantities import measure
from tests.sketch.solving import Drawing, python_calls


def chain(count: int) -> Drawing:
    """Lines end to end."""
    d = Drawing()
    for k in range(count):
        d.add("line", float(k), 0.1 * k, k + 1.0, 0.1 * k + 0.1)
    for k in range(count - 1):
        d.constrain("coincident", f"L{k}.p2", f"L{k + 1}.p1")
    return d


def names(layout: Layout) -> set[str]:
    return set(layout.unknown_names())


def test_points_that_coincide_are_one_unknown() -> None:
    d = chain(3)
    assert names(d.layout) == {
        f"{point}.{axis}" for point in ("L0.p1", "L0.p2", "L1.p2", "L2.p2") for axis in "xy"
    }


def test_aliases_get_the_same_bits() -> None:
    d = chain(3)
    d.dimension("length", "L1", value=2.0)
    assert d.solver.solve().solved
    v = d.document.values
    assert v[2:4].tobytes() == v[4:6].tobytes()
    assert v[6:8].tobytes() == v[8:10].tobytes()


def test_a_coincidence_that_closes_nothing_new_is_redundant_at_once() -> None:
    d = chain(3)
    extra = d.constrain("coincident", "L0.p2", "L1.p1")
    d.layout.refresh()
    assert d.layout.spare == {extra}
    # without the first one, it is needed
    d.remove("constraints", "C0")
    d.layout.refresh()
    assert d.layout.spare == set()
    assert d.layout.same(2, 4)
    d.document.undo()
    d.layout.refresh()
    assert d.layout.spare == {extra}
    d.layout.check()


def test_a_point_where_another_began_keeps_its_place() -> None:
    """What is undone and drawn otherwise at once leaves the same offsets to other entities."""
    d = Drawing()
    d.add("point", 0.0, 0.0)
    d.add("circle", 5.0, 5.0, 1.0)
    circle = d.document.entities["A0"].at
    d.add("line", 1.0, 1.0, 2.0, 2.0)
    d.constrain("coincident", "L0.p1", "P0")
    d.layout.refresh()
    for _ in range(3):
        d.document.undo()
    d.add("line", 1.0, 1.0, 2.0, 2.0)
    assert d.document.entities["L0"].at == circle
    d.constrain("coincident", "P0", "L0.p2")
    d.layout.refresh()
    assert names(d.layout) == {f"{point}.{axis}" for point in ("L0.p1", "P0.pos") for axis in "xy"}
    d.layout.check()


def test_centres_of_concentric_curves_are_one_unknown() -> None:
    d = Drawing()
    d.add("circle", 0.0, 0.0, 1.0)
    d.arc(0.1, 0.0, 2.0, 10.0, 100.0)
    d.constrain("concentric", "A0", "A1")
    assert "A1.center.x" not in names(d.layout)
    assert d.solver.solve().solved
    assert d.point("A0.center").tobytes() == d.point("A1.center").tobytes()


def test_locked_places_are_constants() -> None:
    d = chain(2)
    d.constrain("lock", "L1.p1", numbers=(1.5, 0.5))
    assert names(d.layout) == {f"{p}.{a}" for p in ("L0.p1", "L1.p2") for a in "xy"}
    assert d.solver.solve().solved
    assert d.point("L0.p2").tolist() == [1.5, 0.5]
    d.change("constraints", "C1", numbers=(2.5, 0.5))
    assert d.solver.solve().solved
    assert d.point("L0.p2").tolist() == [2.5, 0.5]
    d.layout.check()


def test_locks_of_one_place_that_differ_are_impossible() -> None:
    d = chain(2)
    d.constrain("lock", "L0.p2", numbers=(1.0, 0.1))
    second = d.constrain("lock", "L1.p1", numbers=(1.0, 0.2))
    d.layout.refresh()
    assert set(d.layout.impossible) == {second}
    assert "C1" in d.layout.impossible[second]
    assert not d.solver.solve().solved
    d.document.undo()
    d.layout.refresh()
    assert not d.layout.impossible


def test_two_locks_at_one_place_agree() -> None:
    d = chain(2)
    d.constrain("lock", "L0.p2", numbers=(1.0, 0.1))
    d.constrain("lock", "L1.p1", numbers=(1.0, 0.1))
    d.layout.refresh()
    assert not d.layout.impossible


def test_fixed_entities_are_constants() -> None:
    d = Drawing()
    d.arc(0.0, 0.0, 1.0, 0.0, 90.0)
    d.add("line", 1.0, 0.0, 1.0, -2.0)
    d.constrain("coincident", "A0.start", "L0.p1")
    d.constrain("fix", "A0")
    assert names(d.layout) == {"L0.p2.x", "L0.p2.y"}
    before = d.numbers("A0")
    d.dimension("length", "L0", value=3.0)
    assert d.solver.solve().solved
    assert d.numbers("A0").tobytes() == before.tobytes()


def test_constraints_that_are_off_do_not_act() -> None:
    d = chain(2)
    name = d.dimension("length", "L0", value=3.0)
    d.change("dimensions", name, active=False)
    d.change("constraints", "C0", active=False)
    d.layout.refresh()
    assert not len(d.layout.rows_of(name))
    assert not d.layout.same(2, 4)
    d.change("constraints", "C0", active=True)
    d.layout.refresh()
    assert d.layout.same(2, 4)
    d.layout.check()


def test_derived_dimensions_give_no_row() -> None:
    d = chain(1)
    name = d.dimension("length", "L0", value=3.0, derived=True)
    d.layout.refresh()
    assert not len(d.layout.rows_of(name))


def test_rows_and_records_find_each_other() -> None:
    d = chain(2)
    d.arc(0.0, 5.0, 1.0, 0.0, 90.0)
    length = d.dimension("length", "L0", value=3.0)
    d.layout.refresh()
    for name in ("A0", length):
        rows = d.layout.rows_of(name)
        assert len(rows)
        assert {d.layout.linearisation().owners[row] for row in rows} == {name}


def test_columns_and_names_find_each_other() -> None:
    d = chain(2)
    d.arc(0.0, 5.0, 1.0, 0.0, 90.0)
    d.layout.refresh()
    assert [d.layout.name_of(c) for c in d.layout.columns_of("A0")] == [
        f"A0.{n}"
        for n in ("center.x", "center.y", "start.x", "start.y", "end.x", "end.y", "radius")
    ]
    assert d.layout.columns_of("L1")[:2].tolist() == d.layout.columns_of("L0")[2:].tolist()
    assert d.layout.columns_of("L0.p2").tolist() == d.layout.columns_of("L1.p1").tolist()
    assert d.layout.columns_of("L0.p2.y").tolist() == d.layout.columns_of("L0.p2")[1:].tolist()


def test_another_value_changes_data_only() -> None:
    d = chain(3)
    name = d.dimension("length", "L1", value=2.0)
    d.layout.refresh()
    version, pattern = d.layout.version, d.layout.rows.pattern_version
    d.set(name, 3.0)
    d.layout.refresh()
    assert (d.layout.version, d.layout.rows.pattern_version) == (version, pattern)
    assert d.layout.rows.data(d.layout.first_rows(name)[0], "value") == 3.0


@pytest.mark.parametrize("kind", ["coincident", "parallel", "lock"])
def test_an_edit_lays_out_only_what_it_touches(kind: str) -> None:
    d = chain(60)
    d.layout.refresh()
    if kind == "coincident":
        name = d.constrain(kind, "L40.p2", "L50.p2")
    elif kind == "lock":
        name = d.constrain(kind, "L40.p2", numbers=(41.0, 4.1))
    else:
        name = d.constrain(kind, "L40", "L50")
    laid = d.layout.refresh()
    assert name in laid
    assert len(laid) <= 6
    d.remove("constraints", name)
    assert len(d.layout.refresh()) <= 6
    d.layout.check()


@pytest.mark.parametrize("kind", ["coincident", "parallel", "lock", "length"])
def test_an_edit_costs_the_same_in_a_large_sketch(kind: str) -> None:
    calls = []
    for count in (50, 500):
        d = chain(count)
        d.layout.gather()
        if kind == "length":
            d.dimension(kind, "L10", value=1.0)
        elif kind == "lock":
            d.constrain(kind, "L10.p2", numbers=(11.0, 1.1))
        elif kind == "parallel":
            d.constrain(kind, "L10", "L20")
        else:
            d.constrain(kind, "L10.p2", "L20.p2")
        calls.append(python_calls(d.layout.gather))
    assert calls[1] <= 1.1 * calls[0]


def test_layout_after_undo_and_redo_is_that_of_the_document() -> None:
    d = chain(4)
    d.arc(0.0, 5.0, 1.0, 0.0, 90.0)
    d.constrain("tangent", "A0", "L0")
    d.constrain("point_on", "L0.p1", "A0")
    d.dimension("distance", "A0.center", "L2", low=1.0, high=4.0)
    d.constrain("coincident", "L3.p2", "L0.p1")
    d.constrain("lock", "L0.p1", numbers=(0.0, 0.0))
    d.solver.solve()
    d.remove("constraints", "C1")
    states = []
    while d.document.history.done:
        states.append(d.document.values.tobytes())
        d.document.undo()
        d.layout.check()
    for state in reversed(states):
        d.document.redo()
        d.layout.check()
        assert d.document.values.tobytes() == state


def test_random_edits_leave_the_layout_of_the_document() -> None:
    rng = np.random.default_rng(4)
    d = chain(6)
    for k in range(3):
        d.arc(2.0 * k, 5.0, 1.0 + k, 10.0, 100.0 + 40 * k)
    d.add("bspline", 0, 9, 1, 10, 2, 9, 3, 10, 4, 9)
    d.add("point", 1.0, 8.0)
    made = len(d.document.history.done)
    for step in range(120):
        a, b = rng.choice(6, 2, replace=False)
        circle = f"A{rng.integers(3)}"
        choice = rng.integers(11)
        if choice == 0:
            ends = [f"L{a}.p1", f"L{a}.p2", f"{circle}.start", f"{circle}.center", "P0"]
            first, second = rng.choice(len(ends), 2, replace=False)
            d.constrain("coincident", ends[first], ends[second])
        elif choice == 1:
            d.constrain("lock", f"L{a}.p{rng.integers(1, 3)}", numbers=(float(a), 1.0))
        elif choice == 2:
            d.constrain("tangent", f"L{a}", circle)
        elif choice == 3:
            d.constrain("point_on", f"L{a}.p1", circle)
        elif choice == 4:
            d.constrain("point_on", "P0", "S0")
        elif choice == 5:
            d.dimension("angle", f"L{a}", f"L{b}", low=10.0, high=170.0)
        elif choice == 6:
            d.constrain("collinear", f"L{a}", f"L{b}")
        elif choice == 7:
            d.constrain("fix", circle)
        elif choice == 8 and d.document.constraints:
            name = list(d.document.constraints)[rng.integers(len(d.document.constraints))]
            active = d.document.constraints[name].active
            d.change("constraints", name, active=not active)
        elif choice == 9 and d.document.constraints:
            name = list(d.document.constraints)[rng.integers(len(d.document.constraints))]
            d.remove("constraints", name)
        else:
            for _ in range(rng.integers(4)):
                if len(d.document.history.done) > made:
                    d.document.undo()
        if step % 3 == 0:
            d.layout.check()
    d.layout.check()


def test_expressions_over_geometry_are_rows_that_follow_it() -> None:
    d = chain(3)
    document = d.document
    with document.transaction("param"):
        document.put("parameters", Parameter("extra", Amount("0.5", 0.5)))
        document.put(
            "dimensions",
            Dimension("d9", "length", ("L2",), Amount("L0.length * 2 + extra", 1.0)),
        )
    length = d.dimension("length", "L0", value=1.5)
    assert d.solver.solve().solved
    for value, extra in ((1.5, 0.5), (2.5, 0.5), (2.5, 1.25)):
        d.set(length, value)
        with document.transaction("param"):
            document.put("parameters", Parameter("extra", Amount(str(extra), extra)))
        assert d.solver.solve().solved
        lengths = [float(np.linalg.norm(np.diff(d.line(f"L{k}"), axis=0))) for k in (0, 2)]
        assert lengths == pytest.approx([value, 2 * value + extra], abs=1e-9)
    # It holds both ways: with the longer line given, the other follows.
    d.change("dimensions", length, active=False)
    d.dimension("length", "L2", value=9.25)
    assert d.solver.solve().solved
    assert np.linalg.norm(np.diff(d.line("L0"), axis=0)) == pytest.approx(4.0, abs=1e-9)
    d.layout.check()


@pytest.mark.parametrize(
    ("kind", "args", "text"),
    [
        ("angle", ("L0", "L1"), "L2.angle / 2 + 20"),
        ("sweep", ("A0",), "L0.p2.x * 30"),
        ("total_length", ("L0", "L1"), "A0.length + 1"),
        ("radius", ("A0",), "max(A0.sweep / 50, L0.length)"),
        ("distance", ("L0.p1", "L1.p2"), "A0.center.y / 2 + dist(L0.p1, L0.p2)"),
    ],
)
def test_every_sort_of_expression_over_geometry(
    kind: str, args: tuple[str, ...], text: str
) -> None:
    d = Drawing()
    d.add("line", 0.0, 0.0, 4.0, 1.0)
    d.add("line", 4.0, 1.0, 5.0, 5.0)
    d.add("line", 9.0, 0.0, 12.0, 2.0)
    d.arc(0.0, 9.0, 2.0, 10.0, 130.0)
    d.constrain("coincident", "L0.p2", "L1.p1")
    with d.document.transaction("dimension"):
        side = d.layout.side_of(kind, args)
        d.document.put("dimensions", Dimension("d0", kind, args, Amount(text, 1.0), side=side))
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    wanted = number(text, DocumentScope(d.document))
    found = measure(kind, operands(d.document, args), d.document.values, side)
    assert (math.degrees(found) if kind in ("angle", "sweep") else found) == pytest.approx(
        wanted, abs=1e-7
    )
    d.layout.check()


@pytest.mark.parametrize("mode", ["", "supplement"])
def test_a_range_of_the_angle_of_opposite_lines_is_met_as_they_are(mode: str) -> None:
    # Their turn is 180 degrees or -180, by the last bit of a product.
    rng = np.random.default_rng(0)
    d = Drawing()
    for k in range(40):
        at, along = rng.uniform(-9.0, 9.0, 2), rng.uniform(-1.0, 1.0, 2)
        ahead, back = at + along, at - rng.uniform(1.0, 9.0) * along
        d.add("line", *at, *ahead)
        d.add("line", *at, *back)
        turned = (0.0, 5.0) if mode else (1.4, None)
        d.dimension("angle", f"L{2 * k}", f"L{2 * k + 1}", low=turned[0], high=turned[1], mode=mode)
    d.layout.gather()
    assert np.abs(d.layout.linearisation().residuals).max() < 1e-12


def test_the_sweep_of_an_arc_whose_ends_are_one_place_has_no_side() -> None:
    session = Session()
    session.run("add_arc 0,0 4,0 2,2\nadd_arc 5,5 9,5 7,8")
    layout = session.editor.layout

    def guards() -> list[str]:
        return [str(one[1][0]) for one in layout.signature()["A1"] if one[0] == "guard"]

    assert guards() == ["ScalarValue", "SweepGuard"]
    session.run("coincident A1.start A0.end\ncoincident A1.end A0.end")
    assert guards() == ["ScalarValue"]
    layout.check()
    layout.renew_sides()
    session.run("delete C1")
    assert guards() == ["ScalarValue", "SweepGuard"]
    layout.check()


@pytest.mark.parametrize(("bound", "inside"), [(">= 100", (100, 180)), ("<= 80", (0, 80))])
def test_a_range_of_an_angle_with_one_end_has_half_a_turn(
    bound: str, inside: tuple[float, float]
) -> None:
    """Without the other end it would reach where the measure wraps around, and count as open."""
    session = Session()
    session.run("add_line 0,0 5,0; fix L0; add_line 0,0 -3,4; length L1 5")
    if inside[1] < 90:
        session.run("drag L1.p2 3,4")
    session.run(f"angle L0 L1 {bound}")
    for k in range(0, 360, 15):
        x, y = 4 * math.cos(math.radians(k)), 4 * math.sin(math.radians(k))
        try:
            session.run(f"drag L1.p2 {x},{y}")
        except AraelError as refused:
            assert refused.diagnostics[0].code.startswith("E12")
        found = session.editor.measure("angle", ("L0", "L1"))
        assert inside[0] - 1e-6 <= found <= inside[1] + 1e-6
        assert abs(Layout(session.document).linearisation().residuals).max() < 1e-9
