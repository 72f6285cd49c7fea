"""Types by their names: the stored value and the type of a read for each."""

from __future__ import annotations

import re
from dataclasses import dataclass

from arael.check.limits import MAX_MATRIX, MAX_VECTOR
from arael.check.typed import (
    BOOL,
    INT,
    QUATERNION,
    REAL,
    SIMILARITY,
    STRING,
    TRANSFORM,
    MatrixType,
    TransformType,
    ValueType,
    VectorType,
)
from arael.manifolds.parameters import parameter_type
from arael.runtime.layout import Param, Part
from arael.syntax import tree

FIXED_TYPES: dict[str, ValueType] = {
    "real": REAL,
    "int": INT,
    "bool": BOOL,
    "string": STRING,
    "vec2": VectorType(2),
    "vec3": VectorType(3),
    "mat2": MatrixType(2, 2),
    "mat3": MatrixType(3, 3),
    "quat": QUATERNION,
}

# Type of a read of each parameter type that is not plain.
PARAM_READINGS: dict[str, ValueType] = {
    "euler": VectorType(3),
    "rotation": QUATERNION,
    "quaternion": QUATERNION,
    "angle": REAL,
    "direction": VectorType(3),
    "transform": TRANSFORM,
    "similarity": SIMILARITY,
}


def _param(name: str) -> Param:
    kind = parameter_type(name)
    parts = tuple(Part(*part) for part in kind.parts)
    return Param(name, kind.storage, kind.tangent_width, parts=parts)  # type: ignore[arg-type]


PARAM_TYPES: dict[str, tuple[ValueType, Param]] = {
    name: (reading, _param(name)) for name, reading in PARAM_READINGS.items()
}

# Parameter types that are allowed for data as well, as measurements of parameters.
DATA_TYPES = frozenset({"direction", "transform", "similarity"})

TYPE_NAMES = frozenset({*FIXED_TYPES, *PARAM_TYPES, "vec", "mat", "constraint_index"})


@dataclass(frozen=True)
class BadSize:
    """A vector or matrix type of invalid size; `reason` completes the message."""

    reason: str


def sized(name: str) -> str:
    """The correct form of ``vec4`` or ``mat34``: ``vec<4>``, ``mat<3,4>``; "" for other names."""
    match = re.fullmatch(r"vec([1-9]\d*)|mat([1-9])(?:x?([1-9]))?", name)
    if match is None:
        return ""
    n, rows, columns = match.groups()
    return f"vec<{n}>" if n else f"mat<{rows},{columns or rows}>"


def value_type(node: tree.NamedType) -> ValueType | BadSize | None:
    """The value type that `node` names; None if it is not one (for example a struct)."""
    if not node.dims:
        if node.name in DATA_TYPES:
            return PARAM_READINGS[node.name]
        if node.name in ("vec", "mat"):
            example = "vec<4>" if node.name == "vec" else "mat<2,3>"
            return BadSize(f"needs its size, as in `{example}`")
        return FIXED_TYPES.get(node.name)
    if node.name == "vec" and len(node.dims) == 1:
        n = node.dims[0]
        return (
            VectorType(n) if 1 <= n <= MAX_VECTOR else BadSize(f"needs 1 to {MAX_VECTOR} scalars")
        )
    if node.name == "mat" and len(node.dims) == 2:
        rows, columns = node.dims
        if rows < 1 or columns < 1 or rows * columns > MAX_MATRIX:
            return BadSize(f"needs 1 to {MAX_MATRIX} scalars")
        return MatrixType(rows, columns)
    if node.name in ("vec", "mat"):
        return BadSize("takes one size for `vec`, two for `mat`")
    return BadSize("takes no size") if node.name in TYPE_NAMES else None


def shape_of(type_: ValueType) -> tuple[int, ...]:
    """Shape of a value in a column."""
    if isinstance(type_, VectorType):
        return (type_.n,)
    if isinstance(type_, MatrixType):
        return (type_.rows, type_.columns)
    if isinstance(type_, TransformType):
        return (8 if type_.scaled else 7,)
    return (4,) if type_ == QUATERNION else ()


def size_of(type_: ValueType) -> int:
    """Number of scalars of a value."""
    size = 1
    for n in shape_of(type_):
        size *= n
    return size


def type_text(node: tree.TypeExpr) -> str:
    """A type as a model writes it."""
    if isinstance(node, tree.NamedType):
        dims = f"<{','.join(map(str, node.dims))}>" if node.dims else ""
        return node.name + dims + (f" [{node.unit.text}]" if node.unit else "")
    if isinstance(node, tree.OptionalType):
        return f"{type_text(node.inner)}?"
    if isinstance(node, tree.CollectionType):
        return f"{node.kind} of {type_text(node.element)}"
    if isinstance(node, tree.RefType):
        return f"ref {node.target.id} in {node.path}" + "?" * node.optional
    if isinstance(node, tree.RefListType):
        return f"[{type_text(node.ref)}; {node.count}]"
    if isinstance(node, tree.BlockType):
        names = ", ".join(e.id for e in node.entities)
        return f"block {names}" if len(node.entities) == 1 else f"block ({names})"
    return "triplets"
