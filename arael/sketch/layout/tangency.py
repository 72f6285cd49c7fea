"""Tangent and smooth as equations.

Where the curves share a point anyway, the distance by which they miss each other has a derivative
of zero at the solution; there directions are compared instead.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from arael.sketch.document.records import Constraint
from arael.sketch.layout.operands import (
    Alike,
    Operand,
    cross,
    dot,
    forward,
    place,
    sign,
    towards,
)
from arael.sketch.layout.plan import Hidden, Plan, Row, Sum, Values

#: Lengths that differ by less than this share of themselves count as the same.
_AS_NEAR = 1e-8
#: Curves whose gap and crossing are below this share of their radius touch.
_TOUCHES = 1e-7


def tangent(
    plan: Plan, what: Constraint, args: list[Operand], values: Values, alike: Alike
) -> None:
    """Equations of `tangent`."""
    first, second = args
    if first.kind == "point":
        _ends(plan, what, first, second, values)
    elif "line" in (first.kind, second.kind):
        line, curve = (first, second) if first.kind == "line" else (second, first)
        _line_round(plan, what.side, line, curve, values, alike)
    elif first.is_circular and second.is_circular:
        _circles(plan, what, first, second, values, alike)
    else:
        _rounds(plan, first, second, values, alike)


def side_of_line(values: Values, line: Operand, curve: Operand) -> int:
    """1 if the centre of a round curve is to the left of a line, else -1."""
    a, b = line.line
    return sign(cross(towards(values, a, b), towards(values, a, curve.center)))


def circles_mode(values: Values, first: Operand, second: Operand) -> tuple[str, int]:
    """How two circles touch, and for one inside of the other 1 if the second is, else -1.

    Which is nearer. Where the centre of one is on the other, both are as near, up to rounding: then
    they touch from outside, at any scale and place.
    """
    u = towards(values, first.center, second.center)
    gap = math.hypot(*u)
    ra, rb = float(values[first.circle.r]), float(values[second.circle.r])
    outside = abs(gap - ra - rb) <= abs(gap - abs(ra - rb)) + _AS_NEAR * (gap + ra + rb)
    return ("outside" if outside else "inside"), sign(ra - rb)


def shared(first: Iterable[int], curve: Operand, alike: Alike) -> tuple[int, int] | None:
    """One of some points that lies on a curve by itself, and the curve's own point there, if any.

    The second number is the first point where the curve has none.
    """
    points = list(first)
    for point in points:
        for end in curve.ends:
            if alike.same(point, end):
                return point, end
    for point in points:
        if alike.lies_on(point, curve.entity.name):
            return point, point
    return None


def _line_round(
    plan: Plan, side: int, line: Operand, curve: Operand, values: Values, alike: Alike
) -> None:
    a, b = line.line
    side = side or side_of_line(values, line, curve)
    common = shared((a, b), curve, alike)
    if common is None:
        common = next(
            ((end, end) for end in curve.ends if alike.lies_on(end, line.entity.name)), None
        )
    point = alike.on_both(line.entity.name, curve.entity.name) if common is None else None
    if point is not None:
        common = point, point
    if curve.is_circular:
        circle = curve.circle
        if common is None:
            plan.add("TangentLineCircle", a, b, *circle, side=float(side))
            return
        plan.add("Perpendicular", a, b, circle.center, common[1])
        plan.guard("TurnGuard", a, b, circle.center, common[1], value=-side * math.pi / 2)
    elif common is None:
        plan.add("TangentLineEllipse", a, b, *curve.ellipse, side=float(side))
    else:
        plan.add("EllipseTangentAlong", common[1], *curve.ellipse, a, b)


def _common(first: Operand, second: Operand, alike: Alike) -> int | None:
    """A point that both of two round curves pass through anyway."""
    found = shared(first.ends, second, alike) or shared(second.ends, first, alike)
    return found[0] if found else None


def _circles(
    plan: Plan, what: Constraint, first: Operand, second: Operand, values: Values, alike: Alike
) -> None:
    mode, larger = circles_mode(values, first, second)
    mode = what.mode or mode
    larger = what.side or larger
    a, b = first.circle, second.circle
    point = _common(first, second, alike)
    if point is not None:
        plan.add("Parallel", a.center, point, b.center, point)
        value = math.pi if mode == "outside" else 0.0
        plan.guard("TurnGuard", a.center, point, b.center, point, value=value)
    elif mode == "outside":
        plan.add("TangentCircles", *a, *b, side=1.0)
    elif larger > 0:
        plan.add("TangentCircles", *a, *b, side=-1.0)
    else:
        plan.add("TangentCircles", *b, *a, side=-1.0)


def _rounds(plan: Plan, first: Operand, second: Operand, values: Values, alike: Alike) -> None:
    """Two round curves, one of them an ellipse, touch in a point of their own."""
    ellipse, other = (first, second) if first.is_elliptic else (second, first)
    point = _common(first, second, alike)
    if point is None:

        def start(values: Values) -> tuple[float, float]:
            return contact(values, ellipse, other)

        point = plan.hide(Hidden(("contact.x", "contact.y"), start))
        plan.add("PointOnEllipse", point, *ellipse.ellipse)
        if other.is_circular:
            plan.add("PointOnCircle", point, *other.circle)
        else:
            plan.add("PointOnEllipse", point, *other.ellipse)
    if other.is_circular:
        plan.add("EllipseNormalAlong", point, *ellipse.ellipse, other.center, point)
    else:
        plan.add("TangentEllipses", point, *ellipse.ellipse, *other.ellipse)


def contact(values: Values, first: Operand, second: Operand) -> tuple[float, float]:
    """Point where two round curves touch, or nearly do; one of them at least is an ellipse.

    With a circle, that is where a normal of the ellipse passes through its centre. Of two ellipses:
    of the places of the smaller curve that are nearer to the other one than their neighbours are,
    moved to where both have a common normal, so that what touches already needs no motion: the one
    where gap and crossing are least. Curves that touch in one point may cross in others.
    """
    if first.is_circular or second.is_circular:
        ellipse, circle = (second, first) if first.is_circular else (first, second)
        return _contact_with_circle(values, ellipse, circle)
    if _radius(values, second) < _radius(values, first):
        first, second = second, first
    nearest = _nearest(values, first, second)
    found = [_touching(values, first, second, a, b) for a, b in nearest]
    if min(found)[0] > (_TOUCHES * _radius(values, first)) ** 2:
        # Where curvatures are nearly the same the normal that was found may be of a place between a
        # contact and a crossing: the others are near.
        for a, _ in nearest:
            for k in (-4, -3, -2, -1, 1, 2, 3, 4):
                beside = a + k * math.pi / 90  # half a sample
                foot = _foot(values, second, _at(values, first, beside))
                found.append(_touching(values, first, second, beside, foot))
    return min(found)[1]


def _contact_with_circle(values: Values, ellipse: Operand, circle: Operand) -> tuple[float, float]:
    """Where an ellipse and a circle touch, or their gap along a normal of both is least."""
    # imported here: start-up time
    from arael.sketch.geometry.feet import ellipse_normals

    center, radius = place(values, circle.center), float(values[circle.circle.r])
    x, y = towards(values, ellipse.center, circle.center)
    _, rx, ry, rot = (float(values[at]) for at in ellipse.ellipse)
    c, s = math.cos(rot), math.sin(rot)
    normals = ellipse_normals(c * x + s * y, c * y - s * x, abs(rx), abs(ry))
    places = [_at(values, ellipse, angle) for angle in normals]
    return min(places, key=lambda p: abs(math.dist(p, center) - radius))


def _touching(
    values: Values, first: Operand, second: Operand, a: float, b: float
) -> tuple[float, tuple[float, float]]:
    """How far curves are from touching near angles `a` and `b`, squared, and where that is."""
    a, b = _common_normal(values, first, second, a, b) or (a, b)
    p, q = _at(values, first, a), _at(values, second, b)
    u, v = _at(values, first, a, 1), _at(values, second, b, 1)
    lengths = math.hypot(*u) * math.hypot(*v)
    crossing = cross(u, v) ** 2 / lengths if lengths > 0.0 else 0.0
    return math.dist(p, q) ** 2 + crossing, ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)


def _radius(values: Values, curve: Operand) -> float:
    """The larger radius of a round curve."""
    radii = curve.circle[1:] if curve.is_circular else curve.ellipse[1:3]
    return max(abs(float(values[at])) for at in radii)


def _nearest(values: Values, first: Operand, second: Operand) -> list[tuple[float, float]]:
    """Angles of samples of a curve, and of their feet on another, where the gap is small."""
    angles = [2 * math.pi * k / 90 for k in range(90)]
    places = [_at(values, first, angle) for angle in angles]
    feet = [_foot(values, second, p) for p in places]
    gaps = [math.dist(p, _at(values, second, b)) for p, b in zip(places, feet, strict=True)]
    low = [k for k in range(90) if gaps[k] <= gaps[k - 1] and gaps[k] <= gaps[(k + 1) % 90]]
    low.sort(key=gaps.__getitem__)
    return [(angles[k], feet[k]) for k in low[:6]]


def _foot(values: Values, curve: Operand, p: tuple[float, float]) -> float:
    """Angle of the point of a circle or ellipse that is nearest to a place."""
    # imported here: start-up time
    from arael.sketch.geometry.feet import ellipse_feet

    x, y = place(values, curve.center)
    dx, dy = p[0] - x, p[1] - y
    if curve.is_circular:
        return math.atan2(dy, dx)
    _, rx, ry, rot = curve.ellipse
    c, s = math.cos(values[rot]), math.sin(values[rot])
    radii = abs(float(values[rx])), abs(float(values[ry]))
    return ellipse_feet(c * dx + s * dy, c * dy - s * dx, *radii)[0]


def _common_normal(
    values: Values, first: Operand, second: Operand, a: float, b: float
) -> tuple[float, float] | None:
    """Angles near `a` and `b` at which a line is normal to both curves, by Newton's method."""
    start = (a, b)
    for _ in range(20):
        p, q = _at(values, first, a), _at(values, second, b)
        u, v = (_at(values, curve, angle, 1) for curve, angle in ((first, a), (second, b)))
        du, dv = (_at(values, curve, angle, 2) for curve, angle in ((first, a), (second, b)))
        gap = (p[0] - q[0], p[1] - q[1])
        f, g = cross(u, v), dot(gap, u)
        fa, fb = cross(du, v), cross(u, dv)
        ga, gb = dot(u, u) + dot(gap, du), -dot(v, u)
        det = fa * gb - fb * ga
        if abs(det) <= 1e-12 * (abs(fa * gb) + abs(fb * ga)):
            return None
        da, db = (fb * g - f * gb) / det, (f * ga - fa * g) / det
        a, b = a + da, b + db
        if max(abs(a - start[0]), abs(b - start[1])) > 0.2:
            return None  # farther than two samples: of another contact
        if max(abs(da), abs(db)) < 1e-15:
            break
    return a, b


def _at(values: Values, curve: Operand, angle: float, order: int = 0) -> tuple[float, float]:
    """A point of a circle or ellipse, or its derivative by the angle."""
    x, y = place(values, curve.center) if order == 0 else (0.0, 0.0)
    angle += order * math.pi / 2  # derivatives of sine and cosine
    if curve.is_circular:
        r = float(values[curve.circle.r])
        return x + r * math.cos(angle), y + r * math.sin(angle)
    _, rx, ry, rot = curve.ellipse
    u = (float(values[rx]) * math.cos(angle), float(values[ry]) * math.sin(angle))
    c, s = math.cos(values[rot]), math.sin(values[rot])
    return x + c * u[0] - s * u[1], y + s * u[0] + c * u[1]


# --- where ends meet ----------------------------------------------------------------------------


def _straight(end: Operand) -> tuple[int, int] | None:
    """Two points along the tangent of a line or spline at its end, in its direction."""
    if end.entity.kind == "line":
        return end.line
    if end.is_spline:
        poles = end.poles
        return (poles[1], poles[0]) if end.is_last else (poles[0], poles[1])
    return None


def _ends(plan: Plan, what: Constraint, first: Operand, second: Operand, values: Values) -> None:
    side = what.side or sign(dot(forward(values, first), forward(values, second)))
    u, v = _straight(first), _straight(second)
    if u and v:
        plan.add("Parallel", *u, *v)
        plan.guard("TurnGuard", *u, *v, value=0.0 if side > 0 else math.pi)
        return
    if v:
        first, second, u, v = second, first, v, u
    if u:
        if second.entity.kind == "earc":
            plan.add("EllipseTangentAlong", second.at, *second.ellipse, *u)
            return
        # An arc runs to the left of the way from its centre.
        plan.add("Perpendicular", *u, second.center, second.at)
        plan.guard("TurnGuard", *u, second.center, second.at, value=-side * math.pi / 2)
    elif first.entity.kind == "arc" and second.entity.kind == "arc":
        spokes = (first.center, first.at, second.center, second.at)
        plan.add("Parallel", *spokes)
        plan.guard("TurnGuard", *spokes, value=0.0 if side > 0 else math.pi)
    elif first.entity.kind == "arc":
        plan.add("EllipseNormalAlong", second.at, *second.ellipse, first.center, first.at)
    elif second.entity.kind == "arc":
        plan.add("EllipseNormalAlong", first.at, *first.ellipse, second.center, second.at)
    else:
        plan.add("TangentEllipses", first.at, *first.ellipse, *second.ellipse)


def _factor(spline: Operand) -> float:
    """The curvature at a spline's end is this times cross(u, v) / |u|^3 of its first poles.

    2/3 for a Bezier curve; 1/3 for a clamped B-spline of several pieces.
    """
    # B-spline on knots 0 0 0 0 1 2 ...: C' = 3 u, C'' = 3 (v - 2 u) where there is a second
    # interval, 6 (v - u) where there is none; cross(C', C'') / |C'|^3.
    return 2 / 3 if spline.entity.size == 8 else 1 / 3


def smooth(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    """Equations of `smooth`."""
    first, second = args
    if second.is_spline and not first.is_spline:
        first, second = second, first
    kinds = (first.entity.kind, second.entity.kind)
    if first.is_spline:
        poles = first.poles[:3]
        u = towards(values, poles[0], poles[1])
        if second.is_spline:
            others = second.poles[:3]
            # Both begin where they meet: going on straight turns the sign of the curvature.
            s = towards(values, others[0], others[1])
            # Only where they fold back on each other is it the same.
            side = 1.0 if dot(u, s) > 0.5 * math.hypot(*u) * math.hypot(*s) else -1.0
            plan.add(
                "SmoothSplines",
                *poles,
                *others,
                factor_p=_factor(first),
                factor_q=_factor(second),
                side=side,
            )
        elif second.entity.kind == "line":
            plan.add("PointLineDistance", poles[2], poles[0], poles[1])
        elif second.entity.kind == "arc":
            side = float(sign(cross(u, towards(values, poles[0], second.center))))
            plan.add("SmoothSplineArc", *poles, second.circle.r, factor=_factor(first), side=side)
        else:
            side = float(sign(cross(u, towards(values, poles[0], second.center))))
            size = math.hypot(*u) ** 2 or 1.0
            bend = Row("SplineCurvature", tuple(poles), {"factor": _factor(first)})
            round_ = Row("EllipseCurvature", (second.at, *second.ellipse))
            plan.sums.append(Sum(((bend, size), (round_, -side * size))))
    elif kinds == ("line", "line"):
        return
    elif kinds == ("arc", "arc"):
        plan.add("Difference", first.circle.r, second.circle.r)
    elif kinds == ("earc", "earc"):
        size = float(values[first.ellipse.rx]) ** 2
        a = Row("EllipseCurvature", (first.at, *first.ellipse))
        b = Row("EllipseCurvature", (second.at, *second.ellipse))
        plan.sums.append(Sum(((a, size), (b, -size))))
    elif "line" in kinds:
        plan.impossible = "a line has no curvature, and the other curve cannot be without"
    else:
        plan.impossible = "the curvature of an elliptic arc cannot be tied to that of an arc"
