"""A line fit with outliers: least squares and robust fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

import arael
from arael.demo.scene_run import SolveOptions
from arael.plot.figure import BLUE, ORANGE, save
from arael.plot.fit import Line, fit_figure

Array = NDArray[np.float64]

TRUE_SLOPE, TRUE_OFFSET = 0.7, 1.0
SIGMA = 0.01
"""Noise of the right points."""
REACH = 1.0
"""Wrong points are up to this far above the line."""


@dataclass(frozen=True)
class LinearRun:
    """Points and the two lines through them, each as slope and offset."""

    x: Array
    y: Array
    wrong: NDArray[np.bool_]
    least_squares: tuple[float, float]
    robust: tuple[float, float]
    seed: int
    result: Any


def make_points(
    count: int, wrong_share: float, seed: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Points of the true line with noise, a share of them far off to one side."""
    rng = Generator(PCG64(seed))
    x = np.sort(rng.uniform(0, 1, size=count))
    y = TRUE_SLOPE * x + TRUE_OFFSET + rng.normal(0, SIGMA, size=count)
    wrong = np.zeros(count, dtype=bool)
    wrong[rng.choice(count, size=round(wrong_share * count), replace=False)] = True
    y[wrong] += rng.uniform(0.1, REACH, size=int(wrong.sum()))
    return x, y, wrong


def run_linear(
    count: int = 100,
    wrong_share: float = 0.3,
    seed: int = 42,
    options: SolveOptions | None = None,
) -> LinearRun:
    """Fit the points in closed form, then robustly from there."""
    options = options or SolveOptions()
    x, y, wrong = make_points(count, wrong_share, seed)
    slope, offset = np.polyfit(x, y, 1)
    model: Any = arael.load(options.model or "linear", precision=options.precision)
    line = model(a=float(slope), b=float(offset))
    line.data.extend(x=x, y=y)
    # Graduated: with a large sigma all points have influence; then outliers lose it.
    for sigma in (10 * SIGMA, 3 * SIGMA, SIGMA):
        line.sigma = sigma
        settings = arael.LmConfig(verbose=options.verbose, num_threads=options.threads)
        result = line.solve(config=settings, solver=options.solver)
    robust = (float(line.a.value), float(line.b.value))
    return LinearRun(x, y, wrong, (float(slope), float(offset)), robust, seed, result)


def report(run: LinearRun) -> Iterator[str]:
    """Lines of text: the points and the two lines."""
    yield f"{len(run.x)} points, {run.wrong.sum()} of them wrong, seed {run.seed}"
    yield f"  true line       {TRUE_SLOPE:.4f} x {TRUE_OFFSET:+.4f}"
    for name, line in (("least squares", run.least_squares), ("robust fit", run.robust)):
        rms = _rms(run, line)
        yield f"  {name:<15} {line[0]:.4f} x {line[1]:+.4f}, RMS error at right points {rms:.5f}"


def _rms(run: LinearRun, line: tuple[float, float]) -> float:
    """RMS distance of a line from the true one at the right points."""
    x = run.x[~run.wrong]
    off = (line[0] - TRUE_SLOPE) * x + line[1] - TRUE_OFFSET
    return float(np.sqrt(np.mean(off**2)))


def summary(run: LinearRun) -> dict[str, Any]:
    """Figures of a run, as plain data."""
    return {
        "observations": len(run.x),
        "wrong_observations": int(run.wrong.sum()),
        "true": [TRUE_SLOPE, TRUE_OFFSET],
        "least_squares": list(run.least_squares),
        "robust": list(run.robust),
        "least_squares_rms": _rms(run, run.least_squares),
        "robust_rms": _rms(run, run.robust),
    }


def plot(run: LinearRun, path: Path) -> list[str]:
    """Draw points and lines into `path`."""
    lines = [
        Line("least squares", *run.least_squares, ORANGE),
        Line("robust fit", *run.robust, BLUE),
    ]
    return [save(fit_figure(run.x, run.y, run.wrong, lines), path)]
