"""Places of a layout with and without the names of files.

In a layout that is in use, a place is written as in messages: ``models/fit.arael:31:5``. One that
is stored has the number of the file instead, ``0:31:5``, and neither `Layout.source` nor
`Layout.name`: these belong to the file at hand. Only fields that hold places are changed; a default
or a collection may have the same text as a file's name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import PurePath

from msgspec.structs import replace

from arael.runtime.layout import Group, Layout, Table

Move = Callable[[str], str]


def detached(layout: Layout, names: Sequence[str]) -> Layout:
    """The layout to be stored.

    Parameters
    ----------
    names : of the files whose places it holds, the model's own first
    """
    numbers = {name: str(k) for k, name in enumerate(names)}

    def move(where: str) -> str:
        name, *place = where.rsplit(":", 2)
        return ":".join((numbers[name], *place)) if name in numbers else where

    return replace(_moved(layout, move), source="", name="", warnings=())


def attached(layout: Layout, names: Sequence[str], warnings: tuple[str, ...] = ()) -> Layout:
    """The layout as it is used: the reverse of `detached`, with the names of the files at hand."""
    numbers = {str(k): name for k, name in enumerate(names)}

    def move(where: str) -> str:
        number, *place = where.split(":")
        known = number in numbers and len(place) == 2
        return ":".join((numbers[number], *place)) if known else where

    name = PurePath(names[0]).stem
    return replace(_moved(layout, move), source=names[0], name=name, warnings=warnings)


def _moved(layout: Layout, move: Move) -> Layout:
    return replace(
        layout,
        tables=tuple(_table(table, move) for table in layout.tables),
        groups=tuple(_group(group, move) for group in layout.groups),
        blocks=tuple(replace(b, where=move(b.where)) for b in layout.blocks),
        functions=tuple(replace(f, where=move(f.where)) for f in layout.functions),
    )


def _table(table: Table, move: Move) -> Table:
    return replace(
        table,
        where=move(table.where),
        columns=tuple(replace(c, where=move(c.where)) for c in table.columns),
        values=tuple(replace(v, where=move(v.where)) for v in table.values),
    )


def _group(group: Group, move: Move) -> Group:
    return replace(
        group,
        where=move(group.where),
        places=tuple(replace(p, where=move(p.where)) for p in group.places),
        look_ups=tuple(replace(one, where=move(one.where)) for one in group.look_ups),
    )
