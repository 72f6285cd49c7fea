"""The shared check of array shapes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic

Array = NDArray[np.float64]


def as_array(values: ArrayLike, tail: tuple[int, ...], what: str) -> Array:
    """Return `values` as f64 of shape ``(..., *tail)``.

    Parameters
    ----------
    tail : the last dimensions
    what : name of the argument, for the message

    Raises
    ------
    AraelError
        E1031 if the values are not numbers or their last dimensions differ.
    """
    try:
        found = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise _refused(what, tail, "something that is not an array of numbers") from None
    if found.ndim < len(tail) or found.shape[found.ndim - len(tail) :] != tail:
        raise _refused(what, tail, f"shape {found.shape}")
    return found


def as_numbers(values: ArrayLike, what: str) -> Array:
    """Return `values` of any shape as f64; AraelError (E1031) if they are not numbers."""
    return as_array(values, (), what)


def as_scalar(value: float, what: str) -> float:
    """Return `value` as a number; AraelError (E1031) if it is none."""
    found = as_numbers(value, what)
    if found.ndim:
        raise _refused(what, (), f"shape {found.shape}")
    return float(found)


def _refused(what: str, tail: tuple[int, ...], found: str) -> AraelError:
    expected = f"have shape ({', '.join(['...', *map(str, tail)])})" if tail else "be a number"
    return AraelError(
        Diagnostic(
            "E1031",
            f"`{what}` must {expected}, found {found}",
            origin="arael.geometry",
            help=("one item or many: the leading dimensions are free",),
        )
    )
