"""Directions of curves at their ends, for tangents that are found by themselves."""

from __future__ import annotations

import math

from arael.sketch.document.document import Document


def direction_at(document: Document, handle: str) -> tuple[float, float] | None:
    """Unit direction of a line or arc along its course at one of its ends; None for others."""
    name, _, point = handle.partition(".")
    entity = document.entities[name]
    n = document.numbers_of(name).tolist()
    if entity.kind == "line":
        return _unit(n[2] - n[0], n[3] - n[1])
    if entity.kind == "arc" and point in ("start", "end"):
        at = 2 if point == "start" else 4
        return _unit(-(n[at + 1] - n[1]), n[at] - n[0])
    if entity.kind == "earc" and point in ("start", "end"):
        at = 2 if point == "start" else 4
        dx, dy, (rx, ry, turn) = n[at] - n[0], n[at + 1] - n[1], n[6:]
        c, s = math.cos(turn), math.sin(turn)
        u, v = (c * dx + s * dy) / rx, (c * dy - s * dx) / ry
        return _unit(-c * rx * v - s * ry * u, -s * rx * v + c * ry * u)
    if entity.kind in ("bezier", "bspline"):
        i = 0 if point in ("p1", "pole1") else len(n) - 4
        return _unit(n[i + 2] - n[i], n[i + 3] - n[i + 1])
    return None


def _unit(x: float, y: float) -> tuple[float, float] | None:
    length = math.hypot(x, y)
    return (x / length, y / length) if length > 0.0 else None


def nearly_parallel(
    one: tuple[float, float] | None, other: tuple[float, float] | None, degrees: float
) -> bool:
    """Whether two directions differ by at most an angle, either way round."""
    if one is None or other is None:
        return False
    sine = abs(one[0] * other[1] - one[1] * other[0])
    return sine <= math.sin(math.radians(degrees))
