"""Pairs of poses at a distance, for relative errors."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.trajectory import Trajectory
from arael.runtime.store import rotations

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
DeltaUnit = Literal["frames", "m", "deg", "rad"]
UNITS = ("frames", "m", "deg", "rad")


def pairs_of(
    trajectory: Trajectory,
    delta: float,
    unit: DeltaUnit = "frames",
    *,
    all_pairs: bool = False,
    tolerance: float = 0.1,
) -> Ints:
    """Rows (N, 2) of pairs of poses `delta` apart.

    Consecutive pairs share a pose: each ends at the first pose whose distance from its start,
    accumulated along the trajectory, is at least `delta`. With `all_pairs` each pose begins one
    (for angles: each with every pose at that angle), if a distance is within ``tolerance * delta``.

    Raises
    ------
    AraelError
        E0729 no pair, a delta that is not positive or, for frames, not whole, or an unknown unit.
    """
    if unit not in UNITS:
        raise _wrong(f"there is no unit `{unit}` of distances", f"units are {', '.join(UNITS)}")
    if not 0 < delta < np.inf or (unit == "frames" and delta != int(delta)):
        kind = "a whole number from 1" if unit == "frames" else "a positive number"
        raise _wrong(f"expected the distance of pairs as {kind}, found {delta:g}")
    if (unit == "deg" and delta > 180) or (unit == "rad" and delta > np.pi):
        raise _wrong(f"expected an angle of at most 180 degrees, found {delta:g} {unit}")
    if unit == "frames":
        found = _by_index(len(trajectory), int(delta), all_pairs)
    elif unit == "m":
        found = _by_path(trajectory, delta, delta * tolerance, all_pairs)
    else:
        angle = float(np.deg2rad(delta)) if unit == "deg" else delta
        found = _by_angle(trajectory, angle, angle * tolerance, all_pairs)
    if not len(found):
        raise _wrong(
            f"no pair of poses is {delta:g} {unit} apart",
            "choose a smaller distance (`--delta`), or a larger tolerance",
        )
    return found


def _by_index(count: int, delta: int, all_pairs: bool) -> Ints:
    first = np.arange(0, max(count - delta, 0), 1 if all_pairs else delta)
    return np.column_stack([first, first + delta])


def _by_path(trajectory: Trajectory, delta: float, most: float, all_pairs: bool) -> Ints:
    steps = np.linalg.norm(np.diff(trajectory.positions, axis=0), axis=1)
    if not all_pairs:
        return _consecutive(steps, delta)
    path = np.concatenate(([0.0], np.cumsum(steps)))
    found = []
    for i in range(len(path) - 1):
        off = np.abs(path[i + 1 :] - path[i] - delta)
        nearest = int(np.argmin(off))
        if off[nearest] <= most:
            found.append((i, i + 1 + nearest))
    return np.array(found, np.int64).reshape(-1, 2)


def _by_angle(trajectory: Trajectory, delta: float, most: float, all_pairs: bool) -> Ints:
    turns = rotations.matrix_from_quaternion(trajectory.quaternions)
    if not all_pairs:
        return _consecutive(_angles(turns[:-1], turns[1:]), delta)
    found: list[Ints] = [np.empty((0, 2), np.int64)]
    for i in range(len(turns) - 1):
        angles = _angles(turns[i : i + 1], turns[i + 1 :])
        ends = i + 1 + np.flatnonzero((delta - most <= angles) & (angles <= delta + most))
        found.append(np.column_stack([np.full(len(ends), i), ends]))
    return np.concatenate(found)


def _consecutive(steps: Array, delta: float) -> Ints:
    """Pairs whose steps, added up from the start of the pair, reach `delta`."""
    found, start, total = [], 0, 0.0
    for end, step in enumerate(steps.tolist(), 1):
        total += step
        if total >= delta:
            found.append((start, end))
            start, total = end, 0.0
    return np.array(found, np.int64).reshape(-1, 2)


def _angles(a: Array, b: Array) -> Array:
    """Angles [rad] between rotation matrices."""
    between = rotations.quaternion_from_matrix(a.transpose(0, 2, 1) @ b)
    return np.asarray(np.linalg.norm(rotations.vector_from_quaternion(between), axis=1))


def _wrong(message: str, help: str = "") -> AraelError:
    return AraelError(Diagnostic("E0729", message, origin="pairs", help=(help,) if help else ()))
