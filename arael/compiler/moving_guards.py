"""Guards over parameters: instances become active and inactive during a solve.

Such a guard is evaluated at each linearisation, into a separate lane beside the data, and kept
until the next, so that linearisation and trial cost use the same active instances. The terms of a
guard over data alone select the instances before the solve.
"""

from __future__ import annotations

from arael.check.guards import conjuncts, moves
from arael.check.typed import BOOL, Apply, Typed
from arael.symbolic.graph import Graph

LANE = "guard"
"""Key of the input that is 1 if an instance is active, else 0."""


def split(guard: Typed | None) -> tuple[Typed | None, Typed | None]:
    """The part of a guard over data alone, and the part over parameters; None where there is none.

    Both must hold: a guard is split at its outermost ``and``.
    """
    still: Typed | None = None
    moving: Typed | None = None
    for part in conjuncts(guard):
        if moves(part):
            moving = _joined(moving, part)
        else:
            still = _joined(still, part)
    return still, moving


def _joined(left: Typed | None, right: Typed) -> Typed:
    if left is None:
        return right
    return Apply(type=BOOL, span=right.span, name="and", args=(left, right))


def switched(g: Graph, residuals: list[int]) -> list[int]:
    """Residuals that are zero, derivatives included, where the guard's lane is."""
    lane, zero = g.input(LANE), g.const(0.0)
    return [g.op("select", lane, r, zero) for r in residuals]
