"""Rigid transforms and similarities of expressions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

from arael.check.typed import TransformType
from arael.sym.expr import Expr, as_expr
from arael.sym.operations import WRITTEN, call_on_any
from arael.sym.shapes import Composite, Matrix, Quaternion, Vector
from arael.sym.value import Value
from arael.symbolic import linear, rigid


class Transform(Composite):
    """``x -> s R x + t``: a translation, a unit quaternion and, of a similarity, a scale.

    ``T * x`` moves a point, ``A * B`` is first `B`, then `A`; ``A.inverse() * B`` lies between.
    """

    __slots__ = ()

    def __init__(
        self, translation: Vector, rotation: Quaternion, scale: Expr | float | None = None
    ) -> None:
        entries = (*translation.entries, *rotation.entries)
        if len(entries) != 7:
            raise ValueError("a transform needs a translation of length 3 and a quaternion")
        self._entries = entries if scale is None else (*entries, as_expr(scale))

    @property
    def type(self) -> TransformType:
        """``transform`` or ``similarity``."""
        return TransformType(scaled=len(self._entries) == 8)

    def with_entries(self, entries: Iterable[Expr]) -> Transform:
        """Return another transform of the same kind."""
        return of_entries(tuple(entries))

    @property
    def translation(self) -> Vector:
        """Translation t."""
        return Vector(self._entries[:3])

    @property
    def rotation(self) -> Quaternion:
        """Rotation as a unit quaternion."""
        return Quaternion(*self._entries[3:7])

    @property
    def scale(self) -> Expr:
        """Scale s: 1 of a rigid transform."""
        return self._entries[7] if len(self._entries) == 8 else as_expr(1.0)

    def inverse(self) -> Transform:
        """Transform back."""
        return cast(Transform, call_on_any("inverse", self))

    def rotation_matrix(self) -> Matrix:
        """Rotation matrix R."""
        return cast(Matrix, call_on_any("rotation_matrix", self))

    def matrix(self) -> Matrix:
        """The homogeneous 4 x 4 matrix."""
        return cast(Matrix, call_on_any("matrix", self))

    def log(self) -> Vector:
        """Twist: translation part, rotation vector and, of a similarity, log of the scale."""
        return cast(Vector, call_on_any("log", self))


def of_entries(entries: tuple[Expr, ...]) -> Transform:
    """Return the transform with these scalars."""
    return Transform(Vector(entries[:3]), Quaternion(*entries[3:7]), *entries[7:])


def part(value: Transform, name: str) -> Value | None:
    """``T.translation``, ``T.rotation``, ``T.scale`` by name; None of anything else."""
    if name in ("translation", "rotation") or (name == "scale" and value.type.scaled):
        return cast(Value, getattr(value, name))
    return None


def apply(operation: str, values: Sequence[Value]) -> list[Expr]:
    """Scalars of an operation whose first operand is a transform."""
    first, *others = values
    a = cast(Any, first.entries)
    matrix = rigid.matrix_of(WRITTEN, a)
    if operation == "mul":
        (other,) = others
        multiply: Callable[..., Any] = (
            rigid.compose if isinstance(other, Transform) else rigid.apply
        )
        if isinstance(other, Transform):
            return list(multiply(WRITTEN, a, cast(Any, other.entries), matrix))
        return list(multiply(WRITTEN, a, matrix, cast(Any, other.entries)))
    made: Any
    match operation:
        case "tf_log":
            made = rigid.log(WRITTEN, a)
        case "inverse":
            made = rigid.inverse(WRITTEN, a, matrix)
        case "matrix":
            made = linear.flatten(rigid.homogeneous(WRITTEN, a, matrix))
        case _:
            assert operation == "rotation_matrix", operation
            made = linear.flatten(matrix)
    return list(made)
