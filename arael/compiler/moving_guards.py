"""Guards over parameters: instances switch on and off as the solve goes.

Such a guard is evaluated at each linearisation, into a lane of its own beside the data, and kept
until the next: the costs that a step is judged by are of the same instances. What of a guard looks
at data alone decides beforehand which instances there are.
"""

from __future__ import annotations

from arael.check.typed import BOOL, Apply, Read, Typed
from arael.check.walk import postorder
from arael.symbolic.graph import Graph

LANE = "guard"
"""Key of the input that says whether an instance acts."""


def split(guard: Typed | None) -> tuple[Typed | None, Typed | None]:
    """The part of a guard over data alone, and the part over parameters; None where there is none.

    Both must hold: a guard falls apart at its outermost ``and``.
    """
    still: Typed | None = None
    moving: Typed | None = None
    for part in _conjuncts(guard):
        reads = [n for n in postorder([part]) if isinstance(n, Read)]
        if any(n.version in ("trial", "computed") for n in reads):
            moving = _joined(moving, part)
        else:
            still = _joined(still, part)
    return still, moving


def _conjuncts(guard: Typed | None) -> list[Typed]:
    waiting, found = [guard] if guard is not None else [], []
    while waiting:
        part = waiting.pop()
        if isinstance(part, Apply) and part.name == "and":
            waiting += reversed(part.args)
        else:
            found.append(part)
    return found


def _joined(left: Typed | None, right: Typed) -> Typed:
    if left is None:
        return right
    return Apply(type=BOOL, span=right.span, name="and", args=(left, right))


def switched(g: Graph, residuals: list[int]) -> list[int]:
    """Residuals that are zero, derivatives included, where the guard's lane is."""
    lane, zero = g.input(LANE), g.const(0.0)
    return [g.op("select", lane, r, zero) for r in residuals]
