"""Scalars of a solution as formulas: stored numbers, and components of tangent vectors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from arael.geometry.quaternions import quat_log
from arael.runtime.problem import Problem
from arael.runtime.system import row_name


@dataclass(frozen=True)
class Coordinate:
    """A scalar that is solved for, as a formula of a runtime residual.

    Attributes
    ----------
    formula, data : its value; data is empty for a stored number
    start : value at the solution, 0 for a component of a tangent vector
    reach : distance from the start up to which it grows without a jump: pi for rotations, whose
        rotation vector is the shorter one
    """

    name: str
    formula: str
    start: float
    data: dict[str, float] = field(default_factory=dict)
    reach: float = math.inf


def coordinate_of(problem: Problem, name: str, value: float | None) -> Coordinate | None:
    """The scalar of that name at the values of a problem; None for one of a direction.

    Parameters
    ----------
    name : one of `Problem.parameter_names`
    value : its stored number; None for a scalar of a rotation, a direction or a transform

    Notes
    -----
    With the value q0 of a rotation: ``log(q0^-1 q)``, ``q0^-1 = exp(-log(q0))``; of a transform
    ``log(T0^-1 T)``, translation first.
    """
    if value is not None:
        return Coordinate(name, name, value)
    system = problem.structure.system
    scalar = int(problem.free[problem.parameter_names().index(name)])
    number, row, tangent = system.owner(scalar)
    entity = system.layout.entities[number]
    use = next(u for u in entity.params if u.tangent_start <= tangent < u.tangent_start + u.tangent)
    if use.kind == "direction":
        return None
    k = tangent - use.tangent_start
    state = np.asarray(problem.states[number], dtype=np.float64)[row]
    stored = state[use.stored_start : use.stored_start + use.stored]
    place = row_name(problem.store, entity.table, row)
    path = f"{place}.{use.column}" if place else use.column
    if use.kind in ("rotation", "quaternion"):
        formula = f"(exp([v0_, v1_, v2_]) * {path}).log()[{k}]"
        return Coordinate(name, formula, 0.0, _numbers("v", -quat_log(stored)), math.pi)
    data = _numbers("v", quat_log(stored[3:7])) | _numbers("p", stored[:3])
    frame = "transform(exp([v0_, v1_, v2_]), [p0_, p1_, p2_])"
    if use.kind == "similarity":
        frame = "similarity(exp([v0_, v1_, v2_]), [p0_, p1_, p2_], s_)"
        data["s_"] = float(stored[7])
    reach = math.pi if 3 <= k < 6 else math.inf
    return Coordinate(name, f"({frame}.inverse() * {path}).log()[{k}]", 0.0, data, reach)


def _numbers(letter: str, values: np.ndarray) -> dict[str, float]:
    return {f"{letter}{k}_": float(value) for k, value in enumerate(values)}
