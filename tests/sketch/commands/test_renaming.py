"""`rename`: entities and dimensions under other names, with everything that refers to them."""

from __future__ import annotations

import json
import re

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.importing import take_over
from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, to_json

#: Every kind of record that refers to L0, A0 or d0: operands, own constraints, expressions, groups.
SCENE = """
add_rect 0,0 60,40
length L0 60
length L1 d0*2/3
param half L0.length/2
add_circle 20,20 5
radius A0 d0/12
distance L0 A0 L0.length/3
add_line 0,-30 9,-30
parallel L4 L0; vdistance L4.p1 L0.p1 d0/2
add_spline 70,0 75,5 80,5 85,0
coincident S0.p1 L0.p2
pattern circular A0 about L0.p1 4
pattern rect L4 3 d0/4 along L0
offset L0 L1 4
"""


@pytest.fixture
def session() -> Session:
    made = Session()
    made.run(SCENE)
    return made


def code(session: Session, text: str) -> str:
    with pytest.raises(AraelError) as caught:
        session.run(text)
    return caught.value.diagnostics[0].code


def replaced(data: bytes, old: str, new: str) -> dict[str, object]:
    """A file with one name put for another in its text."""
    text = re.sub(rf"(?<![\w.]){old}(?!\w)", new, data.decode())
    text = re.sub(rf"\bC{old}([HV])\b", rf"C{new}\1", text)
    found: dict[str, object] = json.loads(text)
    return found


@pytest.mark.parametrize(
    ("old", "new"), [("L0", "base1"), ("A0", "bore1"), ("d0", "width1"), ("L1", "L77")]
)
def test_a_file_differs_by_the_name_alone(session: Session, old: str, new: str) -> None:
    before = to_json(session.document)
    numbers = session.document.values.tobytes()
    assert session.run(f"rename {old} {new}")[0].text == f"Renamed {old} to {new}"
    expected = replaced(before, old, new)
    found = json.loads(to_json(session.document))
    if new == "L77":
        assert found["counters"].pop("L") == 78
        expected["counters"].pop("L")  # type: ignore[attr-defined]
    assert found == expected
    assert session.document.values.tobytes() == numbers
    assert to_json(from_json(to_json(session.document))) == to_json(session.document)
    session.run("undo")
    assert to_json(session.document) == before
    session.run("redo")
    assert json.loads(to_json(session.document))["entities"] == expected["entities"]


def test_the_sketch_goes_on_as_it_would_have() -> None:
    """Solved, judged and edited under the new names as under the old ones."""
    plain, renamed = Session(), Session()
    for one in (plain, renamed):
        one.run(SCENE)
    renamed.run("rename L0 base1; rename d0 width1; rename A0 bore1")
    plain.run("set_driven d0 48")
    renamed.run("set_driven width1 48")
    assert renamed.document.values == pytest.approx(plain.document.values, abs=1e-9)
    assert renamed.document.parameters["half"].amount.number == pytest.approx(24)
    freedoms = [one.run("dof")[0].text.partition(";")[0] for one in (plain, renamed)]
    assert freedoms[0] == freedoms[1]
    assert code(renamed, "distance base1.p1 base1.p2 5") == code(plain, "distance L0.p1 L0.p2 5")
    renamed.run("delete bore1")
    plain.run("delete A0")
    assert list(renamed.document.dimensions) == [
        "width1" if one == "d0" else one for one in plain.document.dimensions
    ]


def test_variables_and_selection_follow(session: Session) -> None:
    session.run("edge = L0\nselect L0 L1\nrename L0 base1")
    assert session.state.variables["edge"] == "base1"
    assert session.selection == ["base1", "L1"]
    session.run("rename base1 base2; print edge")
    assert session.document.entities["base2"].kind == "line"


def test_new_names_begin_behind_one_that_was_given(session: Session) -> None:
    session.run("rename L1 L77\nmade = add_line 100,0 101,0")
    assert session.state.variables["made"] == "L78"


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("rename L0 base", "E1255"),  # no number: a name of parameters
        ("rename L0 A7", "E1255"),  # another kind's
        ("rename d0 M3", "E1255"),
        ("rename L0 L1", "E1255"),  # there is one
        ("rename L0 p1", "E1255"),  # a point
        ("rename L0 atan2", "E1255"),  # a function
        ("rename L0 v1", "E1255"),  # a variable
        ("rename L0 half", "E1255"),  # a parameter
        ("rename L0 a" + "b" * 40 + "1", "E1255"),
        ("rename L0 \u0661", "E1255"),
        ("rename L9 base1", "E1256"),
        ("rename half base1", "E1256"),
        ("rename L0", "E1251"),
        ("rename L0 base1 base2", "E1252"),
    ],
)
def test_what_is_refused_changes_nothing(session: Session, command: str, expected: str) -> None:
    session.run("v1 = 3")
    before = to_json(session.document)
    assert code(session, command) == expected
    assert to_json(session.document) == before


def test_a_name_means_one_thing(session: Session) -> None:
    session.run("rename L0 base1")
    assert code(session, "base1 = 4") == "E1255"
    assert code(session, "param base1 4") == "E1255"
    session.run("undo\nbase1 = L1\nredo")  # the variable was made meanwhile
    assert session.run("info base1")[0].text.startswith("base1")


@pytest.mark.parametrize("name", ["C1", "A1", "base", "base1.p1", "b" * 41 + "1", "base\u0661"])
def test_files_with_other_names_are_refused(session: Session, name: str) -> None:
    data = to_json(session.document).replace(b'"S0"', json.dumps(name).encode())
    with pytest.raises(AraelError) as caught:
        from_json(data)
    assert caught.value.diagnostics[0].code == "E1211"


def test_names_that_are_taken_are_counted_on_when_a_file_comes_in() -> None:
    other = Session()
    other.run("add_line 0,0 5,0; horizontal L0; rename L0 base1; param w2 7")
    other.run("length base1 5; rename d0 width1")
    session = Session()
    session.run("add_line 0,9 5,9; rename L0 base1; param w2 8")
    names = take_over(session, other.document)
    assert names == {"base1": "base2", "w2": "w3", "width1": "width1", "Cbase1H": "Cbase2H"}
    assert session.document.dimensions["width1"].args == ("base2",)
    again: Document = from_json(to_json(session.document))  # its counters are those of kinds alone
    assert list(again.entities) == ["base1", "base2"]
