"""Cost of an iteration and memory against the size of a scene, over three decades."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import arael
from arael.scenes import benchmark_config, make_scene
from benchmarks import pictures, problems
from benchmarks.cases import Case
from benchmarks.measure import table
from benchmarks.systems import Outcome, Plan, run_system

SHAPES = {"chain": "s-curve", "loop": "loop", "eight": "eight"}
SIZES = (10, 30, 100, 300, 1000, 3000, 10_000)
QUICK_SIZES = (10, 30, 100)
LARGEST = (10_000, 50_000)
"""Poses and landmarks drawn of one denser chain, whose observations are 2 million."""
LEAST = 100
"""Poses from which on the exponent is fitted; below, fixed costs show."""


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure all shapes and sizes; return the report's lines."""
    arael.load("slam", precision="f64")  # compiled before the memory of a process is measured
    rows: list[tuple[object, ...]] = []
    curves: dict[str, Sequence[tuple[float, float]]] = {}
    exponents = []
    for shape, trajectory in SHAPES.items():
        points: list[tuple[int, int, Outcome]] = []
        for poses in QUICK_SIZES if plan.quick else SIZES:
            seen, outcome = _measure(plan, trajectory, poses)
            points.append((poses, seen, outcome))
            rows.append(_row(shape, poses, seen, outcome, points[0][2]))
        if shape == "chain" and not plan.quick:
            seen, outcome = _measure(plan, trajectory, *LARGEST)
            denser = f"chain, {LARGEST[1]} landmarks"
            rows.append(_row(denser, LARGEST[0], seen, outcome, points[0][2]))
        good = [(seen, 1e3 * o.median) for _, seen, o in points if o.slopes and o.median > 0]
        curves[shape] = good
        large = [(s, o.median) for p, s, o in points if p >= LEAST and o.slopes and o.median > 0]
        exponents.append(f"{shape} {exponent(large):.2f}" if len(large) > 1 else f"{shape} -")
    drawn = picture is not None and pictures.lines(
        picture, "scale", "observations", "ms per iteration", curves
    )
    return [
        "## scale",
        "",
        "SLAM scenes of four landmarks a pose (and one of five), one thread, f64. Memory of the "
        "process is that at its peak, interpreter and data file included. Bytes per observation: "
        "`peak` is what it has over the peak of the smallest scene of the shape; `data` are the "
        "columns of the model, `factor` the nonzeros of the factor; the ratio is that of `peak` to "
        "the two together.",
        "",
        "Exponent of the time of an iteration in the number of observations, "
        f"from {LEAST} poses on: {', '.join(exponents)}.",
        "",
        *table(
            ("shape", "poses", "observations", "ms per iteration", "us per observation",
             "peak MB", "peak [B]", "data [B]", "factor [B]", "peak / (data + factor)", "solver"),
            rows,
        ),
        *(["", f"![scale]({picture.name})"] if drawn and picture else []),
    ]  # fmt: skip


def _row(shape: str, poses: int, seen: int, outcome: Outcome, first: Outcome) -> tuple[object, ...]:
    """A line of the table, beside the `first`, smallest, scene of the shape."""
    return (
        shape,
        poses,
        seen,
        f"{1e3 * outcome.median:.2f}" if outcome.slopes else outcome.reason,
        f"{1e6 * outcome.median / seen:.2f}" if outcome.slopes else "-",
        f"{outcome.memory:.0f}" if outcome.slopes else "-",
        *bytes_per_observation(outcome, first, seen),
        outcome.settings.removeprefix("solver "),
    )


def exponent(points: Sequence[tuple[float, float]]) -> float:
    """Slope of a line through (size, time) on logarithmic axes, by least squares."""
    if len(points) < 2:
        return math.nan
    size, time = np.log(np.array(points, dtype=float)).T
    return float(np.polyfit(size, time, 1)[0])


def _measure(
    plan: Plan, trajectory: str, poses: int, landmarks: int | None = None
) -> tuple[int, Outcome]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        config = benchmark_config(poses, landmarks, trajectory)  # type: ignore[arg-type]
        scene = make_scene(config)
        seen = len(scene.observations)
        path = folder / "scene.npz"
        problems.write_scene(scene, path)
        del scene
        case = Case("slam", f"{trajectory}, {poses} poses", path, 1, 4, limit=4)
        return seen, run_system("arael", case, None, plan, 1, folder)


def bytes_per_observation(outcome: Outcome, first: Outcome, seen: int) -> tuple[str, str, str, str]:
    """Bytes per observation: of the process over the `first`, of the data, of the factor; ratio."""
    if not outcome.slopes:
        return "-", "-", "-", "-"
    data, factor = (outcome.facts.get(name, math.nan) / seen for name in ("data", "factor"))
    parts = f"{data:.0f}", f"{factor:.0f}"
    if outcome is first or not first.slopes:
        return "-", *parts, "-"
    peak = (outcome.memory - first.memory) * 2**20 / seen
    return f"{peak:.0f}", *parts, f"{peak / (data + factor):.1f}"
