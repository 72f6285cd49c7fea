"""Functions of expressions: those of numbers, and those of points and curves."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from arael.sketch.expressions.vectors import Vec


class Scalar(NamedTuple):
    """A function of numbers.

    Attributes
    ----------
    value : of the numbers
    arity : least and most arguments
    meaning : in words, for help
    """

    value: Callable[..., float]
    arity: tuple[int, int]
    meaning: str


class Geometric(NamedTuple):
    """A function of points and curves.

    Attributes
    ----------
    value : of points (`Vec`), curves (`arael.sketch.geometry`) and numbers
    counts : how many arguments it may have
    takes : the arguments in words
    example : a call
    gives : ``coordinate``, ``direction``, ``number`` or ``angle``
    meaning : in words, for help
    """

    value: Callable[..., float | Vec]
    counts: tuple[int, ...]
    takes: str
    example: str
    gives: str
    meaning: str


def _sign(x: float) -> float:
    return math.copysign(1.0, x) if x else 0.0


_MANY = 100
_SCALARS = MappingProxyType(
    {
        "sqrt": Scalar(math.sqrt, (1, 1), "square root"),
        "abs": Scalar(abs, (1, 1), "absolute value"),
        "min": Scalar(min, (2, _MANY), "smallest"),
        "max": Scalar(max, (2, _MANY), "largest"),
        "sin": Scalar(math.sin, (1, 1), "sine"),
        "cos": Scalar(math.cos, (1, 1), "cosine"),
        "tan": Scalar(math.tan, (1, 1), "tangent"),
        "asin": Scalar(math.asin, (1, 1), "inverse sine, in radians"),
        "acos": Scalar(math.acos, (1, 1), "inverse cosine, in radians"),
        "atan": Scalar(math.atan, (1, 1), "inverse tangent, in radians"),
        "atan2": Scalar(
            math.atan2, (2, 2), "angle of the vector (x, y) from `atan2(y, x)`, radians"
        ),
        "exp": Scalar(math.exp, (1, 1), "exponential"),
        "log": Scalar(math.log, (1, 1), "natural logarithm"),
        "pow": Scalar(math.pow, (2, 2), "power"),
        "floor": Scalar(math.floor, (1, 1), "next whole number below"),
        "ceil": Scalar(math.ceil, (1, 1), "next whole number above"),
        "sign": Scalar(_sign, (1, 1), "-1, 0 or 1"),
    }
)

#: Functions whose argument is an angle.
TRIGONOMETRY = frozenset({"sin", "cos", "tan"})

#: Others of the language of models (`e`) are names like any other in sketches.
CONSTANTS = MappingProxyType({"pi": math.pi})


def scalar_functions() -> Mapping[str, Scalar]:
    """Functions of numbers by name."""
    return _SCALARS


def _vec(point: tuple[float, float]) -> Vec:
    return Vec(float(point[0]), float(point[1]))


def _pair(point: Vec) -> tuple[float, float]:
    return point.x, point.y


def _is_line(curve: Any) -> bool:
    return hasattr(curve, "p1") and hasattr(curve, "signed_distance")


def _require_line(curve: Any) -> Any:
    if not _is_line(curve):
        raise TypeError
    return curve


def _direction(curve: Any, t: float) -> Vec:
    return _vec(curve.tangent_at(t))


def _intersect(a: Any, b: Any, near: Vec | None = None) -> Vec:
    if _is_line(a) and _is_line(b):
        u, v = _direction(a, 0.0), _direction(b, 0.0)
        cross = u.x * v.y - u.y * v.x
        if abs(cross) < 1e-12:
            raise ValueError("the lines are parallel")
        dx, dy = b.p1[0] - a.p1[0], b.p1[1] - a.p1[1]
        t = (dx * v.y - dy * v.x) / cross
        return Vec(a.p1[0] + t * u.x, a.p1[1] + t * u.y)
    # imported here: start-up time
    from arael.sketch.geometry.contacts.intersections import intersections

    found = [_vec(one.point) for one in intersections(a, b)]
    if not found:
        raise ValueError("they do not meet")
    if near is not None:
        return min(found, key=lambda p: math.hypot(p.x - near.x, p.y - near.y))
    if len(found) > 1:
        raise ValueError(f"they meet {len(found)} times; add a point nearby as third argument")
    return found[0]


def _midpoint(a: Any, b: Vec | None = None) -> Vec:
    if b is not None:
        return Vec(0.5 * (a.x + b.x), 0.5 * (a.y + b.y))
    return _vec(a.point_at(0.5))


def _nearest(point: Vec, curve: Any) -> tuple[float, float]:
    found = (
        curve.nearest(_pair(point), carrier=True)
        if _is_line(curve)
        else curve.nearest(_pair(point))
    )
    return found.t, found.distance


def _project(point: Vec, curve: Any) -> Vec:
    t, _ = _nearest(point, curve)
    return _vec(curve.point_at(t))


def _along(curve: Any, t: float) -> Vec:
    return _vec(curve.point_at(t))


def _arc_point(curve: Any, degrees: float) -> Vec:
    return _vec(curve.at_angle(math.radians(degrees)))


def _rotate(point: Vec, center: Vec, degrees: float) -> Vec:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    d = point - center
    return Vec(center.x + c * d.x - s * d.y, center.y + s * d.x + c * d.y)


def _mirror(point: Vec, line: Any) -> Vec:
    foot = _project(point, _require_line(line))
    return Vec(2.0 * foot.x - point.x, 2.0 * foot.y - point.y)


def _tangent(curve: Any, t: float = 0.0) -> Vec:
    return _direction(curve, t)


def _normal(curve: Any, t: float = 0.0) -> Vec:
    d = _direction(curve, t)
    return Vec(-d.y, d.x)


def _dist(a: Any, b: Any) -> float:
    if isinstance(a, Vec) and isinstance(b, Vec):
        return math.hypot(a.x - b.x, a.y - b.y)
    if isinstance(b, Vec):
        a, b = b, a
    return _nearest(a, b)[1]


def _angle(a: Any, b: Any) -> float:
    u, v = _direction(_require_line(a), 0.0), _direction(_require_line(b), 0.0)
    return math.degrees(math.atan2(u.x * v.y - u.y * v.x, u.x * v.x + u.y * v.y))


GEOMETRY = MappingProxyType(
    {
        "intersect": Geometric(
            _intersect,
            (2, 3),
            "two curves, and a point nearby if they meet more than once",
            "intersect(L0, L1)",
            "coordinate",
            "where two lines (extended) or curves meet",
        ),
        "midpoint": Geometric(
            _midpoint,
            (1, 2),
            "a curve or two points",
            "midpoint(L0)",
            "coordinate",
            "middle of a line or curve, or of two points",
        ),
        "project": Geometric(
            _project,
            (2,),
            "a point and a curve",
            "project(P0, L0)",
            "coordinate",
            "nearest point of a line (extended) or curve",
        ),
        "along": Geometric(
            _along,
            (2,),
            "a curve and a fraction",
            "along(L0, 0.5)",
            "coordinate",
            "point at a fraction, from 0 at the start to 1 at the end",
        ),
        "arc_point": Geometric(
            _arc_point,
            (2,),
            "a circle or arc and an angle in degrees",
            "arc_point(A0, 45)",
            "coordinate",
            "point of a circle or arc at a polar angle",
        ),
        "rotate": Geometric(
            _rotate,
            (3,),
            "a point, a centre and an angle in degrees",
            "rotate(P0, A0.center, 90)",
            "coordinate",
            "point turned about a centre, counter-clockwise",
        ),
        "mirror": Geometric(
            _mirror,
            (2,),
            "a point and a line",
            "mirror(P0, L0)",
            "coordinate",
            "point on the other side of a line",
        ),
        "tangent": Geometric(
            _tangent,
            (1, 2),
            "a curve, and a fraction if not its start",
            "tangent(L0)",
            "direction",
            "unit vector along a line or curve",
        ),
        "normal": Geometric(
            _normal,
            (1, 2),
            "a curve, and a fraction if not its start",
            "normal(L0)",
            "direction",
            "unit vector to the left of a line or curve",
        ),
        "dist": Geometric(
            _dist,
            (2,),
            "two points, or a point and a curve",
            "dist(P0, L0)",
            "number",
            "distance of two points, or of a point and a line (extended) or curve",
        ),
        "angle": Geometric(
            _angle,
            (2,),
            "two lines",
            "angle(L0, L1)",
            "angle",
            "angle from one line's direction to the other's in degrees, signed",
        ),
    }
)
