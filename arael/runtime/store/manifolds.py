"""Values on manifolds: accepted representations, and their validation.

The shape determines the form. Matrices of transforms are homogeneous, or their upper three rows.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from arael.runtime.layout import Column
from arael.runtime.store import rotations
from arael.runtime.store.rotations import Array

Shape = tuple[int, ...]

# Forms accepted by kind, the stored one first.
FORMS: dict[str, tuple[Shape, ...]] = {
    "euler": ((3,), (4,), (3, 3)),
    "quaternion": ((4,), (3,), (3, 3)),
    "direction": ((3,),),
    "transform": ((7,), (6,), (4, 4), (3, 4)),
    "similarity": ((8,), (4, 4), (3, 4)),
}

_XYZ = (".x", ".y", ".z")
_WXYZ = (".w", *_XYZ)
_RIGID = (*(f".translation{a}" for a in _XYZ), *(f".rotation{a}" for a in _WXYZ))
# Names of the stored scalars, after that of the field.
SUFFIXES: dict[str, tuple[str, ...]] = {
    "euler": _XYZ,
    "quaternion": _WXYZ,
    "direction": _XYZ,
    "transform": _RIGID,
    "similarity": (*_RIGID, ".scale"),
}

NEUTRAL: dict[str, tuple[float, ...]] = {
    "euler": (0, 0, 0),
    "quaternion": (1, 0, 0, 0),
    "direction": (0, 0, 1),
    "transform": (0, 0, 0, 1, 0, 0, 0),
    "similarity": (0, 0, 0, 1, 0, 0, 0, 1),
}


def kind_of(column: Column) -> str:
    """Kind of a column as `FORMS` lists it; "" if any numbers will do."""
    name = (
        column.param.kind
        if column.param is not None
        else column.type.removeprefix("param ").split(" ")[0].rstrip("?")
    )
    if name in ("rotation", "quaternion", "quat"):
        return "quaternion" if column.shape == (4,) else ""
    return name if name in FORMS and column.shape == FORMS[name][0] else ""


def forms_of(column: Column) -> tuple[Shape, ...]:
    """Accepted shapes of a value of the column, the stored one first."""
    kind = kind_of(column)
    if not kind or (kind == "quaternion" and column.param is None):
        return (column.shape,)
    return FORMS[kind]


def stored_form(kind: str, array: Array, shape: Shape) -> Array:
    """Convert values (..., *shape) of a valid form to the stored form."""
    if shape == FORMS[kind][0]:
        return _normalised(kind, array)
    array = array.astype(np.float64)
    if kind == "euler":
        if shape == (4,):
            array = rotations.matrix_from_quaternion(rotations.normalised(array))
        return rotations.euler_from_matrix(array)
    if kind == "quaternion":
        if shape == (3,):
            return rotations.quaternion_from_euler(array)
        return rotations.quaternion_from_matrix(array)
    if shape == (6,):
        turn = rotations.quaternion_from_euler(array[..., 3:])
        return np.concatenate([array[..., :3], turn], axis=-1)
    scale = scale_of(array) if kind == "similarity" else np.ones(array.shape[:-2])
    turn = rotations.quaternion_from_matrix(array[..., :3, :3] / scale[..., None, None])
    parts = [array[..., :3, 3], turn, scale[..., None]]
    return np.concatenate(parts if kind == "similarity" else parts[:2], axis=-1)


def _normalised(kind: str, array: Array) -> Array:
    if kind in ("quaternion", "direction"):
        return rotations.normalised(array.astype(np.float64))
    if kind in ("transform", "similarity"):
        array = array.astype(np.float64)
        array[..., 3:7] = rotations.normalised(array[..., 3:7])
    return array


def scale_of(matrix: Array) -> Array:
    """Scale of similarities given as matrices: the cube root of the determinant."""
    return np.asarray(np.cbrt(np.linalg.det(matrix[..., :3, :3])))


Check = tuple[str, Callable[[Array], Array], Callable[[Array], Array]]
"""An expectation, the part of a value that it applies to, and the test of that part."""


def checks_of(kind: str, shape: Shape) -> list[Check]:
    """Conditions on values of this form."""
    if shape == (4,):
        return [("a unit quaternion", lambda a: a, rotations.is_unit)]
    if shape == (3, 3):
        return [("a rotation matrix", lambda a: a, rotations.is_rotation)]
    if kind == "direction":
        return [("a unit vector", lambda a: a, rotations.is_unit)]
    if len(shape) == 2:
        found: list[Check] = []
        if shape == (4, 4):
            found.append(("a last row of 0 0 0 1", lambda a: a[..., 3, :], _is_last_row))
        if kind == "similarity":
            found.append(("a rotation matrix times a scale", lambda a: a, _is_scaled_rotation))
        else:
            rotation: Callable[[Array], Array] = lambda a: a[..., :3, :3]  # noqa: E731
            found.append(("a rotation matrix on the left", rotation, rotations.is_rotation))
        return found
    if kind in ("transform", "similarity") and shape != (6,):
        found = [("a unit quaternion", lambda a: a[..., 3:7], rotations.is_unit)]
        if kind == "similarity":
            found.append(("a positive scale", lambda a: a[..., 7], lambda s: np.asarray(s > 0)))
        return found
    return []


def _is_last_row(row: Array) -> Array:
    return np.asarray((np.abs(row - [0, 0, 0, 1]) <= rotations.UNIT_TOLERANCE).all(axis=-1))


def _is_scaled_rotation(matrix: Array) -> Array:
    scale = scale_of(matrix)
    safe = np.where(scale > 0, scale, 1.0)
    return np.asarray(
        (scale > 0) & rotations.is_rotation(matrix[..., :3, :3] / safe[..., None, None])
    )
