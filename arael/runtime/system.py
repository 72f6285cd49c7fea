"""Which scalars are solved for: entity rows as blocks of the system, in order, with their names."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.bounds import Bounded, all_open, bounded_of, bounds_of_scalars, has_bounds
from arael.runtime.layout import Entity, Layout, Param, ParamUse
from arael.runtime.store.access import Bools, Ints, StoreLike, TableLike
from arael.runtime.store.compiled import all_set, numbered, some_set, spread_flags

Floats = NDArray[np.float64]


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class EntityBlocks:
    """The rows of one entity as blocks of the system.

    Attributes
    ----------
    first : (rows,) int64, first scalar of the row in the system; -1 if it is not solved for
    block : (rows,) int64, number of the row's block; -1 if it is not solved for
    free : (rows, tangent) bool, scalars that move
    """

    first: Ints
    block: Ints
    free: Bools

    @cached_property
    def every(self) -> bool:
        """Whether all scalars of all rows move."""
        return all_set(self.free)

    @cached_property
    def solved(self) -> Bools:
        """(rows,) whether some scalar of the row moves."""
        if self.every:
            return np.ones(len(self.free), dtype=bool)
        return some_set(self.free)


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class System:
    """Blocks in order of entities as the layout lists them, rows in table order.

    An entity row with at least one free scalar is a whole block; its other scalars are `held`.
    A session keeps the blocks of rows that were fixed since: all their scalars are `held`.

    Attributes
    ----------
    blocks : one per entity of the layout
    sizes : (nb,) int64, scalars of each block
    held : int64, scalars of the system that do not move, ascending
    low, high : (n,) f64, bounds of each scalar, infinite where open
    """

    layout: Layout
    store: StoreLike
    blocks: tuple[EntityBlocks, ...]
    sizes: Ints
    held: Ints
    low: Floats
    high: Floats
    starts: tuple[int, ...]  # first scalar of each entity

    @cached_property
    def size(self) -> int:
        """Number of scalars."""
        return int(self.sizes.sum())

    @cached_property
    def bounded(self) -> tuple[Bounded, ...]:
        """The bounded scalars that move, of each entity that has some."""
        if not ((self.low != -np.inf) | (self.high != np.inf)).any():
            return ()
        found = []
        for number, (entity, blocks) in enumerate(
            zip(self.layout.entities, self.blocks, strict=True)
        ):
            at = slice(
                self.starts[number],
                self.starts[number] + (blocks.first >= 0).sum() * entity.tangent,
            )
            one = bounded_of(number, entity, blocks.first, self.low[at], self.high[at])
            if len(one.scalars):
                found.append(one)
        return tuple(found)

    def owner(self, scalar: int) -> tuple[int, int, int]:
        """Entity, row and tangent index of a scalar of the system."""
        number = bisect_right(self.starts, scalar) - 1
        first = self.blocks[number].first
        tangent = self.layout.entities[number].tangent
        solved = np.flatnonzero(first >= 0)
        row = int(solved[(scalar - self.starts[number]) // tangent])
        return number, row, scalar - int(first[row])

    def name_of(self, scalar: int) -> str:
        """Name of a scalar in the model's words: ``poses[3].ea.z``."""
        number, row, tangent = self.owner(scalar)
        entity = self.layout.entities[number]
        name = entity.prefix + entity.tangent_names[tangent]
        place = row_name(self.store, entity.table, row)
        return f"{place}.{name}" if place else name

    def names(self) -> list[str]:
        """Names of all scalars, in order."""
        found = []
        for entity, blocks in zip(self.layout.entities, self.blocks, strict=True):
            for row in np.flatnonzero(blocks.first >= 0):
                place = row_name(self.store, entity.table, int(row))
                head = f"{place}." if place else ""
                found += [f"{head}{entity.prefix}{name}" for name in entity.tangent_names]
        return found


def blocks_of(system: System, names: Sequence[str]) -> Ints:
    """Blocks of all rows of the named collections; AraelError E0842 for one that has none."""
    found = [np.zeros(0, dtype=np.int64)]
    tables = [entity.table for entity in system.layout.entities if entity.table]
    for name in names:
        if name not in tables:
            near = closest(name, tables)
            raise AraelError(
                Diagnostic(
                    "E0842",
                    f"eliminate names `{name}`, which is no collection with parameters",
                    origin="solver options",
                    notes=(f"collections with parameters are {', '.join(tables) or 'none'}",),
                    help=(f"did you mean `{near[0]}`?",) if near else (),
                )
            )
        for entity, blocks in zip(system.layout.entities, system.blocks, strict=True):
            if entity.table == name:
                found.append(blocks.block[blocks.block >= 0])
    return np.sort(np.concatenate(found))


def row_name(store: StoreLike, table: str, row: int) -> str:
    """Name of a row, ``poses[3]``."""
    return str(store.tables[table].row_name(row))


def row_names(store: StoreLike, table: str, rows: Ints) -> list[str]:
    """Names of several rows."""
    return list(store.tables[table].row_names(rows))


def free_scalars(store: StoreLike, entity: Entity, frozen: frozenset[str]) -> Bools:
    """(rows, tangent) which scalars of an entity move.

    A parameter is held by `frozen` or by the store: by its data, by its flag, or because the
    optional struct that it belongs to is absent. Parts and components are held by flags of their
    own, and components by the model.
    """
    table = store.tables[entity.table]
    free = np.zeros((table.size, entity.tangent), dtype=bool)
    for use in entity.params:
        if not use.tangent or is_frozen(entity.table, use.column, frozen):
            continue
        mask = np.ascontiguousarray(table.free(use.column), dtype=bool)
        spread_flags(mask, free, use.tangent_start, use.tangent)
        param = store.layout.table(entity.table).column(use.column).param
        if param is None:
            continue
        _hold_components(free, entity, use, param, table, frozen)
        for part in param.parts:
            first = use.tangent_start + part.first
            moves = np.array(table.column_of_flags(use.column, f"optimize_{part.name}"), dtype=bool)
            if is_frozen(entity.table, f"{use.column}.{part.name}", frozen):
                moves[:] = False
            free[:, first : first + part.count] &= moves[:, None]
    return free


def _hold_components(
    free: Bools,
    entity: Entity,
    use: ParamUse,
    param: Param,
    table: TableLike,
    frozen: frozenset[str],
) -> None:
    """Clear the scalars of a parameter that are held one by one."""
    own = free[:, use.tangent_start : use.tangent_start + use.tangent]
    if param.held:
        own[:, list(param.held)] = False
    flags = table.component_flags(use.column)
    if flags is not None:
        own &= flags
    fixed = table.fixed_components(use.column)
    if fixed is not None:
        own &= ~fixed
    if frozen:
        for k, name in enumerate(param.components):
            if is_frozen(entity.table, f"{use.column}.{name}", frozen):
                own[:, k] = False


def is_frozen(table: str, column: str, frozen: frozenset[str]) -> bool:
    """Whether a column or what it lies in is among the frozen paths."""
    path = f"{table}.{column}" if table else column
    return any(path == f or path.startswith(f + ".") for f in frozen)


def build_system(store: StoreLike, free: list[Bools]) -> System:
    """Number the blocks of all entities; `free` as `free_scalars` gives it, one per entity."""
    layout = store.layout
    rows, sizes, held, starts, size = numbered(free)
    blocks = []
    for (first, number, every), moves in zip(rows, free, strict=True):
        one = EntityBlocks(first, number, moves)
        one.__dict__["every"] = every  # as the cached property keeps it
        blocks.append(one)
    ends = None
    if any(map(has_bounds, repeat(store), layout.entities, layout.bounded)):
        ends = _bounds(store, blocks)
    low, high = ends or all_open(size)
    found = System(layout, store, tuple(blocks), sizes, held, low, high, tuple(starts))
    found.__dict__["size"] = size
    if ends is None:
        found.__dict__["bounded"] = ()
    return found


def _bounds(store: StoreLike, blocks: Sequence[EntityBlocks]) -> tuple[Floats, Floats]:
    """Bounds of all scalars of a system."""
    low: list[Floats] = [np.zeros(0)]
    high: list[Floats] = [np.zeros(0)]
    for entity, one in zip(store.layout.entities, blocks, strict=True):
        rows = np.flatnonzero(one.first >= 0)
        lower, upper = bounds_of_scalars(store, entity, rows, len(rows), one.free)
        low.append(lower)
        high.append(upper)
    return np.concatenate(low), np.concatenate(high)


def hold(system: System, free: list[Bools], held: Ints) -> System:
    """The same blocks with other scalars `held`: `free` as for `build_system`.

    Rows in which nothing moves keep their blocks. What moves must have one.
    """
    blocks = [
        EntityBlocks(known.first, known.block, moves)
        for known, moves in zip(system.blocks, free, strict=True)
    ]
    open_before = system.bounded == ()
    ends = None
    if any(map(has_bounds, repeat(system.store), system.layout.entities, system.layout.bounded)):
        ends = _bounds(system.store, blocks)
    elif not open_before:
        ends = all_open(system.size)
    low, high = ends or (system.low, system.high)
    found = replace(system, blocks=tuple(blocks), held=held, low=low, high=high)
    found.__dict__["size"] = system.size  # as the cached property keeps it
    return found


def with_bounds(system: System) -> System:
    """The same system with the bounds that rows have now."""
    low, high = _bounds(system.store, system.blocks)
    return replace(system, low=low, high=high)
