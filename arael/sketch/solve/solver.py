"""The solver of a sketch."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from arael.sketch.layout.layout import Layout
from arael.sketch.solve import newton
from arael.sketch.solve.outcome import Outcome

#: Largest residual of a solved sketch, relative to the size of its component.
TOLERANCE = 1e-10


class Solver:
    """Solves the equations of a layout and writes the result into its document."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout

    def solve(self, touched: Iterable[str] | None = None) -> Outcome:
        """Solve what an edit left open."""
        layout = self.layout
        x = layout.gather().copy()
        if layout.impossible:
            return Outcome("stalled", open=tuple(layout.impossible), fraction=0.0)
        size = float(np.ptp(x)) or 1.0
        status, steps = newton.solve(
            layout.rows, layout.guards, x, TOLERANCE * size, layout.low, layout.high
        )
        r = np.abs(layout.rows.evaluate(x))
        worst = int(np.argmax(r)) if len(r) else -1
        row = layout.owner[worst] if worst >= 0 else ""
        if status != "solved":
            return Outcome(status, (), float(r.max()), row, (), steps, 0.0)
        document = layout.document
        before = document.values.copy()
        with document.transaction("solve"):
            layout.scatter(x)
        moved = np.flatnonzero(before != document.values)
        names = {layout.entity_at(int(k)) for k in moved}
        ordered = tuple(n for n in document.entities if n in names)
        return Outcome(status, ordered, float(r.max(initial=0.0)), row, (), steps)
