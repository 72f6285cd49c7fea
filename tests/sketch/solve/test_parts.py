"""What an edit costs does not grow with parts of the drawing that it does not touch."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.layout.layout import Layout
from arael.sketch.solve.solver import Solver
from tests.sketch.properties.generator import Generator, perform

EDITS = (
    "add_rect 0,-20 5,-17 hv",
    "length {0} 6",
    "lock {0}.p1",
    "length {0} 9",
    "add_circle 2,-18 1 noconnect",
    "radius {5} 0.5",
    "angle {0} {1} 90 derived",
    "delete {1}",
)


def drawn(rectangles: int) -> Session:
    session = Session()
    for k in range(rectangles):
        x, y = k % 20 * 10, k // 20 * 10
        session.run(f"add_rect {x},{y} {x + 5},{y + 3} hv")
    return session


def evaluated(session: Session) -> list[int]:
    """Equations and sides that were evaluated, by edit."""
    layout = session.editor.layout
    numbers = sorted(int(name[1:]) for name in session.document.entities)
    names = [f"L{numbers[-1] + 1 + k}" for k in range(5)] + ["A0"]
    found = []
    for edit in EDITS:
        before = layout.rows.evaluated + layout.guards.evaluated
        session.run(edit.format(*names))
        found.append(layout.rows.evaluated + layout.guards.evaluated - before)
    return found


def test_an_edit_evaluates_only_what_hangs_together_with_it() -> None:
    small, large = (evaluated(drawn(count)) for count in (40, 120))
    # Rows are evaluated eight at a time.
    assert all(b <= a + 8 * 40 for a, b in zip(small, large, strict=True)), (small, large)
    assert sum(large) < 1.2 * sum(small), (small, large)


def accepted(session: Session, line: str) -> bool:
    try:
        perform(session, line)
    except AraelError:
        return False
    return True


@pytest.mark.parametrize("seed", range(3))
def test_parts_alone_are_solved_as_with_everything_else(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = Session()
    generator = Generator(session, seed)
    layout, document = session.editor.layout, session.document
    solved_alone = 0
    monkeypatch.setattr("arael.sketch.layout.layout.LEAST_REST", 1)
    for _ in range(30):
        line = generator.line()
        if line.startswith("add_line") and len(line.split()) == 2:
            continue  # it begins where the last one ends, which is not undone
        position = document.history.position
        monkeypatch.setattr("arael.sketch.layout.layout.MOST_IN_PART", 0)
        whole = accepted(session, line)
        if document.history.position > position:
            document.undo()
        monkeypatch.setattr("arael.sketch.layout.layout.MOST_IN_PART", 10**6)
        solved_alone += layout.part() is not None
        assert accepted(session, line) == whole, line
        layout.check()
        fresh = Layout(document)
        assert not Solver(fresh).left_open(), line
        fresh.detach()
    assert solved_alone > 5
