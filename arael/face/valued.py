"""Mixin of what calculates as its value."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

Array = NDArray[Any]


class Valued(NDArrayOperatorsMixin):
    """What stands for its `value` in arithmetic, NumPy functions, comparisons and formatting."""

    __slots__ = ()

    value: Any

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Conversion to a NumPy array: its value."""
        value = np.asarray(self.value, dtype=dtype)
        return value.copy() if copy else value

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        values = [np.asarray(x.value) if isinstance(x, Valued) else x for x in inputs]
        if any(isinstance(x, Valued) for x in kwargs.get("out", ())):
            return NotImplemented
        return getattr(ufunc, method)(*values, **kwargs)

    __hash__ = None  # type: ignore[assignment]  # compared by value

    def __float__(self) -> float:
        return float(self.value)

    def __getitem__(self, index: Any) -> Any:
        return np.asarray(self.value)[index]

    def __format__(self, how: str) -> str:
        return format(self.value, how) if how else repr(self)
