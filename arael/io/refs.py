"""Refs of a data file: indices and keys, resolved after all rows are read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError
from arael.io.report import Report
from arael.runtime.layout import Column, Step
from arael.runtime.store import Store, Table, references
from arael.runtime.store.keys import double_key, unknown_key
from arael.runtime.store.messages import describe, error
from arael.runtime.store.slots import Ints

Place = Callable[[int], str]


class PendingRefs:
    """Ref columns as given, until all tables are filled."""

    def __init__(self, store: Store, report: Report) -> None:
        self.store = store
        self.report = report
        self._columns: dict[tuple[str, str], tuple[Table, Column, list[Any], Ints, Place]] = {}
        self._keys: dict[str, dict[tuple[int, str], int]] = {}

    def take(
        self, table: Table, refs: list[tuple[Column, list[Any], Ints, Place]], place: Place
    ) -> None:
        """Store ref columns of a table: values and their rows."""
        for column, values, rows, at in refs:
            self._columns[table.layout.path, column.path] = (table, column, values, rows, at)

    def resolve(self) -> None:
        """Set every ref; chained ones after those they depend on."""
        waiting = dict(self._columns)
        while waiting:
            ready = [
                k for k, v in waiting.items() if not self._through(v[0], v[1]) & waiting.keys()
            ]
            for key in ready or list(waiting):
                self._resolve(*waiting.pop(key))
            if self.report.found:
                return

    def _through(self, table: Table, column: Column) -> set[tuple[str, str]]:
        """Ref columns that a chained ref depends on."""
        assert column.target is not None
        found: set[tuple[str, str]] = set()
        for step in column.target.base:
            if step.kind == "ref":
                found.add((table.layout.path, step.ref))
            table = _next(table, step)
        return found - {(table.layout.path, column.path)}

    def _resolve(
        self, table: Table, column: Column, values: list[Any], rows: Ints, place: Place
    ) -> None:
        assert column.target is not None
        target = self.store.tables[column.target.table]
        kinds = set(map(type, values))
        if str in kinds and target.layout.key:
            found = self._from_keys(table, column, target, values, rows, place)
            if found is None:
                return
            values = found
        elif kinds != {int}:
            for i, value in enumerate(values):
                if type(value) is not int:
                    self._wrong_type(column, target, value, place(i))
            return
        try:
            index = np.array(values, dtype=np.int64)
        except OverflowError:
            index = np.array([min(max(v, -2), 2**62) for v in values], dtype=np.int64)
        if (index < 0).any():
            for i in np.flatnonzero(index < 0).tolist():
                self.report.add("E0708", f"index {values[i]} is out of range", place(i), column)
            return
        _, owners = references.walk(table, column.target.base, rows)
        counts = references.counts_of(target, owners)
        wrong = np.flatnonzero(index >= counts).tolist()
        for i in wrong:
            text = references.out_of_range(column, values[i], int(counts[i]))
            self.report.add("E0708", text, place(i), column)
        if not wrong:
            dense = target.child_rows(owners, index)
            table.column(column.path)[rows] = target.handles(dense)

    def _wrong_type(self, column: Column, target: Table, value: Any, place: str) -> None:
        key = f" or its `{target.layout.key}`" if target.layout.key else ""
        self.report.add(
            "E0707" if value is None else "E0703",
            f"expected the index of a `{target.layout.struct}`{key}, found {describe(value)}",
            place,
            column,
        )

    def _from_keys(
        self,
        table: Table,
        column: Column,
        target: Table,
        values: list[Any],
        rows: Ints,
        place: Place,
    ) -> list[int] | None:
        """Return indices for values some of which are keys."""
        assert column.target is not None
        keys = self._keys_of(target)
        _, owners = references.walk(table, column.target.base, rows)
        found: list[int] = []
        for i, value in enumerate(values):
            if type(value) is int:
                found.append(value)
            elif isinstance(value, str):
                owner = int(owners[i])
                if (owner, value) not in keys:
                    known = [k for o, k in keys if o == owner]
                    message, help_ = unknown_key(column, target, value, known)
                    self.report.add("E0708", message, place(i), column, help=help_)
                found.append(keys.get((owner, value), 0))
            else:
                self._wrong_type(column, target, value, place(i))
        return None if self.report.found else found

    def _keys_of(self, target: Table) -> dict[tuple[int, str], int]:
        """(owner row, key) -> index within the owner's collection."""
        path = target.layout.path
        if path not in self._keys:
            keys: dict[tuple[int, str], int] = {}
            column = target.data[target.layout.key]
            owners, places = target.parent_rows().tolist(), target.index_in_parent().tolist()
            for row, key in enumerate(target.column(target.layout.key).tolist()):
                if (owners[row], key) in keys:
                    self.report.add(
                        "E0718",
                        double_key(key),
                        target.name_of(row, target.layout.key),
                        column,
                    )
                keys[owners[row], key] = places[row]
            self._keys[path] = keys
        return self._keys[path]


def _next(table: Table, step: Step) -> Table:
    if step.kind == "root":
        return table.store.tables[""]
    if step.kind == "parent":
        return table.parent
    return table.store.tables[references.target_of(table, step.ref).table]


def refs_as_data(table: Table, column: Column) -> list[Any]:
    """Refs of every row in the form of data files: index or key; None where absent.

    Raises AraelError (E0709) for a stale ref.
    """
    assert column.target is not None
    target = table.store.tables[column.target.table]
    rows = table.target_rows(column.path)
    known = rows >= 0
    index = np.zeros(len(rows), np.int64)
    index[known] = target.index_in_parent()[rows[known]]
    key = target.layout.key
    if not key or not target.size:
        return [i if k else None for i, k in zip(index.tolist(), known.tolist(), strict=True)]
    names = target.column(key).tolist()
    owners = target.parent_rows().tolist()
    if len(set(zip(owners, names, strict=True))) < len(names):
        raise AraelError(
            error(
                "E0718",
                "two rows have the same key",
                f"{target.label}.{key}",
                target.data[key],
            ).diagnostics
        )
    return [names[r] if k else None for r, k in zip(rows.tolist(), known.tolist(), strict=True)]
