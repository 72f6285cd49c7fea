"""The camera ring of the synthetic scenes: five cameras that cover all directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.geometry import PinholeCamera

Array = NDArray[np.float64]

WIDTH, HEIGHT = 1024, 768
FIELD_OF_VIEW = float(np.deg2rad(80))
"""Horizontal [rad]."""
MIN_DEPTH = 0.5
"""Smallest depth of a detection [m]."""
COUNT = 5


def camera_ring() -> tuple[PinholeCamera, ...]:
    """Make the cameras: at yaw 0, 72, ... 288 degrees, 0.1 m off the body's axis, 0.3 m up."""
    return tuple(_camera(2 * np.pi * k / COUNT) for k in range(COUNT))


def _camera(yaw: float) -> PinholeCamera:
    c, s = np.cos(yaw), np.sin(yaw)
    # x points to the body's left, so images are mirrored, which affects no residual.
    axes = np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, -1.0, 0.0]])
    pos = np.array([0.1 * c, 0.1 * s, 0.3])
    return PinholeCamera.from_fov(
        WIDTH, HEIGHT, FIELD_OF_VIEW, pos=pos, axes=axes, min_depth=MIN_DEPTH
    )
