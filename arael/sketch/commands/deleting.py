"""`delete`: by name, the selection, groups, and constraints by what they relate."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.sketch.commands.constraints import WORDS_OF_KINDS
from arael.sketch.commands.describing import noticed, record_line
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.handles import split_handle
from arael.sketch.document.records import Constraint, Dimension, Group, Record

_NAMES = {
    "Entity": "",
    "Constraint": "constraint ",
    "Dimension": "dimension ",
    "Parameter": "parameter ",
    "Group": "group ",
}


@command(
    "delete",
    group="modify",
    usage=[
        "delete L0 [C3 d0 M0 ...]",
        "delete selection",
        "delete M0 all",
        "delete L0 horizontal",
        "delete L0 L1 parallel",
        "delete L0.p2 L1.p1 coincident",
    ],
    summary="Delete entities, constraints, dimensions, parameters, groups.",
    details="""
With an entity go the constraints and dimensions that refer to it, which are listed. A constraint is
also deleted by what it relates, in any order, followed by its kind. Deleting a group keeps its
geometry; with `all` the geometry goes too. Expressions that read what is gone keep their last value
and are marked as broken.
""",
    aliases=("remove",),
    arguments=("*names",),
)
def delete(session: Session, words: Words) -> Reply:
    """Delete."""
    if not words:
        words.missing("what to delete")
    last = words.items[-1]
    if last.text in WORDS_OF_KINDS and session.document.find(session.resolve(last.text)) is None:
        words.items.pop()
        return _deleted(session, [_related(session, words, last).name])
    whole = last.text == "all" and len(words) > 1
    if whole:
        words.items.pop()
    names: list[str] = []
    while words:
        if words.items[0].text == "selection":
            words.next("")
            names += _selected(session, words)
        else:
            names.append(_named(session, words.next("")).name)
    if whole:
        names = [one for name in names for one in _with_results(session, words, name)]
    return _deleted(session, list(dict.fromkeys(names)))


def _selected(session: Session, words: Words) -> list[str]:
    """The selected entities and groups; of selected points nothing."""
    names = [name for name in session.selection if "." not in name]
    if not names:
        hint = "`select L0` selects a line"
        fail("E1259", "nothing is selected", words.statement.span, "", hint)
    return names


def _named(session: Session, token: Token) -> Record:
    document = session.document
    name = session.resolve(token.text)
    found = document.find(name)
    if found is not None:
        return found
    parts = split_handle(name)
    if parts is not None and parts.point and parts.name in document.entities:
        hint = f"`delete {parts.name}` deletes the entity"
        fail("E1256", f"`{token.text}` is a point of an entity", token.span, "", hint)
    tables = (
        document.entities,
        document.constraints,
        document.dimensions,
        document.parameters,
        document.groups,
    )
    near = closest(name, [*(one for table in tables for one in table), *WORDS_OF_KINDS])
    hint = f"did you mean `{near[0]}`?" if near else "`list` shows what there is"
    message = f"nothing in the sketch is called `{token.text[:60]}`"
    fail("E1201", message, token.span, "", hint)


def _with_results(session: Session, words: Words, name: str) -> list[str]:
    group = session.document.groups.get(name)
    if group is None:
        message = f"`all` belongs to a group, and `{name}` is none"
        fail("E1256", message, words.statement.span, "", "`list metas` shows the groups")
    return [name, *group.results]


def _related(session: Session, words: Words, kind: Token) -> Constraint:
    """The constraint of a kind between the operands that follow, in any order."""
    operands: list[Operand] = words.operands("what the constraint relates")
    words.end()
    wanted = sorted(one.handle for one in operands)
    name = WORDS_OF_KINDS[kind.text]
    for constraint in session.document.constraints.values():
        if constraint.kind == name and sorted(constraint.args) == wanted:
            return constraint
    between = " ".join(one.handle for one in operands)
    fail(
        "E1268",
        f"there is no `{name}` of {between}",
        words.statement.span,
        "",
        f"`info {operands[0].handle}` lists the constraints of {operands[0].handle}",
    )


def _deleted(session: Session, names: list[str]) -> Reply:
    document = session.document
    broken = _broken(session)
    owners = dict(document.groups)
    doomed = {name: document.find(name) for name in names}
    lines_of = {one.name: record_line(session, one) for one in _users(session, names)}
    gone = session.editor.delete(names)
    lines = [f"Deleted {_what(one)}" for one in doomed.values() if one is not None]
    cascade = [name for name in gone.names if name not in names]
    if cascade:
        lines.append("  cascade:")
        lines += [f"    {lines_of.get(name, name)}" for name in cascade]
    for name, cause in gone.dissolved.items():
        lines.append(
            f"  notice: {name} ({owners[name].kind}) is dissolved: {cause} was a part of it"
        )
    now = [name for name in _broken(session) if name not in broken]
    if now:
        lines.append(f"  broken: {', '.join(now)} (they keep their last value)")
    return Reply(
        noticed(session, "\n".join(lines)),
        remembered=False,
        data={
            "deleted": list(gone.names),
            "dissolved": list(gone.dissolved),
            "broken": now,
        },
    )


def _users(session: Session, names: list[str]) -> list[Constraint | Dimension]:
    """Constraints and dimensions that may go with these names."""
    document = session.document
    near = set(names)
    for name in names:
        # distances rest on constraints of the same entities
        near.update(document.constraints[name].args if name in document.constraints else ())
    records: list[Constraint | Dimension] = [*document.constraints.values()]
    records += document.dimensions.values()
    return [one for one in records if any(arg.partition(".")[0] in near for arg in one.args)]


def _broken(session: Session) -> list[str]:
    document = session.document
    return [
        *(one.name for one in document.parameters.values() if one.broken),
        *(one.name for one in document.dimensions.values() if one.broken),
    ]


def _what(record: Record) -> str:
    if isinstance(record, Group):
        return f"group {record.name}; its geometry stays"
    kind = type(record).__name__
    return f"{_NAMES[kind] or getattr(record, 'kind', '') + ' '}{record.name}"
