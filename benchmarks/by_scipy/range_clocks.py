"""Ranges by a clock of their own, and the path as a spline."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import OptimizeResult, least_squares
from scipy.sparse import csr_array

from benchmarks.by_scipy import example

MODEL = "range_clocks/range_clocks.arael"


def spline(x: Any, knots: Any) -> BSpline:
    """The path of control points at the end of x, each of which acts around its time."""
    step = knots[1] - knots[0]
    times = knots[0] + step * (np.arange(len(knots) + 4) - 2)
    return BSpline(times, x[-2 * len(knots) :].reshape(-1, 2), 3)


def residuals(x: Any, drive: Any, knots: Any, sigmas: Any) -> Any:
    """Residuals of offset, skew, delay, beacons and control points."""
    path = spline(x, knots)
    beacons = x[3 : -2 * len(knots)].reshape(-1, 2)
    t = drive.times + x[0] + x[1] * (drive.times - drive.middle)
    seen = np.linalg.norm(beacons[drive.beacon] - path(t), axis=1) + x[2]
    fixes = (path(drive.t) - drive.pos) / sigmas[0]
    return np.concatenate([fixes.ravel(), (seen - drive.ranges) / sigmas[1]])


def pattern(start: Any, drive: Any, knots: Any) -> Any:
    """Entries of the Jacobian; ranges have a control point more either way, as the offset moves."""
    n, m, ends = len(drive.t), len(drive.times), len(start) - 2 * len(knots)
    found = np.zeros((2 * n + m, len(start)), dtype=np.int8)
    for t, rows, near in (
        (drive.t, np.arange(2 * n).reshape(n, 2), range(4)),
        (drive.times + start[0], 2 * n + np.arange(m)[:, None], range(-1, 5)),
    ):
        first = ((t - knots[1]) // (knots[1] - knots[0])).astype(int)[:, None]
        for j in near:
            column = ends + 2 * np.clip(first + j, 0, len(knots) - 1)
            found[rows, column] = found[rows, column + 1] = 1
    found[2 * n :, :3] = 1
    for axis in range(2):
        found[2 * n + np.arange(m), 3 + 2 * drive.beacon + axis] = 1
    return csr_array(found)


def solve(start: Any, drive: Any, knots: Any, sigmas: Any) -> OptimizeResult:
    """Solution of SciPy from a start."""
    return least_squares(
        residuals,
        start,
        args=(drive, knots, sigmas),
        x_scale="jac",
        jac_sparsity=pattern(start, drive, knots),
        tr_options={"atol": 1e-10, "btol": 1e-10},
    )


def data(seed: int = 1) -> Any:
    """A drive with 1,165 ranges, times of control points, the start and standard deviations."""
    module = example("range_clocks")
    drive = module.simulate(seed=seed)
    knots = module.knot_times(drive)
    first = module.start(drive)
    pos = np.stack([np.interp(knots, drive.t, column) for column in drive.pos.T], axis=1)
    start = np.concatenate([first, pos.ravel()])
    return module, drive, start, knots, (module.FIX_SIGMA, module.RANGE_SIGMA)


def by_arael(given: Any) -> float:
    """Cost at the solution of arael."""
    module, drive, start, knots, _ = given
    return float(module.problem(drive, start[: -2 * len(knots)]).solve().end_cost)


def by_scipy(given: Any) -> float:
    """Cost at the solution of SciPy."""
    _, drive, start, knots, sigmas = given
    return float(2 * solve(start, drive, knots, sigmas).cost)


PROGRAM = (spline, residuals, pattern, solve)
