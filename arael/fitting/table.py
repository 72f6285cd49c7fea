"""The points of a fit: files, arrays by name, data frames."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.fitting.messages import mistake
from arael.io.csv_numbers import Points, readable_names

Array = NDArray[np.float64]


class Table(Protocol):
    """Columns of numbers by name.

    Attributes
    ----------
    name : of the file or the argument, for messages
    titles : maps the name of a column in formulas to its title
    size : number of rows
    """

    name: str
    titles: dict[str, str]
    size: int

    def columns(self, names: Iterable[str]) -> dict[str, Array]:
        """Columns by name, each (rows,); NaN where a value is missing."""

    def texts(self, name: str) -> list[str]:
        """Cells of one column as texts; "" where a value is missing."""


def table_of(data: Any) -> Table:
    """Read the points of a fit.

    Parameters
    ----------
    data : the path of a CSV file, a list of them, columns by name, or a data frame

    Raises
    ------
    AraelError
        E0712 and others of a file; E0873: no table.
    """
    if isinstance(data, str | os.PathLike):
        return Points(data)
    if isinstance(data, Sequence) and data and all(isinstance(d, str | os.PathLike) for d in data):
        return Points(data[0]) if len(data) == 1 else Files(data)
    if isinstance(data, np.ndarray) and data.dtype.names:
        return Columns({name: data[name] for name in data.dtype.names})
    if hasattr(data, "columns") and hasattr(data, "__getitem__"):  # a data frame
        return Columns({str(title): data[title] for title in data.columns})
    if isinstance(data, Mapping):
        return Columns({str(name): column for name, column in data.items()})
    raise mistake(
        "E0873",
        f"expected columns by name or a file, found {type(data).__name__}",
        "data",
        'write `{"x": x, "y": y}`, `fit(formula, x, y)`, or the path of a CSV file',
    )


def pair_of(x: Any, measured: Any, y: str | None) -> dict[str, Any]:
    """The columns ``x`` and ``y`` of a fit that is given two arrays; E0873 for anything else."""
    both = []
    for name, given in (("x", x), ("y", measured)):
        found = np.asarray(given)
        if isinstance(given, str | Mapping) or found.ndim != 1 or y is not None:
            raise mistake(
                "E0873",
                "two arrays are the columns `x` and `y`, one number a point",
                name if y is None else "y",
                'for others give columns by name: `{"t": t, "v": v}`',
            )
        both.append(found)
    return {"x": both[0], "y": both[1]}


def _array(title: str, column: Any) -> NDArray[Any]:
    try:
        return np.asarray(column)
    except ValueError:
        raise mistake(
            "E0873", f"the column '{title}' is not one number per point", "data"
        ) from None


class Columns:
    """Arrays by name, a number counts for every row."""

    name = "data"

    def __init__(self, given: Mapping[str, Any]) -> None:
        self.titles = readable_names(given)
        self._given = {title: _array(title, column) for title, column in given.items()}
        sizes: dict[str, int] = {}
        for title, column in self._given.items():
            if column.ndim > 1:
                raise mistake(
                    "E0873",
                    f"the column '{title}' has shape {column.shape}, expected one number per point",
                    "data",
                )
            if column.ndim:
                sizes[title] = len(column)
        if len(set(sizes.values())) > 1:
            found = ", ".join(f"{title}: {size}" for title, size in sizes.items())
            raise mistake("E0873", f"the columns differ in length: {found}", "data")
        self.size = next(iter(sizes.values()), 1)
        if not self._given or not self.size:
            raise mistake("E0873", "there are no points", "data")

    def columns(self, names: Iterable[str]) -> dict[str, Array]:
        """Columns by name; E0873 for text and infinities."""
        found = {}
        for name in names:
            title = self.titles[name]
            if self._given[title].dtype.kind in "cmM":
                raise mistake(
                    "E0873",
                    f"the column '{title}' is {self._given[title].dtype}, expected real numbers",
                    "data",
                    "convert it first: a part of complex numbers, or seconds since a first time",
                )
            try:
                column = np.asarray(self._given[title], dtype=np.float64)
            except (TypeError, ValueError):
                raise mistake("E0873", f"the column '{title}' is not numbers", "data") from None
            if np.isinf(column).any():
                row = int(np.argmax(np.isinf(np.atleast_1d(column))))
                raise mistake("E0873", f"the column '{title}' is infinite in row {row}", "data")
            found[name] = np.array(np.broadcast_to(column, self.size))
        return found

    def texts(self, name: str) -> list[str]:
        """Cells of one column as texts."""
        column = np.broadcast_to(self._given[self.titles[name]], self.size)
        return ["" if cell is None or cell != cell else str(cell) for cell in column.tolist()]


class Files:
    """Several files, one after the other, with the column ``file`` of their names.

    Raises
    ------
    AraelError
        E0873: they have no column in common.
    """

    def __init__(self, paths: Sequence[Any]) -> None:
        self._parts = [Points(path) for path in paths]
        self._stems = [Path(os.fspath(path)).name.split(".")[0] for path in paths]
        if len(set(self._stems)) < len(paths):  # equal names in several folders: the whole path
            self._stems = [os.fspath(path) for path in paths]
        for path in self._stems:
            if self._stems.count(path) > 1:
                raise mistake("E0873", "the file is given twice", path, "give each file once")
        self.name = f"{self._parts[0].name} and {len(paths) - 1} more"
        first = self._parts[0].titles
        common = {n: t for n, t in first.items() if all(n in part.titles for part in self._parts)}
        if not common:
            raise mistake("E0873", "the files have no column in common", self.name)
        self.titles = {**common, **({} if "file" in common else {"file": "file"})}
        self.size = sum(part.size for part in self._parts)

    def columns(self, names: Iterable[str]) -> dict[str, Array]:
        """Columns by name, of all files one after the other."""
        wanted = list(names)
        if "file" in wanted and not all("file" in part.titles for part in self._parts):
            raise mistake("E0873", "the column 'file' holds names, not numbers", self.name)
        parts = [part.columns(wanted) for part in self._parts]
        return {name: np.concatenate([part[name] for part in parts]) for name in wanted}

    def texts(self, name: str) -> list[str]:
        """Cells of one column; of ``file`` the file's name without its ending."""
        found: list[str] = []
        for stem, part in zip(self._stems, self._parts, strict=True):
            found += part.texts(name) if name in part.titles else [stem] * part.size
        return found
