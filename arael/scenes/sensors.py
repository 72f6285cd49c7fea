"""GPS, accelerometer tilt and wheel odometry of the synthetic scenes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from arael.scenes.config import SceneConfig
from arael.scenes.evaluate import motions

Array = NDArray[np.float64]

GPS_SIGMA = 2.5
"""Standard deviation of a GPS fix per axis [m]."""
GPS_WANDER = 0.02
"""Error of a fix beyond the common offset, per metre from the start."""
TILT_SIGMA = float(np.deg2rad(0.25))
"""Standard deviation of the measured roll and pitch [rad]."""


@dataclass(frozen=True)
class Sensors:
    """Measurements at each of n poses.

    Attributes
    ----------
    gps : (n, 3) positions in the world frame [m]
    tilt : (n, 2) roll and pitch [rad]
    delta_pos : (n, 3) motion since the previous pose in its frame [m]; zero for the first pose
    delta_ea : (n, 3) rotation since the previous pose as roll, pitch, yaw [rad]
    delta_pos_sigma : (n, 3) standard deviations of `delta_pos` [m]
    delta_ea_sigma : (n, 3) standard deviations of `delta_ea` [rad]
    """

    gps: Array
    tilt: Array
    delta_pos: Array
    delta_ea: Array
    delta_pos_sigma: Array
    delta_ea_sigma: Array


def measure(config: SceneConfig, pos: Array, ea: Array, rotation: Array, rng: Generator) -> Sensors:
    """Sensor readings along a trajectory of `pos`, `ea` (n, 3) and `rotation` (n, 3, 3)."""
    count = len(pos)
    far = np.linalg.norm(pos - pos[0], axis=1)[:, None]
    offset = rng.normal(0.0, GPS_SIGMA, size=3)
    gps = pos + offset + GPS_WANDER * far * rng.standard_normal((count, 3))
    tilt = ea[:, :2] + rng.normal(0.0, TILT_SIGMA, size=(count, 2))

    delta_pos, delta_ea = np.zeros((count, 3)), np.zeros((count, 3))
    delta_pos[1:], delta_ea[1:] = motions(pos, rotation)
    pos_sigma, ea_sigma = _odometry_sigmas(delta_pos, delta_ea)
    if config.odometry_noise:
        delta_pos[1:] += pos_sigma[1:] * rng.standard_normal((count - 1, 3))
        delta_ea[1:] += ea_sigma[1:] * rng.standard_normal((count - 1, 3))
    return Sensors(gps, tilt, delta_pos, delta_ea, pos_sigma, ea_sigma)


def _odometry_sigmas(delta_pos: Array, delta_ea: Array) -> tuple[Array, Array]:
    """Noise increases with the motion; across the path it is half of that along it."""
    moved = np.maximum(np.linalg.norm(delta_pos, axis=1), 0.01)
    turned = np.linalg.norm(delta_ea, axis=1)
    along = 0.10 * moved + 0.03
    pos_sigma = along[:, None] * np.array([1.0, 0.5, 0.5])
    ea_sigma = np.repeat((0.01 * turned + 0.001)[:, None], 3, axis=1)
    return pos_sigma, ea_sigma
