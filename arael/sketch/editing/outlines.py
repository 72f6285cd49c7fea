"""Outlines of areas: chains of curves whose ends are joined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets

if TYPE_CHECKING:
    from arael.sketch.geometry import Chain

Same = Callable[[int, int], bool]
"""Whether two points, by offset, are one by coincident relations."""


def outline(document: Document, args: tuple[str, ...], same: Same) -> tuple[str, ...]:
    """The curves of an area in the order in which they follow each other.

    Raises
    ------
    AraelError
        E1222: they are not one closed chain, nor closed each by itself, or ends are not joined.
    """
    found = _chains(document, args)
    gaps = [chain for chain in found if not chain.closed]
    if gaps:
        start, end = _handle(document, args, gaps[0], 0), _handle(document, args, gaps[0], -1)
        raise _refused(f"nothing leads from `{end}` to `{start}`", "connect them by a curve")
    if all(len(chain.links) == 1 for chain in found):
        return args
    if len(found) > 1:
        raise _refused("these are several", "give each outline an area of its own")
    apart = _apart(document, args, found[0], same)
    if apart:
        a, b = apart
        raise _refused(f"`{a}` and `{b}` are in one place, but not joined", f"`coincident {a} {b}`")
    order = [link.number for link in found[0].links]
    at = order.index(0)
    order = order[at:] + order[:at]
    return args if order[1:] == order[:0:-1] else tuple(args[k] for k in order)


def is_open(document: Document, args: tuple[str, ...], same: Same) -> bool:
    """Whether the outline of an area is not closed any more."""
    found = _chains(document, args)
    if all(chain.closed and len(chain.links) == 1 for chain in found):
        return False
    return len(found) > 1 or not found[0].closed or bool(_apart(document, args, found[0], same))


def _chains(document: Document, args: Sequence[str]) -> list[Chain]:
    # imported here: start-up time
    from arael.sketch.geometry import chains, curve_of

    curves = [curve_of(document.entities[a].kind, document.numbers_of(a).tolist()) for a in args]
    size = max((curve.bounds().size for curve in curves), default=0.0)
    return chains(curves, 1e-6 * size)


def _ends(document: Document, args: Sequence[str], chain: Chain, k: int) -> tuple[str, str]:
    """Handles of first and last point of a link of a chain, in the chain's direction."""
    link = chain.links[k]
    entity = document.entities[args[link.number]]
    offsets = point_offsets(entity)
    names = [name for name in ("start", "end", "p1", "p2") if name in offsets]
    names.sort(key=lambda name: offsets[name], reverse=link.backwards)
    return f"{entity.name}.{names[0]}", f"{entity.name}.{names[-1]}"


def _handle(document: Document, args: Sequence[str], chain: Chain, k: int) -> str:
    return _ends(document, args, chain, k)[k]


def _apart(
    document: Document, args: Sequence[str], chain: Chain, same: Same
) -> tuple[str, str] | None:
    """The first two ends that follow each other and are not one point."""
    count = len(chain.links)
    for k in range(count):
        a = _ends(document, args, chain, k)[1]
        b = _ends(document, args, chain, (k + 1) % count)[0]
        if not same(document.point_at(a), document.point_at(b)):
            return a, b
    return None


def _refused(reason: str, proposal: str) -> AraelError:
    message = f"`area` needs curves that make up one closed chain: {reason}"
    return AraelError(Diagnostic("E1222", message, help=(proposal,)))
