"""Rule: an optional is read only where its presence is proved.

Allowed: ``when info.gps``; ``info.gps and info.gps.quality > 2``; ``if gps then gps.x else 0``; the
constraints of the optional struct itself.

Not allowed: reading ``info.gps.pos`` without a test of ``info.gps``; reading through an optional
ref that only an ``if`` tests. An instance is active only if all rows that its constraint reads
exist, so the test must be in ``when``.
"""

from __future__ import annotations

from collections.abc import Callable

from arael.check.typed import Apply, LookUp, Present, Read, Typed
from arael.check.walk import postorder
from arael.runtime.layout import Step

# "The optional at this path, in the row at the end of these steps, is present."
Fact = tuple[tuple[Step, ...], str]

_NONE: frozenset[Fact] = frozenset()


def facts_of(
    condition: Typed, steps: Callable[[int], tuple[Step, ...]]
) -> tuple[frozenset[Fact], frozenset[Fact]]:
    """The optionals proved present if `condition` holds, and if it does not."""
    facts: dict[Typed, tuple[frozenset[Fact], frozenset[Fact]]] = {}
    for node in postorder([condition]):
        facts[node] = (_NONE, _NONE)
        if isinstance(node, Present):
            facts[node] = (frozenset({(steps(node.slot), node.column)}), _NONE)
        elif isinstance(node, Apply):
            inner = [facts[a] for a in node.args]
            if node.name == "not":
                facts[node] = (inner[0][1], inner[0][0])
            elif node.name == "and":
                (a, b) = inner
                facts[node] = (a[0] | b[0], a[1] & b[1])
            elif node.name == "or":
                (a, b) = inner
                facts[node] = (a[0] & b[0], a[1] | b[1])
    return facts[condition]


def conjuncts(guard: Typed | None) -> list[Typed]:
    """The operands of the outermost ``and`` chain of a guard, which must all hold."""
    waiting, parts = [guard] if guard is not None else [], []
    while waiting:
        part = waiting.pop()
        if isinstance(part, Apply) and part.name == "and":
            waiting += reversed(part.args)
        else:
            parts.append(part)
    return parts


def moves(condition: Typed) -> bool:
    """Whether a condition reads parameters or a look-up, which are evaluated during a solve."""
    return any(
        isinstance(n, LookUp) or (isinstance(n, Read) and n.version in ("trial", "computed"))
        for n in postorder([condition])
    )
