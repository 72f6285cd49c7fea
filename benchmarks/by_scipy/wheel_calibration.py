"""Wheels and a laser scanner with a clock of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import OptimizeResult, least_squares

from benchmarks.by_scipy import example

MODEL = "wheel_calibration/wheel_calibration.arael"


def path_of(drive: Any) -> Any:
    """The odometer's x, y, yaw as cubics with the slopes of parabolas."""
    values = np.column_stack([drive.pos, drive.yaw])
    h = np.diff(drive.t)[:, None]
    d = np.diff(values, axis=0) / h
    inner = (d[:-1] * h[1:] + d[1:] * h[:-1]) / (h[:-1] + h[1:])
    return CubicHermiteSpline(drive.t, values, np.vstack([d[:1], inner, d[-1:]]))


def residuals(x: Any, path: Any, drive: Any, sigmas: Any) -> Any:
    """Residuals of lever, mount, scale and offset."""
    a, b = path(drive.t0 + x[4]), path(drive.t1 + x[4])
    c, s = np.cos(a[:, 2]), np.sin(a[:, 2])
    dx, dy = x[3] * (b[:, :2] - a[:, :2]).T
    turned = b[:, 2] - a[:, 2]
    ct, st = np.cos(turned), np.sin(turned)
    mx = ct * x[0] - st * x[1] + c * dx + s * dy - x[0]
    my = st * x[0] + ct * x[1] - s * dx + c * dy - x[1]
    cm, sm = np.cos(x[2]), np.sin(x[2])
    step = np.column_stack([cm * mx + sm * my, cm * my - sm * mx]) - drive.step
    turn = (turned - drive.turn + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([step / sigmas[0], turn / sigmas[1]]).ravel()


def solve(start: Any, drive: Any, sigmas: Any) -> OptimizeResult:
    """Solution of SciPy from a start."""
    path = path_of(drive)
    return least_squares(residuals, start, args=(path, drive, sigmas), x_scale="jac")


def data(seed: int = 1) -> Any:
    """A drive with 1,165 motions, its start and standard deviations."""
    module = example("wheel_calibration")
    drive = module.simulate(seed=seed)
    model = module.calibration(drive)
    return module, drive, module.start(drive), (float(model.step_sigma), float(model.turn_sigma))


def by_arael(given: Any) -> float:
    """Cost at the solution of arael."""
    module, drive, start, _ = given
    return float(module.calibration(drive, start).solve().end_cost)


def by_scipy(given: Any) -> float:
    """Cost at the solution of SciPy."""
    _, drive, start, sigmas = given
    return float(2 * solve(start, drive, sigmas).cost)


PROGRAM = (path_of, residuals, solve)
