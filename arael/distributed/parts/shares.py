"""The rows that each part needs, with the refs among them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.distributed.parts.graph import Graph, slots_on_the_way
from arael.distributed.parts.split import BOUNDARY
from arael.runtime.layout import Column, Layout, Step
from arael.runtime.store import Store
from arael.runtime.store.access import Walker
from arael.runtime.system import System

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Share:
    """The rows of one part, by table, and what it has to do with the whole.

    Attributes
    ----------
    number : of the part
    rows : table -> rows of the whole data set, ascending
    owners : nested table -> (rows,) row of the owner, in the numbers of the part
    refs : (table, column) -> (rows,) index as in data files, in the numbers of the part; -1: none,
        or in no row of the part
    active : per group, rows of its table that this part evaluates if their guards hold, in its
        numbers
    blocks : (local blocks,) block of the whole system for each of the part
    interior, boundary : (local blocks,) bool; the others take no step here
    entity_rows : per entity, its rows that are solved for, of the whole data set
    places : nested table -> (rows,) number within its owner, of the whole data set
    """

    number: int
    rows: dict[str, Ints]
    owners: dict[str, Ints]
    refs: dict[tuple[str, str], Ints]
    active: tuple[Ints, ...]
    blocks: Ints
    interior: NDArray[np.bool_]
    boundary: NDArray[np.bool_]
    entity_rows: tuple[Ints, ...]
    places: dict[str, Ints]


def shares_of(
    store: Store,
    layout: Layout,
    system: System,
    graph: Graph,
    parts: Ints,
    of_instances: list[Ints],
) -> list[Share]:
    """The shares of all parts.

    Parameters
    ----------
    store : refs and owners of all rows
    layout : the model
    parts : (blocks,) part of each block, `BOUNDARY` for those between parts
    of_instances : per group (instances,) the part of each
    """
    refs = {
        (path, column.path): np.asarray(table.target_rows(column.path))
        for path, table in store.tables.items()
        for column in table.data.values()
        if column.role == "ref"
    }
    count = int(max(parts.max(initial=0), *(p.max(initial=0) for p in of_instances), 0)) + 1
    return [
        _share(store, layout, system, graph, parts, of_instances, refs, p) for p in range(count)
    ]


def _share(
    store: Store,
    layout: Layout,
    system: System,
    graph: Graph,
    parts: Ints,
    of_instances: list[Ints],
    refs: dict[tuple[str, str], Ints],
    number: int,
) -> Share:
    needed = {path: np.zeros(table.size, dtype=bool) for path, table in store.tables.items()}
    needed[""][:] = True
    mine = [np.flatnonzero(of == number) for of in of_instances]
    touched = np.zeros(len(parts) + 1, dtype=bool)
    for group, rows, read in zip(layout.groups, mine, graph.blocks, strict=True):
        walker = Walker(store, group.table, rows)
        for slot in slots_on_the_way(group):
            at = np.asarray(walker.rows(slot))
            needed[table_behind(layout, group.table, slot.steps)][at[at >= 0]] = True
        touched[read[rows].ravel()] = True
    for table in reversed(layout.tables):
        if table.parent:
            owners = np.asarray(store.tables[table.path].parent_rows())
            needed[table.parent][owners[needed[table.path]]] = True
    rows_of = {path: np.flatnonzero(mask) for path, mask in needed.items()}
    owners_of = {
        t.path: np.searchsorted(
            rows_of[t.parent], np.asarray(store.tables[t.path].parent_rows())[rows_of[t.path]]
        )
        for t in layout.tables
        if t.parent
    }
    local_refs = {}
    for (path, column), targets in refs.items():
        target = store.tables[path].data[column].target
        assert target is not None
        local_refs[path, column] = _indices(
            targets[rows_of[path]], rows_of[target.table], owners_of.get(target.table)
        )
    entity_rows, found = [], []
    for entity, blocks in zip(layout.entities, system.blocks, strict=True):
        own = blocks.block[rows_of[entity.table]]
        entity_rows.append(rows_of[entity.table][own >= 0])
        found.append(own[own >= 0])
    blocks_here = np.concatenate([np.zeros(0, dtype=np.int64), *found])
    return Share(
        number,
        rows_of,
        owners_of,
        local_refs,
        tuple(
            np.searchsorted(rows_of[group.table], rows)
            for group, rows in zip(layout.groups, mine, strict=True)
        ),
        blocks_here,
        (parts[blocks_here] == number) & touched[blocks_here],
        (parts[blocks_here] == BOUNDARY) & touched[blocks_here],
        tuple(entity_rows),
        {
            t.path: np.asarray(store.tables[t.path].index_in_parent())[rows_of[t.path]]
            for t in layout.tables
            if t.parent
        },
    )


def restricted(share: Share, layout: Layout, whole: System, system: System) -> Share:
    """The share in a pass with fewer blocks: `system` has some of those of `whole`."""
    blocks, kept, entity_rows = [np.zeros(0, dtype=np.int64)], [], []
    for entity, before, now in zip(layout.entities, whole.blocks, system.blocks, strict=True):
        rows = share.rows[entity.table]
        rows = rows[before.block[rows] >= 0]
        moves = now.block[rows] >= 0
        kept.append(moves)
        entity_rows.append(rows[moves])
        blocks.append(now.block[rows[moves]])
    which = np.concatenate([np.zeros(0, dtype=bool), *kept])
    return replace(
        share,
        blocks=np.concatenate(blocks),
        interior=share.interior[which],
        boundary=share.boundary[which],
        entity_rows=tuple(entity_rows),
    )


def _indices(targets: Ints, rows: Ints, owners: Ints | None) -> Ints:
    """Indices within their collections of target rows of the whole; -1 where `rows` lacks them."""
    found = np.full(len(targets), -1, dtype=np.int64)
    if not len(rows):
        return found
    at = np.minimum(np.searchsorted(rows, targets), len(rows) - 1)
    there = rows[at] == targets
    index = at if owners is None else at - np.searchsorted(owners, owners[at])
    found[there] = index[there]
    return found


def table_behind(layout: Layout, path: str, steps: tuple[Step, ...]) -> str:
    """Table that a way from a row of the table `path` ends in."""
    for step in steps:
        if step.kind == "root":
            path = ""
        elif step.kind == "parent":
            path = layout.table(path).parent
        else:
            target = layout.table(path).column(step.ref).target
            assert target is not None
            path = target.table
    return path


def skeleton(layout: Layout) -> Layout:
    """The model without data and constraints: parameters, presence, and refs that may be null."""
    return _with_tables(layout, ("param", "ref", "present"), groups=())


def lenient(layout: Layout) -> Layout:
    """The model with refs that may be null, since a part has not all rows."""
    return _with_tables(layout, None, groups=layout.groups)


def _with_tables(layout: Layout, roles: tuple[str, ...] | None, **changes: object) -> Layout:
    tables = []
    for table in layout.tables:
        columns = [c for c in table.columns if roles is None or c.role in roles]
        known = {c.path for c in columns if c.role == "present"}
        for c in table.columns:
            if c.role == "ref" and c.path not in known:
                columns.append(
                    Column(c.path, "bool", (), "present", "bool", c.where, within=c.path)
                )
        key = table.key if roles is None else ""
        tables.append(msgspec.structs.replace(table, columns=tuple(columns), key=key))
    return msgspec.structs.replace(layout, tables=tuple(tables), **changes)
