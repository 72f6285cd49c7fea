"""Clocks that differ: what offsets are solved to, whether they are consistent, time beside SciPy.

Problems are those of the examples, simulated with the noise that their models state. The normalised
squared error of an estimate, NEES, is that of all its parameters in their joint covariance; its
mean over runs has a chi-squared distribution if covariances are right.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import chi2

from benchmarks.by_scipy import example, wheel_calibration
from benchmarks.measure import table
from benchmarks.recipes import least
from benchmarks.systems import Plan

RUNS, QUICK_RUNS = 200, 4
CONFIDENCE = 0.99


class Consistency(NamedTuple):
    """Errors of one problem over many runs.

    Attributes
    ----------
    nees : mean normalised squared error
    low, high : its bounds at the confidence of `CONFIDENCE`
    offset, sigma : RMS error of the offset, its mean standard deviation [s]
    """

    nees: float
    low: float
    high: float
    offset: float
    sigma: float

    @property
    def consistent(self) -> bool:
        """Whether the mean is within its bounds."""
        return self.low <= self.nees <= self.high


def wheels(seed: int) -> tuple[Any, Any]:
    """Errors (5,) of the wheel calibration and their covariance; the offset is the last."""
    module = example("wheel_calibration")
    drive = module.simulate(seed=seed)
    model = module.calibration(drive)
    model.solve()
    return module.solution(model) - drive.truth, module.covariance(model)


def hand_eye(seed: int) -> tuple[Any, Any]:
    """Errors (13,) of X, Y and the offset of a hand in motion, and their covariance."""
    module = example("hand_eye")
    poses = module.sweep(seed=seed)
    model = module.moving(poses)
    model.solve(rel_precision=1e-9)
    # Errors of transforms are from the estimate to the truth; so is that of the offset.
    off = [module.error(getattr(model, n).matrix, t) for n, t in (("X", poses.x), ("Y", poses.y))]
    late = poses.offset - float(model.offset.value)
    return np.array([*off[0], *off[1], late]), model.covariance().marginal(["X", "Y", "offset"])


def ranges(seed: int) -> tuple[Any, Any]:
    """Errors (11,) of ranges by a clock of their own, and their covariance; the offset is last."""
    module = example("range_clocks")
    drive = module.simulate(seed=seed)
    model = module.problem(drive)
    model.solve()
    off = module.solution(model) - drive.truth
    return np.roll(off, -1), np.roll(module.covariance(model), (-1, -1), axis=(0, 1))


def camera_imu(seed: int) -> tuple[Any, Any]:
    """Errors (17,) of a camera and an IMU, and their covariance; the offset is last."""
    module = example("camera_imu")
    recording = module.simulate(seed=seed)
    model = module.problem(recording)
    model.solve()
    return module.errors(model, recording), module.covariance(model)


def consistency(one: Callable[[int], tuple[Any, Any]], runs: int) -> Consistency:
    """Errors over seeds."""
    found = [one(seed) for seed in range(1, runs + 1)]
    nees = [float(off @ np.linalg.solve(covariance, off)) for off, covariance in found]
    freedom = runs * len(found[0][0])
    tail = (1 - CONFIDENCE) / 2
    return Consistency(
        float(np.mean(nees)),
        float(chi2.ppf(tail, freedom)) / runs,
        float(chi2.ppf(1 - tail, freedom)) / runs,
        float(np.sqrt(np.mean([off[-1] ** 2 for off, _ in found]))),
        float(np.mean([np.sqrt(covariance[-1, -1]) for _, covariance in found])),
    )


def times(runs: int) -> tuple[float, float, float]:
    """Milliseconds of the wheel calibration: a first solve with its data, one again, SciPy."""
    given = wheel_calibration.data()
    module, drive, start, _ = given
    first = least(lambda: wheel_calibration.by_arael(given), runs)
    beside = least(lambda: wheel_calibration.by_scipy(given), runs)
    model = module.calibration(drive, start)

    def again() -> None:
        model.lever.value = start[:2]
        model.mount.value, model.scale.value, model.offset.value = start[2:]
        model.solve()

    again()
    return 1e3 * first, 1e3 * least(again, runs), 1e3 * beside


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Lines of the chapter."""
    runs = QUICK_RUNS if plan.quick else RUNS
    rows = []
    for name, one in (
        ("wheels and a scanner", wheels), ("hand-eye in motion", hand_eye),
        ("ranges and positions", ranges), ("camera and IMU", camera_imu),
    ):  # fmt: skip
        c = consistency(one, runs)
        bounds = f"{c.low:.2f} to {c.high:.2f}"
        rows.append([name, f"{1e6 * c.offset:.0f}", f"{1e6 * c.sigma:.0f}", f"{c.nees:.2f}", bounds,
                     "yes" if c.consistent else "no"])  # fmt: skip
    first, again, beside = times(3 if plan.quick else 15)
    head = ["problem", "RMS of the offset [us]", "sigma [us]", "mean NEES", "99 % bounds", "within"]
    return [
        "### Clocks that differ",
        "",
        f"{runs} simulated runs each, with the noise that the models state.",
        "",
        *table(head, rows),
        "",
        "Wheel calibration, 1165 motions against 12 049 rows, milliseconds of processor time from "
        f"the same start: first solve with its data {first:.1f}, again {again:.2f}, SciPy "
        f"{beside:.1f}.",
    ]
