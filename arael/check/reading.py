"""Reading a field: a column through a slot, where it is known to be there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from arael.check.binding import BROKEN, Binding, Broken, Collection, Entity, OptionalValue
from arael.check.declared import FieldDecl
from arael.check.typed import BOOL, Apply, Present, Read, Typed
from arael.diagnostics.records import Label, Span

if TYPE_CHECKING:
    from arael.check.typist import Typist


def bind_field(t: Typist, entity: Entity, name: str, span: Span) -> Binding:
    """What the field `name` of `entity` stands for."""
    field = entity.place.struct.fields[name]
    if field.kind == "struct":
        return Entity(entity.steps, entity.place.values[name], entity.holder)
    if field.kind == "collection":
        return Collection(entity, entity.place.collections[name])
    skipped = field.node.role == "skip"
    if field.kind == "ref" and not skipped:
        return t.paths.follow(entity, field)
    if field.kind != "column" or skipped:
        return t.fail(
            "E0304",
            span,
            f"`{name}` cannot be read in an expression",
            label=_unreadable(field),
            labels=[Label(field.span, "declared here")],
        )
    if field.optional:
        return OptionalValue(entity, field, span)
    return read_column(t, entity, field, span)


def _unreadable(field: FieldDecl) -> str:
    if field.node.role == "skip":
        return "`skip` fields are carried along, never read"
    return f"this is `{field.text}`"


def read_column(t: Typist, entity: Entity, field: FieldDecl, span: Span) -> Typed | Broken:
    """The value of a plain field."""
    path = entity.place.column(field)
    optionals = entity.place.optionals
    for optional in (*optionals, path) if field.optional else optionals:
        if (entity.steps, optional) not in t.facts:
            return _unguarded(t, span, optional, field, entity)
    assert field.type is not None
    version, kind = ("trial", field.param.kind) if field.param else ("data", "")
    node = Read(
        type=field.type,
        span=span,
        slot=t.slots.of(entity),
        column=path,
        version=version,  # type: ignore[arg-type]
        parameter=kind,
    )
    t.units.read(node, field)
    t.origins[id(node)] = Label(field.span, f"`{field.name}` is declared `{field.text}` here")
    return t.make(node)


def _unguarded(t: Typist, span: Span, optional: str, field: FieldDecl, entity: Entity) -> Broken:
    """Complain about reading what may not be there, and say how to ask for it."""
    table = entity.place.table
    written = span.text
    name = optional.rsplit(".", 1)[-1]
    # `info.gps.pos` reads through `info.gps`: the guard is the text up to the optional's name.
    guard = written
    if optional != entity.place.column(field):
        at = written.rfind(f"{name}.")
        guard = written[: at + len(name)] if at >= 0 else written.rpartition(".")[0] or name
    declared = next(
        (
            p.owner.struct.fields[name]
            for p in table.places()
            if p.owner is not None and p.prefix == optional + "."
        ),
        field,
    )
    return t.fail(
        "E0501",
        span,
        f"`{written}` may be absent here",
        label=f"`{guard}` is optional",
        labels=[Label(declared.span, f"declared `{declared.text}` here")],
        help=[f"add `when {guard}` to the constraint, or ask with `if {guard} then ... else ...`"],
    )


def presence(t: Typist, entity: Entity, optionals: tuple[str, ...], span: Span) -> Binding:
    """Whether all of `optionals` are there in the row of `entity`."""
    slot = t.slots.of(entity)
    result: Typed | None = None
    for column in optionals:
        test = t.make(Present(type=BOOL, span=span, slot=slot, column=column))
        if isinstance(test, Broken):
            return BROKEN
        if result is None:
            result = test
        else:
            both = t.make(Apply(type=BOOL, span=span, name="and", args=(result, test)))
            if isinstance(both, Broken):
                return BROKEN
            result = both
    return result if result is not None else BROKEN
