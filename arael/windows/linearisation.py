"""Residuals and Jacobian of the constraints that leave with rows, at first estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.geometry.differences import difference
from arael.runtime.layout import ParamUse
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Place = tuple[int, int, int]
"""Entity, row, and number of the parameter in the entity."""


@dataclass(frozen=True)
class Linear:
    """Residuals ``residual + jacobian (x boxminus x0)`` of the instances that leave.

    Attributes
    ----------
    jacobian : (m, n) by the scalars `columns` of the system
    residual : (m,)
    columns : (n,) ascending
    """

    jacobian: Floats
    residual: Floats
    columns: NDArray[np.int64]


def use_of(problem: Problem, place: Place) -> ParamUse:
    """The parameter at a place, in its entity."""
    return problem.layout.entities[place[0]].params[place[2]]


def value_at(problem: Problem, place: Place) -> Floats:
    """(stored,) present value of a parameter."""
    use = use_of(problem, place)
    state = problem.states[place[0]][place[1]]
    return np.array(state[use.stored_start : use.stored_start + use.stored], dtype=np.float64)


def columns_of(problem: Problem, place: Place) -> NDArray[np.int64]:
    """Scalars of a parameter in the system; none if its row is not solved for."""
    use = use_of(problem, place)
    first = int(problem.structure.system.blocks[place[0]].first[place[1]])
    return first + use.tangent_start + np.arange(use.tangent if first >= 0 else 0)


def linearise(
    problem: Problem,
    instances: Sequence[NDArray[np.bool_]],
    bases: Mapping[Place, Floats],
) -> Linear:
    """Linearise chosen instances: residuals at present values, the Jacobian at first estimates.

    Parameters
    ----------
    problem : whose evaluation may be moved; it is not used afterwards
    instances : per group, a mask over its active instances
    bases : first estimates of parameters that have some

    Notes
    -----
    With x the present values, x0 the first estimates and J the Jacobian at x0, the residuals are
    ``r(x) + J (y boxminus x0) - J (x boxminus x0)`` of y: exact at x, with the derivatives of every
    earlier linearisation of the same parameters, so that what they cannot observe stays so (G.
    Huang, A. Mourikis, S. Roumeliotis, "Observability-based rules for designing consistent EKF
    SLAM estimators", 2010).
    """
    structure = problem.structure
    width = problem.size + structure.trash
    chosen = [
        mask & np.asarray(problem.evaluation.acting(number)) if mask.any() else mask
        for number, mask in enumerate(instances)
    ]
    now = [
        problem.evaluation.group_rows(number) if mask.any() else None
        for number, mask in enumerate(chosen)
    ]
    residual = np.concatenate(
        [
            np.asarray(found[0][mask], dtype=np.float64).ravel()
            for found, mask in zip(now, chosen, strict=True)
            if found is not None
        ]
        or [np.zeros(0)]
    )
    moved = _move_to(problem, bases, width)
    jacobian = np.zeros((len(residual), 0))
    rows, columns, values = [], [], []
    first = 0
    for number, mask in enumerate(chosen):
        found = now[number]
        if found is None:
            continue
        entries = found[1] if moved is None else problem.evaluation.group_rows(number)[1]
        group = problem.layout.groups[number]
        own = first + group.residuals * np.arange(mask.sum())
        at = structure.placements[number].gradient_at[mask]
        for k, (component, use, tangent) in enumerate(group.jacobian):
            rows.append(own + component)
            columns.append(at[:, use] + tangent)
            values.append(np.asarray(entries[mask, k], dtype=np.float64))
        first += group.residuals * len(own)
    held = np.zeros(width, dtype=bool)
    held[structure.system.held] = True
    held[problem.size :] = True
    where = np.concatenate(columns or [np.zeros(0, dtype=np.int64)]).astype(np.int64)
    used = np.unique(where[~held[where]])
    if len(used):
        place = np.full(width, -1)
        place[used] = np.arange(len(used))
        row, column, value = np.concatenate(rows), place[where], np.concatenate(values)
        jacobian = np.zeros((len(residual), len(used)))
        np.add.at(jacobian, (row[column >= 0], column[column >= 0]), value[column >= 0])
        if moved is not None:
            residual -= jacobian @ moved[used]
    return Linear(jacobian, residual, used)


def _move_to(problem: Problem, bases: Mapping[Place, Floats], width: int) -> Floats | None:
    """Move the evaluation to first estimates; (width,) present values boxminus these, or None."""
    moved = np.zeros(width)
    states: dict[int, NDArray[Any]] = {}
    for place, base in bases.items():
        at = columns_of(problem, place)
        if not len(at):
            continue
        use, value = use_of(problem, place), value_at(problem, place)
        if np.array_equal(base, value):
            continue
        moved[at] = difference(use.kind, base[None], value[None])[0]
        entity = problem.layout.entities[place[0]]
        state = states.get(place[0])
        if state is None:
            rows = len(problem.structure.system.blocks[place[0]].first)
            state = states[place[0]] = np.array(problem.states[place[0]][:rows, : entity.stored])
        state[place[1], use.stored_start : use.stored_start + use.stored] = base
    if not states:
        return None
    for number, state in states.items():
        problem.evaluation.start_at(number, state)
    return moved
