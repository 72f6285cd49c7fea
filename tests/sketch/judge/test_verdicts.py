"""Verdicts: what a constraint does is known before it is made, and is what happens."""

from __future__ import annotations

import json

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import from_json, to_json
from arael.sketch.judge.judge import Judge

PLATE = """
add_rect 0,0 5,3 hv
length L0 5
length L1 3
add_circle 2,1 0.5
radius A0 0.5
add_line 7,0 9,1
add_line 7,2 9,4
"""


def drawn() -> Session:
    session = Session()
    session.run(PLATE)
    return session


def test_what_holds_nothing_in_this_position_is_let_in_and_said() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 5,0 10,0; length L0 5; length L1 5")
    (reply,) = session.run("hdistance L0.p1 L1.p2 10")
    assert "notice: `hdistance L0.p1 L1.p2 10` takes no degree of freedom" in reply.text
    (reply,) = session.run("xangle L0 0")
    assert "notice" not in reply.text
    assert session.editor.notices == []


CHAIN_OF_RECTANGLES = "\n".join(
    ["add_line 0,0 1,0", "lock L0.p1 0,0", "horizontal L0", "length L0 1"]
    + [
        line
        for k in range(1, 12)
        for line in (
            f"add_line {k},0 {k + 1},0.001",
            f"add_line {k + 1},0.001 {k + 1},5",
            f"horizontal L{2 * k - 1}",
            f"length L{2 * k - 1} 1",
            f"vertical L{2 * k}",
        )
    ]
)


def test_what_adds_to_a_determined_sketch_is_proven_without_a_factor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("the whole sketch was factored")

    monkeypatch.setattr(Judge, "_rank", refuse)
    session = Session()
    session.run(CHAIN_OF_RECTANGLES)
    assert len(session.document.dimensions) == 12


def test_verdicts_are_the_same_with_and_without_proofs(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [
        *CHAIN_OF_RECTANGLES.splitlines(),
        "length L2 4",
        "length L2 5 force",
        "vertical L2",
        "distance L0.p1 L4.p2 6",
        "coincident L2.p2 L4.p2",
        "lock L6.p2 9,9",
        "lock L6.p2",
        "add_arc 0,0 1,1 0.9,0.2",
        "tangent A0 L0",
        "radius A0 1",
        "point_on L8.p2 A0",
        "length L8 2 to 9",
        "equal L10 L12",
        "equal L12 L14",
        "equal L10 L14",
        "parallel L10 L12",
    ]

    def ran() -> list[str]:
        session = Session()
        found = []
        for line in lines:
            try:
                found.append(session.run(line)[0].text)
            except AraelError as refused:
                found.append(str(refused))
        return found

    proven = ran()
    monkeypatch.setattr(Judge, "_surely_help", lambda *_, **__: False)
    assert proven == ran()
    assert sum("error" in one for one in proven) >= 3


# --- how a sketch stands ------------------------------------------------------------------------


def opened(script: str, values: dict[str, float]) -> Session:
    """A sketch as a file that was changed by hand brings it: values were never solved."""
    session = Session()
    session.run(script)
    content = json.loads(to_json(session.document))
    for one in content["dimensions"]:
        if one["name"] in values:
            one["value"] = {"text": repr(values[one["name"]]), "number": values[one["name"]]}
    session.editor = session.make_editor(from_json(json.dumps(content)))
    return session


def standing(session: Session) -> dict[str, str]:
    judge = session.editor.judge
    return {one.name: one.kind for one in judge.standing(judge.freedoms().redundant)}


TRIANGLE = "add_line 0,0 1,0 0.5,0.8 0,0; length L0 1; length L1 1; length L2 1"
TWICE = "add_rect 0,0 5,3 hv; length L0 5; hdistance L0.p1 L0.p2 5 force"


def test_a_sketch_that_holds_has_nothing_wrong() -> None:
    assert standing(drawn()) == {}


def test_the_members_of_a_contradiction_of_a_file_are_impossible() -> None:
    members = ["d0", "d1"]
    assert standing(opened(TWICE, {"d1": 6.0})) == dict.fromkeys(members, "impossible")


def test_a_contradiction_that_only_solving_shows_is_impossible() -> None:
    session = opened(f"{TRIANGLE}; add_line 9,9 12,9; length L3 3", {"d2": 3.0})
    assert standing(session) == dict.fromkeys(["d0", "d1", "d2"], "impossible")


def test_an_edit_elsewhere_in_a_contradictory_file_names_the_contradiction() -> None:
    session = opened(f"{TRIANGLE}; add_line 9,9 12,9", {"d2": 3.0})
    with pytest.raises(AraelError) as caught:
        session.run("length L3 4")
    assert caught.value.diagnostics[0].code == "E1231"
    said = caught.value.diagnostics[0].message
    assert said == "`length L2 3.0` is impossible together with `d0` and `d1`"


def test_each_part_of_a_sketch_has_its_own_contradiction() -> None:
    second = "add_rect 20,0 25,3 hv; length L4 5; hdistance L4.p1 L4.p2 5 force"
    session = opened(f"{TWICE}; {second}", {"d1": 6.0, "d3": 7.0})
    judge = session.editor.judge
    found = judge.standing(judge.freedoms().redundant)
    assert {one.members for one in found} == {("d0", "d1"), ("d2", "d3")}


def test_a_file_that_only_has_to_be_solved_is_not_impossible() -> None:
    assert standing(opened(TRIANGLE, {"d2": 1.5})) == {}


def test_without_time_equations_that_do_not_hold_are_named() -> None:
    judge = opened(TRIANGLE, {"d2": 3.0}).editor.judge
    assert [one.name for one in judge.standing((), seconds=-1.0)] == ["d2"]


def test_what_holds_nothing_in_this_position_only_is_told_from_what_never_does() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 5,0 10,0; length L0 5; length L1 5")
    session.run("hdistance L0.p1 L1.p2 10")
    session.run("distance L0.p2 L0.p1 5 force")
    assert standing(session) == {"d2": "here", "d3": "redundant"}


def test_what_is_partly_redundant_holds_something() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 7,0 9,0; parallel L0 L1; collinear L0 L1")
    assert standing(session).get("C1") is None


def test_redundant_ties_are_redundant() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 5,0 9,4; add_line 5,0 9,-4")
    session.run("coincident L1.p1 L2.p1 force")
    ties = [name for name, kind in standing(session).items() if kind == "redundant"]
    assert len(ties) == 1


def test_numbers_that_can_move_are_known_one_by_one() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; lock L0.p1; horizontal L0")
    assert session.editor.judge.freedoms().moves.tolist() == [False, False, True, False]
