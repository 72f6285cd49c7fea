"""Chains of curves: order, length, area."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.vectors import Point, gap


class Link(NamedTuple):
    """A curve of a chain: its number in the given list, and whether it runs backwards."""

    number: int
    backwards: bool


class Chain(NamedTuple):
    """Curves joined end to end."""

    links: tuple[Link, ...]
    closed: bool

    def curves(self, of: Sequence[Curve]) -> list[Curve]:
        """The curves, each in the direction of the chain."""
        return [of[i].reversed() if back else of[i] for i, back in self.links]


def chains(curves: Sequence[Curve], tolerance: float) -> list[Chain]:
    """Maximal chains of curves whose ends meet within `tolerance`.

    Circles, ellipses, and curves that return to their start are closed chains of one. At a point
    where three or more ends meet, chains end.
    """
    found: list[Chain] = []
    ends: list[tuple[Point, int, bool]] = []
    for i, curve in enumerate(curves):
        if curve.closed or gap(curve.start, curve.end) <= tolerance < 0.5 * curve.length():
            found.append(Chain((Link(i, False),), True))
        else:
            ends += [(curve.start, i, False), (curve.end, i, True)]
    node = clusters([point for point, _, _ in ends], tolerance)
    meeting: dict[int, list[int]] = {}
    for k, n in enumerate(node):
        meeting.setdefault(n, []).append(k)
    # the other end at a joint of exactly two
    partner = {}
    for at in meeting.values():
        if len(at) == 2 and ends[at[0]][1] != ends[at[1]][1]:
            partner[at[0]], partner[at[1]] = at[1], at[0]
    used: set[int] = set()
    # open chains from their first end; what is left then are loops
    starts = [k for k in range(len(ends)) if k not in partner]
    for k in (*starts, *range(len(ends))):
        if ends[k][1] in used:
            continue
        links = []
        here = k
        while True:
            _, i, is_end = ends[here]
            used.add(i)
            links.append(Link(i, is_end))
            far = here - 1 if is_end else here + 1
            following = partner.get(far)
            if following is None or ends[following][1] in used:
                break
            here = following
        found.append(Chain(tuple(links), following is not None))
    return sorted(found, key=lambda chain: min(link.number for link in chain.links))


def clusters(points: Sequence[Point], tolerance: float) -> list[int]:
    """Number of the cluster of each point: those within `tolerance`, found on a grid."""
    cell = tolerance if tolerance > 0 else 1e-300
    grid: dict[tuple[float, float], list[int]] = {}
    node: list[int] = []
    for k, (x, y) in enumerate(points):
        i, j = x // cell, y // cell
        close = (
            other
            for di in (-1.0, 0.0, 1.0)
            for dj in (-1.0, 0.0, 1.0)
            for other in grid.get((i + di, j + dj), ())
            if gap(points[other], (x, y)) <= tolerance
        )
        first = next(close, None)
        node.append(k if first is None else node[first])
        grid.setdefault((i, j), []).append(k)
    return node


def chain_length(curves: Iterable[Curve]) -> float:
    """Sum of the lengths."""
    return sum(curve.length() for curve in curves)


def area(curves: Sequence[Curve]) -> float:
    """Signed area enclosed by curves that follow each other, positive counter-clockwise.

    Each curve starts where the one before ends, and the first where the last ends; small gaps are
    bridged by straight lines. Exact for every kind of curve.
    """
    if not curves:
        return 0.0
    origin = curves[0].start
    total = sum(curve.area_about(origin) for curve in curves)
    if len(curves) == 1 and curves[0].closed:
        return total
    joints = [*pairwise(curves), (curves[-1], curves[0])]
    for before, after in joints:
        (x1, y1), (x2, y2) = before.end, after.start
        total += 0.5 * ((x1 - origin[0]) * (y2 - origin[1]) - (x2 - origin[0]) * (y1 - origin[1]))
    return total
