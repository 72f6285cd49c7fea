"""Which form of a kind some handles are meant for; handles in one spelling."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets, split_handle, takes
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS, Form
from arael.sketch.document.records import Entity

#: Relations that mean the same with their operands exchanged (all, or the first and the last).
EXCHANGEABLE = frozenset(
    {
        "horizontal",
        "vertical",
        "parallel",
        "perpendicular",
        "collinear",
        "equal",
        "tangent",
        "smooth",
        "coincident",
        "concentric",
        "symmetry",
        "distance",
        "hdistance",
        "vdistance",
        "angle",
    }
)


def canonical(document: Document, handle: str) -> tuple[Entity, str, str]:
    """Entity, point and spelling of a handle; ``P0.pos`` is spelt ``P0``.

    Raises
    ------
    AraelError
        E1201: no such entity; E1202: it has no such point.
    """
    parts = split_handle(handle)
    entity = document.entity(parts.name if parts else handle)
    point = parts.point if parts else ""
    if point and point not in point_offsets(entity):
        document.point_at(handle)  # raises
    if entity.kind == "point":
        return entity, "", entity.name
    if point.startswith("pole"):
        spelt = {at: name for name, at in reversed(point_offsets(entity).items())}
        point = spelt[point_offsets(entity)[point]]
    return entity, point, f"{entity.name}.{point}" if point else entity.name


def forms_of(kind: str) -> tuple[Form, ...]:
    """Forms of a kind of constraint or dimension."""
    return CONSTRAINTS[kind].forms if kind in CONSTRAINTS else DIMENSIONS[kind].forms


def matched(document: Document, kind: str, args: tuple[str, ...]) -> tuple[Form, tuple[str, ...]]:
    """The form that handles are meant for, and the handles in one spelling and the form's order.

    Of a distance either comes first.

    Raises
    ------
    AraelError
        E1201, E1202: a handle of nothing; E1222: no form takes them, or one of them twice.
    """
    found = [canonical(document, arg) for arg in args]
    for order in (found, found[::-1]) if kind == "distance" else (found,):
        form = _form_of(kind, order)
        if form is None:
            continue
        spelt = tuple(name for _, _, name in order)
        if len(set(spelt)) < len(spelt):
            twice = next(name for name in spelt if spelt.count(name) > 1)
            raise AraelError(
                Diagnostic("E1222", f"`{kind}` is given `{twice}` twice", help=(_usage(kind),))
            )
        return form, spelt
    raise AraelError(
        Diagnostic(
            "E1222",
            f"`{kind}` does not take {_described(found) or 'nothing'}",
            help=(_usage(kind),),
        )
    )


def _form_of(kind: str, found: list[tuple[Entity, str, str]]) -> Form | None:
    for form in forms_of(kind):
        operands = form.operands
        if operands[-1].endswith("*"):
            operands = operands[:-1] + operands[-1:] * max(1, len(found) - len(operands) + 1)
        if len(operands) == len(found) and all(
            takes(operand, entity, point)
            for operand, (entity, point, _) in zip(operands, found, strict=True)
        ):
            return form
    return None


def same_relation(kind: str, one: tuple[str, ...], other: tuple[str, ...]) -> bool:
    """Whether two lists of operands mean the same for a kind."""
    return one == other or (kind in EXCHANGEABLE and one == other[::-1])


def _described(found: list[tuple[Entity, str, str]]) -> str:
    words = [
        f"`{name}` (a point)" if point else f"`{name}` ({entity.kind})"
        for entity, point, name in found
    ]
    return ", ".join(words)


def _usage(kind: str) -> str:
    return f"`{kind}` takes " + ", or ".join(
        " ".join(
            f"{operand.removesuffix('*')} ..." if operand.endswith("*") else operand
            for operand in form.operands
        )
        for form in forms_of(kind)
    )
