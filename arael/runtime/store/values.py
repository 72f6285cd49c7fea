"""Conversion of input values to a column: checked, never silently converted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime.layout import Column
from arael.runtime.store import manifolds
from arael.runtime.store.messages import describe, error, expected

Array = NDArray[Any]
# Name of element i of the values being converted, for messages.
NameOf = Callable[[int], str]


def dtype_of(column: Column, real: np.dtype[Any]) -> np.dtype[Any]:
    """Type of a column's memory; refs are int64 handles."""
    if column.role == "present":
        return np.dtype(np.bool_)
    if column.role in ("ref", "constraint_index"):
        return np.dtype(np.int64)
    if column.kind == "real":
        return real
    kinds: dict[str, np.dtype[Any]] = {
        "int": np.dtype(np.int64),
        "bool": np.dtype(np.bool_),
        "string": np.dtype(np.object_),
    }
    return kinds[column.kind]


def blank(column: Column) -> Any:
    """Return the value of rows where the field is absent: neutral in arithmetic, never shown."""
    if column.role in ("ref", "constraint_index"):
        return -1
    if column.kind == "string":
        return ""
    kind = manifolds.kind_of(column)
    return np.array(manifolds.NEUTRAL[kind], np.float64) if kind else 0


def default_value(column: Column) -> Any:
    """Return the declared default as a value of the column's shape, if there is one."""
    if isinstance(column.default, str):
        return column.default
    value = np.asarray(column.default)
    return value.reshape(column.shape) if column.shape else value.reshape(-1)[0]


def convert(
    column: Column, values: Any, count: int, dtype: np.dtype[Any], name_of: NameOf, many: bool
) -> Array:
    """Values of `count` rows as (count, *shape), or of all rows alike as (*shape).

    Parameters
    ----------
    column : its declaration
    values : an array or nested sequence; rotations and transforms in any of their forms
    count : number of rows
    dtype : type of the memory
    name_of : name of the i-th element, for messages
    many : whether there is a leading axis of `count`; otherwise one value is expected

    Raises
    ------
    AraelError
        E0703 wrong type, E0704 wrong shape, E0705 not finite, E0706 does not fit, E0721 not a
        rotation, direction or transform.
    """
    if column.kind == "string":
        return _strings(column, values, count, name_of, many)
    array = _as_array(column, values, name_of)
    kind = manifolds.kind_of(column)
    if kind:
        array = _as_stored(kind, column, array, count, name_of, many)
    wanted = (count, *column.shape) if many else column.shape
    if array.shape != wanted and not (many and array.shape == column.shape):
        raise _wrong_shape(column, array, count, name_of, many)
    found = _checked(column, array, dtype, name_of, array.shape == wanted and many)
    return found


def _as_array(column: Column, values: Any, name_of: NameOf) -> Array:
    try:
        array = np.asarray(values)
    except (ValueError, TypeError):
        raise error(
            "E0704",
            f"expected {expected(column)}, found sequences of different lengths",
            name_of(0),
            column,
        ) from None
    except OverflowError:
        raise error("E0706", "the number does not fit", name_of(0), column) from None
    allowed = {"real": "fiu", "int": "iuf", "bool": "b"}[column.kind]
    if array.dtype == object and array.size and set(map(type, array.ravel().tolist())) == {int}:
        raise error("E0706", "the number does not fit 64 bits", name_of(0), column)
    if array.size == 0 and array.dtype.kind == "f":
        return array
    if array.dtype.kind not in allowed or (
        not isinstance(values, np.ndarray) and _mixes_bools(values, column)
    ):
        raise error(
            "E0703", f"expected {expected(column)}, found {describe(values)}", name_of(0), column
        )
    return array


def _mixes_bools(values: Any, column: Column) -> bool:
    """Whether nested sequences of numbers contain a bool, which NumPy would convert to 0 or 1."""
    if column.kind == "bool":
        return False
    if isinstance(values, (list, tuple)):
        return any(_mixes_bools(v, column) for v in values)
    return isinstance(values, (bool, np.bool_))


def _as_stored(
    kind: str, column: Column, array: Array, count: int, name_of: NameOf, many: bool
) -> Array:
    """Convert values in one of the forms of their kind, given by the shape, to the stored form."""
    lead = (count,) if many else ()
    for shape in manifolds.forms_of(column):
        if array.shape in ((*lead, *shape), shape):
            break
    else:
        return array
    if array.size == 0:
        return array.reshape(len(array), *column.shape)
    per_row = array.shape != shape
    flat = array.reshape(len(array) if per_row else 1, -1).astype(np.float64)
    finite = np.isfinite(flat).all(axis=1)
    if not finite.all():
        raise _not_finite(column, name_of(int(np.argmin(finite))))
    for what, part_of, holds in manifolds.checks_of(kind, shape):
        part = part_of(array)
        good = np.atleast_1d(holds(part))
        if not good.all():
            row = int(np.argmin(good))
            detail = ""
            if "unit" in what:
                norm = float(np.linalg.norm(np.atleast_2d(part)[row]))
                detail = f": its norm is {norm:.6g}"
            raise error("E0721", f"expected {what}{detail}", name_of(row), column)
    return manifolds.stored_form(kind, array, shape)


def _wrong_shape(
    column: Column, array: Array, count: int, name_of: NameOf, many: bool
) -> AraelError:
    if many:
        wanted = f"an array of shape {(count, *column.shape)}"
        return error(
            "E0704",
            f"expected {wanted}, found shape {array.shape}",
            name_of(0).split("[")[0] or name_of(0),
            column,
        )
    found = "a single number" if array.shape == () else f"an array of shape {array.shape}"
    if array.ndim == 1 and array.size != 0:
        found = f"{array.shape[0]} numbers"
    return error("E0704", f"expected {expected(column)}, found {found}", name_of(0), column)


def _not_finite(column: Column, origin: str) -> AraelError:
    return error("E0705", "the value is NaN or infinite", origin, column)


def _checked(
    column: Column, array: Array, dtype: np.dtype[Any], name_of: NameOf, per_row: bool
) -> Array:
    """`array` in the column's type, if every number is representable."""

    def row_of(bad: NDArray[np.bool_]) -> str:
        index = int(np.argmax(bad.reshape(len(bad), -1).any(axis=1))) if per_row else 0
        return name_of(index)

    if array.dtype.kind == "f":
        finite = np.isfinite(array)
        if not finite.all():
            raise _not_finite(column, row_of(~finite))
    if column.kind == "real":
        with np.errstate(over="ignore"):
            result = array.astype(dtype)
        if dtype == np.float32 and not np.isfinite(result).all():
            raise error(
                "E0706",
                "the number does not fit single precision",
                row_of(~np.isfinite(result)),
                column,
            )
        return result
    if column.kind == "int":
        if array.dtype.kind == "f":
            bad = (array != np.floor(array)) | (np.abs(array) > 2.0**53)
            if bad.any():
                raise error("E0706", "expected an integer, found a fraction", row_of(bad), column)
        elif array.dtype.kind == "u" and array.size and (array > np.iinfo(np.int64).max).any():
            bad = array > np.iinfo(np.int64).max
            raise error("E0706", "the number does not fit 64 bits", row_of(bad), column)
        return array.astype(np.int64)
    return array.astype(dtype)


def _strings(column: Column, values: Any, count: int, name_of: NameOf, many: bool) -> Array:
    if isinstance(values, str):
        _check_text(column, [values], name_of)
        return np.array(values, dtype=object)
    if not many:
        raise error("E0703", f"expected a string, found {describe(values)}", name_of(0), column)
    items = values.tolist() if isinstance(values, np.ndarray) else list(values)
    for i, item in enumerate(items):
        if not isinstance(item, str):
            raise error("E0703", f"expected a string, found {describe(item)}", name_of(i), column)
    if len(items) != count:
        raise error("E0704", f"expected {count} strings, found {len(items)}", name_of(0), column)
    _check_text(column, items, name_of)
    result = np.empty(count, dtype=object)
    result[:] = items
    return result


def _check_text(column: Column, items: list[str], name_of: NameOf) -> None:
    """Report unpaired surrogates, which no file format can store: E0703."""
    try:
        "".join(items).encode()
        return
    except UnicodeEncodeError:
        pass
    for i, item in enumerate(items):
        try:
            item.encode()
        except UnicodeEncodeError as failure:
            half = f"\\u{ord(item[failure.start]):04x}"
            message = f"expected text, found an unpaired surrogate, `{half}`"
            raise error("E0703", message, name_of(i), column) from None
