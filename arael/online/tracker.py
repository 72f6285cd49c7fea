"""What an online solve knows of a model's data, and what of it has changed since it looked.

Nothing is announced: Python writes through views. Rows are compared by their handles, values and
data by content. Where rows were only appended, the cost is that of a comparison of the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.online.priors import PriorBlock, params_of
from arael.runtime.assembly.structure import active_rows, rows_of_slots
from arael.runtime.evaluation.instances import gather_instances
from arael.runtime.evaluation.states import stored_scalars
from arael.runtime.incremental.compiled import Linearisations
from arael.runtime.layout import Group, Layout
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.store.access import Ints, StoreLike
from arael.runtime.store.compiled import fingerprints
from arael.runtime.store.references import walk
from arael.runtime.store.table import Table
from arael.runtime.system import free_scalars

Int32 = NDArray[np.int32]
F64 = np.dtype(np.float64)


class Rows:
    """The rows of one table, as they were when they were last looked at.

    Attributes
    ----------
    version : of the table's structure
    handles : (n,) of its rows
    moved_to : (n before,) row now of each row of before, -1 if it was removed; None: all stayed
    before : rows there were
    refs : handles of its ref columns, by path
    same_refs : whether the rows of before have the refs of before
    """

    def __init__(self) -> None:
        self.version = -1
        self.handles: Ints = np.zeros(0, dtype=np.int64)
        self.moved_to: Ints | None = None
        self.before = 0
        self.refs: dict[str, Ints] = {}
        self.same_refs = True

    def look(self, table: Any, refs: Sequence[str]) -> bool:
        """Compare with the table; returns whether anything has changed."""
        self.moved_to, self.same_refs = None, True
        self.before = len(self.handles)
        if self.version == table.structure_version:
            return False
        self.version = table.structure_version
        known, n = self.handles, self.before
        if not isinstance(table, Table):  # of a runtime residual: its rows are compared by number
            self.handles = np.arange(table.size, dtype=np.int64)
            self.same_refs = False
            if table.size < n:
                self.moved_to = np.where(known < table.size, known, -1)
            return True
        self.handles = table.handles(slice(None))
        if len(self.handles) < n or not np.array_equal(self.handles[:n], known):
            self.moved_to = table.rows_of(known)
        for path in refs:
            now = table.column(path)
            if self.moved_to is None:
                before = self.refs.get(path)
                if before is not None and not np.array_equal(now[:n], before):
                    self.same_refs = False
            self.refs[path] = now.copy()
        return True


class Terms:
    """Instances of one group: rows of its table, numbers in the engine, variables they read."""

    def __init__(self, uses: int) -> None:
        self.rows: Ints = np.zeros(0, dtype=np.int64)
        self.numbers: Int32 = np.zeros(0, dtype=np.int32)
        self.variables: Int32 = np.zeros((0, uses), dtype=np.int32)
        self.uniform: NDArray[np.float64] | None = None


class Tracker:
    """The rows and instances of a model, as variables and terms of an engine.

    Parameters
    ----------
    layout, store, kernels, programs, natives : as those of `Problem`

    Attributes
    ----------
    engine : factor and linearisation points
    variables : per entity, (rows,) numbers of its rows in the engine
    stored : per entity, (rows, stored) values of its rows
    held : per entity, (rows, tangent) scalars that do not move
    terms : per group, its instances
    frozen : paths that the last `take` was given
    changed : whether `take` found anything
    """

    def __init__(
        self, layout: Layout, store: StoreLike, kernels: Any, programs: Any, natives: NativeTable
    ) -> None:
        self.layout, self.store, self.kernels = layout, store, kernels
        self.engine = Linearisations(layout, kernels, programs, natives)
        self._natives = natives
        self._tables = {table.path: Rows() for table in layout.tables}
        self._refs = {
            table.path: tuple(c.path for c in table.columns if c.role == "ref")
            for table in layout.tables
        }
        self._version: Any = None
        self.variables: list[Int32] = [np.zeros(0, dtype=np.int32) for _ in layout.entities]
        self.stored = [np.zeros((0, one.stored)) for one in layout.entities]
        self.held = [np.zeros((0, one.tangent), dtype=bool) for one in layout.entities]
        self._flags: list[Any] = [None for _ in layout.entities]
        self.terms = [Terms(len(group.uses)) for group in layout.groups]
        self._plain = [
            isinstance(store.tables[group.table], Table) and _is_plain(layout, group)
            for group in layout.groups
        ]
        self._params = params_of(layout)
        self._priors: dict[Any, int] = {}  # residual by own code -> number in the engine
        self.frozen: frozenset[str] = frozenset()
        self._passed = [_passed(layout, group) for group in layout.groups]
        self._seen: dict[str, tuple[int, list[Any]]] = {}
        self.changed = False

    # --- looking for changes -----------------------------------------------------------------

    def take(self, frozen: frozenset[str], priors: Mapping[str, Any]) -> None:
        """Take in all that has changed in the store, and in the priors, since the last call."""
        self.frozen = frozen
        current = set(priors.values())
        moved = self._look_at_rows()
        touched = self._look_at_data()
        # Instances that go come first, then the rows that they read.
        removed = self._map_rows(moved)
        added = self._map_terms(moved, touched)
        for code in self._priors.keys() - current:
            self.engine.remove_prior(self._priors.pop(code))
        for variables in removed:
            self.engine.remove_rows(variables)
        self._take_rows(frozen)
        for number, rows, ways in added:
            self._add_terms(number, rows, ways)
        for code in priors.values():
            if code not in self._priors:
                self._add_prior(code)
        self.changed = bool(moved or touched or added)

    def _look_at_rows(self) -> set[str]:
        """Paths of the tables whose rows or refs have changed."""
        if self._version == self.store.structure_version:
            for one in self._tables.values():
                one.moved_to, one.same_refs, one.before = None, True, len(one.handles)
            return set()
        self._version = self.store.structure_version
        return {
            path
            for path, rows in self._tables.items()
            if rows.look(self.store.tables[path], self._refs[path])
        }

    def _look_at_data(self) -> set[int]:
        """Numbers of the groups whose rows of before read data that has changed."""
        found: set[int] = set()
        for path, (columns, optionals, readers) in self.layout.read_columns.items():
            table, rows = self.store.tables[path], self._tables[path]
            if not table.size and not rows.before:
                continue
            contents = table.columns(columns)
            if optionals:
                contents = [*contents, *map(table.present, optionals)]
            count, before = self._seen.get(path, (0, []))
            size = table.size
            if rows.moved_to is not None:
                found.update(*readers)
                now = fingerprints(contents)
            else:
                now = fingerprints([one[:count] for one in contents] if count < size else contents)
                for groups, was, present in zip(readers, before, now, strict=bool(before)):
                    if was != present:
                        found.update(groups)
                if count < size:
                    now = fingerprints(contents)
            self._seen[path] = (size, now)
        return found

    # --- rows of entities --------------------------------------------------------------------

    def _map_rows(self, moved: set[str]) -> list[Int32]:
        """Let variables follow their rows; new rows have -1. Returns variables of removed rows."""
        removed = []
        for e, entity in enumerate(self.layout.entities):
            if entity.table not in moved:
                continue
            rows, known = self._tables[entity.table], self.variables[e]
            n = len(rows.handles)
            if rows.moved_to is None and n == len(known):
                continue
            found = np.full(n, -1, dtype=np.int32)
            stored, held = np.zeros((n, entity.stored)), np.zeros((n, entity.tangent), dtype=bool)
            to = slice(len(known)) if rows.moved_to is None else rows.moved_to
            keep: Any = slice(None)
            if rows.moved_to is not None:
                keep = rows.moved_to >= 0
                to = rows.moved_to[keep]
                self._flags[e] = None  # the same flags may be those of other rows
                removed.append(known[~keep])
            found[to] = known[keep]
            stored[to], held[to] = self.stored[e][keep], self.held[e][keep]
            self.variables[e], self.stored[e], self.held[e] = found, stored, held
        return removed

    def _take_rows(self, frozen: frozenset[str]) -> None:
        """New rows, other values, other flags."""
        for e, entity in enumerate(self.layout.entities):
            numbers = self.variables[e]
            table = self.store.tables[entity.table]
            if not len(numbers):
                continue
            stored = stored_scalars(self.store, entity, F64)
            new = np.flatnonzero(numbers < 0)
            if len(new):
                numbers[new] = self.engine.add_rows(e, stored[new])
                self.stored[e][new] = stored[new]
            if not np.array_equal(stored, self.stored[e]):
                other = np.flatnonzero((stored != self.stored[e]).any(axis=1))
                self.engine.put_rows(e, numbers[other], stored[other])
                self.stored[e] = stored
            flags = (table.flags_version, frozen)
            if flags != self._flags[e]:
                self._flags[e] = flags
                held = ~free_scalars(self.store, entity, frozen)
                differs = np.flatnonzero((held != self.held[e]).any(axis=1))
                if len(differs):
                    self.engine.hold(numbers[differs], held[differs].view(np.uint8))
                self.held[e] = held

    def _add_prior(self, code: Any) -> None:
        block = PriorBlock(self.layout, self._params, code)
        rows = [
            (e, 0 if handle < 0 else self.store.tables[path].row_of(handle))
            for e, path, handle in block.rows
        ]
        variables = np.array([self.variables[e][row] for e, row in rows], dtype=np.int32)
        self._priors[code] = self.engine.add_prior(variables, code.count, block)

    def forget(self) -> None:
        """Let the next `take` compare estimates with the values of the store, not with the last."""
        for e in range(len(self.layout.entities)):
            self.stored[e] = self.engine.estimates(e, self.variables[e])

    def put_back(self) -> dict[str, Ints]:
        """Write the estimates that have moved into the store; returns the rows, by table."""
        moved = self.engine.take_moved()
        found: dict[str, Ints] = {}
        if not len(moved):
            return found
        kinds = self.engine.entities_of(moved)
        for e, entity in enumerate(self.layout.entities):
            mine = moved[kinds == e]
            if not len(mine):
                continue
            rows = self._rows_of(e, mine)
            values = self.engine.estimates(e, mine)
            table = self.store.tables[entity.table]
            for use in entity.params:
                part = values[:, use.stored_start : use.stored_start + use.stored]
                column = table.column(use.column)
                column[rows] = part.reshape(len(rows), *column.shape[1:])
            table.written()
            self.stored[e][rows] = values
            before = found.get(entity.table)
            found[entity.table] = rows if before is None else np.union1d(before, rows)
        return found

    def _rows_of(self, e: int, variables: Int32) -> Ints:
        """Dense rows of variables of an entity."""
        numbers = self.variables[e]
        place = np.empty(int(numbers.max()) + 1, dtype=np.int64)
        place[numbers] = np.arange(len(numbers))
        return place[variables]

    def is_current(self, priors: Mapping[str, Any]) -> bool:
        """Whether rows, refs and priors are those of the last `take`."""
        same = self._priors.keys() == set(priors.values())
        return same and bool(self._version == self.store.structure_version)

    def marginal(self, path: str, row: int) -> NDArray[np.float64] | None:
        """Covariance of a row; None with several entities, held or undetermined scalars."""
        entities = [e for e, one in enumerate(self.layout.entities) if one.table == path]
        if len(entities) != 1 or self.engine.tree.undetermined:
            return None
        e = entities[0]
        if self.held[e][row].any():
            return None
        found: NDArray[np.float64] = self.engine.tree.marginal(int(self.variables[e][row]))
        return found

    # --- instances of groups -----------------------------------------------------------------

    def _map_terms(
        self, moved: set[str], touched: set[int]
    ) -> list[tuple[int, Ints, list[Ints] | None]]:
        """Remove instances that are gone or read other rows, and refresh the data of others.

        Returns
        -------
        Per group with new instances its number, their rows, and the rows of its slots, or None if
        these are still to be found.
        """
        added: list[tuple[int, Ints, list[Ints] | None]] = []
        for number, group in enumerate(self.layout.groups):
            own = self._tables[group.table]
            passed = self._passed[number]
            if number not in touched and passed is not None and not (passed & moved):
                continue
            simple = (
                self._plain[number]
                and number not in touched
                and own.moved_to is None
                and all(
                    self._tables[path].moved_to is None and self._tables[path].same_refs
                    for path in passed or ()
                )
            )
            if simple:
                first, last = len(self.terms[number].rows), len(own.handles)
                if last > first:
                    rows = np.arange(first, last, dtype=np.int64)
                    added.append((number, rows, None))
                continue
            found = self._compare(number, group)
            if found is not None:
                added.append(found)
        return added

    def _compare(self, number: int, group: Group) -> tuple[int, Ints, list[Ints] | None] | None:
        """All instances of a group anew, against those there are."""
        known, own = self.terms[number], self._tables[group.table]
        if not len(known.rows) and not self.store.tables[group.table].size:
            return None
        active = active_rows(self.store, group, self._natives)
        ways = rows_of_slots(self.store, group, active)
        variables = self._variables(group, ways, len(active))
        before = known.rows if own.moved_to is None else own.moved_to[known.rows]
        # Where each instance of before is among those of now, if it is.
        place = np.searchsorted(active, before)
        there = before >= 0
        there &= place < len(active)
        there[there] = active[place[there]] == before[there]
        there[there] = (variables[place[there]] == known.variables[there]).all(axis=1)
        there[there] &= (variables[place[there]] >= 0).all(axis=1)
        gone = known.numbers[~there]
        if len(gone):
            self.engine.remove_terms(gone)
        stays = place[there]
        order = np.argsort(stays, kind="stable")
        known.rows = active[stays][order]
        known.numbers = known.numbers[there][order]
        known.variables = known.variables[there][order]
        kept = stays[order]
        if len(kept):
            self._refresh(number, group, active[kept], [one[kept] for one in ways])
        fresh = np.ones(len(active), dtype=bool)
        fresh[kept] = False
        if not fresh.any():
            return None
        return number, active[fresh], [one[fresh] for one in ways]

    def _refresh(self, number: int, group: Group, rows: Ints, ways: list[Ints]) -> None:
        """Give instances their data, if it is other than before."""
        known = self.terms[number]
        gathered = self._gather(group, rows, ways)
        data = np.ascontiguousarray(gathered.data)
        other = (self.engine.data_of(number, known.numbers) != data).any(axis=1)
        if known.uniform is None or not np.array_equal(known.uniform, gathered.uniform):
            self._put_uniform(number, gathered.uniform)
            other[:] = True
        if other.any():
            self.engine.put_data(number, known.numbers[other], data[other])

    def _gather(self, group: Group, rows: Ints, ways: list[Ints]) -> Any:
        if group.sigma is not None or any("sigma" in raw.column for raw in group.raw):
            # imported here: start-up time
            from arael.runtime.evaluation.sigmas import check_sigmas

            check_sigmas(self.store, group, rows, ways, self._natives)
        return gather_instances(self.store, group, rows, ways, F64, self._natives)

    def _put_uniform(self, number: int, uniform: NDArray[np.float64]) -> None:
        self.terms[number].uniform = uniform
        self.engine.put_uniform(number, np.ascontiguousarray(uniform))

    def _add_terms(self, number: int, rows: Ints, ways: list[Ints] | None) -> None:
        group, known = self.layout.groups[number], self.terms[number]
        if ways is None:
            ways = self._ways(group, rows)
        variables = self._variables(group, ways, len(rows))
        gathered = self._gather(group, rows, ways)
        if known.uniform is None or not np.array_equal(known.uniform, gathered.uniform):
            self._put_uniform(number, gathered.uniform)
            if len(known.rows):  # shared by those there are
                old = self.engine.data_of(number, known.numbers)
                self.engine.put_data(number, known.numbers, old)
        numbers = self.engine.add_terms(number, variables, np.ascontiguousarray(gathered.data))
        order: Any = slice(None)
        if len(known.rows) and rows[0] < known.rows[-1]:
            order = np.argsort(np.concatenate((known.rows, rows)), kind="stable")
        known.rows = np.concatenate((known.rows, rows))[order]
        known.numbers = np.concatenate((known.numbers, numbers))[order]
        known.variables = np.concatenate((known.variables, variables))[order]

    def _ways(self, group: Group, rows: Ints) -> list[Ints]:
        """Rows of the slots of some instances of a plain group."""
        table = self.store.tables[group.table]
        found = [walk(table, slot.steps, rows)[1] if slot.steps else rows for slot in group.slots]
        if any(len(one) and one.min() < 0 for one in found):
            return rows_of_slots(self.store, group, rows)  # a null ref may be one not needed
        return found

    def _variables(self, group: Group, ways: Sequence[Ints], n: int) -> Int32:
        """(n, uses) variables that instances read; -1 for rows that are new."""
        found = np.empty((n, len(group.uses)), dtype=np.int32)
        for u, use in enumerate(group.uses):
            found[:, u] = self.variables[use.entity][ways[use.slot]]
        return found


def _is_plain(layout: Layout, group: Group) -> bool:
    """Whether all rows of a group's table are instances, with refs that no other ref decides."""
    if layout.passed[layout.groups.index(group)] is None:
        return False
    path = group.table
    for slot in group.slots:
        path = group.table
        for step in slot.steps:
            if step.kind == "root":
                path = ""
            elif step.kind == "parent":
                path = layout.table(path).parent
            else:
                target = layout.table(path).column(step.ref).target
                if target is None or any(one.kind == "ref" for one in target.base):
                    return False
                path = target.table
    return True


def _passed(layout: Layout, group: Group) -> frozenset[str] | None:
    """Tables whose rows and refs decide what a group's instances read; None: data does too."""
    return layout.passed[layout.groups.index(group)]
