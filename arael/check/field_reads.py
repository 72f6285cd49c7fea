"""Reading a field: a column through a slot, if its presence is proved."""

from __future__ import annotations

from arael.check.binding import (
    BROKEN,
    Binding,
    Broken,
    Collection,
    Entity,
    OptionalValue,
    RefList,
)
from arael.check.context import Context
from arael.check.declared import FieldDecl
from arael.check.scope import ComponentScope
from arael.check.typed import BOOL, Apply, Formula, Present, Read, Typed
from arael.check.units_quantities import UNKNOWN
from arael.diagnostics.records import Label, Span
from arael.syntax import tree


def bind_field(t: Context, entity: Entity, name: str, span: Span) -> Binding:
    """The binding of the field `name` of `entity`."""
    if name in entity.place.struct.formulas:
        return bind_formula(t, entity, name, span)
    field = entity.place.struct.fields[name]
    if field.kind == "struct":
        return Entity(entity.steps, entity.place.values[name], entity.holder, entity.needs)
    if field.kind == "collection":
        return Collection(entity, entity.place.collections[name])
    if field.kind == "refs":
        return RefList(entity, field)
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
        return "`skip` fields are stored but never read"
    return f"this is `{field.text}`"


def read_column(t: Context, entity: Entity, field: FieldDecl, span: Span) -> Typed | Broken:
    """The value of a plain field."""
    path = entity.place.column(field)
    optionals = entity.place.optionals
    if isinstance(row_is_there(t, entity, span), Broken):
        return BROKEN
    for optional in (*optionals, path) if field.optional else optionals:
        if (entity.steps, optional) not in t.facts:
            return _unguarded(t, span, optional, field, entity)
    assert field.type is not None
    version, kind = ("trial", field.param.kind) if field.param else ("data", "")
    if entity.place.struct.component:
        version = "trial"  # stored data of a component changes with its updates
    node = Read(
        type=field.type,
        span=span,
        slot=t.slots.of(entity),
        column=path,
        version=version,  # type: ignore[arg-type]
        parameter=kind,
    )
    t.units.read(node, field)
    t.origins[node] = Label(field.span, f"`{field.name}` is declared `{field.text}` here")
    return t.make(node)


def bind_formula(t: Context, entity: Entity, name: str, span: Span) -> Typed | Broken:
    """The formula of a ``symbolic`` field, or the stored value of a ``compute`` field."""
    place = entity.place
    if isinstance(row_is_there(t, entity, span), Broken):
        return BROKEN
    for optional in place.optionals:
        if (entity.steps, optional) not in t.facts:
            first = next(iter(place.struct.fields.values()))
            return _unguarded(t, span, optional, first, entity)
    value = definition(t, entity, name, span)
    if isinstance(value, Broken):
        return BROKEN
    node, column, slot = place.struct.formulas[name], place.prefix + name, t.slots.of(entity)
    if isinstance(node, tree.Symbolic | tree.Tie):
        if isinstance(value, Read):
            return value
        written = Formula(type=value.type, span=span, of=value, slot=slot, column=column)
        return t.make(written)
    read = Read(type=value.type, span=span, slot=slot, column=column, version="computed")
    if (unit := t.units.of(value)) is not UNKNOWN:
        t.units.known[read] = unit
    return t.make(read)


def definition(t: Context, entity: Entity, name: str, span: Span) -> Typed | Broken:
    """The formula of a component, typed once per body and row; `span` is the place of its use."""
    place = entity.place
    node = place.struct.formulas[name]
    key = (entity.steps, place.prefix + name)
    if key not in t.formulas:
        t.formulas[key] = None
        before, t.scope = t.scope, scope_within(t, entity)
        value = t.value(node.value)
        t.scope = before
        t.formulas[key] = value
    found = t.formulas[key]
    if found is not None:
        return found
    return t.fail(
        "E0442",
        node.name.span,
        f"`{name}` of the {place.struct.node.kind} {place.struct.name} depends on itself",
        label="circular definition",
        labels=[Label(span, "used again here")],
        help=["use parameters, stored data and formulas that do not depend on this one"],
    )


def scope_within(t: Context, entity: Entity) -> ComponentScope:
    """Names inside the formulas of a component."""
    return ComponentScope(t.declarations, entity, lambda *use: bind_field(t, *use), t.constant)


def row_is_there(t: Context, entity: Entity, span: Span) -> Broken | None:
    """Report an error if the row of `entity` is reached through a ref that may be null here."""
    for source, column in entity.needs:
        if (source.steps, column) not in t.facts:
            declared = field_at(source, column)
            return _unguarded(t, span, column, declared, source)
    return None


def field_at(entity: Entity, column: str) -> FieldDecl:
    """The ref field of `entity` whose values are the column `column`."""
    field = entity.place.struct.field_at(column.removeprefix(entity.place.prefix))
    assert field is not None, column
    return field


def ref_text(entity: Entity, column: str) -> str:
    """The path to a ref as a constraint writes it: ``parent.prev``."""
    steps = entity.steps
    if any(s.kind == "rows" for s in steps):  # below a row that a sum runs over
        last = max(i for i, s in enumerate(steps) if s.kind == "rows")
        return ".".join([*(s.ref or s.kind for s in steps[last + 1 :]), column])
    return ".".join([*(s.ref or s.kind for s in steps), column])


def _unguarded(t: Context, span: Span, optional: str, field: FieldDecl, entity: Entity) -> Broken:
    """Report a read of an optional that may be absent, with the test to add."""
    table = entity.place.table
    written = span.text
    name = optional.rsplit(".", 1)[-1]
    # `info.gps.pos` reads through `info.gps`: the guard is the text up to the optional's name.
    guard = written
    if optional != entity.place.column(field):
        at = written.rfind(f"{name}.")
        guard = written[: at + len(name)] if at >= 0 else written.rpartition(".")[0] or name
    if field.kind == "ref":
        guard = ref_text(entity, optional)
        at = f".{written}".find(f".{guard}.")
        guard = written[: at + len(guard)] if at >= 0 else guard
    declared = next(
        (
            p.owner.struct.fields[name]
            for p in table.places()
            if p.owner is not None and p.prefix == optional + "."
        ),
        field,
    )
    help_ = []
    if any(s.kind == "rows" for s in entity.steps):
        help_ = [
            "a sum reads every row: each needs a target here"
            if field.kind == "ref"
            else f"write `if {guard} then ... else ...`"
        ]
    return t.fail(
        "E0501",
        span,
        f"`{written}` may be absent here",
        label=f"`{guard}` is optional",
        labels=[Label(declared.span, f"declared `{declared.text}` here")],
        help=help_
        or [
            f"add `when {guard}` to the constraint"
            if field.kind == "ref"
            else f"add `when {guard}` to the constraint, or write `if {guard} then ... else ...`"
        ],
    )


def presence(t: Context, entity: Entity, optionals: tuple[str, ...], span: Span) -> Binding:
    """Whether the row of `entity` and all of `optionals` in it are proved present."""
    tests = [(t.slots.of(source), column) for source, column in entity.needs]
    tests += [(t.slots.of(entity), column) for column in optionals]
    result: Typed | None = None
    for slot, column in tests:
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
