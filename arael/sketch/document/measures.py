"""What a dimension's quantity is now: lengths in the document's unit, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from arael.sketch.document.document import Document
from arael.sketch.document.records import Entity

Numbers = list[float]


def measured(document: Document, kind: str, args: tuple[str, ...], mode: str = "") -> float:
    """The quantity of a dimension; never negative but for ``xangle``.

    Parameters
    ----------
    args : handles that a form of the kind takes, see `operands.matched`
    mode : ``supplement`` for the other angle of two lines
    """
    return (
        abs(signed(document, kind, args, mode))
        if kind != "xangle"
        else (signed(document, kind, args, mode))
    )


def signed(document: Document, kind: str, args: tuple[str, ...], mode: str = "") -> float:
    """The quantity with the sign that `Dimension.side` keeps: from the first to the second.

    Distances of a point from a line are positive on its left, of a line from a line where the
    second is on the left of the first, as `_from_edge` says of circles; angles are positive
    counter-clockwise.
    """
    return _MEASURES[kind](document, args, mode)


def _point(document: Document, handle: str) -> tuple[float, float]:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y


def _line(document: Document, name: str) -> Numbers:
    found: Numbers = document.numbers_of(name).tolist()
    return found


def _length(document: Document, args: tuple[str, ...], mode: str) -> float:
    x1, y1, x2, y2 = _line(document, args[0])
    return math.hypot(x2 - x1, y2 - y1)


def _from_line(line: Numbers, x: float, y: float) -> float:
    x1, y1, x2, y2 = line
    length = math.hypot(x2 - x1, y2 - y1)
    if length == 0.0:
        return math.hypot(x - x1, y - y1)
    return ((x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)) / length


def _distance(document: Document, args: tuple[str, ...], mode: str) -> float:
    first, second = (document.entities.get(name) for name in args)
    if second is not None and second.kind in ("circle", "arc"):
        return _from_edge(document, first, second, args, mode)
    if second is None or second.kind == "point":
        (x1, y1), (x2, y2) = _point(document, args[0]), _point(document, args[1])
        return math.hypot(x2 - x1, y2 - y1)
    if second.kind == "line":
        line = _line(document, second.name)
        if first is None or first.kind == "point":
            return _from_line(line, *_point(document, args[0]))
        x1, y1, x2, y2 = _line(document, first.name)
        middle = 0.5 * (line[0] + line[2]), 0.5 * (line[1] + line[3])
        return _from_line([x1, y1, x2, y2], *middle)
    raise AssertionError(second.kind)


def _from_edge(
    document: Document, first: Entity | None, second: Entity, args: tuple[str, ...], mode: str
) -> float:
    """To the edge of a circle, whole also of an arc; 0 where it is crossed.

    Positive outside of it, of concentric circles where the second is larger, of a line with the
    centre on its left.
    """
    x, y, *_ = document.numbers_of(second.name).tolist()
    r = _radius_of(document, second)
    if first is not None and first.kind == "line":
        gap = _from_line(_line(document, first.name), x, y)
        return math.copysign(max(abs(gap) - r, 0.0), gap)
    if first is None or first.kind == "point":
        p, q = _point(document, args[0])
        return math.hypot(p - x, q - y) - r
    p, q, *_ = document.numbers_of(first.name).tolist()
    apart, own = math.hypot(p - x, q - y), _radius_of(document, first)
    if mode == "outside":
        return max(apart - r - own, 0.0)
    return max(abs(r - own) - apart, 0.0) if mode == "inside" else r - own


def _hdistance(document: Document, args: tuple[str, ...], mode: str) -> float:
    return _point(document, args[1])[0] - _point(document, args[0])[0]


def _vdistance(document: Document, args: tuple[str, ...], mode: str) -> float:
    return _point(document, args[1])[1] - _point(document, args[0])[1]


def _radius_of(document: Document, entity: Entity) -> float:
    numbers = document.numbers_of(entity.name)
    return float(numbers[{"circle": 2, "arc": 6, "ellipse": 2, "earc": 6}[entity.kind]])


def _radius(document: Document, args: tuple[str, ...], mode: str) -> float:
    return _radius_of(document, document.entities[args[0]])


def _diameter(document: Document, args: tuple[str, ...], mode: str) -> float:
    return 2.0 * _radius(document, args, mode)


def _radius_b(document: Document, args: tuple[str, ...], mode: str) -> float:
    entity = document.entities[args[0]]
    return float(document.numbers_of(entity.name)[3 if entity.kind == "ellipse" else 7])


def sweep_of(numbers: Numbers) -> float:
    """Angle of an arc from start to end, counter-clockwise, in (0, 2 pi]."""
    cx, cy, sx, sy, ex, ey = numbers[:6]
    turn = math.atan2(ey - cy, ex - cx) - math.atan2(sy - cy, sx - cx)
    return turn % math.tau or math.tau


def _sweep(document: Document, args: tuple[str, ...], mode: str) -> float:
    entity = document.entities[args[0]]
    if entity.kind == "circle":
        return 360.0
    return math.degrees(sweep_of(document.numbers_of(entity.name).tolist()))


def _arc_length(document: Document, args: tuple[str, ...], mode: str) -> float:
    return math.radians(_sweep(document, args, mode)) * _radius(document, args, mode)


def _angle(document: Document, args: tuple[str, ...], mode: str) -> float:
    a, b = (_line(document, name) for name in args)
    ux, uy, vx, vy = a[2] - a[0], a[3] - a[1], b[2] - b[0], b[3] - b[1]
    angle = math.degrees(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
    if mode != "supplement":
        return angle
    return math.copysign(180.0 - abs(angle), -angle if angle else 1.0)


def _xangle(document: Document, args: tuple[str, ...], mode: str) -> float:
    entity = document.entities[args[0]]
    if entity.kind == "line":
        x1, y1, x2, y2 = _line(document, entity.name)
        return math.degrees(math.atan2(y2 - y1, x2 - x1))
    rotation = float(document.numbers_of(entity.name)[-1])
    return math.degrees(math.remainder(rotation, math.tau))


def _curve_length(document: Document, entity: Entity) -> float:
    # imported here: start-up time
    from arael.sketch.geometry import curve_of

    if entity.kind == "line":
        return _length(document, (entity.name,), "")
    return curve_of(entity.kind, document.numbers_of(entity.name).tolist()).length()


def _total_length(document: Document, args: tuple[str, ...], mode: str) -> float:
    return sum(_curve_length(document, document.entities[name]) for name in args)


def _area(document: Document, args: tuple[str, ...], mode: str) -> float:
    # imported here: start-up time
    from arael.sketch.geometry import chain_area

    return chain_area(
        [(document.entities[name].kind, document.numbers_of(name).tolist()) for name in args]
    )


_MEASURES: dict[str, Callable[[Document, tuple[str, ...], str], float]] = {
    "length": _length,
    "distance": _distance,
    "hdistance": _hdistance,
    "vdistance": _vdistance,
    "radius": _radius,
    "diameter": _diameter,
    "radius_b": _radius_b,
    "sweep": _sweep,
    "arc_length": _arc_length,
    "angle": _angle,
    "xangle": _xangle,
    "total_length": _total_length,
    "area": _area,
}


def size_of(document: Document) -> float:
    """Length of the diagonal of the box around all points, at least the largest radius."""
    boxes = []
    for entity in document.entities.values():
        numbers = document.numbers_of(entity.name)
        points = (
            numbers[: 2 * (len(numbers) // 2)]
            if entity.kind not in ("circle", "arc")
            else (numbers[:-1])
        )
        if entity.kind in ("ellipse", "earc"):
            points = numbers[:-3]
        spread = (
            0.0
            if entity.kind in ("point", "line", "bezier", "bspline")
            else float(numbers[2 if entity.kind in ("circle", "ellipse") else 6])
        )
        xy = points.reshape(-1, 2)
        boxes += [xy.min(axis=0) - spread, xy.max(axis=0) + spread]
    if not boxes:
        return 1.0
    box = np.array(boxes)
    return float(np.hypot(*(box.max(axis=0) - box.min(axis=0)))) or 1.0
