"""Vectors, matrices and quaternions of expressions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from arael.check.typed import (
    QUATERNION,
    MatrixType,
    QuaternionType,
    TransformType,
    ValueType,
    VectorType,
)
from arael.sym.errors import fail
from arael.sym.expr import Expr, as_expr, const, symbol
from arael.sym.limits import MAX_SCALARS
from arael.sym.value import Value


class Composite(Value):
    """A value of several scalars."""

    __slots__ = ("_entries",)

    _entries: tuple[Expr, ...]

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Scalars in order."""
        return self._entries

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Composite):
            return NotImplemented
        return self.type == other.type and self.entries == other.entries

    def __hash__(self) -> int:
        return hash((self.type, self.entries))

    def _call(self, name: str, *args: Any) -> Any:
        from arael.sym.operations import call_on_any

        return call_on_any(name, self, *args)


class Vector(Composite):
    """A column of expressions: ``Vector([x, y, 1])``, or ``Vector("p", 3)`` for p.x, p.y, p.z."""

    __slots__ = ()

    def __init__(self, entries: Iterable[Expr | float] | str, n: int | None = None) -> None:
        if isinstance(entries, str):
            entries = _named(entries, n)
        self._entries = tuple(as_expr(e) for e in entries)
        _check_count(len(self._entries))

    @property
    def type(self) -> VectorType:
        """``vec<n>``."""
        return VectorType(len(self._entries))

    def with_entries(self, entries: Iterable[Expr]) -> Vector:
        """Return another vector."""
        return Vector(entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[Expr]:
        return iter(self._entries)

    def __getitem__(self, i: int) -> Expr:
        return self._entries[i]

    @property
    def x(self) -> Expr:
        """First component."""
        return self._entries[0]

    @property
    def y(self) -> Expr:
        """Second component."""
        return self._entries[1]

    @property
    def z(self) -> Expr:
        """Third component."""
        return self._entries[2]

    def dot(self, other: Vector) -> Expr:
        """Inner product."""
        return self._call("dot", other)  # type: ignore[no-any-return]

    def cross(self, other: Vector) -> Vector:
        """Cross product of vectors of length 3."""
        return self._call("cross", other)  # type: ignore[no-any-return]

    def norm(self) -> Expr:
        """Euclidean norm."""
        return self._call("norm")  # type: ignore[no-any-return]

    def norm2(self) -> Expr:
        """Squared Euclidean norm."""
        return self._call("norm2")  # type: ignore[no-any-return]

    def unit(self) -> Vector:
        """Vector of length 1 in the same direction."""
        return self._call("unit")  # type: ignore[no-any-return]


class Matrix(Composite):
    """A matrix of expressions, given by its rows."""

    __slots__ = ("_columns",)

    def __init__(self, rows: Sequence[Iterable[Expr | float]]) -> None:
        table = [tuple(as_expr(e) for e in row) for row in rows]
        if not table or not table[0] or len({len(row) for row in table}) != 1:
            raise ValueError("a matrix needs rows of one length, one at least")
        self._columns = len(table[0])
        self._entries = tuple(e for row in table for e in row)
        _check_count(len(self._entries))

    @property
    def type(self) -> MatrixType:
        """``mat<rows,columns>``."""
        return MatrixType(len(self._entries) // self._columns, self._columns)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns."""
        return self.type.rows, self._columns

    @property
    def rows(self) -> tuple[tuple[Expr, ...], ...]:
        """Entries, row by row."""
        n = self._columns
        return tuple(self._entries[i : i + n] for i in range(0, len(self._entries), n))

    def with_entries(self, entries: Iterable[Expr]) -> Matrix:
        """Return another matrix of the same shape."""
        return composite(self.type, tuple(entries))  # type: ignore[return-value]

    def __getitem__(self, at: tuple[int, int]) -> Expr:
        i, j = at
        return self.rows[i][j]

    @property
    def T(self) -> Matrix:
        """Transposed matrix."""
        return self.transpose()

    def transpose(self) -> Matrix:
        """Transposed matrix."""
        return self._call("transpose")  # type: ignore[no-any-return]

    def row(self, i: int) -> Vector:
        """Row `i` as a vector."""
        return Vector(self.rows[i])

    def col(self, j: int) -> Vector:
        """Column `j` as a vector."""
        return Vector(row[j] for row in self.rows)

    def det(self) -> Expr:
        """Determinant, up to 4 x 4."""
        return self._call("det")  # type: ignore[no-any-return]

    def inverse(self) -> Matrix:
        """Inverse matrix, up to 6 x 6."""
        return self._call("inverse")  # type: ignore[no-any-return]

    def trace(self) -> Expr:
        """Sum of the diagonal."""
        return self._call("trace")  # type: ignore[no-any-return]

    def euler_angles(self) -> Vector:
        """Roll, pitch, yaw (rad) of a rotation matrix."""
        return self._call("euler_angles")  # type: ignore[no-any-return]

    def rotation_vector(self) -> Vector:
        """Rotation vector (rad) of a rotation matrix."""
        return self._call("rotation_vector")  # type: ignore[no-any-return]


class Quaternion(Composite):
    """A quaternion, scalar first; those that rotate are of length 1."""

    __slots__ = ()

    def __init__(self, w: Expr | float, x: Expr | float, y: Expr | float, z: Expr | float) -> None:
        self._entries = tuple(as_expr(e) for e in (w, x, y, z))

    @classmethod
    def named(cls, name: str) -> Quaternion:
        """Return the quaternion of the variables ``name.w name.x name.y name.z``."""
        return cls(*(symbol(f"{name}.{part}") for part in "wxyz"))

    @property
    def type(self) -> QuaternionType:
        """``quat``."""
        return QUATERNION

    def with_entries(self, entries: Iterable[Expr]) -> Quaternion:
        """Return another quaternion."""
        return Quaternion(*entries)

    @property
    def w(self) -> Expr:
        """Scalar part."""
        return self._entries[0]

    @property
    def x(self) -> Expr:
        """First component of the vector part."""
        return self._entries[1]

    @property
    def y(self) -> Expr:
        """Second component of the vector part."""
        return self._entries[2]

    @property
    def z(self) -> Expr:
        """Third component of the vector part."""
        return self._entries[3]

    @property
    def vec(self) -> Vector:
        """Vector part."""
        return Vector(self._entries[1:])

    def conj(self) -> Quaternion:
        """Conjugate: of a quaternion of length 1, the inverse."""
        return self._call("conj")  # type: ignore[no-any-return]

    def inverse(self) -> Quaternion:
        """Inverse of any quaternion but zero."""
        return self._call("inverse")  # type: ignore[no-any-return]

    def rotate(self, v: Vector) -> Vector:
        """Turn `v`, body to world."""
        return self._call("rotate", v)  # type: ignore[no-any-return]

    def rotation_matrix(self) -> Matrix:
        """Rotation matrix, body to world."""
        return self._call("rotation_matrix")  # type: ignore[no-any-return]

    def euler_angles(self) -> Vector:
        """Roll, pitch, yaw (rad)."""
        return self._call("euler_angles")  # type: ignore[no-any-return]

    def log(self) -> Vector:
        """Rotation vector (rad), of length at most pi."""
        return self._call("log")  # type: ignore[no-any-return]


def composite(type_: ValueType, entries: tuple[Expr, ...]) -> Value:
    """Return a value of type `type_`; a scalar as itself."""
    if isinstance(type_, VectorType):
        return Vector(entries)
    if isinstance(type_, MatrixType):
        n = type_.columns
        return Matrix([entries[i * n : (i + 1) * n] for i in range(type_.rows)])
    if isinstance(type_, QuaternionType):
        return Quaternion(*entries)
    if isinstance(type_, TransformType):
        from arael.sym.transforms import of_entries

        return of_entries(entries)
    (entry,) = entries
    return entry


def as_value(x: Any) -> Value:
    """Return what a caller gave as a value: numbers, lists and arrays become constants."""
    if isinstance(x, Value):
        return x
    if hasattr(x, "ndim") and hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, (list, tuple)):
        if x and isinstance(x[0], (list, tuple)):
            return Matrix(x)
        return Vector(x)
    if isinstance(x, (str, bytes)):
        raise TypeError("text is no value: `parse` reads formulas, `symbol` names variables")
    return const(float(x))


def _named(name: str, n: int | None) -> list[Expr]:
    if n is None:
        raise TypeError("a vector of named variables needs its length")
    parts = "xyz"[:n] if n <= 3 else [f"_{i}" for i in range(n)]
    return [symbol(f"{name}.{part}") for part in parts]


def _check_count(n: int) -> None:
    if n > MAX_SCALARS:
        fail(
            "E0653",
            f"{n} scalars in one value",
            origin="expression",
            help=(f"at most {MAX_SCALARS} are allowed",),
        )
    if n == 0:
        raise ValueError("a value needs one scalar at least")
