"""Documents as JSON: the same sketch comes back; anything else is refused with its place."""

from __future__ import annotations

from pathlib import Path

import hypothesis.strategies as st
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS, ENTITIES
from arael.sketch.document.records import Amount, Constraint, Dimension, Group, Parameter
from arael.sketch.document.saved import from_json, load, save, to_json


def everything() -> Document:
    """One of each kind of entity, and of the records that fit without looking at geometry."""
    document = Document()
    with document.transaction("all"):
        document.set_setting("unit", "in")
        for kind, table in ENTITIES.items():
            count = 8 if table.poles else len(table.values)
            document.add_entity(
                kind,
                0.1 + np.arange(count) / 3,
                construction=kind == "line",
                clockwise=kind == "arc",
            )
        document.add_entity("line", [0, 0, 0.1, -0.0], style="dashed", quiet=True)
        put = document.put
        put("parameters", Parameter("width", Amount("12 mm", 12.0)))
        put("constraints", Constraint("CL0H", "horizontal", ("L0",)))
        put("constraints", Constraint(document.next_name("C"), "coincident", ("L0.p2", "P0")))
        put("constraints", Constraint(document.next_name("C"), "lock", ("A1.start",), (1.0, 2.0)))
        put("constraints", Constraint(document.next_name("C"), "tangent", ("L1", "A0"), side=-1))
        d = Dimension(document.next_name("d"), "length", ("L0",), Amount("width/2", 6.0))
        put("dimensions", d)
        low, high = Amount("1", 1.0), Amount("2", 2.0)
        between = Dimension(document.next_name("d"), "radius", ("A0",), low=low, high=high)
        put("dimensions", between)
        chain = Dimension(document.next_name("d"), "total_length", ("L0", "A1", "L1"), low)
        put("dimensions", chain)
        options = {"n": 3, "by": 2.5, "about": "P0", "cells": (1.0, 2.0), "names": ("L0",)}
        group = Group(document.next_name("M"), "pattern", ("L0",), ("L1",), ("C1",), options)
        put("groups", group)
    return document


def test_the_same_sketch_comes_back() -> None:
    document = everything()
    again = from_json(to_json(document))
    assert to_json(again) == to_json(document)
    for table in ("entities", "constraints", "dimensions", "parameters", "groups"):
        assert getattr(again, table) == getattr(document, table)
    assert again.values.tobytes() == document.values.tobytes()
    assert again.history.position == 0


def test_names_go_on_after_those_of_the_file() -> None:
    data = msgspec.json.decode(to_json(everything()))
    data["counters"] = {}
    document = from_json(msgspec.json.encode(data))
    with document.transaction("x"):
        assert document.next_name("L") == "L2"
        assert document.next_name("EA") == "EA2"


def test_numbers_of_deleted_entities_are_dropped_by_saving() -> None:
    document = everything()
    with document.transaction("delete"):
        document.remove("entities", "S1")
    assert len(from_json(to_json(document)).values) == len(document.values) - 8


def test_a_file_is_written_whole_and_read_again(tmp_path: Path) -> None:
    save(everything(), tmp_path / "a.json")
    assert to_json(load(tmp_path / "a.json")) == to_json(everything())
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"null",
        b"[1]",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"format": "arael-sketch", "version": 2}',
        b'{"format": "other", "version": 1}',
        b'{"format": "arael-sketch", "version": 1, "lines": []}',
        b'{"format": "arael-sketch", "version": 1, "entities": [{"name": "L0"}]}',
    ],
)
def test_what_is_no_sketch_says_so(data: bytes) -> None:
    with pytest.raises(AraelError, match=r"a\.json.*E1210"):
        from_json(data, "a.json")


WRONG = [
    ("entities.1.kind", "circl", r"entities\[1\]: `circl`"),
    ("entities.1.name", "P1", r"entities\[1\]: `P1`"),
    ("entities.1.name", "L0.p1", "not a name"),
    ("entities.1.name", "P0", "used twice"),
    ("entities.1.values", [1, 2, 3], "has 4 numbers"),
    ("entities.6.values", [1.0] * 10, "has 8 numbers"),
    ("entities.1.values", [1e101, 0.0, 1.0, 1.0], r"entities\[1\]: a number is above 1e\+100"),
    ("entities.2.values", [0.0, 0.0, -1.0], "a circle has a radius above 0"),
    ("entities.1.clockwise", True, "has no direction"),
    ("entities.1.style", "wavy", "not a style"),
    ("constraints.1.kind", "near", r"constraints\[1\]: `near`"),
    ("constraints.1.args", ["L0.p2"], "does not take L0.p2"),
    ("constraints.1.args", ["L0.p2", "L9.p1"], "no entity `L9.p1`"),
    ("constraints.1.args", ["L0.p2", "A0.start"], "`A0.start` is not a point"),
    ("constraints.2.numbers", [1.0], "has 2 numbers"),
    ("constraints.3.side", 5, "side"),
    ("constraints.3.mode", "upside", "mode"),
    ("constraints.0.name", "CL1H", "not a name"),
    ("dimensions.0.kind", "volume", "`volume`"),
    ("dimensions.0.value", None, "either a value or a range"),
    ("dimensions.2.args", ["L0", "P0"], "does not take"),
    ("dimensions.2.args", [], "does not take"),
    ("parameters.0.name", "a b", "not a name of a parameter"),
    ("groups.0.kind", "heap", "`heap`"),
    ("groups.0.results", ["L7"], "no entity `L7`"),
    ("groups.0.owned", ["C7"], "no constraint or dimension `C7`"),
    ("groups.0.options", {"deep": {"x": 1}}, "neither text"),
    ("unit", "furlong", "`furlong`"),
    ("counters", {"Q": 1}, "not a counter"),
]


@pytest.mark.parametrize(("place", "value", "message"), WRONG)
def test_an_entry_that_cannot_be_is_named(place: str, value: object, message: str) -> None:
    data = msgspec.json.decode(to_json(everything()))
    *steps, last = [int(step) if step.isdigit() else step for step in place.split(".")]
    target = data
    for step in steps:
        target = target[step]
    target[last] = value
    with pytest.raises(AraelError, match=f"E1211.*{message}"):
        from_json(msgspec.json.encode(data))


@settings(deadline=None)
@given(st.data())
def test_damaged_files_give_a_message_never_a_traceback(data: st.DataObject) -> None:
    text = bytearray(to_json(everything()))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    try:
        from_json(bytes(text))
    except AraelError as error:
        assert error.diagnostics[0].code in ("E1210", "E1211")


def test_tables_name_operands_that_exist() -> None:
    from arael.sketch.document.kinds import OPERANDS

    for kind in (*CONSTRAINTS.values(), *DIMENSIONS.values()):
        for form in kind.forms:
            assert {operand.removesuffix("*") for operand in form.operands} <= set(OPERANDS)
