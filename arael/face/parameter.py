"""A parameter of one row or of many, as Python sees it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.store import Table, rotations
from arael.runtime.store.columns import Rows
from arael.runtime.store.messages import error

Array = NDArray[Any]


def taken(array: Array, rows: Rows) -> Any:
    """Rows of a column: a live view where they lie together, else a read-only copy."""
    part = array[rows]
    if isinstance(rows, np.ndarray):
        part.flags.writeable = False
    return part


class Parameter:
    """Value and flags of a parameter: of one row (``poses[3].pos``) or of many (``poses.pos``)."""

    __slots__ = ("_path", "_rows", "_table", "_whole")

    def __init__(
        self, table: Table, path: str, rows: Callable[[], Rows], whole: bool = False
    ) -> None:
        self._table = table
        self._path = path
        self._rows = rows
        self._whole = whole

    @property
    def _name(self) -> str:
        rows = self._rows()
        if isinstance(rows, int):
            return self._table.name_of(rows, self._path)
        return f"{self._table.label}.{self._path}"

    @property
    def value(self) -> Any:
        """What the parameter holds: (N, ...) or (...) as a live view; a number for one scalar.

        Euler angles as roll, pitch, yaw [rad]; rotations as unit quaternions (w, x, y, z). Valid
        until rows are added or removed. Writing into the view is not checked; assigning is.
        """
        part = taken(self._table.column(self._path), self._rows())
        return part if isinstance(part, np.ndarray) else part.item()

    @value.setter
    def value(self, value: Any) -> None:
        self._table.set_values(self._path, self._rows(), value, self._name)

    @property
    def fixed(self) -> Any:
        """Whether the data keeps the parameter out of every solve: bool, or (N,) bools."""
        return self._flag(self._table.fixed(self._path))

    @fixed.setter
    def fixed(self, value: Any) -> None:
        self._set_flag("fixed", value)

    @property
    def optimize(self) -> Any:
        """Whether the parameter is solved for, where it is not fixed: bool, or (N,) bools.

        Set for a whole collection it also holds for rows appended later.
        """
        return self._flag(self._table.optimize(self._path))

    @optimize.setter
    def optimize(self, value: Any) -> None:
        self._set_flag("optimize", value)
        if self._whole and isinstance(value, (bool, np.bool_)):
            self._table.optimize_new[self._path] = bool(value)

    def _flag(self, flags: Array) -> Any:
        part = taken(flags, self._rows())
        return part if isinstance(part, np.ndarray) else bool(part)

    def _set_flag(self, name: str, value: Any) -> None:
        array = np.asarray(value)
        flags, rows = self._table.column_of_flags(self._path, name), self._rows()
        if array.dtype != np.bool_ or array.shape not in ((), np.shape(flags[rows])):
            raise error("E0703", "expected true or false for each row", f"{self._name}.{name}")
        flags[rows] = array

    # --- rotations in other forms ----------------------------------------------------------------

    @property
    def _kind(self) -> str:
        param = self._table.data[self._path].param
        return param.kind if param is not None else ""

    @property
    def matrix(self) -> Array:
        """Rotation matrices (..., 3, 3), body to world; of an angle (..., 2, 2). Assignable."""
        value = np.asarray(self.value)
        if self._kind == "euler":
            return rotations.matrix_from_euler(value)
        if self._kind == "angle":
            c, s = np.cos(value), np.sin(value)
            return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
        return rotations.matrix_from_quaternion(self._rotation(value))

    @matrix.setter
    def matrix(self, value: Any) -> None:
        self._assign(value, (3, 3))

    @property
    def quaternion(self) -> Array:
        """Unit quaternions (..., 4): w, x, y, z. Assignable."""
        value = np.asarray(self.value)
        if self._kind == "euler":
            return rotations.quaternion_from_euler(value)
        return self._rotation(value).copy()

    @quaternion.setter
    def quaternion(self, value: Any) -> None:
        self._assign(value, (4,))

    @property
    def euler(self) -> Array:
        """Roll, pitch, yaw (..., 3) [rad]: ``R = Rz(yaw) Ry(pitch) Rx(roll)``. Assignable."""
        value = np.asarray(self.value)
        if self._kind == "euler":
            return value.copy()
        return rotations.euler_from_matrix(rotations.matrix_from_quaternion(self._rotation(value)))

    @euler.setter
    def euler(self, value: Any) -> None:
        self._assign(value, (3,))

    def _rotation(self, value: Array) -> Array:
        if self._kind not in ("rotation", "quaternion"):
            raise self._not_a_rotation()
        return value

    def _assign(self, value: Any, shape: tuple[int, ...]) -> None:
        if self._kind not in ("rotation", "quaternion", "euler"):
            raise self._not_a_rotation()
        if np.shape(value)[-len(shape) :] != shape:
            raise error(
                "E0704",
                f"expected values of shape {shape}, found shape {np.shape(value)}",
                self._name,
                self._table.data[self._path],
            )
        self.value = value

    def _not_a_rotation(self) -> Exception:
        return error(
            "E0703", "the parameter is not a rotation", self._name, self._table.data[self._path]
        )

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Let NumPy take the parameter for its value."""
        value = np.asarray(self.value, dtype=dtype)
        return value.copy() if copy else value

    def __repr__(self) -> str:
        flags = "".join(
            f", {text}"
            for text, is_so in (
                ("fixed", np.all(self.fixed)),
                ("not optimised", not np.any(self.optimize)),
            )
            if is_so and np.size(self.value)
        )
        text = np.array2string(np.asarray(self.value), precision=6, threshold=12, edgeitems=2)
        return f"<{self._name}: {text}{flags}>"
