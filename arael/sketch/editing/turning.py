"""Where a line starts that is to have quite another direction.

From across, the nearest solution of ``vertical`` is a line without length. So a line that deviates
by more than 30 degrees from the direction that a new relation wants is turned there first.
"""

from __future__ import annotations

import math

from arael.sketch.document.document import Document

_FAR = math.radians(30.0)

Moves = dict[int, tuple[float, float]]
"""Offset of the x of a point -> where to."""


def turned(document: Document, kind: str, args: tuple[str, ...]) -> Moves:
    """Places of points with which a relation of directions starts; empty if it can start as it is.

    The second operand is turned: about the end that others hold, else about its middle. Points
    that are coincident with its ends move along.
    """
    found = _wanted(document, kind, args)
    if found is None:
        return {}
    name, direction = found
    x1, y1, x2, y2 = document.numbers_of(name).tolist()
    off = math.remainder(math.atan2(y2 - y1, x2 - x1) - direction, math.pi)
    if abs(off) < _FAR:
        return {}
    ties = [_tied(document, f"{name}.p1"), _tied(document, f"{name}.p2")]
    held = [_is_held(document, name, tied) for tied in ties]
    share = {(True, False): 0.0, (False, True): 1.0}.get((held[0], held[1]), 0.5)
    px, py = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
    c, s = math.cos(-off), math.sin(-off)
    moves: Moves = {}
    for tied, x, y in zip(ties, (x1, x2), (y1, y2), strict=True):
        to = px + c * (x - px) - s * (y - py), py + s * (x - px) + c * (y - py)
        moves |= {document.point_at(handle): to for handle in tied}
    return moves


def _wanted(document: Document, kind: str, args: tuple[str, ...]) -> tuple[str, float] | None:
    """The line that is to be turned, and the direction (radians) that it is to have."""
    names = [arg.partition(".")[0] for arg in args]
    if any(document.entities[name].kind != "line" for name in names):
        return None
    if kind in ("horizontal", "vertical") and len(set(names)) == 1:
        return names[0], 0.0 if kind == "horizontal" else 0.5 * math.pi
    if kind in ("parallel", "collinear", "perpendicular") and len(names) == 2:
        x1, y1, x2, y2 = document.numbers_of(names[0]).tolist()
        direction = math.atan2(y2 - y1, x2 - x1)
        return names[1], direction + (0.5 * math.pi if kind == "perpendicular" else 0.0)
    return None


def _tied(document: Document, start: str) -> list[str]:
    """Handles at one place with one, by coincident relations."""
    found = {start: None}
    waiting = [start]
    pairs = [
        one.args for one in document.constraints.values() if one.kind == "coincident" and one.active
    ]
    while waiting:
        here = waiting.pop()
        for a, b in pairs:
            for one, other in ((a, b), (b, a)):
                if one == here and other not in found:
                    found[other] = None
                    waiting.append(other)
    return list(found)


def _is_held(document: Document, line: str, tied: list[str]) -> bool:
    """Whether something else is at an end, or locks it."""
    if len(tied) > 1:
        return True
    return any(
        one.kind in ("lock", "fix", "point_on", "midpoint") and one.args[0] in (*tied, line)
        for one in document.constraints.values()
    )
