"""The rows of a runtime residual: its data, and refs to the rows of the model that it reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.ref import Refs
from arael.residuals.expression import Expression
from arael.residuals.messages import error
from arael.residuals.plain_table import PlainTable

Array = NDArray[Any]


class RowsTable(PlainTable):
    """A table without model data: one row per instance of the residual.

    Parameters
    ----------
    label : name of the residual
    data : columns by path: the expression that has the data, and its name there
    refs : ref columns by path: rows of the model, or None for the one row of a parameter table
    """

    def __init__(
        self,
        label: str,
        data: Mapping[str, tuple[Expression, str]],
        refs: Mapping[str, Refs | None],
    ) -> None:
        self.label = label
        self.structure_version = 0
        self.data_version = 0
        self.values_version = self.flags_version = 0  # no parameters here
        self._data = data
        self._refs = refs
        self._columns: dict[str, Array] = {}
        self._targets: dict[str, tuple[tuple[int, int], Array]] = {}
        self.size = 0
        self.refresh()

    def refresh(self) -> None:
        """Update from the current data.

        Raises
        ------
        AraelError
            E0762: columns of different length.
        """
        lengths: dict[str, int] = {}
        for path, (owner, name) in self._data.items():
            if owner._data[name].ndim:
                lengths[path] = len(owner._data[name])
        for path, refs in self._refs.items():
            if refs is not None and len(refs) != 1:
                lengths[path] = len(refs)
        # A column of one row holds for all rows, whatever their number.
        several = {path: n for path, n in lengths.items() if n != 1}
        if len(set(several.values())) > 1:
            found = ", ".join(f"`{path}` has {n}" for path, n in several.items())
            raise error("E0762", f"columns differ in length: {found} rows", self.label)
        size = next(iter(several.values()), 1)
        columns = {}
        for path, (owner, name) in self._data.items():
            values = owner._data[name]
            values = values if values.ndim else values[None]
            columns[path] = np.broadcast_to(values, (size, *values.shape[1:]))
        self._columns = columns
        self.data_version += 1
        if size != self.size:
            self.size = size
            self.structure_version += 1

    def column(self, path: str) -> Array:
        """Return the values (size, *shape)."""
        return self._columns[path]

    def written(self) -> None:
        """There are no parameters to be written."""

    def free(self, path: str) -> Array:
        """There are no parameters here."""
        raise KeyError(path)

    def target_rows(self, path: str) -> Array:
        """Row that each ref points to (size,), -1 where the row was removed."""
        refs = self._refs[path]
        if refs is None:
            return np.zeros(self.size, dtype=np.int64)
        version = refs._table.structure_version, self.size
        cached = self._targets.get(path)
        if cached is None or cached[0] != version:
            rows = np.array(np.broadcast_to(refs.rows, (self.size,)))
            cached = self._targets[path] = version, rows
        return cached[1]

    def row_name(self, row: int) -> str:
        """Name of a row: ``decay[3]``, or ``width`` if there is only one."""
        return self.label if self.size == 1 else f"{self.label}[{row}]"

    def row_names(self, rows: Array) -> list[str]:
        """Names of several rows."""
        return [self.row_name(row) for row in rows.tolist()]
