"""A drag of one window, frame by frame, one step of undo."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.editing.dragging import Dragging
from arael.sketch.editing.editor import Editor
from arael.sketch.server.windows import Window
from arael.sketch.solve.outcome import Outcome
from arael.sketch.solve.solver import Drag

MAX_HANDLES = 10_000
"""Points that are dragged at once."""

FRAME_SECONDS = 0.004
"""Time of the solver for a frame: the rest of a refresh of the screen is for the page."""

LAST_SECONDS = 0.25
"""Time of the solver for the last frame, if those before it did not reach their place."""


class _Cancelled(Exception):
    """Takes a drag back."""


class OpenDrag:
    """Points that follow the pointer of a window, until `end`.

    Parameters
    ----------
    editor : of the sketch
    window : whose pointer it is
    handles : points, or names of entities, all points of which move; ``A0.radius``: a radius
    at : where the pointer was at the beginning

    Attributes
    ----------
    unfinished : whether the last frame ended because its time was over

    Raises
    ------
    AraelError
        E1201, E1202: there is no such thing; E1402: nothing to drag
    """

    def __init__(
        self, editor: Editor, window: Window, handles: Sequence[str], at: tuple[float, float]
    ) -> None:
        self.window = window
        self.began = at
        self.unfinished = False
        self._place = at
        self._stack = ExitStack()
        document = editor.document
        points = _points(document, handles)
        radius = next((one for one in handles if one.endswith((".radius", ".radius_b"))), "")
        self._radius = _Radius(editor, radius) if radius else None
        if not points and self._radius is None:
            raise AraelError(Diagnostic("E1402", "expected something to drag, found nothing"))
        self._document = document
        if self._radius is not None:
            self._stack.enter_context(document.transaction(f"drag {radius}"))
            self._drag: Dragging | None = None
        else:
            self._drag = self._stack.enter_context(editor.dragging(points))

    def to(self, x: float, y: float, seconds: float = FRAME_SECONDS) -> NDArray[np.float64]:
        """One frame, and all numbers after it; without a solution nothing moves.

        Parameters
        ----------
        x, y : where the pointer is
        seconds : time of the solver, after which the frame is as near as it came
        """
        self._place = (x, y)
        found: Outcome | None = None
        if self._drag is not None:
            found = self._drag.by(x - self.began[0], y - self.began[1], seconds)
        elif self._radius is not None:
            found = self._radius.to(x, y, seconds)
        self.unfinished = found is not None and found.solved and not found.converged
        return self._document.values.copy()

    def go_on(self) -> NDArray[np.float64]:
        """Another frame at the same place, after one that is unfinished; all numbers after it."""
        before = self._document.values.copy()
        values = self.to(*self._place)
        self.unfinished = self.unfinished and not np.array_equal(before, values)
        return values

    def end(self, cancel: bool = False) -> None:
        """Keep the last frame as one step of undo, or take the drag back."""
        if not cancel:
            with self._stack:
                if self.unfinished:
                    self.to(*self._place, LAST_SECONDS)
            return
        try:
            with self._stack:
                raise _Cancelled
        except _Cancelled:
            pass


class _Radius:
    """A radius that follows the distance of the pointer from the centre."""

    def __init__(self, editor: Editor, handle: str) -> None:
        name, _, which = handle.partition(".")
        entity = editor.document.entity(name)
        if entity.kind not in ("circle", "arc", "ellipse", "earc") or (
            which == "radius_b" and entity.kind in ("circle", "arc")
        ):
            raise AraelError(
                Diagnostic("E1402", f"`{handle}` cannot be dragged: {name} is a {entity.kind}")
            )
        self._document = editor.document
        self._center = entity.at
        self._offset = entity.at + ENTITIES[entity.kind].values.index(which)
        self._drag = Drag(editor.solver, [])

    def to(self, x: float, y: float, seconds: float) -> Outcome | None:
        values = self._document.values
        reach = float(np.hypot(x - values[self._center], y - values[self._center + 1]))
        if reach <= 0.0:
            return None
        return self._drag.pull([self._offset], [reach], seconds)


def _points(document: Document, handles: Sequence[str]) -> list[str]:
    """Handles of points; those of an entity for its name."""
    found: dict[str, None] = {}
    for handle in handles:
        name, dot, point = handle.partition(".")
        entity = document.entity(name)
        if point in ("radius", "radius_b"):
            continue
        if dot:
            document.point_at(handle)
            found[handle] = None
        else:
            for one in point_offsets(entity):
                found[f"{name}.{one}"] = None
    if len(found) > MAX_HANDLES:
        message = f"{len(found):,} points to drag; at most {MAX_HANDLES:,}"
        raise AraelError(Diagnostic("E1402", message))
    return list(found)
