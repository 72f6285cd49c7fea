"""True trajectories of the synthetic scenes."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

TrajectoryName = Literal["s-curve", "loop", "eight"]
TRAJECTORIES: tuple[TrajectoryName, ...] = get_args(TrajectoryName)

SPACING = 0.25
"""Distance travelled from pose to pose [m] (along x on the S-curve)."""

Array = NDArray[np.float64]


def trajectory(name: TrajectoryName, count: int) -> tuple[Array, Array]:
    """Positions and attitudes of `count` poses in the plane z = 0, heading along the path.

    Parameters
    ----------
    name : ``s-curve``, ``loop`` (a closed circle) or ``eight`` (a closed lemniscate)
    count : number of poses, at least 2

    Returns
    -------
    pos : (count, 3) positions in the world frame [m]
    ea : (count, 3) roll, pitch, yaw [rad]; roll and pitch are zero
    """
    x, y, yaw = _SHAPES[name](count)
    zero = np.zeros(count)
    return np.column_stack([x, y, zero]), np.column_stack([zero, zero, yaw])


def _s_curve(count: int) -> tuple[Array, Array, Array]:
    t: Array = SPACING * np.arange(count, dtype=np.float64)
    return t, 1.5 * np.sin(0.8 * t), np.arctan2(1.2 * np.cos(0.8 * t), 1.0)


def _loop(count: int) -> tuple[Array, Array, Array]:
    angle = 2 * np.pi * np.arange(count) / count
    radius = SPACING * count / (2 * np.pi)
    return radius * np.cos(angle), radius * np.sin(angle), _wrapped(angle + np.pi / 2)


def _eight(count: int) -> tuple[Array, Array, Array]:
    # Arc length has no closed form here: integrate the speed on a fine grid and invert it.
    fine = np.linspace(0.0, 2 * np.pi, 64 * count + 1)
    speed = np.hypot(np.sin(fine), np.cos(2 * fine))
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(fine)
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    t = np.interp(arc[-1] * np.arange(count) / count, arc, fine)
    scale = SPACING * count / arc[-1]
    yaw = np.arctan2(np.cos(2 * t), -np.sin(t))
    return scale * np.cos(t), scale * np.sin(t) * np.cos(t), yaw


def _wrapped(angle: Array) -> Array:
    return np.arctan2(np.sin(angle), np.cos(angle))


_SHAPES = {"s-curve": _s_curve, "loop": _loop, "eight": _eight}
