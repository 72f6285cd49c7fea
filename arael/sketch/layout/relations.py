"""Constraints as equations: one function per kind of `arael.sketch.document.kinds.CONSTRAINTS`."""

from __future__ import annotations

import math
from collections.abc import Callable

from arael.sketch.document.handles import point_offsets
from arael.sketch.document.records import Constraint
from arael.sketch.layout import tangency
from arael.sketch.layout.operands import Alike, Operand, cross, dot, sign, towards
from arael.sketch.layout.plan import Constant, Hidden, Plan, Values
from arael.sketch.layout.splines import basis_of, nearest, nearest_on, pieces, poles_of

Maker = Callable[[Plan, Constraint, list[Operand], Values, Alike], None]

#: Kinds that are aliases or constants, not equations.
WITHOUT_ROWS = ("coincident", "concentric", "lock", "fix")


def plan_of(constraint: Constraint, args: list[Operand], values: Values, alike: Alike) -> Plan:
    """What a constraint contributes; nothing for those in `WITHOUT_ROWS`.

    Parameters
    ----------
    values : numbers of the document, for guards and hidden unknowns
    alike : which points are one place: where curves share a point, other equations are regular
    """
    plan = Plan()
    if constraint.kind not in WITHOUT_ROWS:
        MAKERS[constraint.kind](plan, constraint, args, values, alike)
    return plan


def _aligned(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    struct = what.kind.capitalize()
    if len(args) == 2:
        plan.add(struct, args[0].at, args[1].at)
        return
    line = args[0].line
    plan.add(struct, *line)
    u = towards(values, *line)
    along = (sign(u[0]), 0) if what.kind == "horizontal" else (0, sign(u[1]))
    plan.guard("SegmentGuard", *line, along=(float(along[0]), float(along[1])))


def _directed(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    """Parallel and perpendicular."""
    upright = what.kind == "perpendicular"
    angle = math.pi / 2 if upright else 0.0
    first, second = args
    if first.kind == "line" and second.kind == "line":
        plan.add("Perpendicular" if upright else "Parallel", *first.line, *second.line)
        side = what.side
        if not side:
            u, v = towards(values, *first.line), towards(values, *second.line)
            side = sign(cross(u, v) if upright else dot(u, v))
        value = side * angle if upright else (0.0 if side > 0 else math.pi)
        plan.guard("TurnGuard", *first.line, *second.line, value=value)
    elif first.is_elliptic and second.is_elliptic:
        turned_axes(plan, first, second, angle, values)
    else:
        line, curve = (first, second) if first.kind == "line" else (second, first)
        plan.add("AxisAngle", *line.line, curve.ellipse.rot, value=angle)


def turned_axes(plan: Plan, first: Operand, second: Operand, angle: float, values: Values) -> None:
    """The axis of an ellipse is turned by an angle from that of another.

    An ellipse is the same after half a turn: of those the nearest is meant. The weight makes the
    residual a length; it is constant, so that no ellipse shrinks in place of turning.
    """
    a, b = first.ellipse, second.ellipse
    turns = round((float(values[b.rot] - values[a.rot]) - angle) / math.pi)
    size = min(abs(float(values[a.rx])), abs(float(values[b.rx]))) or 1.0
    plan.add("Difference", b.rot, a.rot, value=angle + turns * math.pi, weight=size)


def _collinear(
    plan: Plan, what: Constraint, args: list[Operand], values: Values, alike: Alike
) -> None:
    a, b = args[0].line
    for point in args[1].line:
        if not (alike.same(point, a) or alike.same(point, b)):
            plan.add("PointLineDistance", point, a, b)


def _equal(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    first, second = args
    if first.kind == "line":
        plan.add("EqualLength", *first.line, *second.line)
    elif first.is_circular:
        plan.add("Difference", first.circle.r, second.circle.r)
    else:
        plan.add("Difference", first.ellipse.rx, second.ellipse.rx)
        plan.add("Difference", first.ellipse.ry, second.ellipse.ry)


def _equal_angle(
    plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike
) -> None:
    lines = [arg.line for arg in args]
    side = what.side
    if not side:
        u, v, s, t = (towards(values, *line) for line in lines)
        side = sign(cross(u, v) * cross(s, t))
    plan.add("EqualAngle", *(point for line in lines for point in line), side=float(side))


def _point_on(
    plan: Plan, what: Constraint, args: list[Operand], values: Values, alike: Alike
) -> None:
    point, curve = args
    if curve.kind == "line":
        plan.add("PointLineDistance", point.at, *curve.line)
    elif curve.is_circular:
        plan.add("PointOnCircle", point.at, *curve.circle)
    elif curve.is_elliptic:
        plan.add("PointOnEllipse", point.at, *curve.ellipse)
    else:
        at = (float(values[point.at]), float(values[point.at + 1]))
        wanted = alike.piece_of(what.name)
        piece = nearest(values, curve, at)[0] if wanted is None else wanted
        plan.piece = piece if pieces(curve) > 1 else -1

        def start(values: Values) -> tuple[float]:
            at = (float(values[point.at]), float(values[point.at + 1]))
            return (nearest_on(values, curve, piece, at)[0],)

        t = plan.hide(Hidden(("t",), start, 0.0, 1.0))
        weights = basis_of(curve, piece).ravel().tolist()
        plan.add("PointOnCubic", point.at, *poles_of(curve, piece), t, basis=weights)


def _midpoint(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    point, curve = args
    if curve.kind == "line":
        plan.add("Midpoint", point.at, *curve.line)
        return
    start, end = curve.ends
    plan.add("ArcMidpoint", point.at, curve.center, start, end, curve.circle.r)
    # An arc bulges to the right of the way from its start to its end.
    plan.guard("PointLineDistance", point.at, start, end, side=-1.0)


def _symmetry(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    first, about, second = args
    if about.kind == "point":
        plan.add("SymmetricAboutPoint", first.at, second.at, about.at)
    elif first.kind == "point":
        plan.add("SymmetricPoints", first.at, second.at, *about.line)
    elif first.kind == "line":
        plan.add("SymmetricLines", *first.line, *second.line, *about.line)
    else:
        plan.add("SymmetricPoints", first.center, second.center, *about.line)
        plan.add("Difference", first.circle.r, second.circle.r)


def _on_normal(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    point, end = args
    if end.entity.kind == "line":
        plan.add("OnNormal", point.at, end.at, *end.line)
    elif end.entity.kind == "arc":
        plan.add("PointLineDistance", point.at, end.center, end.at)
    elif end.entity.kind == "earc":
        plan.add("EllipseNormalAlong", end.at, *end.ellipse, end.at, point.at)
    else:
        poles = end.poles
        plan.add("OnNormal", point.at, end.at, poles[0], poles[1])


def _image(plan: Plan, what: Constraint, args: list[Operand], values: Values, _: Alike) -> None:
    source, copy = args[0], args[1]
    about = args[2] if len(args) == 3 else None
    degrees, first, second = what.numbers
    angle = math.radians(degrees)
    turned, moved = angle != 0.0, first != 0.0 or second != 0.0
    center = about.at if about is not None and about.kind == "point" else Constant((0.0, 0.0))

    def shift(p: int, q: int) -> None:
        if about is not None and about.kind == "line":
            plan.add("ImageAlong", p, q, *about.line, along=first, left=second)
        else:
            plan.add("ShiftedImage", p, q, shift=(first, second))

    tokens = what.mode.split()
    for token in tokens:
        p, q = _number(source, token), _number(copy, token)
        if token in ("radius", "radius_b"):
            plan.add("Difference", p, q)
        elif token == "rotation":
            turned_axes(plan, source, copy, angle, values)
        elif not turned:
            shift(p, q)
        elif not moved:
            plan.add("RotatedImage", p, q, center, value=angle)
        else:
            between = plan.hide(_turned(p, center, angle, token))
            plan.add("RotatedImage", p, between, center, value=angle)
            shift(between, q)


def _turned(point: int, center: int | Constant, angle: float, token: str) -> Hidden:
    def start(values: Values) -> tuple[float, float]:
        if isinstance(center, Constant):
            x, y = center.numbers
        else:
            x, y = float(values[center]), float(values[center + 1])
        u = (float(values[point]) - x, float(values[point + 1]) - y)
        c, s = math.cos(angle), math.sin(angle)
        return x + c * u[0] - s * u[1], y + s * u[0] + c * u[1]

    return Hidden((f"turned.{token}.x", f"turned.{token}.y"), start)


def _number(entity: Operand, token: str) -> int:
    """Offset of one of the numbers that an image's mode lists."""
    if token in ("radius", "radius_b", "rotation"):
        if entity.is_elliptic:
            ellipse = entity.ellipse
            return {"radius": ellipse.rx, "radius_b": ellipse.ry, "rotation": ellipse.rot}[token]
        return entity.circle.r
    if token == "pos":
        return entity.at
    return point_offsets(entity.entity)[token]


MAKERS: dict[str, Maker] = {
    "horizontal": _aligned,
    "vertical": _aligned,
    "parallel": _directed,
    "perpendicular": _directed,
    "collinear": _collinear,
    "equal": _equal,
    "equal_angle": _equal_angle,
    "tangent": tangency.tangent,
    "smooth": tangency.smooth,
    "point_on": _point_on,
    "midpoint": _midpoint,
    "symmetry": _symmetry,
    "on_normal": _on_normal,
    "image": _image,
}
