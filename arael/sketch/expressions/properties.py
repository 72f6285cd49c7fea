"""What expressions read of geometry: ``L0.length``, ``A0.center.x``, ``EA0.rotation``."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.records import Entity
from arael.sketch.expressions.shapes import curve_of

Numbers = Sequence[float]
TURN = 2.0 * math.pi


def _direction(v: Numbers, at: int, of: int) -> float:
    return math.atan2(v[at + 1] - v[of + 1], v[at] - v[of])


def _in_turn(angle: float) -> float:
    """An angle in [0, 2 pi)."""
    return angle % TURN


def _sweep(v: Numbers) -> float:
    """Counter-clockwise angle from start to end of an arc, in (0, 2 pi]."""
    return _in_turn(_direction(v, 4, 0) - _direction(v, 2, 0)) or TURN


def _parameter(v: Numbers, at: int) -> float:
    """Parameter of a point on an elliptic arc, from its first axis."""
    rx, ry, rot = v[6], v[7], v[8]
    dx, dy = v[at] - v[0], v[at + 1] - v[1]
    c, s = math.cos(rot), math.sin(rot)
    return math.atan2((-s * dx + c * dy) / ry, (c * dx + s * dy) / rx)


def _length(v: Numbers) -> float:
    return math.hypot(v[2] - v[0], v[3] - v[1])


#: Kinds whose length has no closed form of their numbers.
_BY_CURVE = frozenset({"ellipse", "earc", "bezier", "bspline"})

#: Properties that are not numbers of the entity itself; angles in degrees.
PROPERTIES: dict[str, dict[str, Callable[[Numbers], float]]] = {
    "point": {},
    "line": {
        "length": _length,
        "angle": lambda v: math.degrees(_direction(v, 2, 0)),
    },
    "circle": {
        "radius": lambda v: v[2],
        "diameter": lambda v: 2.0 * v[2],
        "length": lambda v: TURN * v[2],
        "sweep": lambda v: 360.0,
    },
    "arc": {
        "radius": lambda v: v[6],
        "diameter": lambda v: 2.0 * v[6],
        "sweep": lambda v: math.degrees(_sweep(v)),
        "length": lambda v: v[6] * _sweep(v),
        "start_angle": lambda v: math.degrees(_direction(v, 2, 0)),
        "end_angle": lambda v: math.degrees(_direction(v, 4, 0)),
    },
    "ellipse": {
        "radius": lambda v: v[2],
        "radius_b": lambda v: v[3],
        "rotation": lambda v: math.degrees(v[4]),
    },
    "earc": {
        "radius": lambda v: v[6],
        "radius_b": lambda v: v[7],
        "rotation": lambda v: math.degrees(v[8]),
        "start_angle": lambda v: math.degrees(_parameter(v, 2)),
        "end_angle": lambda v: math.degrees(_parameter(v, 4)),
    },
    "bezier": {},
    "bspline": {},
}

ANGLES = frozenset({"angle", "sweep", "start_angle", "end_angle", "rotation"})


def property_names(entity: Entity) -> list[str]:
    """Every property of an entity, for messages and completion."""
    points = [name for name in point_offsets(entity) if name != "pos"]
    parts = [f"{name}.{axis}" for name in points for axis in "xy"]
    own = ["x", "y"] if entity.kind == "point" else []
    long = ["length"] if entity.kind in _BY_CURVE else []
    return [*own, *PROPERTIES[entity.kind], *long, *parts]


def property_of(document: Document, entity: Entity, name: str) -> float | None:
    """Value of a property, None if the entity has none of this name."""
    point, dot, axis = name.rpartition(".")
    if entity.kind == "point" and not dot:
        point = "pos"
    if axis in ("x", "y"):
        at = point_offsets(entity).get(point)
        return None if at is None else float(document.values[at + (axis == "y")])
    if entity.clockwise:
        name = {"start_angle": "end_angle", "end_angle": "start_angle"}.get(name, name)
    if name == "length" and entity.kind in _BY_CURVE:
        return curve_of(document, entity).length()
    found = PROPERTIES[entity.kind].get(name)
    if found is None:
        return None
    return float(found(document.values[entity.at : entity.at + entity.size].tolist()))
