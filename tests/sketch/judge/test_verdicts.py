"""Verdicts: what a constraint does is known before it is made, and is what happens."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.records import Amount
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

CANDIDATES = [
    ("length", ("L2",), 5.0),
    ("length", ("L2",), 6.0),
    ("length", ("L4",), 2.0),
    ("radius", ("A0",), 0.5),
    ("hdistance", ("L0.p1", "A0.center"), 2.0),
    ("hdistance", ("L0.p1", "L0.p2"), 5.0),
    ("distance", ("L0.p1", "L1.p2"), 34**0.5),
    ("distance", ("L0.p1", "L1.p2"), 6.0),
    ("parallel", ("L0", "L2"), None),
    ("parallel", ("L4", "L5"), None),
    ("perpendicular", ("L0", "L1"), None),
    ("equal", ("L4", "L5"), None),
    ("equal", ("L0", "L2"), None),
    ("tangent", ("L0", "A0"), None),
    ("point_on", ("A0.center", "L4"), None),
]


def drawn() -> Session:
    session = Session()
    session.run(PLATE)
    return session


@pytest.mark.parametrize(("kind", "args", "value"), CANDIDATES)
def test_what_would_help_is_let_in_and_nothing_else(
    kind: str, args: tuple[str, ...], value: float | None
) -> None:
    session = drawn()
    editor = session.editor
    amount = None if value is None else Amount(repr(value), value)
    before = editor.judge.freedoms().total
    said = editor.would_help(kind, args, value=amount)
    words = " ".join([kind, *args, *([] if value is None else [repr(value)])])
    known = kind == "radius"  # a new value of the dimension there is
    if said is None or known:
        return
    if said.kind == "helps":
        session.run(words)
        assert editor.judge.freedoms().total == before - 1
        return
    with pytest.raises(AraelError) as caught:
        session.run(words)
    wanted = {"redundant": "E1230", "impossible": "E1231"}[said.kind]
    assert caught.value.diagnostics[0].code == wanted
    for member in said.members:
        assert f"`{member}`" in str(caught.value)


def test_most_candidates_need_no_trial() -> None:
    editor = drawn().editor
    said = [editor.would_help(kind, args) for kind, args, _ in CANDIDATES]
    assert sum(one is not None for one in said) >= 12


def test_asking_changes_nothing() -> None:
    session = drawn()
    before = session.document.values.tobytes(), dict(session.document.constraints)
    for kind, args, _ in CANDIDATES:
        session.editor.would_help(kind, args)
    assert (session.document.values.tobytes(), dict(session.document.constraints)) == before
    session.editor.layout.check()


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
    monkeypatch.setattr(Judge, "_surely_help", lambda *_: False)
    assert proven == ran()
    assert sum("error" in one for one in proven) >= 3
