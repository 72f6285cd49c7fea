"""Values of rotations and transforms in other representations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Column
from arael.runtime.store import rotations
from arael.runtime.store.messages import error

Array = NDArray[Any]

RIGID = ("transform", "similarity")


class Forms:
    """Reads and writes ``value`` in other representations, with the same checks."""

    __slots__ = ()

    value: Any

    @property
    def _name(self) -> str:
        raise AssertionError

    @property
    def _column(self) -> Column:
        raise AssertionError

    @property
    def _kind(self) -> str:
        param = self._column.param
        return param.kind if param is not None else ""

    # --- as matrices -------------------------------------------------------------------------

    @property
    def matrix(self) -> Array:
        """Matrices body to world: of rotations (..., 3, 3), of angles (..., 2, 2), of transforms.

        Those of transforms and similarities are homogeneous, (..., 4, 4). Assignable, except for
        angles.
        """
        if self._kind not in RIGID:
            return self.rotation_matrix
        value = np.asarray(self.value)
        found = np.zeros((*value.shape[:-1], 4, 4), value.dtype)
        found[..., :3, :3] = self.rotation_matrix * self._scales(value)[..., None, None]
        found[..., :3, 3] = value[..., :3]
        found[..., 3, 3] = 1
        return found

    @matrix.setter
    def matrix(self, value: Any) -> None:
        if self._kind in RIGID:
            self._shaped(value, (4, 4))
            self.value = value
        else:
            self.rotation_matrix = value

    @property
    def rotation_matrix(self) -> Array:
        """Rotation matrices (..., 3, 3), body to world; of an angle (..., 2, 2). Assignable."""
        value = np.asarray(self.value)
        if self._kind == "euler":
            return rotations.matrix_from_euler(value)
        if self._kind == "angle":
            c, s = np.cos(value), np.sin(value)
            return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
        return rotations.matrix_from_quaternion(self._quaternion())

    @rotation_matrix.setter
    def rotation_matrix(self, value: Any) -> None:
        array = self._rotation(value, (3, 3))
        if self._kind in RIGID:
            old = np.asarray(self.value)
            scaled = array * self._scales(old)[..., None, None]
            self.value = np.concatenate([scaled, old[..., :3, None]], axis=-1)
        else:
            self.value = array

    # --- rotations ---------------------------------------------------------------------------

    @property
    def quaternion(self) -> Array:
        """Unit quaternions (..., 4): w, x, y, z. Assignable."""
        if self._kind == "euler":
            return rotations.quaternion_from_euler(np.asarray(self.value))
        return self._quaternion().copy()

    @quaternion.setter
    def quaternion(self, value: Any) -> None:
        self._turn(self._rotation(value, (4,)))

    @property
    def euler(self) -> Array:
        """Roll, pitch, yaw (..., 3) [rad]: ``R = Rz(yaw) Ry(pitch) Rx(roll)``. Assignable."""
        if self._kind == "euler":
            return np.array(self.value)
        return rotations.euler_from_matrix(rotations.matrix_from_quaternion(self._quaternion()))

    @euler.setter
    def euler(self, value: Any) -> None:
        array = self._rotation(value, (3,))
        if self._kind in RIGID:
            array = rotations.quaternion_from_euler(array.astype(np.float64))
        self._turn(array)

    # --- parts of transforms -----------------------------------------------------------------

    @property
    def translation(self) -> Array:
        """Translations (..., 3) of transforms, a live view of ``value``. Assignable."""
        return np.asarray(self._rigid("translation")[..., :3])

    @translation.setter
    def translation(self, value: Any) -> None:
        self._part(value, slice(0, 3), self._rigid("translation"))

    @property
    def scale(self) -> Any:
        """Scales (...) of similarities, a number for one. Assignable."""
        found = self._rigid("scale")[..., 7]
        return found if found.ndim else found.item()

    @scale.setter
    def scale(self, value: Any) -> None:
        self._part(np.asarray(value)[..., None], slice(7, 8), self._rigid("scale"))

    def _rigid(self, part: str) -> Array:
        kinds = RIGID if part == "translation" else ("similarity",)
        if self._kind not in kinds:
            raise error("E0703", f"the parameter has no {part}", self._name, self._column)
        return np.asarray(self.value)

    def _part(self, value: Any, at: slice, whole: Array) -> None:
        array = np.asarray(value)
        full = np.array(whole)
        if array.dtype.kind not in "fiu" or array.shape not in (
            full[..., at].shape,
            full[..., at].shape[-1:],
        ):
            raise error(
                "E0704",
                f"expected numbers of shape {full[..., at].shape}, found shape {array.shape}",
                self._name,
                self._column,
            )
        full[..., at] = array
        self.value = full

    def _scales(self, value: Array) -> Array:
        return (
            np.asarray(value[..., 7]) if self._kind == "similarity" else np.ones(value.shape[:-1])
        )

    def _quaternion(self) -> Array:
        value = np.asarray(self.value)
        if self._kind in RIGID:
            return value[..., 3:7]
        if self._kind not in ("rotation", "quaternion"):
            raise self._not_a_rotation()
        return value

    def _rotation(self, value: Any, shape: tuple[int, ...]) -> Array:
        """`value` as an array of rotations in one form, if the parameter is a rotation."""
        if self._kind not in ("rotation", "quaternion", "euler", *RIGID):
            raise self._not_a_rotation()
        return self._shaped(value, shape)

    def _shaped(self, value: Any, shape: tuple[int, ...]) -> Array:
        array = np.asarray(value)
        if array.shape[-len(shape) :] != shape:
            raise error(
                "E0704",
                f"expected values of shape {shape}, found shape {array.shape}",
                self._name,
                self._column,
            )
        return array

    def _turn(self, array: Array) -> None:
        """Assign rotations as quaternions or Euler angles; for a transform, quaternions."""
        if self._kind in RIGID:
            self._part(array, slice(3, 7), np.asarray(self.value))
        else:
            self.value = array

    def _not_a_rotation(self) -> Exception:
        return error("E0703", "the parameter is not a rotation", self._name, self._column)
