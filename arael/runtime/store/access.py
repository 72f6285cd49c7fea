"""Interface of the store for the solver, and paths from a constraint's row to the rows it reads."""

from __future__ import annotations

from math import prod
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Columns, Layout, Raw, Slot, Step, Total, columns_of
from arael.runtime.machine.programs import evaluate
from arael.runtime.machine.tape import Tape
from arael.runtime.store.compiled import followed, taken

if TYPE_CHECKING:
    from arael.runtime.machine.compiled import NativeTable

Array = NDArray[Any]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class TableLike(Protocol):
    """One table of a store: columns over dense rows."""

    @property
    def size(self) -> int:
        """Number of rows."""

    @property
    def structure_version(self) -> int:
        """Changes whenever rows or refs do."""

    @property
    def data_version(self) -> int | None:
        """Changes whenever data does; None where that is not counted, as views are handed out."""

    @property
    def values_version(self) -> int | None:
        """Changes whenever values of parameters do; None where that is not counted."""

    @property
    def flags_version(self) -> Any:
        """Changes whenever parameters are fixed or freed, or become absent; None: not known."""

    def column(self, path: str) -> Array:
        """Live values (size, *shape)."""

    def columns(self, paths: tuple[str, ...]) -> list[Array]:
        """Live values of several columns."""

    def written(self) -> None:
        """Values of parameters were written into their columns."""

    def present(self, path: str) -> Array:
        """Whether what is at `path` is there (size,)."""

    def free(self, path: str) -> Array:
        """Whether a parameter is solved for (size,)."""

    def column_of_flags(self, path: str, name: str) -> Array:
        """Live flags (size,) of a parameter: ``optimize_translation``."""

    def component_flags(self, path: str) -> Array | None:
        """Live flags (size, tangent) of the components of a parameter; None if all are free."""

    def fixed_components(self, path: str) -> Array | None:
        """Live flags (size, tangent) of components fixed by the data; None if none is."""

    def bound(self, path: str, end: str) -> Array | None:
        """Live bounds (size, *shape) of rows, ``low`` or ``high``; None: those of the model."""

    @property
    def bounds_version(self) -> Any:
        """Differs from what it was whenever bounds of rows do; () if there are none."""

    def parent_rows(self) -> Array:
        """Row of each row's owner (size,)."""

    def target_rows(self, path: str) -> Array:
        """Row that each ref points to (size,), -1 for null."""

    def row_name(self, row: int) -> str:
        """``poses[3]``; "" for the root."""

    def row_names(self, rows: Array) -> list[str]:
        """The same of several rows."""


class StoreLike(Protocol):
    """A model instance: its tables by path, the root's under the empty one."""

    @property
    def layout(self) -> Layout:
        """The compiled model."""

    @property
    def tables(self) -> Any:
        """Path -> `TableLike`."""

    @property
    def structure_version(self) -> Any:
        """Differs from what it was whenever rows or refs of any table have changed."""


class Walker:
    """Follows slots from the rows of one table; each way is walked once.

    Parameters
    ----------
    store : the model instance
    table : path of the table where the ways begin
    rows : (n,) rows to begin from
    whole : whether these are all rows of the table, in order
    """

    def __init__(self, store: StoreLike, table: str, rows: Ints, whole: bool = False) -> None:
        self._store = store
        self._whole = whole
        self._start = table
        self._known: dict[tuple[Step, ...], tuple[str, Ints]] = {(): (table, rows)}
        self._children: dict[str, tuple[Ints, Ints, Ints]] = {}

    def rows(self, slot: Slot) -> Ints:
        """(n,) row of `slot` for each row of the start; -1 where a ref on the way is null."""
        return self._walk(slot.steps)[1]

    def first_null(self, slot: Slot, at: int) -> str:
        """Path of the ref at which the way of the `at`-th row ends."""
        for length in range(1, len(slot.steps) + 1):
            if self._walk(slot.steps[:length])[1][at] < 0:
                return slot.steps[length - 1].ref
        raise ValueError("no ref of this way is null")

    def _walk(self, steps: tuple[Step, ...]) -> tuple[str, Ints]:
        if steps not in self._known:
            path, rows = self._walk(steps[:-1])
            self._known[steps] = self._take(steps[-1], path, rows, self._whole and len(steps) == 1)
        return self._known[steps]

    def _take(self, step: Step, path: str, rows: Ints, whole: bool) -> tuple[str, Ints]:
        if step.kind == "root":
            return "", np.zeros(len(rows), dtype=np.int64)
        layout, table = self._store.layout.table(path), self._store.tables[path]
        if step.kind == "parent":
            return layout.parent, _follow(np.asarray(table.parent_rows()), rows, whole)
        if step.kind == "row":
            return self._element(*step.element, rows)
        target = layout.column(step.ref).target
        assert target is not None
        return target.table, _follow(np.asarray(table.target_rows(step.ref)), rows, whole)

    def _element(self, collection: str, number: int, rows: Ints) -> tuple[str, Ints]:
        """Row of that number in the list of each owner, the last one if there are fewer."""
        if collection not in self._children:
            parents = np.asarray(self._store.tables[collection].parent_rows(), dtype=np.int64)
            self._children[collection] = (
                np.argsort(parents, kind="stable"),
                *lengths_of(self._store, collection),
            )
        order, count, end = self._children[collection]
        found = np.full(len(rows), -1, dtype=np.int64)
        some = np.flatnonzero(rows >= 0)
        some = some[count[rows[some]] > 0]
        owners = rows[some]
        found[some] = order[end[owners] - count[owners] + np.minimum(number, count[owners] - 1)]
        return collection, found


def lengths_of(store: StoreLike, collection: str) -> tuple[Ints, Ints]:
    """(owners,) number of rows in the list of each owner, and the sums of these so far."""
    owner = store.layout.table(collection).parent
    parents = np.asarray(store.tables[collection].parent_rows(), dtype=np.int64)
    count = np.bincount(parents, minlength=store.tables[owner].size).astype(np.int64)
    return count, np.cumsum(count)


def lengths_through(store: StoreLike, collection: str, owners: Ints) -> Ints:
    """(n,) number of rows in the lists of `owners`; 0 where an owner is null."""
    count = lengths_of(store, collection)[0]
    if not len(count):
        return np.zeros(len(owners), dtype=np.int64)
    return np.where(owners >= 0, count[np.maximum(owners, 0)], 0)


def _follow(targets: Array, rows: Ints, whole: bool) -> Ints:
    targets = np.ascontiguousarray(targets, dtype=np.int64)
    return targets if whole else followed(targets, np.ascontiguousarray(rows, dtype=np.int64))


def gather_all(
    store: StoreLike, slots: tuple[Slot, ...], rows: list[Ints], columns: Columns
) -> list[Array]:
    """All raw inputs for all instances as f64; columns of the root come as scalars.

    No row is -1. Each column is read once, however many of its components are inputs.
    """
    found: list[Any] = [None] * sum(len(numbers) for _, _, numbers, _ in columns)
    for slot, column, numbers, components in columns:
        path = slots[slot].table
        if path == "":
            flat = _column(store, path, column)
            for number, component in zip(numbers, components, strict=True):
                found[number] = np.asarray(flat[0, component], dtype=np.float64)
            continue
        if column[-1] == "?" or "#" in column:
            flat = _column(store, path, column)
        else:
            flat = store.tables[path].column(column)
            if flat.ndim > 2:
                flat = flat.reshape(len(flat), prod(flat.shape[1:]))
        values = taken(np.ascontiguousarray(flat), components, rows[slot])
        for number, one in zip(numbers, values, strict=True):
            found[number] = one
    return found


def _column(store: StoreLike, path: str, column: str) -> Array:
    """(rows, scalars) a column of a table, or whether what it names is present."""
    table = store.tables[path]
    if "#" in column:
        return _total(store, store.layout.totals[path, column])
    if column.endswith("?"):
        values = np.asarray(table.present(column[:-1]))
    else:
        values = np.asarray(table.column(column))
    return values if values.ndim == 2 else values.reshape(table.size, prod(values.shape[1:]))


def _total(store: StoreLike, total: Total) -> Array:
    """(owners, sums) of a total, in f64."""
    table, owners = store.tables[total.collection], store.tables[total.owner].size
    rows = np.arange(table.size, dtype=np.int64)
    walker = Walker(store, total.collection, rows, True)
    ways = [walker.rows(slot) for slot in total.slots]
    inputs = gather_all(store, total.slots, ways, columns_of(total.raw))
    terms = outputs(total.tape, inputs, table.size)
    parents = np.asarray(table.parent_rows(), dtype=np.int64)
    return np.stack([np.bincount(parents, term, owners) for term in terms], axis=-1)


def gather(store: StoreLike, slots: tuple[Slot, ...], rows: list[Ints], raw: Raw) -> Array:
    """One raw input for all instances as f64; a column of the root comes as a scalar.

    Rows that are -1 read as NaN: only a guard looks at them.
    """
    path = slots[raw.slot].table
    flat = _column(store, path, raw.column)
    if path == "":
        return np.asarray(flat[0, raw.component], dtype=np.float64)
    at = rows[raw.slot]
    if len(flat) == 0:
        return np.full(len(at), np.nan)
    found = flat[np.maximum(at, 0), raw.component].astype(np.float64)
    if np.any(at < 0):
        found[at < 0] = np.nan
    return np.asarray(found)


def outputs(
    tape: Tape, inputs: list[Array], n: int, natives: NativeTable | None = None
) -> list[Array]:
    """Results of a tape, each as (n,) f64."""
    return [np.broadcast_to(one, (n,)) for one in evaluate(tape, inputs, np.float64, natives)]
