"""Derivatives against differences: whether the Jacobian says how the residuals change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.runtime.interpreter import refresh
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

STEP = 1e-6
"""Length of the step to either side, in the units of the parameters."""
TOLERANCE = 1e-5
"""Largest relative difference that rounding and curvature explain."""


@dataclass(frozen=True)
class GradientCheck:
    """How well the derivatives of one constraint agree with central differences.

    Attributes
    ----------
    label : of the constraint
    instances : how many were looked at
    difference : the largest relative difference
    worst : name of the instance that has it, and the row it acts on
    residual : number of its residual
    derivative, measured : what the Jacobian says and what the residual does there
    """

    label: str
    instances: int
    difference: float
    worst: str
    residual: int
    derivative: float
    measured: float

    @property
    def agrees(self) -> bool:
        """Whether the difference is within `TOLERANCE`."""
        return self.difference <= TOLERANCE


def check_gradients(problem: Problem, directions: int = 3, seed: int = 0) -> list[GradientCheck]:
    """Compare J d with central differences of the residuals along random directions d.

    Parameters
    ----------
    problem : in f64; differences in f32 say nothing
    directions : how many; each moves every parameter that is free

    Returns
    -------
    The worst found for each constraint that has instances, in the order of the model.
    """
    rng = np.random.default_rng(seed)
    found: dict[int, GradientCheck] = {}
    for _ in range(directions):
        steps = [
            rng.standard_normal(b.free.shape) * b.free for b in problem.structure.system.blocks
        ]
        ahead, behind = _moved(problem, steps, STEP), _moved(problem, steps, -STEP)
        for number, active in enumerate(problem.structure.active):
            if len(active):
                one = _compare(problem, number, steps, ahead, behind)
                if number not in found or not one.difference <= found[number].difference:
                    found[number] = one
    return [found[number] for number in sorted(found)]


def _moved(problem: Problem, steps: list[Floats], length: float) -> list[Floats]:
    states = []
    for entity, state, step in zip(problem.layout.entities, problem.states, steps, strict=True):
        moved = np.array(state)
        if len(step):
            refresh(entity, state[: len(step)], length * step, moved[: len(step)])
        states.append(moved)
    return states


def _compare(
    problem: Problem,
    number: int,
    steps: list[Floats],
    ahead: list[Floats],
    behind: list[Floats],
) -> GradientCheck:
    group = problem.layout.groups[number]
    interpreter = problem.evaluation.interpreters[number]
    interpreter.guard(problem.states)  # instances that act are those of the state in between
    measured = (interpreter.residuals(ahead) - interpreter.residuals(behind)) / (2 * STEP)
    residuals, entries = problem.evaluation.group_rows(number)
    rows = problem.structure.placements[number].rows
    derivative = np.zeros_like(measured)
    for k, (residual, use, tangent) in enumerate(group.jacobian):
        direction = steps[group.uses[use].entity][rows[:, use], tangent]
        derivative[:, residual] += entries[:, k] * direction
    # Rounding of a residual shows in its difference as eps |r| / step: far below the tolerance.
    size = np.maximum(1.0, np.maximum(np.abs(derivative), np.abs(residuals)))
    difference = np.abs(derivative - measured) / size
    difference[~np.isfinite(difference)] = np.inf
    instance, column = np.unravel_index(int(np.argmax(difference)), difference.shape)
    name = problem.instance_name(number, int(instance))
    return GradientCheck(
        label=group.label,
        instances=len(rows),
        difference=float(difference[instance, column]),
        worst=f"{name} at {problem.instance_place(number, int(instance))}",
        residual=int(column),
        derivative=float(derivative[instance, column]),
        measured=float(measured[instance, column]),
    )
