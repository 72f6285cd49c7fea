"""A pinhole camera on a body."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.geometry.arrays import Array, as_array, as_numbers, as_scalar


def level_axes(yaw: float = 0.0) -> Array:
    """Axes (3, 3) of a camera with a horizontal optical axis at `yaw` [rad], body z up.

    Columns are the camera's x (right), y (down) and z (forward) in the body frame.
    """
    angle = as_scalar(yaw, "yaw")
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class PinholeCamera:
    """A camera without lens distortion, fixed to a body.

    A point (X, Y, Z) of the camera frame projects to ``(fx X / Z + cx, fy Y / Z + cy)``. Pixel
    coordinates run from 0 to `width` and `height`; the middle of the first pixel is (0.5, 0.5).

    Attributes
    ----------
    fx, fy : focal lengths [px]
    cx, cy : principal point [px]
    width, height : of the image [px]
    pos : (3,) position in the body frame [m]
    axes : (3, 3) columns are the camera's x, y (down) and z (forward) in the body frame
    min_depth : closest depth at which anything is visible [m]
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    pos: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=level_axes)
    min_depth: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pos", as_array(self.pos, (3,), "pos"))
        object.__setattr__(self, "axes", as_array(self.axes, (3, 3), "axes"))
        for name in ("cx", "cy", "min_depth"):
            as_scalar(getattr(self, name), name)
        for name in ("fx", "fy", "width", "height"):
            if not as_scalar(getattr(self, name), name) > 0:
                raise _refused(f"`{name}` is {getattr(self, name)!r}", "it must be above 0")
        if not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-6):
            raise _refused(
                "the columns of `axes` are not unit vectors at right angles",
                "`level_axes(yaw)` returns the axes of a horizontal camera",
            )

    @classmethod
    def from_fov(cls, width: int, height: int, fov: float, **rest: Any) -> PinholeCamera:
        """A camera with square pixels and the principal point in the middle of the image.

        Parameters
        ----------
        fov : horizontal field of view [rad]
        **rest : `pos`, `axes`, `min_depth`
        """
        if not 0 < as_scalar(fov, "fov") < np.pi:
            raise _refused(f"`fov` is {fov!r}", "it is an angle between 0 and pi [rad]")
        focal = float(0.5 * width / np.tan(0.5 * fov))
        return cls(focal, focal, 0.5 * width, 0.5 * height, width, height, **rest)

    def project(self, points: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
        """Project points.

        Parameters
        ----------
        points : (..., 3) in the body frame [m]

        Returns
        -------
        pixels : (..., 2) [px]; NaN for points that are not in front of the camera
        visible : (...) in front by `min_depth` or more, and inside the image
        """
        local = (as_array(points, (3,), "points") - self.pos) @ self.axes
        depth = local[..., 2]
        ahead = depth > 0
        ratio = local[..., :2] / np.where(ahead, depth, np.nan)[..., None]
        pixels = ratio * (self.fx, self.fy) + (self.cx, self.cy)
        inside = np.all((pixels >= 0) & (pixels < (self.width, self.height)), axis=-1)
        return pixels, inside & (depth >= self.min_depth)

    def visible(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Visibility of the body-frame `points` (..., 3)."""
        return self.project(points)[1]

    def rays(self, pixels: ArrayLike) -> Array:
        """Unit vectors (..., 3) in the body frame from the camera through `pixels` (..., 2)."""
        return _normalised(self._image_plane(pixels) @ self.axes.T)

    def unproject(self, pixels: ArrayLike, depth: ArrayLike) -> Array:
        """Body-frame points (..., 3) [m] seen at `pixels` (..., 2) at a `depth` (...) [m].

        Depth is along the optical axis, as a depth camera measures it; inverse of `project`.
        """
        local = self._image_plane(pixels) * as_numbers(depth, "depth")[..., None]
        found: Array = local @ self.axes.T + self.pos
        return found

    def feature_frames(self, pixels: ArrayLike) -> Array:
        """Frames (..., 3, 3), feature to body, of detections at `pixels` (..., 2).

        Column 0 is along the ray, column 2 is the camera's up direction orthogonalised to it,
        column 1 completes a right-handed frame. In it, the directions of a bearing residual are
        ``atan2`` of the second and third coordinate against the first.
        """
        ray = self.rays(pixels)
        up = -self.axes[:, 1]
        col2 = _normalised(up - ray * (ray @ up)[..., None])
        return np.stack([ray, np.cross(col2, ray), col2], axis=-1)

    def pixel_angles(self, pixels: ArrayLike) -> Array:
        """Angular size (..., 2) [rad] of pixels, across and up in their feature frame.

        A step of one pixel moves the ray (u, v, 1) by 1 / f in the image plane; the angle is its
        component across the ray, divided by the ray's length. Off the axis a pixel is smaller than
        1 / f. A detector with an error of s pixels measures a bearing with isigma 1 / (s
        pixel_angles).
        """
        u, v, _ = np.moveaxis(self._image_plane(pixels), -1, 0)
        square = 1 + u**2 + v**2
        level = np.sqrt(1 + u**2)  # column 1 of the frame is level, column 2 takes the rest
        across = 1 / (level * np.sqrt(square)) / self.fx
        return np.stack([across, level / square / self.fy], axis=-1)

    def _image_plane(self, pixels: ArrayLike) -> Array:
        """Points (..., 3) at depth 1 of the camera frame."""
        plane = (as_array(pixels, (2,), "pixels") - (self.cx, self.cy)) / (self.fx, self.fy)
        return np.concatenate([plane, np.ones((*plane.shape[:-1], 1))], axis=-1)


def _normalised(vectors: Array) -> Array:
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def _refused(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E1032", message, origin="PinholeCamera", help=(advice,)))
