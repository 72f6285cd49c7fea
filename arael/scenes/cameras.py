"""The camera ring of the synthetic scenes: five cameras that together see all around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WIDTH, HEIGHT = 1024, 768
FOCAL = 512 / np.tan(np.deg2rad(40))
"""Focal length [px] of a horizontal field of view of 80 degrees."""
CENTRE = (512.0, 384.0)
MIN_DEPTH = 0.5
"""Closest depth at which a camera detects anything [m]."""
COUNT = 5


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in the body.

    Attributes
    ----------
    pos : (3,) position in the body frame [m]
    axes : (3, 3) columns are the camera's x, y (down) and z (forward) in the body frame; x points
        to the body's left, so images are mirrored, which no residual notices
    """

    pos: Array
    axes: Array

    def project(self, points: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Pixels (n, 2) of body-frame `points` (n, 3), and which are inside the image."""
        local = (points - self.pos) @ self.axes
        depth = local[:, 2]
        ahead = depth >= MIN_DEPTH
        ratio = local[:, :2] / np.where(ahead, depth, 1.0)[:, None]
        pixel = FOCAL * ratio + CENTRE
        inside = np.all((pixel >= 0) & (pixel < (WIDTH, HEIGHT)), axis=1)
        return pixel, ahead & inside

    def feature_frames(self, pixel: Array) -> Array:
        """Frames (n, 3, 3), feature to body, of detections at `pixel` (n, 2).

        Column 0 looks along the ray, column 2 is the camera's up made orthogonal to it, column 1
        completes a right-handed frame.
        """
        image = np.column_stack([(pixel - CENTRE) / FOCAL, np.ones(len(pixel))])
        ray = _normalised(image @ self.axes.T)
        up = -self.axes[:, 1]
        col2 = _normalised(up - ray * (ray @ up)[:, None])
        return np.stack([ray, np.cross(col2, ray), col2], axis=2)


def pixel_angles(pixel: Array) -> Array:
    """Angular size (n, 2) [rad] of the pixels at `pixel` (n, 2), across and up in their frame.

    A step of one pixel moves the ray ``(u, v, 1)`` by ``1 / f`` in the image plane; seen from the
    camera, the part of it across the ray counts, over the ray's length. Off the axis a pixel is
    smaller than ``1 / f``.
    """
    u, v = ((pixel - CENTRE) / FOCAL).T
    length = np.sqrt(1 + u**2 + v**2)
    level = np.sqrt(1 + u**2)  # column 1 is horizontal, column 2 the rest
    sizes: Array = np.column_stack([1 / (level * length), level / length**2]) / FOCAL
    return sizes


def camera_ring() -> tuple[Camera, ...]:
    """Make the cameras: at yaw 0, 72, ... 288 degrees, 0.1 m off the body's axis, 0.3 m up."""
    return tuple(_camera(2 * np.pi * k / COUNT) for k in range(COUNT))


def _camera(yaw: float) -> Camera:
    c, s = np.cos(yaw), np.sin(yaw)
    axes = np.array([[-s, 0.0, c], [c, 0.0, s], [0.0, -1.0, 0.0]])
    return Camera(pos=np.array([0.1 * c, 0.1 * s, 0.3]), axes=axes)


def _normalised(vectors: Array) -> Array:
    unit: Array = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit
