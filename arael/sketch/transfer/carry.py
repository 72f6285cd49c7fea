"""References to an entity that was cut, carried over to its pieces by role."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends
from arael.sketch.document.records import Constraint, Dimension, Parameter
from arael.sketch.editing.editor import Editor
from arael.sketch.expressions.renaming import rename_everywhere
from arael.sketch.transfer.contacts import contact_of
from arael.sketch.transfer.expressions import replacements
from arael.sketch.transfer.pieces import Division
from arael.sketch.transfer.report import Transfer
from arael.sketch.transfer.roles import role_of


class _Lost(Exception):
    """A record has no successor; the reason."""


Pending = list[tuple[Constraint | Dimension, tuple[str, ...]]]


def carry(editor: Editor, division: Division) -> Transfer:
    """Carry over everything that refers to an entity, join its pieces, and remove it.

    The pieces are in the document, the old entity too; a transaction is open.
    """
    document, old = editor.document, division.old
    done = Transfer()
    before = _broken(document)
    copies: Pending = []
    for record in users(document, old.name):
        try:
            _follow(document, division, record, copies, done)
        except _Lost as reason:
            _remove(document, record)
            done.dropped[record.name] = f"{_text(record)} ({reason})"
    done.rewritten = rename_everywhere(document, replacements(division))
    dissolve(document, old.name, done)
    document.remove("entities", old.name)
    editor.solve()
    _join(editor, division, done)
    for record, args in copies:
        _copy(editor, record, args, done)
    done.broken = [name for name in _broken(document) if name not in before]
    return done


def users(document: Document, name: str) -> list[Constraint | Dimension]:
    """Constraints and dimensions that refer to an entity."""
    records: list[Constraint | Dimension] = [*document.constraints.values()]
    records += document.dimensions.values()
    return [one for one in records if any(arg.partition(".")[0] == name for arg in one.args)]


def dissolve(document: Document, name: str, done: Transfer) -> None:
    """Remove the groups that have something as a part."""
    for group in list(document.groups.values()):
        if name in (*group.sources, *group.results, *group.owned):
            document.remove("groups", group.name)
            done.dissolved.append(group.name)


def _broken(document: Document) -> list[str]:
    records: list[Parameter | Dimension] = [*document.parameters.values()]
    records += document.dimensions.values()
    return [one.name for one in records if one.broken]


def _text(record: Constraint | Dimension) -> str:
    return f"{record.kind} {' '.join(record.args)}"


def _remove(document: Document, record: Constraint | Dimension) -> None:
    table = "constraints" if isinstance(record, Constraint) else "dimensions"
    document.remove(table, record.name)


def _follow(
    document: Document,
    division: Division,
    record: Constraint | Dimension,
    copies: Pending,
    done: Transfer,
) -> None:
    if isinstance(record, Dimension):
        extent = _extent(division, record)
        if extent is not None:
            document.put("dimensions", extent)
            done.moved[record.name] = record.name
            return
    choices = [_operands(document, division, record, k) for k in range(len(record.args))]
    first, *others = product(*choices)
    if len(set(first)) < len(first):
        raise _Lost("both operands are one point now")
    name = record.name
    if isinstance(record, Dimension):
        document.put("dimensions", replace(record, args=first))
    elif name == f"C{division.old.name}{record.kind[0].upper()}":
        name = f"C{first[0]}{record.kind[0].upper()}"
        document.rename("constraints", record.name, replace(record, name=name, args=first))
    else:
        document.put("constraints", replace(record, args=first))
    done.moved[name] = record.name
    copies += [(replace(record, name=name), args) for args in others]


def _operands(
    document: Document, division: Division, record: Constraint | Dimension, position: int
) -> list[str]:
    """What takes the place of an operand: several for one that holds for every piece."""
    arg = record.args[position]
    name, _, point = arg.partition(".")
    if name != division.old.name:
        return [arg]
    if not division.parts:
        raise _Lost(f"{name} is gone")
    role = role_of(document, record, position)
    names = [part.entity.name for part in division.parts]
    if role == "point":
        successor = division.successor(point)
        if successor is None:
            raise _Lost(f"{arg} is gone")
        return [successor]
    if role == "whole":
        return names
    if role == "carrier":
        return [_carrier(document, division, record, position)]
    if role == "contact":
        assert isinstance(record, Constraint)
        part = division.at(*contact_of(document, record, position))
        if part is None:
            raise _Lost("its contact was cut away")
        return [part.entity.name]
    raise _Lost("it means the whole, which no piece is")


def _carrier(
    document: Document, division: Division, record: Constraint | Dimension, position: int
) -> str:
    """The piece next to the point that is measured from, else the first."""
    for arg in record.args:
        entity = document.entities[arg.partition(".")[0]]
        if "." in arg or entity.kind == "point":
            at = document.point_at(arg)
            part = division.at(*document.values[at : at + 2].tolist())
            if part is not None:
                return part.entity.name
    return division.parts[0].entity.name


def _extent(division: Division, dimension: Dimension) -> Dimension | None:
    """A length between ends that are still there as a distance; a chain with all pieces."""
    old = division.old
    if dimension.kind == "length":
        p1, p2 = division.successor("p1"), division.successor("p2")
        if p1 is None or p2 is None:
            raise _Lost("an end of it was cut away")
        return replace(dimension, kind="distance", args=(p1, p2), side=1)
    if dimension.kind in ("total_length", "area") and division.whole:
        at = dimension.args.index(old.name)
        names = tuple(part.entity.name for part in division.parts)
        return replace(dimension, args=dimension.args[:at] + names + dimension.args[at + 1 :])
    if dimension.kind == "arc_length" and division.whole and len(division.parts) > 1:
        names = tuple(part.entity.name for part in division.parts)
        return replace(dimension, kind="total_length", args=names)
    return None


def _join(editor: Editor, division: Division, done: Transfer) -> None:
    """Ends that meet are one point; neighbouring arcs have one centre; splines go on smoothly."""
    joints = division.joints()
    for a, b in joints:
        if division.old.clockwise:
            a, b = b, a
        left, right = (
            f"{a.entity.name}.{high_end(a.entity)}",
            f"{b.entity.name}.{low_end(b.entity)}",
        )
        _tie(editor, "coincident", (left, right), done)
        if division.old.kind in ("bezier", "bspline"):
            _tie(editor, "tangent", (left, right), done)
    if division.old.kind in ("circle", "arc", "ellipse", "earc"):
        for a, b in zip(division.parts, division.parts[1:], strict=False):
            _tie(editor, "concentric", (a.entity.name, b.entity.name), done)


def _tie(editor: Editor, kind: str, args: tuple[str, ...], done: Transfer) -> None:
    try:
        with editor.document.transaction(kind):
            done.added.append(editor.constrain(kind, args).name)
    except AraelError:
        return  # follows from what is there


def _copy(
    editor: Editor, record: Constraint | Dimension, args: tuple[str, ...], done: Transfer
) -> None:
    """The same for another piece; what follows from the others is left out or only measured."""
    document = editor.document
    try:
        with document.transaction("copy"):
            if isinstance(record, Constraint):
                made = editor.constrain(
                    record.kind,
                    args,
                    numbers=record.numbers,
                    mode=record.mode,
                    force=record.forced,
                )
                if not record.active:
                    editor.change_constraint(made.name, active=False)
                done.copied[made.name] = record.name
                return
    except AraelError:
        done.implied.append(f"{record.kind} {' '.join(args)}")
        return
    assert isinstance(record, Dimension)
    for derived in (record.derived, True):
        try:
            with document.transaction("copy"):
                one = editor.dimension(
                    record.kind,
                    args,
                    value=record.value,
                    low=record.low,
                    high=record.high,
                    derived=derived,
                    mode=record.mode,
                    force=record.forced,
                )
            done.copied[one.name] = record.name
            return
        except AraelError:
            continue
    done.implied.append(f"{record.kind} {' '.join(args)}")
