"""Two cameras on a rig, one with a fisheye lens."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.sparse import lil_matrix
from scipy.spatial.transform import Rotation

from benchmarks.by_scipy import example

MODEL = "camera_calibration/camera_calibration.arael"
SIGMA = 0.2


def pixels(camera: Any, p: Any, fisheye: bool) -> Any:
    """Pixels (n, 2) of points (n, 3), for fx, fy, cx, cy, k1 to k4 (8,)."""
    f, c, k = camera[:2], camera[2:4], camera[4:]
    if fisheye:
        r = np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2 + 1e-18)
        t = np.arctan2(r, p[:, 2])
        bent = t + k[0] * t**3 + k[1] * t**5 + k[2] * t**7 + k[3] * t**9
        return f * p[:, :2] * (bent / r)[:, None] + c
    x, y = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
    s = x**2 + y**2
    radial = 1 + k[0] * s + k[1] * s**2
    u = x * radial + 2 * k[2] * x * y + k[3] * (s + 2 * x**2)
    v = y * radial + k[2] * (s + 2 * y**2) + 2 * k[3] * x * y
    return f * np.column_stack([u, v]) + c


def residuals(x: Any, seen: Any) -> Any:
    """Residuals of both cameras (16,), the mount (6,), and the pose of the target by view (6 each).

    Poses are rotation vector and translation.
    """
    views = x[22:].reshape(-1, 6)[seen.view]
    in_rig = Rotation.from_rotvec(views[:, :3]).apply(seen.on) + views[:, 3:]
    found = np.empty_like(seen.pixel)
    first = seen.camera == 0
    found[first] = pixels(x[:8], in_rig[first], False)
    in_second = Rotation.from_rotvec(x[16:19]).apply(in_rig[~first]) + x[19:22]
    found[~first] = pixels(x[8:16], in_second, True)
    return ((found - seen.pixel) / SIGMA).ravel()


def sparsity(seen: Any) -> Any:
    """Non-zeros of the Jacobian."""
    rows = np.arange(2 * len(seen.view))
    pattern = lil_matrix((len(rows), 22 + 6 * seen.views), dtype=int)
    camera, view = np.repeat(seen.camera, 2), np.repeat(seen.view, 2)
    for k in range(8):
        pattern[rows, 8 * camera + k] = 1
    for k in range(6):
        pattern[rows[camera == 1], 16 + k] = 1
        pattern[rows, 22 + 6 * view + k] = 1
    return pattern


def start(seen: Any) -> Any:
    """The rough start of the example."""
    cameras = [600, 600, 320, 240, 0, 0, 0, 0, 300, 300, 320, 240, 0, 0, 0, 0]
    t, turn = example("camera_calibration").starts(seen)
    views = np.hstack([Rotation.from_matrix(turn).as_rotvec(), t])
    return np.concatenate([cameras, np.zeros(6), views.ravel()])


def solve(seen: Any) -> OptimizeResult:
    """Solution of SciPy."""
    pattern = sparsity(seen)
    return least_squares(residuals, start(seen), args=(seen,), jac_sparsity=pattern, x_scale="jac")


def data(seed: int = 1) -> Any:
    """Corners in 15 views."""
    return example("camera_calibration").simulate(seed=seed)


def by_arael(seen: Any) -> float:
    """Cost at the solution of arael."""
    return float(example("camera_calibration").problem(seen).solve().end_cost)


def by_scipy(seen: Any) -> float:
    """Cost at the solution of SciPy."""
    return float(2 * solve(seen).cost)


PROGRAM = (pixels, residuals, sparsity, start, solve)
