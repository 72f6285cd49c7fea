"""A CSV file of numbers, as columns by name, where no model says what it holds."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.csv_reader import csv_rows
from arael.io.files import StrPath, check_name, read_bytes, shown, without_mark
from arael.io.plain_numbers import real
from arael.runtime.store.messages import problem, shorten

MOST_MISTAKES = 20


def read_numbers(path: StrPath) -> dict[str, NDArray[np.float64]]:
    """Columns of a CSV file, each (rows,), by the names in its first line.

    Raises
    ------
    AraelError
        With file, line and column, several at once: E0712 unreadable, E0711 not CSV or without
        rows, E0718 a column twice, E0704 wrong number of cells, E0703 not a number, E0705 not
        finite.
    """
    path = check_name(path)
    name = shown(os.path.basename(path))
    header, rows, lines = csv_rows(without_mark(read_bytes(path), name), name)
    found: list[Diagnostic] = [
        problem("E0718", f"the column `{shorten(column)}` is given twice", name)
        for column in sorted({c for c in header if header.count(c) > 1})
    ]
    if not rows:
        found.append(problem("E0711", "there is no row below the names of the columns", name))
    values = np.empty((len(rows), len(header)))
    for number, (line, row) in enumerate(zip(lines, rows, strict=True)):
        if len(found) >= MOST_MISTAKES:
            break
        if len(row) != len(header):
            text = f"expected {len(header)} cells, found {len(row)}"
            found.append(problem("E0704", text, f"{name}:{line}"))
            continue
        for column, cell in enumerate(row):
            value = _number(cell)
            if value is None or not math.isfinite(value):
                code = "E0703" if value is None else "E0705"
                wanted = "a number" if value is None else "a finite number"
                text = f'expected {wanted}, found "{shorten(cell)}"'
                found.append(problem(code, text, f"{name}:{line}: {header[column]}"))
            else:
                values[number, column] = value
    if found:
        raise AraelError(found)
    columns: dict[str, Any] = {c: values[:, k].copy() for k, c in enumerate(header)}
    return columns


def _number(cell: str) -> float | None:
    try:
        return real(cell.strip())
    except ValueError:
        return None
