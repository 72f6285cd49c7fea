"""Arcs from ends, points and directions."""

from __future__ import annotations

from math import acos, atan2, copysign, cos, hypot, pi, sin, sqrt

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.circles import circle_through
from arael.sketch.geometry.circular import Arc
from arael.sketch.geometry.elliptic import EllipticArc
from arael.sketch.geometry.vectors import (
    TURN,
    Point,
    cross,
    direction_angle,
    dot,
    left,
    signed_angle,
    subtract,
    sweep_between,
    unit,
)


def arc_through(start: Point, end: Point, through: Point) -> Arc | None:
    """Arc between two points through a third; None if they are on one line.

    Its sweep is negative if it runs clockwise from `start`.
    """
    circle = circle_through(start, through, end)
    if circle is None:
        return None
    a = direction_angle(subtract(start, circle.center))
    b = direction_angle(subtract(end, circle.center))
    c = direction_angle(subtract(through, circle.center))
    sweep = sweep_between(a, b)
    if sweep_between(a, c) > sweep:
        sweep -= TURN
    return Arc(circle.center, circle.radius, a, sweep)


def arc_tangent(start: Point, direction: Point, end: Point) -> Arc | None:
    """Arc that leaves `start` in a direction and ends at `end`; None if that is a straight line.

    The angle of chord and tangent is half the sweep (positive: to the left).
    """
    d, w = unit(direction), subtract(end, start)
    length = hypot(*w)
    sine, cosine = cross(d, w), dot(d, w)
    if abs(sine) <= 1e-13 * length or not length > 0.0:
        return None
    half = atan2(sine, cosine)
    radius = length / (2.0 * sin(half))  # signed: the centre is to the left for a left turn
    n = left(d)
    center = start[0] + radius * n[0], start[1] + radius * n[1]
    return Arc(center, abs(radius), direction_angle(subtract(start, center)), 2.0 * half)


def elliptic_arc(
    start: Point,
    end: Point,
    rx: float,
    ry: float,
    rotation: float = 0.0,
    *,
    large: bool = False,
    clockwise: bool = False,
) -> EllipticArc | None:
    """Elliptic arc between two points with given radii (SVG 1.1, F.6.5); None if points coincide.

    Radii too small for the distance are scaled up as SVG demands. `large` takes the longer of the
    two arcs, `clockwise` the negative direction of rotation (y upwards).
    """
    w = subtract(start, end)
    if not hypot(*w) > 0.0 or not (abs(rx) > 0.0 and abs(ry) > 0.0):
        return None
    rx, ry = abs(rx), abs(ry)
    c, s = cos(rotation), sin(rotation)
    x, y = 0.5 * (c * w[0] + s * w[1]) / rx, 0.5 * (c * w[1] - s * w[0]) / ry
    size = hypot(x, y)
    if size > 1.0:
        rx, ry, x, y = rx * size, ry * size, x / size, y / size
        size = 1.0
    # on the unit circle the ends are +-(x, y) about the centre of the chord
    height = sqrt(max((1.0 - size) * (1.0 + size), 0.0)) / size
    if large != clockwise:
        height = -height
    ux, uy = height * y, -height * x
    px, py = rx * ux, ry * uy
    center = (
        0.5 * (start[0] + end[0]) + c * px - s * py,
        0.5 * (start[1] + end[1]) + s * px + c * py,
    )
    a, b = atan2(y - uy, x - ux), atan2(-y - uy, -x - ux)
    sweep = sweep_between(a, b)
    if clockwise:
        sweep -= TURN
    return EllipticArc(center, rx, ry, rotation, a, sweep)


def elliptic_arc_through(
    start: Point, end: Point, near: Point, rx: float, ry: float, rotation: float = 0.0
) -> EllipticArc | None:
    """The one of the four elliptic arcs between two points that passes nearest to a third."""
    found = [
        elliptic_arc(start, end, rx, ry, rotation, large=large, clockwise=clockwise)
        for large in (False, True)
        for clockwise in (False, True)
    ]
    arcs = [arc for arc in found if arc is not None]
    return min(arcs, key=lambda arc: arc.nearest(near).distance, default=None)


def elliptic_arc_tangent(
    start: Point, first: Point, end: Point, last: Point, bulge: float | None = None
) -> EllipticArc | None:
    """Elliptic arc that leaves `start` along `first` and arrives at `end` along `last`.

    Of the ellipses with these tangents `bulge` takes the one that passes through the point at
    `bulge` times half the chord beside the chord's middle, on the side where the normals of the
    ends meet. None takes the one that is a circle where both tangents are equally long.

    Returns
    -------
    None if there is no such ellipse: the tangents meet ahead of one end and behind the other, the
    directions agree, or the conic through that point is open.

    The arc is a rational quadratic curve with the tangents' meeting point as its middle pole and
    the weight w = cos(turn / 2) for the circle; in barycentric coordinates (a, b, c) of the poles
    the conic is b^2 = 4 w^2 a c (Farin: NURBS, section 4.5). Opposite directions meet at infinity:
    half an ellipse.
    """
    d, e = unit(first), unit(last)
    chord = subtract(end, start)
    turn = signed_angle(direction_angle(e) - direction_angle(d))
    if not hypot(*chord) > 0.0 or abs(turn) < 1e-9:
        return None
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    away = cross(chord, d)
    if abs(away) <= 1e-12 * hypot(*chord):
        return None
    # the point beside the middle of the chord, relative to it
    sine = cross(d, e)
    normals = dot(chord, d) * dot(chord, e) * sine  # above 0: they meet to the left of the chord
    reach = 0.5 * (bulge if bulge is not None else 1.0) * (1.0 if normals > 0.0 else -1.0)
    beside = (-chord[1] * reach, chord[0] * reach)
    if pi - abs(turn) < 1e-9:
        # parts of `beside` along the radius to the start, and along d
        radius = subtract(start, middle)
        u, v = cross(beside, d) / cross(radius, d), cross(radius, beside) / cross(radius, d)
        if bulge is None:
            u, v = 0.0, 0.5 * abs(away)  # a circle for a perpendicular chord
        if not (u * u < 1.0 and v != 0.0):
            return None
        v = abs(v) / sqrt(1.0 - u * u)
        return _conjugate(middle, radius, (d[0] * v, d[1] * v), pi)
    p, q = cross(chord, e) / sine, cross(d, chord) / sine
    if p * q <= 0.0:
        return None
    apex = start[0] + p * d[0], start[1] + p * d[1]
    lift = subtract(apex, middle)
    weight = cos(0.5 * turn) if p > 0.0 else cos(0.5 * (pi - abs(pi - abs(turn))))
    if bulge is not None:
        # beside = b lift + s chord: a, c = (1 - b) / 2 -+ s
        b, s = cross(beside, chord) / cross(lift, chord), cross(lift, beside) / cross(lift, chord)
        square = 0.25 * (1.0 - b) ** 2 - s * s
        if not square > 0.0:
            return None
        weight = abs(b) / (2.0 * sqrt(square))
    if not 1e-12 < weight < 1.0 - 1e-12:
        return None
    # centre on the line from the apex through the middle of the chord; half the sweep has the
    # cosine w, in the affine frame where the ellipse is a circle
    k = weight * weight / (1.0 - weight * weight)
    center = middle[0] - k * lift[0], middle[1] - k * lift[1]
    half = acos(weight)
    # unit vectors of that frame: towards the apex, and along the chord
    rise = weight / (1.0 - weight * weight)  # |apex - centre| = radius / w, in units of lift
    up = (lift[0] * rise, lift[1] * rise)
    scale = 0.5 / sin(half)
    right = (chord[0] * scale, chord[1] * scale)
    c, s = cos(half), sin(half)
    found = _conjugate(
        center,
        (up[0] * c - right[0] * s, up[1] * c - right[1] * s),
        (up[0] * s + right[0] * c, up[1] * s + right[1] * c),
        2.0 * half,
    )
    if p > 0.0:
        return found
    # more than half of the ellipse: the rest of the arc the other way
    rest = found.sweep - copysign(TURN, found.sweep)
    return EllipticArc(found.center, found.rx, found.ry, found.rotation, found.angle, rest)


def _conjugate(center: Point, a: Point, b: Point, sweep: float) -> EllipticArc:
    """Arc center + cos(s) a + sin(s) b for s from 0 to `sweep`, by its axes."""
    frame = Affine(a[0], a[1], b[0], b[1], center[0], center[1])
    found = Arc((0.0, 0.0), 1.0, 0.0, sweep).transformed(frame)
    if isinstance(found, EllipticArc):
        return found
    return EllipticArc(found.center, found.radius, found.radius, 0.0, found.angle, found.sweep)
