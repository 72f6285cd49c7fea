"""Rule: the operands of an operator fit each other.

Allowed: ``mat3 * vec3``, ``2 * quat``, ``vec3 .* vec3``.

Not allowed: ``mat3 * vec2``, ``vec3 * vec3`` (ambiguous: use `dot` or ``.*``), ``1 + vec2``.
"""

from __future__ import annotations

from arael.check.builtins import is_number
from arael.check.typed import (
    BOOL,
    QUATERNION,
    REAL,
    MatrixType,
    TransformType,
    ValueType,
    VectorType,
)

OPERATIONS = {
    "+": "add",
    "-": "sub",
    "*": "mul",
    "/": "div",
    "^": "pow",
    ".*": "emul",
    "./": "ediv",
    "==": "eq",
    "!=": "ne",
    "<": "lt",
    "<=": "le",
    ">": "gt",
    ">=": "ge",
}


def result_type(operator: str, a: ValueType, b: ValueType) -> ValueType | None:
    """Type of ``a operator b``; None if the operands do not fit. Neither is bool or string."""
    if operator in ("==", "!=", "<", "<=", ">", ">="):
        return BOOL if is_number(a) and is_number(b) else None
    if is_number(a) and is_number(b):
        return REAL
    if operator in ("+", "-"):
        return a if a == b and not isinstance(a, TransformType) else None
    if operator == "*":
        return _product(a, b)
    if operator == "/":
        return a if is_number(b) and not isinstance(a, TransformType) else None
    if operator in (".*", "./"):
        return _elementwise(operator, a, b)
    return None


def _product(a: ValueType, b: ValueType) -> ValueType | None:
    if isinstance(a, TransformType):
        return b if b in (a, VectorType(3)) else None
    if isinstance(b, TransformType):
        return None
    if is_number(a):
        return b
    if is_number(b):
        return a
    if isinstance(a, MatrixType) and isinstance(b, MatrixType):
        return MatrixType(a.rows, b.columns) if a.columns == b.rows else None
    if isinstance(a, MatrixType) and isinstance(b, VectorType):
        return VectorType(a.rows) if a.columns == b.n else None
    if isinstance(a, VectorType) and isinstance(b, MatrixType):
        return VectorType(b.columns) if a.n == b.rows else None
    return QUATERNION if a == b == QUATERNION else None


def _elementwise(operator: str, a: ValueType, b: ValueType) -> ValueType | None:
    shaped = (VectorType, MatrixType)
    if isinstance(a, shaped) and (a == b or is_number(b)):
        return a
    return b if isinstance(b, shaped) and is_number(a) else None


def advice(operator: str, a: ValueType, b: ValueType) -> list[str]:
    """Help for an operation whose operands do not fit."""
    if isinstance(a, TransformType) or isinstance(b, TransformType):
        return _transform_advice(operator, a, b)
    vectors = isinstance(a, VectorType) and isinstance(b, VectorType)
    if operator == "*" and vectors and a == b:
        return ["write `dot(a, b)` for the inner product, `a .* b` to multiply element by element"]
    if operator == "/" and vectors and a == b:
        return ["write `a ./ b` to divide element by element"]
    if operator == "*" and a == QUATERNION and b == VectorType(3):
        return ["write `q.rotate(v)` to rotate a vector by a quaternion"]
    if operator == "*" and isinstance(a, MatrixType):
        flipped = MatrixType(a.columns, a.rows)
        if result_type("*", flipped, b) is not None:
            return ["transpose the left side: `M' * ...`"]
        if isinstance(b, VectorType):
            return [f"the right side needs {a.columns} rows"]
    if operator == "/" and isinstance(b, MatrixType):
        return ["write `b.inverse() * a` to divide by a matrix"]
    if operator in ("==", "!=", "<", "<=", ">", ">="):
        return ["compare scalars: components (`a.x < b.x`) or a norm (`norm(a - b) < c`)"]
    if operator == "^":
        return ["both sides of `^` are scalars"]
    return []


def _transform_advice(operator: str, a: ValueType, b: ValueType) -> list[str]:
    if operator in ("+", "-", "/") and a == b:
        return ["write `A.inverse() * B` for the transform between two"]
    if operator == "*" and isinstance(a, TransformType) and isinstance(b, TransformType):
        return ["a transform becomes a similarity by `similarity(T.translation, T.rotation, 1)`"]
    if operator == "*" and isinstance(b, TransformType):
        return ["write the transform on the left: `T * x`"]
    return ["a transform multiplies a vec3 or a transform: `T * x`, `A.inverse() * B`"]
