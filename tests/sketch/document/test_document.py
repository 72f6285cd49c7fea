"""Documents: every change can be undone, bit by bit."""

from __future__ import annotations

from dataclasses import replace

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import TABLES, Document
from arael.sketch.document.history import RecordChange
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.records import Amount, Constraint, Entity, Parameter
from arael.sketch.document.saved import to_json


def state(document: Document) -> tuple[bytes, bytes, list[list[str]]]:
    """Everything undo must restore: records in their order, settings, the bits of all numbers."""
    return (
        to_json(document),
        document.values.tobytes(),
        [list(getattr(document, table)) for table in TABLES],
    )


def two_lines() -> Document:
    document = Document()
    with document.transaction("add_line 0,0 1,0"):
        document.add_entity("line", [0, 0, 1, 0])
    with document.transaction("add_line 1,0 1,1"):
        document.add_entity("line", [1, 0, 1, 1])
        name = document.next_name("C")
        document.put("constraints", Constraint(name, "coincident", ("L0.p2", "L1.p1")))
    return document


def test_names_count_by_prefix() -> None:
    assert list(two_lines().entities) == ["L0", "L1"]
    assert list(two_lines().constraints) == ["C0"]


def test_numbers_by_name_and_by_point() -> None:
    document = two_lines()
    assert document.numbers_of("L1").tolist() == [1, 0, 1, 1]
    at = document.point_at("L1.p2")
    assert document.values[at : at + 2].tolist() == [1, 1]


def test_the_numbers_cannot_be_written_past_the_history() -> None:
    document = two_lines()
    with pytest.raises(ValueError, match="read-only"):
        document.values[0] = 3.0
    with pytest.raises(RuntimeError, match="transaction"):
        document.set_values([0], [3.0])


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_numbers_are_finite(number: float) -> None:
    document = two_lines()
    before = state(document)
    with pytest.raises(ValueError, match="finite"), document.transaction("x"):
        document.set_values([0], [number])
    with pytest.raises(ValueError, match="finite"), document.transaction("x"):
        document.add_entity("point", [number, 0])
    assert state(document) == before


@pytest.mark.parametrize(("kind", "count"), [("line", 3), ("bezier", 6), ("bspline", 9)])
def test_entities_have_their_numbers(kind: str, count: int) -> None:
    document = Document()
    with pytest.raises(ValueError, match="has"), document.transaction("x"):
        document.add_entity(kind, np.zeros(count))


def test_undo_and_redo() -> None:
    document = two_lines()
    full = state(document)
    assert document.undo() == "add_line 1,0 1,1"
    assert list(document.entities) == ["L0"]
    assert document.undo() == "add_line 0,0 1,0"
    assert document.undo() is None
    assert state(document) == state(Document())
    assert document.redo() == "add_line 0,0 1,0"
    assert document.redo() == "add_line 1,0 1,1"
    assert document.redo() is None
    assert state(document) == full


def test_a_new_change_ends_redo() -> None:
    document = two_lines()
    document.undo()
    with document.transaction("add_point"):
        document.add_entity("point", [3, 3])
    assert document.redo() is None
    assert document.history.labels == ["add_line 0,0 1,0", "add_point"]


def test_a_failed_transaction_is_taken_back() -> None:
    document = two_lines()
    before = state(document)
    with pytest.raises(KeyError), document.transaction("wrong"):
        document.remove("entities", "L0")
        document.set_values([5], [9.0])
        document.next_name("L")
        document.remove("entities", "L7")
    assert state(document) == before
    assert document.history.position == 2


def test_a_failed_part_leaves_the_rest() -> None:
    document = two_lines()
    with document.transaction("both"):
        document.set_values([0], [-1.0])
        with pytest.raises(ValueError), document.transaction("part"):
            document.set_values([1], [-2.0])
            raise ValueError
    assert document.values[:2].tolist() == [-1, 0]
    document.undo()
    assert document.values[:2].tolist() == [0, 0]


def test_a_removed_record_comes_back_in_its_place() -> None:
    document = two_lines()
    with document.transaction("delete L0"):
        document.remove("entities", "L0")
    document.undo()
    assert list(document.entities) == ["L0", "L1"]


def test_rename_keeps_the_place_and_is_undone() -> None:
    document = Document()
    with document.transaction("params"):
        for name in "abc":
            document.put("parameters", Parameter(name, Amount("1", 1.0)))
    before = state(document)
    with document.transaction("rename_param b x"):
        document.rename("parameters", "b", replace(document.parameters["b"], name="x"))
    assert list(document.parameters) == ["a", "x", "c"]
    document.undo()
    assert state(document) == before


def test_watchers_see_changes_and_their_return() -> None:
    document = Document()
    seen: list[tuple[str, bool]] = []

    def watch(change: RecordChange, backwards: bool) -> None:
        seen.append((change.key, backwards))

    document.watchers.append(watch)
    with document.transaction("x"):
        document.add_entity("point", [0, 0])
    document.undo()
    document.redo()
    assert seen == [("P0", False), ("P0", True), ("P0", False)]


def test_unknown_names_are_told_what_there_is() -> None:
    document = two_lines()
    with pytest.raises(AraelError, match=r"E1201[\s\S]*there are L0, L1"):
        document.point_at("L2.p1")
    with pytest.raises(AraelError, match=r"E1202[\s\S]*`L1\.p1`"):
        document.point_at("L1.start")
    with pytest.raises(AraelError, match="E1202"):
        document.point_at("L1")


EDIT = st.one_of(
    st.tuples(st.just("add"), st.sampled_from(sorted(ENTITIES)), st.integers(4, 6)),
    st.tuples(st.just("remove"), st.integers(0, 9), st.just(0)),
    st.tuples(st.just("values"), st.integers(0, 9), st.floats(-1e300, 1e300)),
    st.tuples(st.just("flag"), st.integers(0, 9), st.booleans()),
    st.tuples(st.just("unit"), st.sampled_from(["mm", "in"]), st.just(0)),
    st.tuples(st.just("undo"), st.just(0), st.just(0)),
    st.tuples(st.just("redo"), st.just(0), st.just(0)),
)


def _edit(document: Document, kind: str, a: object, b: object) -> None:
    names = list(document.entities)
    if kind == "undo":
        document.undo()
        return
    if kind == "redo":
        document.redo()
        return
    with document.transaction(kind):
        if kind == "add":
            assert isinstance(a, str) and isinstance(b, int)
            table = ENTITIES[a]
            count = 2 * min(b, table.most or b) if table.poles else len(table.values)
            document.add_entity(a, np.linspace(0, 1, count))
        elif kind == "unit":
            document.set_setting("unit", a)
        elif names:
            assert isinstance(a, int)
            name = names[a % len(names)]
            if kind == "remove":
                document.remove("entities", name)
            elif kind == "values":
                document.set_values([document.entities[name].at], [b])
            else:
                document.put("entities", replace(document.entities[name], quiet=bool(b)))


@settings(deadline=None)
@given(st.lists(EDIT, max_size=30))
def test_any_history_goes_back_and_forth_bit_by_bit(
    edits: list[tuple[str, object, object]],
) -> None:
    document = Document()
    states = [state(document)]
    for edit in edits:
        _edit(document, *edit)
        del states[document.history.position :]
        states.append(state(document)) if len(states) == document.history.position else None
    last = state(document)
    back = 0
    while document.undo() is not None:
        back += 1
    assert state(document) == state(Document())
    for _ in range(back):
        document.redo()
    assert state(document) == last


def test_every_kind_has_points_inside_of_its_numbers() -> None:
    for kind, table in ENTITIES.items():
        for name, offset in table.points:
            assert offset + 1 < len(table.values), (kind, name)
            x = table.values[offset]
            assert x in ("x", f"{name}.x"), (kind, name)


def test_an_arc_that_was_drawn_clockwise_starts_where_its_numbers_end() -> None:
    document = Document()
    with document.transaction("x"):
        arc = document.add_entity("arc", [0, 0, 1, 0, 0, 1, 1], clockwise=True)
    assert document.point_at("A0.start") == arc.at + 4
    assert document.point_at("A0.end") == arc.at + 2


def test_entities_are_immutable() -> None:
    with pytest.raises(AttributeError):
        Entity("L0", "line", 0, 4).name = "L1"  # type: ignore[misc]
