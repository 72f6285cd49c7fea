"""Rule: an optional is read only where it is known to be there.

Allowed: ``when info.gps``; ``info.gps and info.gps.quality > 2``; ``if gps then gps.x else 0``; the
constraints of the optional struct itself.

Not allowed: reading ``info.gps.pos`` where nothing has asked for ``info.gps``.
"""

from __future__ import annotations

from collections.abc import Callable

from arael.check.typed import Apply, Present, Typed
from arael.check.walk import postorder
from arael.runtime.layout import Step

# "The optional at this path, in the row at the end of these steps, is there."
Fact = tuple[tuple[Step, ...], str]

_NONE: frozenset[Fact] = frozenset()


def facts_of(
    condition: Typed, steps: Callable[[int], tuple[Step, ...]]
) -> tuple[frozenset[Fact], frozenset[Fact]]:
    """What is known where `condition` holds, and where it does not."""
    known: dict[int, tuple[frozenset[Fact], frozenset[Fact]]] = {}
    for node in postorder([condition]):
        known[id(node)] = (_NONE, _NONE)
        if isinstance(node, Present):
            known[id(node)] = (frozenset({(steps(node.slot), node.column)}), _NONE)
        elif isinstance(node, Apply):
            inner = [known[id(a)] for a in node.args]
            if node.name == "not":
                known[id(node)] = (inner[0][1], inner[0][0])
            elif node.name == "and":
                (a, b) = inner
                known[id(node)] = (a[0] | b[0], a[1] & b[1])
            elif node.name == "or":
                (a, b) = inner
                known[id(node)] = (a[0] & b[0], a[1] | b[1])
    return known[id(condition)]
