"""Rule: ``track.at(t, pos)`` looks a column up between the rows of a collection with a key.

Allowed: on a collection whose struct has a number as ``key``: a column of data, or a parameter of
the rows, read at an argument that may depend on parameters; ``linear`` (the default), ``cubic`` or
``bspline(k)``; ``wrapped`` for angles; ``clamp``; ``rate`` and ``acceleration`` in place of ``at``
for the first and the second derivative.

Not allowed: parameters that are Euler angles, directions or similarities, or of components;
matrices, truth values and text; a look-up within the argument of another; an argument that differs
from row to row of a sum.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields

from arael.check.binding import BROKEN, Binding, Broken, Collection, Entity
from arael.check.declared import FieldDecl
from arael.check.field_reads import read_column, row_is_there
from arael.check.places import Place
from arael.check.suggest import did_you_mean
from arael.check.typed import (
    INT,
    QUATERNION,
    REAL,
    TRANSFORM,
    LookUp,
    Read,
    ScalarType,
    Typed,
    ValueType,
    VectorType,
)
from arael.check.typist import Typist
from arael.check.units import Unit
from arael.check.units_messages import unit_text, written
from arael.check.units_quantities import UNKNOWN, Clash, all_joined, joined
from arael.check.walk import postorder
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import Step
from arael.syntax import tree

METHODS = ("at", "rate", "acceleration")
"""By the derivative that each is."""
ORDERS = range(2, 7)
"""Of B-splines: the number of control points that a value depends on."""

_OPTIONS = ("linear", "cubic", "bspline", "wrapped", "clamp")
_INTERPOLATED = ("real", "vec", "angle", "rotation", "quaternion", "transform")
"""Kinds of parameters that have a value between rows."""


@dataclass
class _Options:
    order: int = 2
    spline: bool = False
    wrapped: bool = False
    clamp: bool = False


@dataclass
class _Column:
    path: str
    field: FieldDecl
    place: Place  # of the struct that has the field


def look_up(t: Typist, node: tree.Call, func: tree.Attribute, table: Collection) -> Binding:
    """``track.at(argument, column, options)`` or ``track.rate(...)``."""
    if func.name not in METHODS:
        near = did_you_mean(func.name, METHODS)
        return t.fail(
            "E0205",
            func.name_span,
            f"a collection has no method `{func.name}`",
            label="unknown method",
            help=near or [f"`{func.obj.span.text}.at(t, x)` looks the column `x` up at `t`"],
        )
    struct = table.site.place.struct
    if not struct.order:
        reals = [f.name for f in struct.fields.values() if f.type == REAL and not f.param]
        shown = reals[0] if reals else "t"
        return t.fail(
            "E0623",
            func.obj.span,
            f"the rows of `{func.obj.span.text}` have no order",
            label=f"{struct.name} has no number as key",
            labels=[Label(struct.node.name.span, f"{struct.name} is declared here")],
            help=[
                f"write `key {shown}` in {struct.name} for a column `{shown}: real` to look up by"
            ],
        )
    if len(node.args) < 2:
        return t.fail(
            "E0303",
            node.span,
            f"`{func.name}` takes an argument and a column, found {len(node.args)}",
            label="in this call",
            help=[f"write `{func.obj.span.text}.{func.name}(t, x)`, x a field of {struct.name}"],
        )
    argument = t.number(node.args[0])
    column = _column(t, node.args[1], table.site.place)
    options = _options(t, node.args[2:])
    if isinstance(row_is_there(t, table.owner, func.obj.span), Broken):
        return BROKEN
    if isinstance(argument, Broken) or column is None or options is None:
        return BROKEN
    return _made(t, node, func, table, argument, column, options)


def _made(
    t: Typist,
    node: tree.Call,
    func: tree.Attribute,
    table: Collection,
    argument: Typed,
    column: _Column,
    options: _Options,
) -> Binding:
    place, field = table.site.place, column.field
    assert field.type is not None
    derivative = METHODS.index(func.name)
    type_ = _rate_type(field.type) if derivative else field.type
    if not _is_single(t, node, argument) or not _keyed(t, node, place, argument):
        return BROKEN
    if type_ is None:
        return t.fail(
            "E0623",
            node.args[1].span,
            "the rate of a transform is not one value",
            label=f"`{field.name}` is a transform",
            help=["look up translation and rotation as two columns, `vec3` and `quat`"],
        )
    if derivative == 2 and field.type == QUATERNION:
        return t.fail(
            "E0623",
            node.args[1].span,
            "a turn has no `acceleration`",
            label=f"`{field.name}` is {field.text}",
            help=["`rate` is its angular velocity"],
        )
    if options.wrapped and not isinstance(field.type, ScalarType):
        return t.fail(
            "E0623",
            node.args[1].span,
            f"`wrapped` is for angles, found {field.type}",
            label=f"this is {field.type}",
            labels=[Label(field.span, "declared here")],
            help=["leave `wrapped` out: quaternions and transforms turn the short way anyway"],
        )
    rows = _rows(t, table, column, argument, options, node.args[1].span) if field.param else []
    if any(isinstance(row, Broken) for row in rows):
        return BROKEN
    made = LookUp(
        type=type_,
        span=node.span,
        of=argument,
        slot=t.slots.of(table.owner),
        collection=table.site.path,
        key=place.prefix + place.struct.order,
        column=column.path,
        order=options.order,
        spline=options.spline,
        wrapped=options.wrapped or (field.param is not None and field.param.kind == "angle"),
        clamp=options.clamp,
        derivative=derivative,
        value=field.type,
        rows=tuple(row for row in rows if isinstance(row, Typed)),
    )
    key = place.struct.fields[place.struct.order]
    t.units.look_up(made, field.quantity, key.quantity)
    return t.make(made, cost=made.order * 8)


def _rows(
    t: Typist,
    table: Collection,
    column: _Column,
    argument: Typed,
    options: _Options,
    span: Span,
) -> list[Typed | Broken]:
    """The parameter in each row that the value depends on.

    Look-ups in one collection at one argument, for the same number of rows, read the same rows.
    """
    owner = table.owner
    at = _numbered(t, argument)
    key = (owner.steps, table.site.path, options.order, options.spline, at)
    number = t.slots.look_ups.setdefault(key, len(t.slots.look_ups) + 1)
    found = []
    for k in range(options.order):
        step = Step("near", f"{table.site.path}@{number}[{k}]")
        row = Entity((*owner.steps, step), column.place, owner, owner.needs)
        found.append(read_column(t, row, column.field, span))
    return found


def _numbered(t: Typist, expression: Typed) -> int:
    """A number that is the same for equal expressions, wherever they are written."""
    numbers: dict[Typed, int] = {}
    for node in postorder([expression]):
        parts: list[Hashable] = [type(node).__name__]
        for field in fields(node):
            value = getattr(node, field.name)
            if isinstance(value, tuple):
                parts.append(tuple(numbers.get(one, one) for one in value))
            elif field.name not in ("span", "type", "unit"):
                parts.append(numbers.get(value, value))
        numbers[node] = t.slots.arguments.setdefault(tuple(parts), len(t.slots.arguments))
    return numbers[expression]


def _column(t: Typist, node: tree.Expr, place: Place) -> _Column | None:
    """The column that is looked up; None after an error."""
    names: list[tree.Name | tree.Attribute] = []
    here = node
    while isinstance(here, tree.Attribute):
        names.insert(0, here)
        here = here.obj
    if not isinstance(here, tree.Name):
        t.fail(
            "E0623",
            node.span,
            f"expected a field of {place.struct.name}",
            label="no name of a field",
            help=["look a field up, and compute with its value: `2 * track.at(t, x)`"],
        )
        return None
    names.insert(0, here)
    field: FieldDecl | None = None
    for number, one in enumerate(names):
        name = one.id if isinstance(one, tree.Name) else one.name
        at = one.span if isinstance(one, tree.Name) else one.name_span
        field = place.struct.fields.get(name)
        if field is None:
            t.fail(
                "E0204",
                at,
                f"{place.struct.name} has no field `{name}`",
                label="unknown field",
                labels=[Label(place.struct.node.name.span, "declared here")],
                help=did_you_mean(name, place.struct.fields),
            )
            return None
        if number < len(names) - 1:
            if field.kind != "struct" or field.optional:
                _unfit(t, one, field)
                return None
            place = place.values[name]
    assert field is not None
    plain = isinstance(field.type, VectorType) or field.type in (REAL, INT, QUATERNION, TRANSFORM)
    fits = field.node.role == "data"
    if field.param:
        fits = field.param.kind in _INTERPOLATED and not place.struct.component
    if field.kind != "column" or field.optional or not (plain and fits):
        _unfit(t, node, field)
        return None
    return _Column(place.column(field), field, place)


def _unfit(t: Typist, node: tree.Expr, field: FieldDecl) -> None:
    what = "optional" if field.optional else f"`{field.text}`"
    help_ = ["look up numbers, vectors, `quat` and `transform`"]
    if field.param:
        help_ = [
            "of parameters look up numbers, vectors, `angle`, `rotation`, `quaternion` and "
            "`transform`"
        ]
    t.fail(
        "E0623",
        node.span,
        f"`{field.name}` cannot be looked up",
        label=f"it is {what}",
        labels=[Label(field.span, "declared here")],
        help=help_,
    )


def _options(t: Typist, nodes: tuple[tree.Expr, ...]) -> _Options | None:
    """How a table is read; None after an error."""
    found = _Options()
    kinds: list[tree.Expr] = []
    for node in nodes:
        name = node.func if isinstance(node, tree.Call) else node
        word = name.id if isinstance(name, tree.Name) else ""
        if word in ("linear", "cubic") and node is name:
            kinds.append(node)
            found.order = 4 if word == "cubic" else 2
        elif word == "bspline" and isinstance(node, tree.Call) and len(node.args) == 1:
            kinds.append(node)
            order = node.args[0]
            value = order.value if isinstance(order, tree.Number) and order.is_integer else 0
            if value not in ORDERS:
                t.fail(
                    "E0623",
                    order.span,
                    "the order of a B-spline is a number from 2 to 6",
                    label="rows that a value depends on",
                    help=["write `bspline(4)` for a cubic spline"],
                )
                return None
            found.order, found.spline = int(value), True
        elif word in ("wrapped", "clamp") and node is name:
            setattr(found, word, True)
        else:
            t.fail(
                "E0623",
                node.span,
                "expected an option of a look-up",
                label="not one",
                help=did_you_mean(word, _OPTIONS)
                or ["options are linear, cubic, bspline(2 to 6), wrapped, clamp"],
            )
            return None
    if len(kinds) > 1:
        t.fail(
            "E0623",
            kinds[1].span,
            "a look-up has one kind of interpolation",
            label="second kind",
            labels=[Label(kinds[0].span, "first given here")],
        )
        return None
    return found


def _rate_type(type_: ValueType) -> ValueType | None:
    """Type of the derivative of a value; None for what has none as one value."""
    if type_ == TRANSFORM:
        return None
    if type_ == QUATERNION:
        return VectorType(3)
    return REAL if type_ == INT else type_


def _is_single(t: Typist, node: tree.Call, argument: Typed) -> bool:
    """Whether the argument is a number that is evaluated once for each instance."""
    inner = next((n for n in postorder([argument]) if isinstance(n, LookUp)), None)
    if inner is not None:
        t.fail(
            "E0622",
            inner.span,
            "a look-up within the argument of another",
            label="looked up first",
            labels=[Label(node.span, "then this")],
            help=["let the data have the inner value as a column of its own"],
        )
        return False
    for read in postorder([argument]):
        if isinstance(read, Read) and any(s.kind == "rows" for s in t.slots.steps(read.slot)):
            t.fail(
                "E0622",
                node.span,
                "a look-up for each row of a sum",
                label="its argument reads the row",
                labels=[Label(read.span, "read here")],
                help=[
                    "sum over a list of refs of fixed length, or let the struct of the row have "
                    "the constraint"
                ],
            )
            return False
    if argument.type not in (REAL, INT):
        t.fail(
            "E0302",
            argument.span,
            f"a table is looked up at a number, found {argument.type}",
            label=f"this is {argument.type}",
            labels=t.origin(argument),
        )
        return False
    return True


def _keyed(t: Typist, node: tree.Call, place: Place, argument: Typed) -> bool:
    """Whether the argument has the unit of the key."""
    key = place.struct.fields[place.struct.order]
    quantity = t.units.of(argument)
    if quantity is UNKNOWN or key.quantity is UNKNOWN:
        return True
    try:
        joined(all_joined(quantity), all_joined(key.quantity))
    except Clash as clash:
        if not (written(t, argument) or key.unit):
            return True
        first, second = clash.first, clash.second
        assert isinstance(first, Unit)
        t.fail(
            "E0321",
            node.args[0].span,
            f"cannot look up at {unit_text(first)} by a key in {second}",
            label=f"this is in {first}",
            labels=[Label(key.span, f"`{key.name}` is declared `{key.text}` here")],
        )
        return False
    return True
