"""Vectors and matrices in constant expressions: operations that are not elementwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.check.typed import MatrixType, ScalarType, ValueType, VectorType

Array = NDArray[np.float64]
Values = tuple[float, ...]


def _skew(v: Array) -> Array:
    """The matrix of the cross product, ``skew(v) * u = cross(v, u)``."""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


OPERATIONS: dict[str, Callable[..., Any]] = {
    "mul": np.matmul,
    "dot": np.dot,
    "cross": np.cross,
    "norm": np.linalg.norm,
    "norm2": lambda v: np.sum(v * v),
    "unit": lambda v: v / np.linalg.norm(v),
    "skew": _skew,
    "trace": np.trace,
    "det": np.linalg.det,
    "transpose": np.transpose,
    "inverse": np.linalg.inv,
}


def vector_value(name: str, types: Sequence[ValueType], args: Sequence[Values]) -> Values | None:
    """Value of an operation on vectors and matrices, flat; None for an unsupported operation."""
    operation = OPERATIONS.get(name)
    arrays = [_array(type_, values) for type_, values in zip(types, args, strict=True)]
    if operation is None or any(a is None for a in arrays):
        return None
    try:
        with np.errstate(all="ignore"):
            numbers = np.ravel(operation(*arrays))
    except np.linalg.LinAlgError:  # a singular matrix has no inverse
        return (float("nan"),)
    return tuple(float(x) for x in numbers)


def _array(type_: ValueType, values: Values) -> Array | None:
    if isinstance(type_, MatrixType):
        return np.reshape(values, (type_.rows, type_.columns))
    if isinstance(type_, VectorType):
        return np.array(values, dtype=np.float64)
    return np.array(values[0], dtype=np.float64) if isinstance(type_, ScalarType) else None
