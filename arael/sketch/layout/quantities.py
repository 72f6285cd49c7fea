"""Dimensions as equations: one function per kind gives the rows whose residual is the quantity."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Dimension
from arael.sketch.expressions.gradient import Program
from arael.sketch.layout import chains
from arael.sketch.layout.operands import Operand, cross, dot, sign, sweep_of, towards, turn
from arael.sketch.layout.plan import Constant, Data, Hidden, Plan, Row, Setting, Sum, Use, Values

_RIGHT = math.pi / 2


@dataclass(slots=True)
class Quantity:
    """How a quantity becomes rows.

    Attributes
    ----------
    parts : rows, with factors, that add up to the quantity: what is measured
    equation : struct, refs and data of the row that gives the quantity a value; empty: the sum of
        the parts
    scale, shift : the row's `value` is ``scale * value + shift``
    guards : struct, refs and data; a field `None` takes the row's value
    also : rows that hold so that it is the quantity: lines stay parallel, circles concentric
    kept : rows whose residual stays positive for the same reason
    size : by what the sum is multiplied to be a length: a length for angles, its inverse for areas
    problem : why it cannot be an equation, else empty
    """

    parts: list[tuple[Row, float]]
    equation: tuple[str, tuple[Use, ...], Data] | None = None
    scale: float = 1.0
    shift: float = 0.0
    guards: list[tuple[str, tuple[Use, ...], Data]] = field(default_factory=list)
    also: list[Row] = field(default_factory=list)
    kept: list[Row] = field(default_factory=list)
    size: float = 1.0
    problem: str = ""


Maker = Callable[[list[Operand], Values, int, str], Quantity]


def plan_of(
    dimension: Dimension,
    args: list[Operand],
    values: Values,
    program_of: Callable[[str], Program | None] = lambda text: None,
    same: chains.Same = chains.apart,
) -> Plan:
    """What a dimension contributes: nothing if it is derived.

    Parameters
    ----------
    program_of : a text of an amount as a program, where it follows geometry
    same : which points are one place: how the curves of an outline follow each other
    """
    plan = Plan()
    if dimension.derived:
        return plan
    quantity = quantity_of(dimension, args, values, same)
    middle: float | None = None
    if dimension.kind == "xangle" and not args[0].is_elliptic:
        middle = _middle(dimension)
        quantity = _direction(args[0], values, middle)
    if quantity.problem:
        plan.impossible = quantity.problem
        return plan
    if dimension.value is not None:
        _valued(plan, quantity, dimension, program_of(dimension.value.text))
    else:

        def now(values: Values) -> float:
            found = measure(dimension.kind, args, values, dimension.side, dimension.mode, same)
            return found if middle is None else middle + math.remainder(found - middle, math.tau)

        _ranged(plan, quantity, dimension, now, program_of)
    plan.rows += quantity.also
    plan.guards += quantity.kept
    return plan


def _valued(plan: Plan, quantity: Quantity, dimension: Dimension, program: Program | None) -> None:
    """The equation of a value; where it follows geometry, with a program."""
    assert dimension.value is not None
    if program is None:
        _equation(plan, quantity, inner(dimension.kind, dimension.value.number))
        return
    whole, factor = _measured(quantity)
    scale = factor * inner(dimension.kind, 1.0)
    plan.sums.append(Sum(tuple(whole), program=program, scale=scale))


def _ranged(
    plan: Plan,
    quantity: Quantity,
    dimension: Dimension,
    now: Callable[[Values], float],
    program_of: Callable[[str], Program | None],
) -> None:
    """The equations of a range."""
    turn = inner(dimension.kind, 1.0)
    total, factor = _measured(quantity)
    implied = _implied(dimension)
    for what, amount, direction in (("low", dimension.low, 1.0), ("high", dimension.high, -1.0)):
        if amount is None and what not in implied:
            continue
        bound = implied[what] if amount is None else inner(dimension.kind, amount.number)

        def start(
            values: Values, bound: float = bound, direction: float = direction
        ) -> tuple[float]:
            return (max(0.0, factor * direction * (now(values) - bound)),)

        slack = plan.hide(Hidden((f"slack.{what}",), start, 0.0))
        # quantity - bound - slack = 0, or bound - quantity - slack = 0.
        parts = tuple((row, direction * part) for row, part in total)
        program = program_of(amount.text) if amount is not None else None
        if program is not None:
            scale = direction * factor * turn
            plan.sums.append(Sum(parts, 0.0, ((slack, -1.0),), program, scale))
            continue
        plan.sums.append(Sum(parts, direction * factor * bound, ((slack, -1.0),)))
        if amount is not None:
            plan.settings.append(Setting("sums", len(plan.sums) - 1, what, direction * factor))


def _implied(dimension: Dimension) -> dict[str, float]:
    """The other end of a range of angles that has one: none, or half a turn.

    Beyond them lies where the measure wraps around, -90 and 270 degrees, which a range without an
    end would reach. A range that begins beyond half a turn has no other end.
    """
    if dimension.kind != "angle":
        return {}
    if dimension.high is not None:
        return {} if dimension.low is not None else {"low": 0.0}
    if dimension.low is not None and math.radians(dimension.low.number) <= math.pi:
        return {"high": math.pi}
    return {}


def quantity_of(
    dimension: Dimension, args: list[Operand], values: Values, same: chains.Same
) -> Quantity:
    """The quantity of a dimension."""
    if dimension.kind == "area":
        parts = chains.area_of(args, values, same)
        return Quantity(parts, size=1.0 / chains.size_of(args, values))
    return MAKERS[dimension.kind](args, values, dimension.side, dimension.mode)


def inner(kind: str, number: float) -> float:
    """A dimension's value as equations take it: angles in radians."""
    return math.radians(number) if DIMENSIONS[kind].quantity == "angle" else number


def _measured(quantity: Quantity) -> tuple[list[tuple[Row, float]], float]:
    """Rows that add up to a quantity as a length, and the factor that makes it one."""
    return [(row, factor * quantity.size) for row, factor in quantity.parts], quantity.size


def _equation(plan: Plan, quantity: Quantity, number: float) -> None:
    value = quantity.scale * number + quantity.shift
    if quantity.equation is None:
        parts, factor = _measured(quantity)
        plan.sums.append(Sum(tuple(parts), factor * number))
        plan.settings.append(Setting("sums", 0, "value", factor))
    else:
        struct, uses, data = quantity.equation
        plan.rows.append(Row(struct, uses, {**data, "value": value}))
        plan.settings.append(Setting("rows", 0, "value", quantity.scale, quantity.shift))
    for number_of, (struct, uses, data) in enumerate(quantity.guards):
        plan.guards.append(Row(struct, uses, {**data, "value": value}))
        plan.settings.append(Setting("guards", number_of, "value", quantity.scale, quantity.shift))


def _simple(struct: str, *uses: Use, **data: float) -> Quantity:
    """A row with a field `value` that is 0 or the quantity."""
    return Quantity([(Row(struct, uses, data), 1.0)], (struct, uses, data))


def _length(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    return _simple("Distance", *args[0].line)


def _distance(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    first, second = args
    side = side or side_of_quantity("distance", args, values)
    if first.kind == "point" and second.kind == "point":
        return _simple("Distance", first.at, second.at)
    if second.is_circular:
        return _from_edge(first, second, side, mode)
    if first.kind == "point":
        return _simple("PointLineDistance", first.at, *second.line, side=float(side))
    # Lines that a distance is given of stay parallel, running as they do.
    found = _simple("PointLineDistance", second.line[0], *first.line, side=float(side))
    uses = (*first.line, *second.line)
    along = dot(towards(values, *first.line), towards(values, *second.line))
    found.also = [Row("Parallel", uses)]
    found.kept = [Row("TurnGuard", uses, {"value": 0.0 if sign(along) > 0 else math.pi})]
    return found


def _from_edge(first: Operand, second: Operand, side: int, mode: str) -> Quantity:
    """From a point, a line or a circle to the edge of another circle."""
    center, r = second.circle
    if first.kind == "line":
        across = Row("PointLineDistance", (center, *first.line), {"side": float(side)})
        return Quantity([(across, 1.0), (Row("ScalarValue", (r,)), -1.0)])
    if first.kind == "point":
        apart, edge = Row("Distance", (first.at, center)), Row("ScalarValue", (r,))
        return Quantity([(apart, 1.0), (edge, -1.0)] if side > 0 else [(edge, 1.0), (apart, -1.0)])
    if not mode:
        found = _simple("Difference", r, first.circle.r, side=float(side))
        found.also = [Row("Coincident", (first.center, center))]
        return found
    apart = Row("Distance", (first.center, center))
    own, other = (Row("ScalarValue", (one,)) for one in (first.circle.r, r))
    if mode == "outside":
        return Quantity([(apart, 1.0), (own, -1.0), (other, -1.0)])
    larger, smaller = (other, own) if side > 0 else (own, other)
    return Quantity([(larger, 1.0), (smaller, -1.0), (apart, -1.0)])


def _offset(struct: str, axis: int) -> Maker:
    def make(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
        a, b = args[0].at, args[1].at
        side = side or sign(float(values[b + axis] - values[a + axis]))
        return _simple(struct, a, b, side=float(side))

    return make


def _radius(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    curve = args[0]
    return _simple("ScalarValue", curve.ellipse.rx if curve.is_elliptic else curve.circle.r)


def _diameter(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    r = (args[0].circle.r,)
    return Quantity([(Row("ScalarValue", r), 2.0)], ("ScalarValue", r, {}), scale=0.5)


def _radius_b(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    return _simple("ScalarValue", args[0].ellipse.ry)


def _sweep(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    arc = args[0]
    if arc.entity.kind == "circle":
        return Quantity([], problem="a circle always turns by 360 degrees")
    uses = (arc.center, *arc.ends)
    spokes = (arc.center, arc.ends[0], arc.center, arc.ends[1])
    return Quantity(
        [(Row("SweepMeasure", uses), 1.0)],
        ("Sweep", uses, {}),
        guards=[("TurnGuard", spokes, {})],
        size=abs(float(values[arc.circle.r])) or 1.0,
    )


def _arc_length(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    return Quantity(chains.length_of(args[0]))


def _angle(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    first, second = args
    uses = (*first.line, *second.line)
    u, v = towards(values, *first.line), towards(values, *second.line)
    side = side or side_of_quantity("angle", args, values)
    supplement = mode == "supplement"
    # The turn from the first line to the second is side * value, or side * (pi - value).
    scale, shift = (-side, side * math.pi) if supplement else (side, 0.0)
    # The supplement is -(angle - pi).
    measured = Row(
        "AngleMeasure", uses, {"side": float(side), "turn": -math.pi if supplement else 0.0}
    )
    parts = [(measured, -1.0 if supplement else 1.0)]
    size = min(math.hypot(*u), math.hypot(*v)) or 1.0
    return Quantity(
        parts,
        ("Angle", uses, {}),
        float(scale),
        shift,
        guards=[("TurnGuard", uses, {})],
        size=size,
    )


def _xangle(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    curve = args[0]
    if curve.is_elliptic:
        ellipse = curve.ellipse
        size = abs(float(values[ellipse.rx])) or 1.0
        row = Row("ScalarValue", (ellipse.rot,))
        # Whole and half turns of an ellipse are the same; the nearest is meant.
        return Quantity([(row, 1.0)], size=size)
    uses = curve.line
    u = towards(values, *uses)
    return Quantity(
        [(Row("XAngleMeasure", uses, {"turn": _turn_near(u)}), 1.0)],
        ("XAngle", uses, {}),
        size=math.hypot(*u) or 1.0,
    )


def _middle(dimension: Dimension) -> float:
    """The direction that values of an ``xangle`` are near to, in radians.

    A bound by itself leaves half a turn.
    """
    if dimension.value is not None:
        return math.radians(dimension.value.number)
    low, high = dimension.low, dimension.high
    if low is not None and high is not None:
        return math.radians(0.5 * (low.number + high.number))
    if low is not None:
        return math.radians(low.number) + 0.5 * math.pi
    assert high is not None
    return math.radians(high.number) - 0.5 * math.pi


def _direction(line: Operand, values: Values, middle: float) -> Quantity:
    """Direction of a line within half a turn of a middle one, where it does not wrap around."""
    uses = line.line
    # The measure runs from a right angle behind its first line to three ahead.
    first = middle - _RIGHT
    ahead = Constant((math.cos(first), math.sin(first)))
    row = Row("AngleMeasure", (Constant((0.0, 0.0)), ahead, *uses), {"turn": first})
    size = math.hypot(*towards(values, *uses)) or 1.0
    return Quantity([(row, 1.0)], ("XAngle", uses, {}), size=size)


def _turn_near(u: tuple[float, float]) -> float:
    """What is added to a direction so that it is 0 .. 2 pi."""
    return 2 * math.pi if math.atan2(u[1], u[0]) < 0 else 0.0


def _total_length(args: list[Operand], values: Values, side: int, mode: str) -> Quantity:
    for curve in args:
        if curve.entity.kind not in chains.WITH_LENGTH:
            what = curve.entity.name
            return Quantity(
                [], problem=f"the length of `{what}` can be measured (`derived`), not set"
            )
    return Quantity([part for curve in args for part in chains.length_of(curve)])


def side_of_quantity(kind: str, args: list[Operand], values: Values) -> int:
    """Sign of a quantity as it is drawn: of distances to a line, of offsets, of angles; else 0."""
    first = args[0]
    if kind == "angle":
        lines = (towards(values, *args[0].line), towards(values, *args[1].line))
        return sign(turn(*lines))
    if kind in ("hdistance", "vdistance"):
        axis = kind == "vdistance"
        return sign(float(values[args[1].at + axis] - values[first.at + axis]))
    if kind != "distance":
        return 0
    second = args[1]
    if second.kind == "point":
        return 0
    if second.is_circular:
        if first.kind == "point":
            gap = math.hypot(*towards(values, first.at, second.center))
            return sign(gap - float(values[second.circle.r]))
        if first.kind != "line":
            return sign(float(values[second.circle.r] - values[first.circle.r]))
        return sign(cross(towards(values, *first.line), towards(values, first.at, second.center)))
    line, point = (second, first.at) if first.kind == "point" else (first, second.line[0])
    return sign(cross(towards(values, *line.line), towards(values, line.line[0], point)))


def measure(
    kind: str,
    args: list[Operand],
    values: Values,
    side: int = 0,
    mode: str = "",
    same: chains.Same = chains.apart,
) -> float:
    """A quantity as it is drawn, angles in radians.

    Signed quantities are positive on their side; without a side they are absolute. `same` tells
    which points are one place, where the numbers of a change do not show it yet.
    """
    first = args[0]
    side = side or side_of_quantity(kind, args, values) or 1
    if kind == "length":
        return math.hypot(*towards(values, *first.line))
    if kind in ("hdistance", "vdistance"):
        axis = kind == "vdistance"
        return side * float(values[args[1].at + axis] - values[first.at + axis])
    if kind == "distance":
        return _distance_of(args, values, side, mode)
    if kind in ("radius", "diameter"):
        r = first.ellipse.rx if first.is_elliptic else first.circle.r
        return (2.0 if kind == "diameter" else 1.0) * float(values[r])
    if kind == "radius_b":
        return float(values[first.ellipse.ry])
    if kind == "sweep":
        return sweep_of(values, first)
    if kind == "angle":
        u, v = towards(values, *first.line), towards(values, *args[1].line)
        found = side * turn(u, v)
        if found < -_RIGHT:
            found += 2 * math.pi
        return math.pi - found if mode == "supplement" else found
    if kind == "xangle":
        if first.is_elliptic:
            return float(values[first.ellipse.rot])
        u = towards(values, *first.line)
        return math.atan2(u[1], u[0]) + _turn_near(u)
    if kind == "area":
        return chains.measured_area(args, values, same)
    return sum(chains.measured_length(curve, values) for curve in args)


def _distance_of(args: list[Operand], values: Values, side: int, mode: str) -> float:
    first, second = args
    if second.kind == "point":
        return math.hypot(*towards(values, first.at, second.at))
    if second.is_circular:
        r = float(values[second.circle.r])
        if first.kind == "point":
            return side * (math.hypot(*towards(values, first.at, second.center)) - r)
        if first.kind == "line":
            u, v = towards(values, *first.line), towards(values, first.at, second.center)
            return side * cross(u, v) / (math.hypot(*u) or 1.0) - r
        own, apart = float(values[first.circle.r]), 0.0
        if mode:
            apart = math.hypot(*towards(values, first.center, second.center))
        return apart - own - r if mode == "outside" else side * (r - own) - apart
    line, point = (second, first.at) if first.kind == "point" else (first, second.line[0])
    u = towards(values, *line.line)
    length = math.hypot(*u)
    return side * cross(u, towards(values, line.line[0], point)) / length if length else 0.0


MAKERS: dict[str, Maker] = {
    "length": _length,
    "distance": _distance,
    "hdistance": _offset("HorizontalDistance", 0),
    "vdistance": _offset("VerticalDistance", 1),
    "radius": _radius,
    "diameter": _diameter,
    "radius_b": _radius_b,
    "sweep": _sweep,
    "arc_length": _arc_length,
    "angle": _angle,
    "xangle": _xangle,
    "total_length": _total_length,
}
