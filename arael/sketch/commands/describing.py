"""Records of a sketch in words, as replies and lists show them."""

from __future__ import annotations

from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.session import Session, measure_of
from arael.sketch.commands.tokens import quoted
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import (
    Amount,
    Constraint,
    Dimension,
    Entity,
    Group,
    Parameter,
    Record,
)
from arael.sketch.expressions.properties import property_of
from arael.sketch.expressions.reading import literal
from arael.sketch.text import height_of


def point_place(document: Document, handle: str) -> str:
    """Where a point is: ``(5, 3)``."""
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return place(x, y)


def entity_line(document: Document, entity: Entity) -> str:
    """``L0: line (0, 0)-(5, 0), length 5 [constr]``."""
    parts = [f"{entity.name}: {entity.kind} {_geometry(document, entity)}"]
    if entity.construction:
        parts.append("[constr]")
    if entity.quiet:
        parts.append("[quiet]")
    if entity.style != "solid":
        parts.append(f"[{entity.style}]")
    return " ".join(parts)


def _geometry(document: Document, entity: Entity) -> str:
    name = entity.name

    def number(of: str) -> str:
        return shown(property_of(document, entity, of) or 0.0)

    def at(point: str) -> str:
        return point_place(document, name if point == "pos" else f"{name}.{point}")

    if entity.kind == "point":
        return at("pos")
    if entity.kind == "line":
        text = ""
        if entity.text:
            length = property_of(document, entity, "length") or 0.0
            height = shown(height_of(entity.text, length))
            text = f", text {quoted(entity.text)}, height {height}"
        return f"{at('p1')}-{at('p2')}, length {number('length')}{text}"
    if entity.kind == "circle":
        return f"center {at('center')}, radius {number('radius')}"
    if entity.kind == "arc":
        return (
            f"{at('start')}-{at('end')}, center {at('center')}, radius {number('radius')}, "
            f"sweep {number('sweep')} deg{', clockwise' if entity.clockwise else ''}"
        )
    axes = f"radii {number('radius')} {number('radius_b')}, rotation {number('rotation')} deg"
    if entity.kind == "ellipse":
        return f"center {at('center')}, {axes}"
    if entity.kind == "earc":
        return f"{at('start')}-{at('end')}, center {at('center')}, {axes}"
    return f"{at('p1')}-{at('p2')}, {entity.size // 2} poles"


def constraint_line(constraint: Constraint) -> str:
    """``C3: coincident L1.p1 L0.p2``."""
    numbers = " ".join(shown(one) for one in constraint.numbers)
    flags = [
        constraint.mode,
        "" if constraint.active else "[off]",
        "[forced]" if constraint.forced else "",
    ]
    words = [constraint.kind, *constraint.args, numbers, *flags]
    return f"{constraint.name}: {' '.join(filter(None, words))}"


def dimension_line(session: Session, dimension: Dimension) -> str:
    """``d0: length L0 = 5 (width/2)``."""
    return f"{dimension.name}: {dimension_text(session, dimension)}"


def dimension_text(session: Session, dimension: Dimension) -> str:
    """``length L0 = 5 (width/2)``, ``distance L0 L1 2 to 5 (now 3)``."""
    mode = f" {dimension.mode}" if dimension.mode else ""
    head = f"{dimension.kind} {' '.join(dimension.args)}{mode}"
    if dimension.is_range:
        now = measure_of(session.editor)(dimension)
        body = f" {_range(dimension)} (now {shown(now)})"
    elif dimension.derived:
        body = f" = ({shown(measure_of(session.editor)(dimension))})"
    else:
        assert dimension.value is not None
        body = f" = {amount_text(dimension.value)}"
    unit = " deg" if DIMENSIONS[dimension.kind].quantity == "angle" else ""
    flags = [
        "derived" if dimension.derived else "",
        "off" if not dimension.active else "",
        "forced" if dimension.forced else "",
        f"broken: {dimension.broken}" if dimension.broken else "",
    ]
    tail = "".join(f" [{flag}]" for flag in flags if flag)
    return f"{head}{body}{unit}{tail}"


def amount_text(amount: Amount) -> str:
    """``5``, or ``5 (width/2)`` of an expression."""
    value = literal(amount.text)
    if value is not None and abs(value) == abs(amount.number):
        return shown(amount.number)
    return f"{shown(amount.number)} ({amount.text})"


def _range(dimension: Dimension) -> str:
    low, high = dimension.low, dimension.high
    if low is not None and high is not None:
        return f"{amount_text(low)} to {amount_text(high)}"
    if low is not None:
        return f">= {amount_text(low)}"
    assert high is not None
    return f"<= {amount_text(high)}"


def parameter_line(parameter: Parameter) -> str:
    """``height = width * 2 (20)``."""
    broken = f" [broken: {parameter.broken}]" if parameter.broken else ""
    return f"{parameter.name} = {parameter.amount.text} ({shown(parameter.amount.number)}){broken}"


def group_line(group: Group) -> str:
    """``M0: offset of L0 L1: L2 L3``."""
    of = f" of {' '.join(group.sources)}" if group.sources else ""
    return f"{group.name}: {group.kind}{of}: {' '.join(group.results)}"


def record_line(session: Session, record: Record) -> str:
    """Any record, in one line."""
    if isinstance(record, Entity):
        return entity_line(session.document, record)
    if isinstance(record, Constraint):
        return constraint_line(record)
    if isinstance(record, Dimension):
        return dimension_line(session, record)
    if isinstance(record, Parameter):
        return parameter_line(record)
    return group_line(record)


def users_of(document: Document, name: str) -> list[Constraint | Dimension]:
    """Constraints and dimensions that name an entity, or one of its points."""
    exact = "." in name

    def uses(arg: str) -> bool:
        return arg == name if exact else arg.partition(".")[0] == name

    found: list[Constraint | Dimension] = []
    for constraint in document.constraints.values():
        if any(map(uses, constraint.args)):
            found.append(constraint)
    for dimension in document.dimensions.values():
        if any(map(uses, dimension.args)):
            found.append(dimension)
    return found


def points_of(entity: Entity) -> list[str]:
    """Handles of an entity's points."""
    if entity.kind == "point":
        return [entity.name]
    return [f"{entity.name}.{name}" for name in point_offsets(entity)]


def noticed(session: Session, text: str) -> str:
    """A reply with what the editor let in with a reservation."""
    lines = [text, *session.editor.notices]
    session.editor.notices.clear()
    return "\n".join(lines)
