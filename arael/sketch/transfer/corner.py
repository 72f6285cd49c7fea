"""References to the corner of two lines that is cut off, carried over to a point that stays there.

A fillet or chamfer shortens its lines. What was said of the corner (a lock, a distance, a third
line that ends there) and of the full lengths is about the place where the lines would meet, so it
goes to an anchor: a point on both lines.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint, Dimension, Parameter
from arael.sketch.expressions.dependencies import amounts_of, paths_of
from arael.sketch.expressions.renaming import rename_everywhere
from arael.sketch.transfer.carry import users
from arael.sketch.transfer.report import Transfer


@dataclass(frozen=True, slots=True)
class End:
    """An end of a line that meets another one in a corner: ``L0`` at ``p2``."""

    line: str
    point: str

    @property
    def handle(self) -> str:
        """``L0.p2``."""
        return f"{self.line}.{self.point}"

    @property
    def far(self) -> str:
        """Handle of the other end."""
        return f"{self.line}.{'p1' if self.point == 'p2' else 'p2'}"


def needs_anchor(document: Document, ends: tuple[End, End], tie: str) -> bool:
    """Whether anything but the coincident `tie` refers to the corner or to full lengths."""
    for end in ends:
        for record in users(document, end.line):
            if record.name != tie and (
                end.handle in record.args
                or record.kind == "length"
                or (record.kind == "midpoint" and record.args[1] == end.line)
            ):
                return True
    paths = {path for end in ends for path in (end.handle, f"{end.line}.length")}
    records: list[Parameter | Dimension] = [*document.parameters.values()]
    records += document.dimensions.values()
    return any(
        path == one or path.startswith(f"{one}.")
        for record in records
        for _, amount in amounts_of(record)
        for path in paths_of(amount.text)
        for one in paths
    )


def to_anchor(
    document: Document, ends: tuple[End, End], anchor: str, new: str, done: Transfer
) -> None:
    """Let everything that refers to the corner refer to the anchor.

    Parameters
    ----------
    anchor : a point at the corner
    new : the arc or line that cuts the corner off, for chains of curves that run through it
    """
    for end in ends:
        for record in users(document, end.line):
            if isinstance(record, Dimension):
                _dimension(document, end, anchor, new, record, done)
            else:
                _constraint(document, end, anchor, record, done)
    if anchor:
        names = {end.handle: anchor for end in ends}
        names |= {f"{end.line}.length": f"dist({end.far}, {anchor})" for end in ends}
        done.rewritten += [
            one for one in rename_everywhere(document, names) if one not in done.rewritten
        ]


def _dimension(
    document: Document, end: End, anchor: str, new: str, record: Dimension, done: Transfer
) -> None:
    if record.kind in ("total_length", "area"):
        if new in record.args:
            return
        if record.derived:
            at = record.args.index(end.line)
            args = (*record.args[: at + 1], new, *record.args[at + 1 :])
            document.put("dimensions", replace(record, args=args))
            done.moved[record.name] = record.name
        else:
            document.remove("dimensions", record.name)
            done.dropped[record.name] = f"{record.kind} (its outline is another one now)"
        return
    if record.kind == "length":
        changed = replace(record, kind="distance", args=(end.far, anchor), side=1)
    elif end.handle in record.args:
        args = tuple(anchor if arg == end.handle else arg for arg in record.args)
        changed = replace(record, args=args)
    else:
        return
    if len(set(changed.args)) < len(changed.args):
        document.remove("dimensions", record.name)
        done.dropped[record.name] = f"{record.kind} {' '.join(record.args)} (of one point now)"
        return
    document.put("dimensions", changed)
    done.moved[record.name] = record.name


def _constraint(
    document: Document, end: End, anchor: str, record: Constraint, done: Transfer
) -> None:
    changed = record
    if record.kind == "midpoint" and record.args[1] == end.line:
        args: tuple[str, ...] = (end.far, record.args[0], anchor)
        changed = replace(record, kind="symmetry", args=args)
    elif end.handle not in record.args:
        return
    elif record.kind in ("tangent", "smooth") or (
        record.kind == "on_normal" and record.args[1] == end.handle
    ):
        other = record.args[1 - record.args.index(end.handle)].partition(".")[0]
        if record.kind == "tangent" and document.entities[other].kind in ("arc", "earc"):
            changed = replace(record, args=(end.line, other))
        else:
            _drop(document, record, "it needs the end of the line there", done)
            return
    else:
        args = tuple(anchor if arg == end.handle else arg for arg in record.args)
        changed = replace(record, args=args)
    if len(set(changed.args)) < len(changed.args) or any(
        one.name != record.name and one.kind == changed.kind and set(one.args) == set(changed.args)
        for one in document.constraints.values()
    ):
        _drop(document, record, "the anchor has it already", done)
        return
    document.put("constraints", changed)
    done.moved[record.name] = record.name


def _drop(document: Document, record: Constraint, reason: str, done: Transfer) -> None:
    document.remove("constraints", record.name)
    done.dropped[record.name] = f"{record.kind} {' '.join(record.args)} ({reason})"
