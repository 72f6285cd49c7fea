"""Checks that structured arrays match the C structs that read them, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def probe_of(dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an array of one record whose fields hold 1, 2, 3, ... in order."""
    probe = np.zeros(1, dtype=dtype)
    for k, name in enumerate(dtype.names or ()):
        probe[name] = k + 1
    return probe


def check_record(name: str, dtype: np.dtype[Any], found: Mapping[str, float], size: int) -> None:
    """Compare the values that C read from `probe_of(dtype)` with the written ones.

    Parameters
    ----------
    name : of the struct
    found : value of each member of the struct, by name
    size : of the struct, in bytes

    Raises
    ------
    TypeError
        If a member has another name, offset or type than the field, or one of them is missing.
    """
    expected = {field: k + 1 for k, field in enumerate(dtype.names or ())}
    if dict(found) != expected or size != dtype.itemsize:
        raise TypeError(
            f"struct {name} ({size} bytes) does not match its records ({dtype.itemsize} bytes): "
            f"expected {expected}, found {dict(found)}"
        )
