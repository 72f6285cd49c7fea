"""Components of columns of data: how they are varied, and what they cover at present."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.geometry.quaternions import quat_conjugate, quat_exp, quat_log, quat_product
from arael.runtime.layout import Column

Floats = NDArray[np.float64]

TURN = 0.7
"""Largest turn of a rotation [rad]: far enough from the identity for all axes, less than a quarter
turn, so that what is seen stays in front."""
_WIDER = 2.0
"""Range of varied numbers relative to the present one."""
_LONGER = 3.0
"""Time span relative to the present one."""
_NARROW = 0.1
"""Range relative to the size of the numbers below which they count as constant."""
_SHIFT = 0.5
"""Change of numbers that are constant, relative to their size."""
_TIMES = ("t", "time", "times", "stamp", "timestamp", "dt", "duration")

Kind = Literal["turn", "spread"]


@dataclass(frozen=True)
class VariedComponent:
    """One component of a column of data.

    Attributes
    ----------
    column : the column
    index : number of the component; those of a quaternion are the three of a rotation vector
    """

    column: Column
    index: int

    @property
    def _rotation(self) -> int | None:
        return _place_of_rotation(self.column)

    @property
    def _axis(self) -> int | None:
        """Axis of the rotation vector; None if it is a number."""
        start = self._rotation
        return None if start is None or self.index < start else self.index - start

    @property
    def kind(self) -> Kind:
        """Whether it is varied by turns."""
        angle = self.column.unit == "rad" or self.column.type.startswith("angle")
        turned = self._axis is not None or (angle and self._rotation is None)
        return "turn" if turned else "spread"

    @property
    def part(self) -> str:
        """Its name within the column: ``x``, ``[3]``."""
        if self._axis is not None:
            return "xyz"[self._axis]
        if not self.column.shape:
            return ""
        return "xyz"[self.index] if self.index < 3 >= self._numbers else f"[{self.index}]"

    @property
    def _numbers(self) -> int:
        """Number of components that are not of a rotation."""
        return math.prod(self.column.shape) if self._rotation is None else self._rotation

    @property
    def is_time(self) -> bool:
        """Whether the column is a time."""
        return self.column.path.rpartition(".")[2].lower() in _TIMES or self.column.unit == "s"

    def varied(self, values: Floats, share: float) -> Floats:
        """Values of the column, this component of which is varied.

        Parameters
        ----------
        share : part of the usual change; of turns at most the whole
        """
        if self.kind == "turn":
            return self.moved(values, TURN * min(share, 1.0) * pattern(len(values)))
        found = np.array(values, dtype=np.float64)
        flat = found.reshape(len(found), -1)[:, : self._numbers]
        flat[:, self.index] = _spread(flat, self.index, share, self.is_time)
        return found

    def moved(self, values: Floats, step: Floats) -> Floats:
        """Values of the column, this component of which is moved by `step` (rows,)."""
        found = np.array(values, dtype=np.float64)
        start = self._rotation
        if self._axis is None or start is None:
            found.reshape(len(found), -1)[:, self.index] += step
            return found
        axis = np.zeros((len(found), 3))
        axis[:, self._axis] = step
        found[:, start : start + 4] = quat_product(quat_exp(axis), found[:, start : start + 4])
        return found

    def scale(self, values: Floats) -> float:
        """Natural size of a change of a number."""
        return scale_of(values.reshape(len(values), -1)[:, : self._numbers])

    def coverage(self, values: Floats) -> str:
        """What the rows cover at present, in words."""
        start = self._rotation
        if self._axis is not None and start is not None:
            return _turns(values[:, start : start + 4])
        unit = f" {self.column.unit}" if self.column.unit else ""
        part = values.reshape(len(values), -1)[:, self.index]
        low, high = float(part.min()), float(part.max())
        if high - low <= 1e-9 * max(abs(low), abs(high), 1e-300):
            return f"{low + 0.0:.4g}{unit} in all rows"
        return f"{low:.4g} to {high:.4g}{unit}"


def components_of(column: Column) -> list[VariedComponent]:
    """All components of a column that can be varied."""
    start = _place_of_rotation(column)
    count = math.prod(column.shape) if start is None else start + 3
    return [VariedComponent(column, k) for k in range(count)]


def _place_of_rotation(column: Column) -> int | None:
    """Place of the quaternion in a column; None if it has none."""
    name = column.type.split()[0]
    return {"quat": 0, "quaternion": 0, "transform": 3, "similarity": 3}.get(name)


def pattern(count: int) -> Floats:
    """Numbers from -1 to 1 that fill the interval evenly, without a period (golden ratio)."""
    found: Floats = 2 * np.modf(0.5 + 0.6180339887498949 * np.arange(count))[0] - 1
    return found


def scale_of(values: Floats) -> float:
    """Natural size of a change: the widest half range of components, or their size, or 1."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 1.0
    wide = float((np.nanmax(values, axis=0) - np.nanmin(values, axis=0)).max()) / 2
    size = float(np.abs(finite).max())
    if wide > _NARROW * size / 2:
        return wide
    return _SHIFT * size or 1.0


def _spread(flat: Floats, index: int, share: float, time: bool) -> Floats:
    """One component (n,) of values (n, k) over a wider range."""
    values = flat[:, index]
    low, high = float(values.min()), float(values.max())
    wider = 1 + share * ((_LONGER if time else _WIDER) - 1)
    if time and high > low:
        return np.asarray(low + wider * (values - low))
    scale = scale_of(flat)
    if high - low > _NARROW * max(abs(low), abs(high), scale if flat.shape[1] > 1 else 0.0):
        middle = low if low >= 0 else high if high <= 0 else (low + high) / 2
        return np.asarray(middle + wider * (values - middle))
    return np.asarray(values + share * scale * pattern(len(values)))


def _turns(quaternions: Floats) -> str:
    """The axes about which rotations differ."""
    first = quaternions[:1]
    apart = quat_log(quat_product(quat_conjugate(np.broadcast_to(first, quaternions.shape)),
                                  quaternions))  # fmt: skip
    whole = quat_log(quaternions)
    vectors = apart if np.linalg.norm(apart) < np.linalg.norm(whole) else whole
    values, axes = np.linalg.eigh(vectors.T @ vectors / len(vectors))
    angles = np.sqrt(np.maximum(values, 0.0))
    if angles[2] < 1e-3:
        return "no turn"
    wide = [k for k in (2, 1, 0) if angles[k] > 0.05 * angles[2]]
    if len(wide) == 1:
        return f"turns about one axis, {_axis(axes[:, 2])}"
    if len(wide) == 2:
        return f"no turn about {_axis(axes[:, 0])}"
    return f"turns of {np.degrees(angles[0]):.2g} to {np.degrees(angles[2]):.2g} deg"


def _axis(axis: Floats) -> str:
    at = int(np.argmax(np.abs(axis)))
    if abs(axis[at]) > 0.99:
        return "xyz"[at]
    axis = axis * np.sign(axis[at])
    return "(" + ", ".join(f"{value:.2f}" for value in axis) + ")"
