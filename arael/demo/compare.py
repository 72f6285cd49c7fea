"""One problem with several linear solvers: times and agreement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.scenes import Scene, columns, fill

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SolverRun:
    """A scene solved with one linear solver.

    Attributes
    ----------
    solver : its name
    poses : of the scene
    parameters : scalars solved for
    x : the solution
    cost : at the solution
    iterations : attempted steps
    linearise, linear : seconds per attempt for residuals with derivatives and J'J, and for the
        linear system
    first : seconds before the first step: setup and symbolic analysis
    """

    solver: str
    poses: int
    parameters: int
    x: Array
    cost: float
    iterations: int
    linearise: float
    linear: float
    first: float

    @property
    def seconds(self) -> float:
        """Per attempt."""
        return self.linearise + self.linear


def solve_with(name: str, model: str, scene: Scene, solver: str, repeats: int = 3) -> SolverRun:
    """Solve a scene from its start with one linear solver, by the passes of the model.

    Parameters
    ----------
    name : of the data, ``"slam"`` or ``"localization"``
    model : name or file of the model
    repeats : number of runs; the fastest counts, since disturbances only make a run slower
    """
    loaded: Any = arael.load(model, precision="f64")
    runs = []
    for _ in range(repeats):
        instance = loaded()
        fill(instance, loaded.layout, columns(scene, name))  # type: ignore[arg-type]
        runs.append(instance.solve(solver=solver))
    best = min(runs, key=lambda one: one.timing["total"])
    timing = best.timing
    each = max(best.iterations, 1)
    return SolverRun(
        solver,
        len(scene.pos),
        len(best.x),
        np.array(best.x),
        best.end_cost,
        best.iterations,
        (timing["linearise"] + timing["cost"]) / each,
        (timing["first_factor"] + timing["factor"] + timing["solve"]) / each,
        timing["prepare"] + timing["analyse"],
    )


def disagreement(runs: Sequence[SolverRun]) -> float:
    """Largest difference of a parameter between runs of one scene."""
    return max(float(np.abs(one.x - runs[0].x).max()) for one in runs)


def table(runs: Sequence[SolverRun], base: str) -> Iterator[str]:
    """Lines of a table: milliseconds per attempt, and the speed-up relative to `base`."""
    yield (
        f"{'poses':>6} {'unknowns':>8}  {'solver':<12} {'first':>8} {'linearise':>9} "
        f"{'linear':>8} {'attempt':>8}   speed-up      cost"
    )
    slow = {one.poses: one.seconds for one in runs if one.solver == base}
    for one in runs:
        ms = [f"{1e3 * t:.3f}" for t in (one.first, one.linearise, one.linear, one.seconds)]
        ratio = f"{slow[one.poses] / one.seconds:8.1f} x" if one.poses in slow else ""
        yield (
            f"{one.poses:>6} {one.parameters:>8}  {one.solver:<12} {ms[0]:>8} {ms[1]:>9} "
            f"{ms[2]:>8} {ms[3]:>8} {ratio:>10}  {one.cost:.6g}"
        )
    yield "times in ms, first: before the first step; the fastest of several runs"
