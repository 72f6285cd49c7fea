"""JSON values to columns: a fast path for valid data, a slow path for error messages."""

from __future__ import annotations

from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.report import Report
from arael.runtime.layout import Column
from arael.runtime.store.manifolds import forms_of
from arael.runtime.store.messages import SCALAR_WORDS, describe, expected

ALLOWED: dict[str, set[type]] = {
    "real": {float, int},
    "int": {float, int},
    "bool": {bool},
    "string": {str},
}


def shapes_of(column: Column) -> tuple[tuple[int, ...], ...]:
    """Shapes in which a value may be given, the declared one first."""
    if len(column.shape) == 2:
        return (column.shape, (column.shape[0] * column.shape[1],))  # also flat, row by row
    return forms_of(column)


def fast_array(column: Column, values: list[Any]) -> NDArray[Any] | None:
    """All values as one array (n, ...), or None if any of them may be invalid."""
    for shape in shapes_of(column):
        flat: list[Any] | None = values
        for size in shape:
            assert flat is not None
            if set(map(type, flat)) != {list} or set(map(len, flat)) != {size}:
                flat = None
                break
            flat = list(chain.from_iterable(flat))
        if flat is None:
            continue
        kinds = set(map(type, flat))
        if not kinds <= ALLOWED[column.kind]:
            return None
        if column.kind == "string":
            return np.array(flat, dtype=object)
        try:
            dtype = np.int64 if kinds == {int} and column.kind == "int" else None
            array = np.array(flat, dtype=dtype if column.kind != "real" else np.float64)
        except OverflowError:
            return None
        if array.dtype == object:
            return None
        return array.reshape(len(values), *(column.shape if _is_flat(column, shape) else shape))
    return None


def _is_flat(column: Column, shape: tuple[int, ...]) -> bool:
    return len(column.shape) == 2 and len(shape) == 1


def explain(column: Column, value: Any, place: str, report: Report) -> Any:
    """Report errors in the form of a value; return it ready to convert."""
    if value is None:
        report.add("E0707", "null where a value is needed", place, column)
        return value
    if not column.shape:
        _scalar(column, value, place, report)
        return value
    if not isinstance(value, list):
        report.add("E0703", f"expected {expected(column)}, found {describe(value)}", place, column)
        return value
    for shape in shapes_of(column):
        if len(value) == shape[0] and all(isinstance(v, list) == (len(shape) == 2) for v in value):
            return _elements(column, value, shape, place, report)
    if any(isinstance(v, list) for v in value) != (len(column.shape) == 2):
        nested = any(isinstance(v, list) for v in value)
        found = "an array of arrays" if nested else f"an array of {len(value)}"
        report.add("E0704", f"expected {expected(column)}, found {found}", place, column)
        return value
    unit = "numbers" if len(column.shape) == 1 else "rows"
    report.add("E0704", f"expected {column.shape[0]} {unit}, found {len(value)}", place, column)
    return value


def _elements(
    column: Column, value: list[Any], shape: tuple[int, ...], place: str, report: Report
) -> Any:
    if len(shape) == 1:
        for i, item in enumerate(value):
            _scalar(column, item, f"{place}[{i}]", report)
        if _is_flat(column, shape) and not report.found:
            return np.array(value, dtype=np.float64).reshape(column.shape)
        return value
    for i, row in enumerate(value):
        if len(row) != shape[1]:
            report.add(
                "E0704", f"expected {shape[1]} numbers, found {len(row)}", f"{place}[{i}]", column
            )
            continue
        for j, item in enumerate(row):
            _scalar(column, item, f"{place}[{i}][{j}]", report)
    return value


def _scalar(column: Column, value: Any, place: str, report: Report) -> None:
    if type(value) not in ALLOWED[column.kind]:
        code = "E0707" if value is None else "E0703"
        report.add(
            code, f"expected {SCALAR_WORDS[column.kind]}, found {describe(value)}", place, column
        )
    elif column.kind == "int" and isinstance(value, int) and not -(2**63) <= value < 2**63:
        report.add("E0706", f"{describe(value)} does not fit a 64-bit integer", place, column)
    elif column.kind == "int" and isinstance(value, float) and value != int(value):
        report.add("E0706", f"expected an integer, found {describe(value)}", place, column)
    elif column.kind == "real" and isinstance(value, int) and abs(value) > 2**1023:
        report.add("E0706", "the number does not fit a real", place, column)
