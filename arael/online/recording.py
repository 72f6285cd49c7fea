"""A recorded problem as a sequence of steps, in which its rows are appended to an empty model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.store.references import Handles
from arael.runtime.store.rows import PARENT, SLOT

Ints = NDArray[np.int64]
NEVER = np.iinfo(np.int64).max


class Recording:
    """The rows of a model in the order in which they came.

    Rows of the collection `by` come one at a time. Rows of others come with the last row that they
    refer to or belong to; those that refer to none come with the first row that refers to them,
    or with the last step.

    Parameters
    ----------
    whole : a model with all data
    by : a collection, ``"poses"``, or a column by which its rows are sorted, ``"poses.stamp"``;
        None: the first collection with parameters
    every : rows of it a step

    Raises
    ------
    AraelError
        E0701: no such collection or column.
    """

    def __init__(self, whole: Any, by: str | None = None, every: int = 1) -> None:
        self.whole = whole
        self._tables = whole._store.tables
        self._layout = whole._store.layout
        self.by, rank = self._ranks(by)
        self._step: dict[str, Ints] = {self.by: rank // every}
        self._spread()
        self.steps = int(self._step[self.by].max(initial=-1)) + 1

    def _ranks(self, by: str | None) -> tuple[str, Ints]:
        """The collection, and the place of each of its rows in the sequence."""
        collections = [path for path in self._tables if path]
        if by is None:
            named = [e.table for e in self._layout.entities if e.table]
            by = (named or collections or [""])[0]
        table, column = by, ""
        if by not in collections:
            table, _, column = by.rpartition(".")
        columns = [
            f"{one.path}.{c.path}"
            for one in self._layout.tables
            for c in one.columns
            if one.path and c.kind in ("real", "int") and c.shape == () and c.role != "ref"
        ]
        if by not in (*collections, *columns):
            near = closest(by, [*collections, *columns])
            raise AraelError(
                Diagnostic(
                    "E0701",
                    f"`{by}` is neither a collection nor a column of numbers",
                    origin=self._layout.name,
                    notes=(f"collections are {', '.join(collections) or 'none'}",),
                    help=(f"did you mean `{near[0]}`?",) if near else (),
                )
            )
        rank = np.arange(self._tables[table].size)
        if column:
            order = np.argsort(self._tables[table].column(column), kind="stable")
            rank[order] = np.arange(len(rank))
        return table, rank

    def _ways(self, path: str) -> Iterator[tuple[str, Ints]]:
        """Tables that rows of a table refer to or belong to, and their rows; -1 for none."""
        table = self._tables[path]
        if table.layout.parent:
            yield table.layout.parent, table.parent_rows()
        for column in table.data.values():
            if column.role == "ref" and column.target is not None:
                yield column.target.table, table.target_rows(column.path)

    def _spread(self) -> None:
        """Steps of all tables from those of one."""
        paths = [path for path in self._tables if path]
        for _ in paths:  # with the last row that they refer to
            for path in paths:
                known = [
                    (self._step[to], rows) for to, rows in self._ways(path) if to in self._step
                ]
                if path not in self._step and known:
                    self._step[path] = np.zeros(self._tables[path].size, dtype=np.int64)
        self._settle(paths)
        for path in paths:  # with the first row that refers to them
            if path in self._step:
                continue
            first = np.full(self._tables[path].size, NEVER)
            for other in paths:
                for to, rows in self._ways(other):
                    if to == path and other in self._step:
                        some = rows >= 0
                        np.minimum.at(first, rows[some], self._step[other][some])
            first[first == NEVER] = self._step[self.by].max(initial=0)
            self._step[path] = first
        self._settle(paths)

    def _settle(self, paths: list[str]) -> None:
        """No row comes before one that it refers to."""
        for _ in range(len(paths) + 1):
            for path in paths:
                for to, rows in self._ways(path) if path in self._step else ():
                    if to in self._step:
                        some = rows >= 0
                        mine = self._step[path]
                        mine[some] = np.maximum(mine[some], self._step[to][rows[some]])

    def replay(self, model: Any) -> Iterator[int]:
        """Append the rows of one step after the other to an empty model; yields their numbers."""
        root, target = self._tables[""], model._store.tables[""]
        for name in root.buffers.names:
            if name not in (SLOT, PARENT):
                target.writable(name)[...] = root.buffers.view(name)
        target.missing.difference_update(root.data.keys() - root.missing)
        paths = [table.path for table in self._layout.tables if table.path]
        sorted_rows = {path: np.argsort(self._step[path], kind="stable") for path in paths}
        bounds = {
            path: np.searchsorted(self._step[path][sorted_rows[path]], np.arange(self.steps + 1))
            for path in paths
        }
        handles = {path: np.full(self._tables[path].size, -1) for path in paths}
        for step in range(self.steps):
            chosen = {}
            for path in paths:
                low, high = bounds[path][step : step + 2]
                if high > low:
                    chosen[path] = np.sort(sorted_rows[path][low:high])
            for path, rows in chosen.items():
                handles[path][rows] = self._append(model, path, rows, handles)
            for path, rows in chosen.items():
                self._refer(model, path, rows, handles)
            yield step

    def _append(self, model: Any, path: str, rows: Ints, handles: dict[str, Ints]) -> Ints:
        source, table = self._tables[path], model._store.tables[path]
        owners, parent = None, source.layout.parent
        if parent:
            owners = model._store.tables[parent].rows_of(
                handles[parent][source.parent_rows()[rows]]
            )
        elif path:
            owners = np.zeros(len(rows), dtype=np.int64)
        values = {
            name: source.buffers.view(name)[rows]
            for name in source.buffers.names
            if name not in (SLOT, PARENT) and not self._is_ref(path, name)
        }
        before = table.size
        table.extend_trusted(len(rows), owners, values)
        found: Ints = table.handles(slice(before, before + len(rows)))
        return found

    def _is_ref(self, path: str, name: str) -> bool:
        column = self._tables[path].data.get(name)
        return column is not None and column.role == "ref"

    def _refer(self, model: Any, path: str, rows: Ints, handles: dict[str, Ints]) -> None:
        source, table = self._tables[path], model._store.tables[path]
        mine = table.rows_of(handles[path][rows])
        for column in source.data.values():
            if column.role != "ref" or column.target is None:
                continue
            to = source.target_rows(column.path)[rows]
            some = to >= 0
            if some.any():
                targets = Handles(
                    model._store.tables[column.target.table], handles[column.target.table][to[some]]
                )
                table.set_refs(column.path, mine[some], targets, path)
