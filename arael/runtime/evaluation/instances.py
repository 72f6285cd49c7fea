"""The data of a group's active instances, gathered once per solve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.runtime.assembly.ordering import in_lanes
from arael.runtime.layout import Group
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.machine.programs import columns_of, tape_program
from arael.runtime.store.access import Array, Ints, StoreLike, gather_all

if TYPE_CHECKING:
    from arael.runtime.evaluation.look_up_tables import LookUpTable

# Rows that are evaluated at once: their columns stay in the second-level cache.
_AT_ONCE = 4096


class Instances:
    """Active instances of one group.

    Parameters
    ----------
    rows : (n,) rows of the group's table
    data : (n, data_count) what does not change within a solve, in C or Fortran order
    uniform : (uniform_count,) what is the same for all instances
    tables : of the look-ups of the group
    """

    def __init__(
        self, rows: Ints, data: Array, uniform: Array, tables: Sequence[LookUpTable] = ()
    ) -> None:
        self.rows = rows
        self.tables = tables
        self.uniform = uniform
        self._data: Array | None = data
        self._lanes: dict[int, tuple[Array | None, Array]] = {}

    @property
    def data(self) -> Array:
        """(n, data_count) what does not change within a solve."""
        if self._data is None:
            order, lanes = next(iter(self._lanes.values()))
            self._data = _from_lanes(lanes, len(self.rows), order)
        return self._data

    def in_lanes(self, lanes: int, order: Array | None) -> Array:
        """The data in lane order, of instances in `order`; cached until the order changes.

        Data by instance is freed meanwhile, and gathered again on request.
        """
        kept = self._lanes.get(lanes)
        if kept is None or not _same(kept[0], order):
            kept = self._lanes[lanes] = order, in_lanes(self.data, lanes, order)
            self._data = None
        return kept[1]


def _same(one: Array | None, other: Array | None) -> bool:
    if one is None or other is None:
        return one is other
    return one is other or np.array_equal(one, other)


def gather_instances(
    store: StoreLike,
    group: Group,
    rows: Ints,
    slot_rows: list[Ints],
    dtype: np.dtype[Any],
    natives: NativeTable | None = None,
) -> Instances:
    """Evaluate the group's `prepare` tape over its active rows, in f64, then round to `dtype`.

    Raises
    ------
    SolveError
        E1019: a collection does not have the rows for a look-up.
    """
    found = gathered(store, group, rows, slot_rows, dtype, natives)
    if not group.look_ups:
        return found
    # Imported here for start-up time: only models with look-ups need it.
    from arael.runtime.evaluation.look_up_tables import look_up_tables

    tables = look_up_tables(store, group, slot_rows, dtype)
    data = np.array(found.data, order="F")
    for one in tables:
        data[:, one.first] = one.begin  # where the first search begins
    return Instances(rows, data, found.uniform, tables)


def gathered(
    store: StoreLike,
    group: Group,
    rows: Ints,
    slot_rows: list[Ints],
    dtype: np.dtype[Any],
    natives: NativeTable | None,
) -> Instances:
    """The same without the tables of look-ups."""
    n = len(rows)
    uniform = np.zeros(group.uniform_count, dtype=dtype)
    if not n:
        return Instances(rows, np.zeros((n, group.data_count), dtype=dtype), uniform)
    # By columns, as they are computed: the lanes take them in that order.
    if n <= _AT_ONCE and dtype == np.float64 and not group.prepare.natives:
        # Nothing to convert or to join, and no function of the caller that NumPy might warn of.
        inputs = gather_all(store, group.slots, slot_rows, group.raw_columns)
        program = tape_program(group.prepare, len(inputs))
        found = program.columns(inputs, n if group.reads_rows else 1, dtype)
        if group.uniform_count:
            uniform[:] = found[group.data_count :, 0]
        if found.shape[1] == n:
            return Instances(rows, found[: group.data_count].T, uniform)
        return Instances(rows, np.repeat(found[: group.data_count], n, axis=1).T, uniform)
    data = np.empty((group.data_count, n), dtype=dtype)
    with np.errstate(over="ignore", invalid="ignore"):
        for begin in range(0, n, _AT_ONCE):
            end = min(begin + _AT_ONCE, n)
            part = slot_rows if n <= _AT_ONCE else [one[begin:end] for one in slot_rows]
            inputs = gather_all(store, group.slots, part, group.raw_columns)
            found, _ = columns_of(group.prepare, inputs, np.float64, natives)
            data[:, begin:end] = found[: group.data_count]
            uniform[:] = found[group.data_count :, 0]
    return Instances(rows, data.T, uniform)


def _from_lanes(lanes: Array, n: int, order: Array | None) -> Array:
    """(n, k) by instance of what is in lane order."""
    blocks, k, width = lanes.shape
    found = lanes.transpose(0, 2, 1).reshape(blocks * width, k)[:n]
    if order is None:
        return np.array(found)  # never a view: flags of guards are written into lanes
    data = np.empty_like(found)
    data[order] = found
    return data
