"""A drag, frame by frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from arael.diagnostics.records import AraelError
from arael.sketch.editing.operands import canonical
from arael.sketch.solve.outcome import Outcome
from arael.sketch.solve.solver import Drag

if TYPE_CHECKING:
    from arael.sketch.editing.editor import Editor


class Dragging:
    """Points that follow a cursor, while `Editor.dragging` lasts.

    Parameters
    ----------
    editor : of the sketch
    handles : points that are pulled
    """

    def __init__(self, editor: Editor, handles: Sequence[str]) -> None:
        document = editor.document
        self.handles = [canonical(document, handle)[2] for handle in handles]
        self._document = document
        self._editor = editor
        self._size = editor.layout.size
        mine = document.open_transaction
        self._since = len(mine.changes) if mine is not None else 0
        self._drag = Drag(editor.solver, [document.point_at(handle) for handle in self.handles])

    def to(self, *places: tuple[float, float], seconds: float | None = None) -> Outcome:
        """One frame: every point as near to its place as the constraints let it.

        A frame without a solution leaves everything where it was. One whose time is over goes as
        near as it came; with the same places the next goes on.
        """
        return self._frame(lambda: self._drag.move(np.array(places, dtype=np.float64), seconds))

    def by(self, dx: float, dy: float, seconds: float | None = None) -> Outcome:
        """One frame: every point to where it was at the beginning, moved by a vector."""
        return self._frame(lambda: self._drag.shift(dx, dy, seconds))

    def _frame(self, move: Callable[[], Outcome]) -> Outcome:
        """A frame in which something would collapse, or run away, is not made."""
        document = self._document
        before, moves = document.values.copy(), document.moves
        found: list[Outcome] = []
        try:
            with document.transaction("frame"):
                found.append(move())
                self._editor.remaining.check(found[0].moved, before, self._size)
                self._editor.remaining.check_near(before, self._size, moves)
        except AraelError:
            return replace(found[0], status="side", moved=())
        if document.open_transaction is not None:
            document.open_transaction.merge_last(self._since)
        return found[0]
