"""Values of dimensions that follow geometry: expressions as parts of rows."""

from __future__ import annotations

import math
from collections.abc import Iterator

from arael.diagnostics.records import AraelError
from arael.runtime.machine.tape import Tape
from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.document.records import Dimension, Parameter
from arael.sketch.expressions.dependencies import amounts_of, reads
from arael.sketch.expressions.gradient import Program, program
from arael.sketch.expressions.reading import literal
from arael.sketch.expressions.refresh import follows_geometry
from arael.sketch.layout.operands import Operand
from arael.sketch.layout.plan import Constant, Row

_ORIGIN = Constant((0.0, 0.0))
_DEGREES = 180.0 / math.pi


def program_of(document: Document, dimension: Dimension, text: str) -> Program | None:
    """An amount of a dimension as a program over geometry; None for what is only a number.

    What cannot be followed keeps the number it had when it was worked out last.
    """
    if literal(text) is not None or dimension.broken:
        return None
    if not follows_geometry(document, dimension.name):
        return None
    try:
        found = program(document, text)
    except AraelError:
        return None
    if not found.geometry or any(property_row(document, path) is None for path in found.geometry):
        return None
    return found


def read_by(document: Document, dimension: Dimension) -> Iterator[str]:
    """Names of parameters and dimensions that a dimension reads, also through others."""
    seen: set[str] = set()
    front: list[Dimension | Parameter] = [dimension]
    while front:
        for name in reads(document, front.pop()):
            if name not in seen:
                seen.add(name)
                yield name
                record = document.parameters.get(name) or document.dimensions.get(name)
                if record is not None:
                    front.append(record)


def is_live(dimension: Dimension) -> bool:
    """Whether an amount of a dimension is more than a literal."""
    return any(literal(amount.text) is None for _, amount in amounts_of(dimension))


def number_of(document: Document, name: str) -> float:
    """Value of a parameter, or of a dimension, as its record has it."""
    parameter = document.parameters.get(name)
    if parameter is not None:
        return parameter.amount.number
    dimension = document.dimensions[name]
    amount = dimension.value or dimension.low or dimension.high
    assert amount is not None
    return amount.number


def property_row(document: Document, path: str) -> Row | None:
    """The row whose residual is a property of an entity: ``L0.length``, ``A0.center.x``.

    Angles in degrees. None for what no row of the model gives.
    """
    name, _, rest = path.partition(".")
    entity = document.entities.get(name)
    if entity is None:
        return None
    point, _, axis = rest.rpartition(".")
    if axis in ("x", "y") and (point or entity.kind == "point"):
        handle = f"{name}.{point}" if point else name
        if split_handle(handle) is None:
            return None
        struct = "HorizontalDistance" if axis == "x" else "VerticalDistance"
        return Row(struct, (_ORIGIN, document.point_at(handle)))
    curve = Operand(entity, "", entity.at)
    if entity.kind == "line":
        if rest == "length":
            return Row("Distance", curve.line)
        return Row("XAngleMeasure", curve.line, {"weight": _DEGREES}) if rest == "angle" else None
    if curve.is_circular:
        return _of_circle(curve, rest)
    if curve.is_elliptic:
        ellipse = curve.ellipse
        scalars = {"radius": ellipse.rx, "radius_b": ellipse.ry, "rotation": ellipse.rot}
        if rest in scalars:
            weight = _DEGREES if rest == "rotation" else 1.0
            return Row("ScalarValue", (scalars[rest],), {"weight": weight})
    return None


def _of_circle(curve: Operand, name: str) -> Row | None:
    center, r = curve.circle
    whole = curve.entity.kind == "circle"
    if name in ("radius", "diameter"):
        return Row("ScalarValue", (r,), {"weight": 2.0 if name == "diameter" else 1.0})
    if name == "sweep":
        if whole:
            return Row("HorizontalDistance", (_ORIGIN, Constant((360.0, 0.0))))
        return Row("SweepMeasure", (center, *curve.ends), {"weight": _DEGREES})
    if name == "length":
        if whole:
            return Row("ScalarValue", (r,), {"weight": 2.0 * math.pi})
        return Row("ArcLength", (center, *curve.ends, r))
    if name in ("start_angle", "end_angle") and not whole:
        end = curve.ends[name == "end_angle"]
        return Row("XAngleMeasure", (center, end), {"weight": _DEGREES})
    return None


def with_program(count: int, tape: Tape, geometry: int) -> Tape:
    """A linear form of `count` quantities plus a multiple of a program.

    Inputs: the quantities, the program's geometry; then the factors of the quantities, that of the
    program, its numbers. Outputs: the value, then its derivatives by quantities and geometry.
    """
    ops: list[str] = []
    args: list[tuple[int, ...]] = []

    def node(op: str, *operands: int) -> int:
        ops.append(op)
        args.append(operands)
        return len(ops) - 1

    for op, operands in zip(tape.ops, tape.args, strict=True):
        if op == "input":
            number = operands[0]
            shifted = number + count if number < geometry else number + 2 * count + 1
            node("input", shifted)
        else:
            node(op, *operands)
    scale = node("input", geometry + 2 * count)
    factors = [node("input", geometry + count + k) for k in range(count)]
    total = node("mul", scale, tape.outputs[0])
    for k, factor in enumerate(factors):
        total = node("add", total, node("mul", factor, node("input", k)))
    slopes = [node("mul", scale, output) for output in tape.outputs[1:]]
    return Tape(tuple(ops), tuple(args), tape.constants, (total, *factors, *slopes))
