"""Commands that answer questions and change nothing: `print`, `info`, `list`, `find`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from arael.diagnostics.suggest import closest
from arael.sketch.commands.constraints import WORDS_OF_KINDS
from arael.sketch.commands.describing import (
    constraint_line,
    dimension_line,
    entity_line,
    group_line,
    parameter_line,
    point_place,
    points_of,
    record_line,
    users_of,
)
from arael.sketch.commands.numbers import exact, place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session, described
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from arael.sketch.document.measures import size_of
from arael.sketch.document.records import Constraint, Dimension, Entity, Group, Parameter, Record
from arael.sketch.expressions.dependencies import readers
from arael.sketch.expressions.properties import property_names, property_of
from arael.sketch.expressions.shapes import curve_of
from arael.sketch.expressions.vectors import Vec


@command(
    "print",
    group="ask",
    usage=["print EXPRESSION ..."],
    summary="Show the value of expressions, coordinates and variables.",
    details="""
```
print L0.length
print dist(P0, L0) width * 2 + 1
print midpoint(L0)
```
""",
    arguments=("*expressions",),
)
def print_(session: Session, words: Words) -> Reply:
    """Show values."""
    lines = []
    values: list[object] = []
    while True:
        token = words.next("an expression")
        text, value = _printed(session, words, token)
        lines.append(text)
        values.append(value)
        if not words:
            break
    return Reply("\n".join(lines), remembered=False, data={"values": values})


def _printed(session: Session, words: Words, token: Token) -> tuple[str, object]:
    name = session.resolve(token.text)
    record = session.document.find(name)
    if isinstance(record, Entity) and record.kind != "point":
        return entity_line(session.document, record), name
    if isinstance(record, Constraint | Group):
        return record_line(session, record), name
    value = words.coordinate_or_number(token)
    if isinstance(value, Vec):
        return f"{token.text} = {described(value)}", [value.x, value.y]
    return f"{token.text} = {shown(value)}", value


@command(
    "info",
    group="ask",
    usage=["info L0", "info L0.p1", "info C3", "info d0", "info width", "info M0"],
    summary="Show everything about one thing, and what refers to it.",
    arguments=("name",),
)
def info(session: Session, words: Words) -> Reply:
    """Show everything about one thing."""
    token = words.next("a name")
    words.end()
    document = session.document
    name = session.resolve(token.text)
    record = document.find(name)
    if record is None:
        variable = session.variable(token.text)
        if variable is not None and not isinstance(variable, str):
            return Reply(f"{token.text}: variable = {described(variable)}", remembered=False)
        found = words.require(token, "a name of something in the sketch")
        return _point_info(session, found.handle)
    lines = [record_line(session, record)]
    if isinstance(record, Entity):
        lines += _entity_info(session, record)
    elif isinstance(record, Dimension):
        lines += _dimension_info(record)
    elif isinstance(record, Group):
        lines += [f"  {key}: {value}" for key, value in record.options.items()]
        lines += [f"  owns: {', '.join(record.owned)}"] if record.owned else []
    if isinstance(record, Dimension | Parameter):
        read = readers(document, record.name)
        lines += [f"  read by: {', '.join(read)}"] if read else []
    return Reply("\n".join(lines), remembered=False, data=_facts(session, record))


def _facts(session: Session, record: Record) -> dict[str, object]:
    """A record for programs."""
    if isinstance(record, Entity):
        facts = {
            name: property_of(session.document, record, name) for name in property_names(record)
        }
        text = {"text": record.text} if record.text else {}
        return {"name": record.name, "kind": record.kind, **text, **facts}
    return {"name": record.name, "text": record_line(session, record)}


def _entity_info(session: Session, entity: Entity) -> list[str]:
    document = session.document
    lines = []
    if entity.kind == "line":
        lines.append(f"  angle {shown(property_of(document, entity, 'angle') or 0.0)} deg")
    for group in document.groups.values():
        if entity.name in group.results:
            lines.append(f"  result of {group_line(group)}")
        elif entity.name in group.sources:
            lines.append(f"  source of {group_line(group)}")
    lines += _users(session, entity.name)
    read = readers(document, entity.name)
    return [*lines, f"  read by: {', '.join(read)}"] if read else lines


def _point_info(session: Session, handle: str) -> Reply:
    document = session.document
    locked = any(
        one.kind in ("lock", "fix") and one.args[0] in (handle, handle.partition(".")[0])
        for one in document.constraints.values()
    )
    head = f"{handle}: {point_place(document, handle)}{' [locked]' if locked else ''}"
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    lines = [head, *_users(session, handle)]
    return Reply("\n".join(lines), remembered=False, data={"x": x, "y": y, "locked": locked})


def _users(session: Session, name: str) -> list[str]:
    return [f"  {record_line(session, one)}" for one in users_of(session.document, name)]


def _dimension_info(dimension: Dimension) -> list[str]:
    lines = [f"  meaning: {DIMENSIONS[dimension.kind].meaning}"]
    for name, amount in (
        ("value", dimension.value),
        ("low", dimension.low),
        ("high", dimension.high),
    ):
        if amount is not None:
            lines.append(f"  {name}: {amount.text} ({exact(amount.number)})")
    lines.append(f"  state: {'derived' if dimension.derived else 'driven'}")
    offset = "automatic" if dimension.offset is None else shown(dimension.offset)
    along = "automatic" if dimension.along is None else shown(dimension.along)
    return [*lines, f"  text: offset {offset}, along {along}"]


# --- lists ----------------------------------------------------------------------------------

_ENTITY_LISTS = {
    "points": ("point",),
    "lines": ("line",),
    "arcs": ("circle", "arc"),
    "circles": ("circle",),
    "ellipses": ("ellipse", "earc"),
    "splines": ("bezier", "bspline"),
}
LISTS = (
    "all",
    *_ENTITY_LISTS,
    "dims",
    "params",
    "constraints",
    "metas",
    "selection",
    "constr",
    "variables",
)


def list_words() -> list[str]:
    """Words that `list` takes."""
    return [*LISTS, *WORDS_OF_KINDS, *DIMENSIONS]


@command(
    "list",
    group="ask",
    usage=["list", "list lines", "list dims", "list parallel", "list radius"],
    summary="List what there is, of all kinds or of one.",
    details="Kinds: "
    + ", ".join(f"`{name}`" for name in LISTS)
    + ", every kind of constraint (`parallel`), every kind of dimension (`radius`).",
    arguments=("kind=",),
)
def list_(session: Session, words: Words) -> Reply:
    """List what there is."""
    token = words.peek()
    kind = words.next("").text if token is not None else "all"
    words.end()
    if token is not None and kind not in list_words():
        near = closest(kind, list_words())
        hint = f"did you mean `{near[0]}`?" if near else "`help list` shows what it takes"
        fail("E1252", f"`list` has no `{kind[:60]}`", token.span, "", hint)
    lines = list(_listed(session, kind))
    return Reply("\n".join(lines) or f"No {kind}", remembered=False, data={"lines": lines})


def _listed(session: Session, kind: str) -> Iterable[str]:
    document = session.document
    entities = document.entities.values()
    plain: dict[str, Callable[[], Iterable[str]]] = {
        "dims": lambda: (dimension_line(session, d) for d in document.dimensions.values()),
        "params": lambda: map(parameter_line, document.parameters.values()),
        "constraints": lambda: map(constraint_line, document.constraints.values()),
        "metas": lambda: map(group_line, document.groups.values()),
        "selection": lambda: session.selection,
        "constr": lambda: (entity_line(document, e) for e in entities if e.construction),
        "variables": lambda: (
            f"{name} = {described(value)}" for name, value in session.state.variables.items()
        ),
    }
    if kind == "all":
        if document.unit != "mm":
            yield f"unit {document.unit}"
        yield from (entity_line(document, e) for e in entities)
        for name in ("constraints", "dims", "params", "metas"):
            yield from plain[name]()
    elif kind in _ENTITY_LISTS:
        kinds = _ENTITY_LISTS[kind]
        yield from (entity_line(document, e) for e in entities if e.kind in kinds)
    elif kind in plain:
        yield from plain[kind]()
    elif kind in DIMENSIONS:
        found = (d for d in document.dimensions.values() if d.kind == kind)
        yield from (dimension_line(session, d) for d in found)
    else:
        wanted = WORDS_OF_KINDS[kind]
        assert wanted in CONSTRAINTS
        constraints = (c for c in document.constraints.values() if c.kind == wanted)
        yield from map(constraint_line, constraints)


# --- by place -------------------------------------------------------------------------------


@command(
    "find",
    group="ask",
    usage=["find x,y", "find x,y radius"],
    summary="Find points and entities near a place.",
    details="Without a radius, within a twentieth of the sketch's size; the nearest comes first.",
    arguments=("at", "radius="),
)
def find(session: Session, words: Words) -> Reply:
    """Find points and entities near a place."""
    at = words.point()
    radius = words.number("the radius", "length", above=0.0) if words else _reach(session)
    words.end()
    document = session.document
    found: list[tuple[float, str]] = []
    for entity in document.entities.values():
        for handle in points_of(entity):
            start = document.point_at(handle)
            x, y = document.values[start : start + 2].tolist()
            found.append((math.hypot(x - at.x, y - at.y), handle))
        if entity.kind != "point":
            nearest = curve_of(document, entity).nearest((at.x, at.y))
            found.append((nearest.distance, entity.name))
    near = sorted(one for one in found if one[0] <= radius)
    lines = [f"{name}: distance {shown(distance)}" for distance, name in near]
    return Reply(
        "\n".join(lines) or f"Nothing within {shown(radius)} of {place(at.x, at.y)}",
        remembered=False,
        data={"found": [name for _, name in near]},
    )


def _reach(session: Session) -> float:
    return 0.05 * size_of(session.document)
