"""Every set of culprits is minimal: without any one of its members there is room."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.properties.generator import snapshot
from tests.sketch.properties.test_exact_rank import Exact


def members(session: Session, error: AraelError) -> list[str]:
    """Names that a refusal lists."""
    document = session.document
    tables = (document.constraints, document.dimensions)
    quoted = error.diagnostics[0].message.split("`")[1::2]
    return [name for name in quoted if any(name in table for table in tables)]


def proven(session: Session, line: str) -> int:
    """Leave out each member of a refusal of `line` in turn; how many there were."""
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert caught.value.diagnostics[0].code in ("E1230", "E1231")
    found = members(session, caught.value)
    before = snapshot(session.document)
    for name in found:
        session.run(f"delete {name}")
        session.run(line)  # not refused
        session.run("undo 2")
        assert snapshot(session.document) == before
    return len(found)


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 6])
def test_redundant_ones_are_independent_without_any_member(seed: int) -> None:
    exact = Exact(seed)
    candidates = exact.candidates()
    exact.random.shuffle(candidates)
    total = 0
    for line, _ in candidates[:24]:
        if line.startswith("lock"):
            continue
        try:
            exact.session.run(line)
        except AraelError as error:
            if error.diagnostics[0].code != "E1221":
                total += proven(exact.session, line)
    assert total > 0


#: A script, and what contradicts it.
CONTRADICTIONS = [
    ("add_line 0,0 1,0 0.5,1 0,0; length L0 1; length L1 1", "length L2 3", 2),
    ("add_line 0,0 3,0 3,4 0,0; length L0 3; length L1 4; perpendicular L0 L1", "length L2 9", 2),
    ("add_line 0,0 4,0; length L0 4; add_point 1,1; distance P0 L0.p1 1", "distance P0 L0.p2 9", 2),
    (
        "add_line 0,0 2,0 3,2 1,3 0,0; length L0 2; length L1 2; length L2 2",
        "length L3 9",
        3,
    ),
]


#: What a collapse alone would solve: that is no solution.
COLLAPSES = [
    ("add_line 0,0 5,0; horizontal L0", "vertical L0", 1),
    ("add_line 0,0 5,0; horizontal L0; length L0 5", "vertical L0", 1),
    ("add_line 0,0 5,0 5,3; coincident L1.p2 L0.p1; horizontal L0", "vertical L1", 1),
    ("add_circle -9,2 0.5; add_line A0.center -3,-2.6", "tangent L0 A0", 1),
]
#: Points that are held far apart in a drawing that hangs together.
FAR = "add_line 0,0 " + " ".join(f"{i},{i % 2}" for i in range(1, 80))
HELD = [
    (f"{FAR}; lock L0.p1; lock L70.p2", "distance L0.p1 L70.p2 99", 2),
    (f"{FAR}; fix L0; lock L70.p2", "hdistance L0.p1 L70.p2 99", 2),
]


@pytest.mark.parametrize(("script", "line", "count"), [*CONTRADICTIONS, *COLLAPSES, *HELD])
def test_contradictions_are_solvable_without_any_member(script: str, line: str, count: int) -> None:
    session = Session()
    session.run(script)
    assert proven(session, line) == count


def test_a_chain_of_directions_that_only_a_collapse_would_solve_is_named() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 0,2 5,2; horizontal L0; parallel L0 L1")
    before = snapshot(session.document)
    with pytest.raises(AraelError) as caught:
        session.run("vertical L1")
    assert caught.value.diagnostics[0].code == "E1231"
    assert members(session, caught.value) == ["CL0H", "C0"]
    assert snapshot(session.document) == before
