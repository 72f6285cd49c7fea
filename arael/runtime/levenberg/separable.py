"""Inner iterations of a problem: what of it the linear solver eliminates, and what reads that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arael.runtime.assembly.components import Labels, blocks_of
from arael.runtime.levenberg.compiled import InnerSteps
from arael.runtime.linear.compiled import LinearSolver, SchurSolver
from arael.runtime.problem import Problem


@dataclass(frozen=True)
class Eliminated:
    """The instances of a problem by the eliminated entity that they read.

    Attributes
    ----------
    count : eliminated entities
    of_instance : per group (instances,) int32, the number of one, or `count`
    """

    count: int
    of_instance: tuple[Labels, ...]


def inner_steps(problem: Problem, solver: LinearSolver, floor: float) -> InnerSteps | None:
    """Inner iterations over the entities that `solver` eliminates.

    None if it eliminates none, or if an instance reads two of them: costs of entities would then
    depend on each other. None too with bounds, with guards over parameters, or where functions are
    called before each linearisation: inner iterations linearise at states that are only tried.
    """
    if not isinstance(solver, SchurSolver):
        return None
    evaluation = problem.evaluation
    if evaluation.guarded or evaluation.updating or problem.box.count:
        return None
    entities, structure = solver.reduction.entities, problem.structure
    count = len(entities) - 1
    number = np.full(structure.pattern.block_count + 1, count, dtype=np.int32)
    number[np.searchsorted(structure.pattern.offsets, entities["scalar"][:-1])] = np.arange(count)
    found = []
    for group in range(len(problem.layout.groups)):
        read = number[blocks_of(structure, group)]
        one = read.min(axis=1, initial=count)
        if (
            read[(read != count)] != np.broadcast_to(one[:, None], read.shape)[read != count]
        ).any():
            return None
        found.append(np.ascontiguousarray(one, dtype=np.int32))
    return InnerSteps(evaluation, entities, Eliminated(count, tuple(found)), floor)
