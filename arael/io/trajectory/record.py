"""A trajectory: poses in order, with times if they are known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.store import rotations

Array = NDArray[np.float64]
NANO = 1_000_000_000
LONGEST = 9.2e9
"""Times [s] up to which nanoseconds fit into 64 bits."""
UNIT_TOLERANCE = 1e-2
"""Largest difference of a quaternion's norm from 1: files have as few as three decimals."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses of a body in a world frame.

    Attributes
    ----------
    positions : (N, 3) position of the body in the world [m]
    quaternions : (N, 4) body to world, unit, scalar first (w, x, y, z)
    times : (N,) [s], or None
    stamps : (N,) int64 times in whole nanoseconds [ns], or None where they are not known exactly
    velocities : (N, 3) [m/s] in the world, or None
    gyro_biases : (N, 3) [rad/s], or None
    accel_biases : (N, 3) [m/s^2], or None
    """

    positions: Array
    quaternions: Array
    times: Array | None = None
    stamps: NDArray[np.int64] | None = None
    velocities: Array | None = None
    gyro_biases: Array | None = None
    accel_biases: Array | None = None

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.positions))
        shapes: dict[str, tuple[int, ...]] = {
            "positions": (count, 3),
            "quaternions": (count, 4),
            "times": (count,),
            "velocities": (count, 3),
            "gyro_biases": (count, 3),
            "accel_biases": (count, 3),
        }
        for name, shape in shapes.items():
            given = getattr(self, name)
            if given is not None:
                object.__setattr__(self, name, _checked(given, shape, name))
        norms = np.linalg.norm(self.quaternions, axis=1)
        bad = np.flatnonzero(np.abs(norms - 1) > UNIT_TOLERANCE)
        if len(bad):
            raise _wrong("E0721", f"the norm of quaternion {bad[0]} is {norms[bad[0]]:.4g}, not 1")
        object.__setattr__(self, "quaternions", rotations.normalised(self.quaternions))
        if self.stamps is not None:
            stamps = np.asarray(self.stamps)
            if stamps.dtype.kind not in "iu" or stamps.shape != (count,):
                raise _wrong("E0704", f"expected `stamps` to be {count} integers")
            object.__setattr__(self, "stamps", stamps.astype(np.int64))
            if self.times is None:
                object.__setattr__(self, "times", stamps / NANO)

    def __len__(self) -> int:
        return len(self.positions)

    @classmethod
    def from_matrices(cls, matrices: ArrayLike, times: ArrayLike | None = None) -> Trajectory:
        """Poses from homogeneous matrices.

        Parameters
        ----------
        matrices : (N, 4, 4) or (N, 3, 4), body to world
        times : (N,) [s]

        Raises
        ------
        AraelError
            E0704 wrong shape, E0705 not finite, E0721 not a rotation.
        """
        given = np.asarray(matrices, np.float64)
        if given.ndim != 3 or given.shape[1:] not in ((4, 4), (3, 4)):
            raise _wrong("E0704", f"expected matrices (N, 4, 4), found shape {given.shape}")
        turns = given[:, :3, :3]
        bad = np.flatnonzero(~rotations.is_rotation(turns))
        if len(bad):
            raise _wrong("E0721", f"matrix {bad[0]} is not a rotation")
        quaternions = rotations.quaternion_from_matrix(turns)
        return cls(given[:, :3, 3], quaternions, None if times is None else np.asarray(times))

    @property
    def matrices(self) -> Array:
        """Homogeneous matrices (N, 4, 4), body to world."""
        found = np.zeros((len(self), 4, 4))
        found[:, :3, :3] = rotations.matrix_from_quaternion(self.quaternions)
        found[:, :3, 3] = self.positions
        found[:, 3, 3] = 1
        return found

    def rows(self, chosen: Any) -> Trajectory:
        """The poses of some rows, an index array or a slice."""
        parts: dict[str, Any] = {
            name: None if value is None else value[chosen] for name, value in vars(self).items()
        }
        return Trajectory(**parts)

    def with_times(self, times: ArrayLike) -> Trajectory:
        """The same poses at other times [s]."""
        return replace(self, times=np.asarray(times, np.float64), stamps=None)

    def exact_stamps(self) -> NDArray[np.int64]:
        """Times in whole nanoseconds (N,); row numbers in seconds if there are no times.

        Raises
        ------
        AraelError
            E0706: a time beyond 292 years, which nanoseconds in 64 bits do not hold.
        """
        if self.stamps is not None:
            return self.stamps
        times = np.arange(len(self), dtype=np.float64) if self.times is None else self.times
        if len(times) and np.abs(times).max() >= LONGEST:
            far = float(times[np.argmax(np.abs(times))])
            raise _wrong("E0706", f"the time {far:g} s is too large: are these nanoseconds?")
        seconds = np.floor(times)
        rest = np.rint((times - seconds) * NANO)
        return seconds.astype(np.int64) * NANO + rest.astype(np.int64)


def _checked(given: Any, shape: tuple[int, ...], name: str) -> Array:
    try:
        array = np.array(given, np.float64)
    except (TypeError, ValueError):
        raise _wrong("E0703", f"expected `{name}` to be numbers") from None
    if array.size == 0 and shape[0] == 0:
        array = array.reshape(shape)
    if array.shape != shape:
        raise _wrong("E0704", f"expected `{name}` of shape {shape}, found {array.shape}")
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array.reshape(len(array), -1)).all(axis=1))[0])
        raise _wrong("E0705", f"`{name}[{row}]` is NaN or infinite")
    return array


def _wrong(code: str, message: str) -> AraelError:
    return AraelError(Diagnostic(code, message, origin="trajectory"))
