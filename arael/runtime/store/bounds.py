"""Bounds of parameters and flags of components by row, as a program or a data file sets them.

Each is a column of its own (``gain.low``, ``gain.high``, ``pos.fixed_components``), added when it
is first needed: until then bounds are those of the model, and no component is fixed by the data.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime import layout
from arael.runtime.store.messages import Origin, describe, error, problem

Array = NDArray[Any]
Bools = NDArray[np.bool_]

ENDS = ("low", "high")
COMPONENTS_FIXED = "fixed_components"
OPEN = {"low": -np.inf, "high": np.inf}


def may_be_bounded(column: layout.Column) -> bool:
    """Whether bounds of a field make sense: of real and vector parameters."""
    return column.param is not None and column.param.kind in ("real", "vec")


def has_components(column: layout.Column) -> bool:
    """Whether the numbers of a parameter have flags of their own: of vectors and Euler angles."""
    return column.param is not None and column.param.kind in ("vec", "euler")


def of_model(column: layout.Column, end: str) -> NDArray[np.float64]:
    """The model's lower or upper bounds of a field, of its shape; infinite where open."""
    given = () if column.param is None else getattr(column.param, end)
    found = np.full(column.shape, OPEN[end])
    for k, bound in enumerate(given):
        if bound is not None:
            found.reshape(-1)[k] = bound
    return found


def converted(
    column: layout.Column, end: str, given: Any, count: int | None, origin: Origin
) -> NDArray[np.float64]:
    """Bounds as numbers, (count, *shape), or (*shape) for one row (`count` None) or for all rows.

    Parameters
    ----------
    given : numbers, None or infinite where there is no bound; one for all components, of the
        field's shape, or with a leading axis of `count`

    Raises
    ------
    AraelError
        E0703 a parameter without bounds, or no numbers; E0704 another shape; E0705 NaN.
    """
    require_bounded(column, origin)
    found = _numbers(given, end, column, origin)
    shapes = [(), column.shape]
    if count is not None:
        shapes += [(count, *column.shape)] + ([(1, *column.shape)] if column.shape else [])
    if found.shape not in shapes:
        wanted = " or ".join(str(shape) for shape in dict.fromkeys(shapes) if shape)
        raise error(
            "E0704",
            f"expected a number{' or shape ' * bool(wanted)}{wanted}, found shape {found.shape}",
            origin,
            column,
            "one number is for all components" if column.shape else "",
        )
    if np.isnan(found).any():
        raise error("E0705", "a bound is NaN", origin, column, "None is no bound")
    whole = found.ndim == 0 or found.shape == column.shape
    return np.broadcast_to(found, column.shape) if whole else found


def require_bounded(column: layout.Column, origin: Origin) -> None:
    """Raise E0703 for a field that takes no bounds."""
    if not may_be_bounded(column):
        raise error(
            "E0703",
            "only plain parameters have bounds",
            origin,
            column,
            "bounds are for `param` of real, vec2, vec3, vec<n>",
        )


def _numbers(given: Any, end: str, column: layout.Column, origin: Origin) -> NDArray[np.float64]:
    """An array of numbers, with None as infinity."""
    if given is None:
        return np.asarray(OPEN[end])
    try:
        array = np.asarray(given, dtype=object) if _has_none(given) else np.asarray(given)
        if array.dtype == object:
            array = np.array([OPEN[end] if x is None else x for x in array.flat], object).reshape(
                array.shape
            )
            if all(_is_number(x) for x in array.flat):
                array = array.astype(np.float64)
    except (ValueError, OverflowError):  # lists of different lengths; an integer beyond all floats
        array = np.asarray("")
    if array.dtype.kind not in "iuf":
        raise error("E0703", f"expected numbers, found {describe(given)}", origin, column)
    return array.astype(np.float64)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def _has_none(given: Any) -> bool:
    if not isinstance(given, list | tuple):
        return given is None
    return any(_has_none(item) for item in given)


def first_empty(low: Array | None, high: Array | None) -> int | None:
    """The first row whose bounds leave no value, or are NaN; None if there is none.

    Parameters
    ----------
    low, high : (rows, ...); None: open
    """
    if low is None or high is None:
        one = low if high is None else high
        bad = None if one is None else np.isnan(one)
    else:
        bad = ~(low <= high)
    if bad is None or not bad.any():
        return None
    return int(np.argmax(bad.reshape(len(bad), -1).any(axis=1)))


def empty(origin: Origin, column: layout.Column, low: Array, high: Array) -> Diagnostic:
    """The message about bounds of one row, of the field's shape, that leave no value."""
    bad = np.atleast_1d(~(low <= high)).ravel()
    k = int(np.argmax(bad))
    least, most = np.atleast_1d(low).ravel()[k], np.atleast_1d(high).ravel()[k]
    return problem(
        "E0730",
        f"the bounds {least:g} .. {most:g} leave no value",
        origin,
        column,
        "set `low` below `high`; null is no bound",
    )


def split_fixed(flags: Bools) -> tuple[Bools, Bools]:
    """Flags (rows, k) of components as flags of whole rows (rows,), and of components elsewhere."""
    whole = np.asarray(flags.all(axis=-1))
    return whole, flags & ~whole[..., None]
