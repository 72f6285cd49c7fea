"""The built-in functions: arguments and result types.

A signature maps argument types to the type of the result, or to None if they do not fit; `takes`
describes valid arguments in words.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arael.check.typed import (
    INT,
    QUATERNION,
    REAL,
    SIMILARITY,
    TRANSFORM,
    MatrixType,
    QuaternionType,
    ScalarType,
    TransformType,
    ValueType,
    VectorType,
)
from arael.manifolds.inverse import LARGEST_DETERMINANT, LARGEST_INVERSE
from arael.operations import OPERATIONS, Operation, constants

Types = Sequence[ValueType]

MAT2 = MatrixType(2, 2)
MAT3 = MatrixType(3, 3)
MAT4 = MatrixType(4, 4)
VEC3 = VectorType(3)
TWISTS: dict[ValueType, ValueType] = {VectorType(6): TRANSFORM, VectorType(7): SIMILARITY}

# Constants by name, and the functions without arguments that read like constants.
CONSTANTS = tuple(constants.CONSTANTS)
IDENTITIES: dict[str, ValueType] = {"identity2": MAT2, "identity3": MAT3}


def is_number(type_: ValueType) -> bool:
    """Whether a type is a scalar number."""
    return type_ in (REAL, INT)


@dataclass(frozen=True)
class Signature:
    """A built-in function.

    `result` is the type of the result, or the name of the operation in typed expressions with that
    type, or None if the arguments do not fit.
    """

    least: int
    most: int | None
    takes: str
    result: Callable[[Types], ValueType | tuple[str, ValueType] | None]
    method: bool = False

    @property
    def arity(self) -> str:
        """Number of arguments in words."""
        if self.most is None:
            return f"at least {self.least}"
        return str(self.least) if self.most == self.least else f"{self.least} or {self.most}"


def _elementwise(types: Types) -> ValueType | None:
    (x,) = types
    if is_number(x):
        return REAL
    return x if isinstance(x, VectorType) else None


def _scalars(types: Types) -> ValueType | None:
    return REAL if all(is_number(t) for t in types) else None


def _starship(types: Types) -> ValueType | None:
    r, gamma = types
    if not is_number(gamma):
        return None
    return REAL if is_number(r) else r if isinstance(r, VectorType) else None


def _exp(types: Types) -> ValueType | tuple[str, ValueType] | None:
    if types[0] == VEC3:
        return "quat_exp", QUATERNION
    if types[0] in TWISTS:
        return "tf_exp", TWISTS[types[0]]
    return REAL if is_number(types[0]) else None


def _log(types: Types) -> ValueType | tuple[str, ValueType] | None:
    if types[0] == QUATERNION:
        return "quat_log", VEC3
    if isinstance(types[0], TransformType):
        return "tf_log", VectorType(7 if types[0].scaled else 6)
    return _elementwise(types)


def _same_vectors(types: Types) -> ValueType | None:
    a, b = types
    return REAL if isinstance(a, VectorType) and a == b else None


def _vector_to_scalar(types: Types) -> ValueType | None:
    return REAL if isinstance(types[0], VectorType) else None


def _vector_to_vector(types: Types) -> ValueType | None:
    return types[0] if isinstance(types[0], VectorType) else None


def _cross(types: Types) -> ValueType | None:
    return VEC3 if all(t == VEC3 for t in types) else None


def _perp(types: Types) -> ValueType | None:
    return types[0] if types[0] == VectorType(2) else None


def _transpose(types: Types) -> ValueType | None:
    m = types[0]
    return MatrixType(m.columns, m.rows) if isinstance(m, MatrixType) else None


def _square(m: ValueType, largest: int) -> bool:
    return isinstance(m, MatrixType) and m.rows == m.columns and m.rows <= largest


def _inverse(types: Types) -> ValueType | None:
    if types[0] == QUATERNION or isinstance(types[0], TransformType):
        return types[0]
    return types[0] if _square(types[0], LARGEST_INVERSE) else None


def _det(types: Types) -> ValueType | None:
    return REAL if _square(types[0], LARGEST_DETERMINANT) else None


def _trace(types: Types) -> ValueType | None:
    m = types[0]
    return REAL if isinstance(m, MatrixType) and m.rows == m.columns else None


def _rotation_matrix(types: Types) -> ValueType | None:
    x = types[0]
    if is_number(x):
        return MAT2
    return MAT3 if x in (VEC3, QUATERNION, TRANSFORM, SIMILARITY) else None


def _matrix(types: Types) -> ValueType | None:
    return MAT4 if isinstance(types[0], TransformType) else None


def _is_motion(types: Types) -> bool:
    """Whether `types` are a translation and a rotation, in either order."""
    return len(types) == 2 and VEC3 in types and (QUATERNION in types or MAT3 in types)


def _transform(types: Types) -> ValueType | None:
    whole = len(types) == 1 and types[0] in (MAT4, MatrixType(3, 4))
    return TRANSFORM if whole or _is_motion(types) else None


def _similarity(types: Types) -> ValueType | None:
    return SIMILARITY if _is_motion(types[:2]) and is_number(types[2]) else None


def _mat3(types: Types) -> tuple[str, ValueType] | None:
    return ("rotation_matrix", MAT3) if types[0] in (QUATERNION, TRANSFORM, SIMILARITY) else None


def _rotation_vector(types: Types) -> ValueType | tuple[str, ValueType] | None:
    return ("quat_log", VEC3) if types[0] == QUATERNION else VEC3 if types[0] == MAT3 else None


def _exactly(takes: ValueType, gives: ValueType) -> Callable[[Types], ValueType | None]:
    return lambda types: gives if types[0] == takes else None


def _euler_angles(types: Types) -> ValueType | None:
    return VEC3 if types[0] in (MAT3, QUATERNION) else None


def _conj(types: Types) -> ValueType | None:
    return QUATERNION if types[0] == QUATERNION else None


def _rotate(types: Types) -> ValueType | None:
    return VEC3 if isinstance(types[0], QuaternionType) and types[1] == VEC3 else None


def _one(
    takes: str, result: Callable[[Types], ValueType | tuple[str, ValueType] | None]
) -> Signature:
    return Signature(1, 1, takes, result, method=True)


def _scalar_function(operation: Operation) -> Signature:
    if operation.arity == 1:
        return Signature(1, 1, "a scalar or a vector", _elementwise)
    if operation.units == "starship":
        return Signature(2, 2, operation.takes, _starship)
    if operation.several:
        return Signature(2, None, "scalars", _scalars)
    return Signature(operation.arity, operation.arity, operation.takes or "two scalars", _scalars)


FUNCTIONS: dict[str, Signature] = {
    **{one.name: _scalar_function(one) for one in OPERATIONS.values() if one.function},
    "exp": _one(
        "a scalar, a rotation vector (vec3) for a quaternion, or a twist (vec<6>, vec<7>) for a "
        "transform",
        _exp,
    ),
    "log": _one("a scalar, a vector, a quaternion or a transform", _log),
    "dot": Signature(2, 2, "two vectors of the same length", _same_vectors, method=True),
    "cross": Signature(2, 2, "two vectors of length 3", _cross, method=True),
    "norm": _one("a vector", _vector_to_scalar),
    "norm2": _one("a vector", _vector_to_scalar),
    "unit": _one("a vector", _vector_to_vector),
    "perp": _one("a vec2", _perp),
    "transpose": _one("a matrix", _transpose),
    "inverse": _one(
        f"a square matrix of up to {LARGEST_INVERSE} rows, a quaternion, or a transform", _inverse
    ),
    "det": _one(f"a square matrix of up to {LARGEST_DETERMINANT} rows", _det),
    "trace": _one("a square matrix", _trace),
    "skew": _one("a vec3", _exactly(VEC3, MAT3)),
    "vee": _one("a mat3", _exactly(MAT3, VEC3)),
    "rotation_matrix": _one(
        "Euler angles (vec3), a quaternion, a transform, or an angle (real)", _rotation_matrix
    ),
    "matrix": _one("a transform", _matrix),
    "mat3": Signature(1, 1, "a quaternion or a transform", _mat3),
    "quaternion": Signature(1, 1, "a rotation matrix (mat3)", _exactly(MAT3, QUATERNION)),
    "transform": Signature(
        1, 2, "a matrix (mat<4,4>), or a rotation (mat3, quaternion) and a vec3", _transform
    ),
    "similarity": Signature(
        3, 3, "a translation (vec3), a rotation (quaternion, mat3), and a scale (real)", _similarity
    ),
    "euler_angles": _one("a mat3 or a quaternion", _euler_angles),
    "rotation_vector": _one("a mat3 or a quaternion", _rotation_vector),
    "conj": _one("a quaternion", _conj),
    "rotate": Signature(2, 2, "a quaternion and a vec3", _rotate, method=True),
}

# `M.row(i)` and `M.col(i)`: methods only, their argument is a constant.
ROW_METHODS = {"row": "row", "col": "column"}

METHODS = frozenset({name for name, s in FUNCTIONS.items() if s.method} | ROW_METHODS.keys())

BUILTIN_NAMES = frozenset({*FUNCTIONS, *CONSTANTS, *IDENTITIES})


def widened(type_: ValueType) -> ValueType:
    """The type that arithmetic on a value of `type_` gives: whole numbers become real."""
    return REAL if isinstance(type_, ScalarType) and type_ == INT else type_
