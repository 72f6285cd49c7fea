"""Gauge freedoms: translation, rotation and scale of the whole map at no cost.

Relative measurements alone do not determine the position of the map. The null space of the Jacobian
then contains the motion of all positions together: along an axis (1 at every position), about an
axis w (w x (p - c) at the position p), in scale (p - c). This is tested by a small least-squares
problem: the linear combination of free directions closest to that motion. The corresponding changes
of angles and other parameters need not be known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

AXES = "xyz"
_EXACT = 1e-4
"""Largest relative misfit of a detected motion."""


@dataclass(frozen=True)
class Gauge:
    """A motion of the whole map that does not change the cost.

    Attributes
    ----------
    words : description with the moving positions
    weights : (f,) coefficients of the free directions
    """

    kind: Literal["translation", "rotation", "scale"]
    words: str
    weights: Floats


@dataclass(frozen=True)
class _Positions:
    """Free positions: indices of their scalars, and their values."""

    at: Ints  # (m, d) indices among the free scalars
    values: Floats  # (m, d)
    names: list[str]


def find_gauges(problem: Problem, moves: Floats) -> list[Gauge]:
    """Translations, rotations and scale among the free directions `moves` (n, f)."""
    found: list[Gauge] = []
    for dimension in (3, 2):
        positions = _moving_positions(problem, moves, dimension)
        if positions is not None:
            found += _of(positions, moves, moves.shape[1] - len(found))
    return found


def _of(positions: _Positions, moves: Floats, most: int) -> list[Gauge]:
    whose = ", ".join(f"`{name}`" for name in positions.names)
    free = moves[positions.at.ravel()]
    found: list[Gauge] = []
    # A rotation about any other point, such as an anchor, includes a translation.
    shifts = np.tile(np.eye(positions.values.shape[1]), (len(positions.values), 1))
    for kind, words, motion in _motions(positions):
        freedoms = free if kind == "translation" else np.column_stack([free, shifts])
        solved = np.linalg.lstsq(freedoms, motion, rcond=1e-9)[0]
        weights: Floats = np.asarray(solved, dtype=np.float64)
        off = np.linalg.norm(freedoms @ weights - motion)
        size = np.linalg.norm(motion)
        if len(found) == most or size == 0 or off > _EXACT * size:
            continue
        weights = weights[: moves.shape[1]]
        if _is_new(weights, found):
            found.append(Gauge(kind, f"{whose} {words}", weights))
    return found


def _is_new(weights: Floats, found: list[Gauge]) -> bool:
    """Whether it is linearly independent of those found before."""
    if not found:
        return bool(np.linalg.norm(weights) > 0)
    known = np.column_stack([one.weights for one in found])
    left = weights - known @ np.linalg.lstsq(known, weights, rcond=None)[0]
    return bool(np.linalg.norm(left) > 1e-6 * np.linalg.norm(weights))


def _motions(
    positions: _Positions,
) -> Iterator[tuple[Literal["translation", "rotation", "scale"], str, Floats]]:
    count, dimension = positions.values.shape
    centred = positions.values - positions.values.mean(axis=0)
    for k in range(dimension):
        shift = np.zeros((count, dimension))
        shift[:, k] = 1
        yield "translation", f"move together along {AXES[k]}", shift.ravel()
    if dimension == 2:
        turned = np.column_stack([-centred[:, 1], centred[:, 0]])
        yield "rotation", "turn together", turned.ravel()
    else:
        for k in range(3):
            turned = np.cross(np.eye(3)[k], centred)
            yield "rotation", f"turn together about {AXES[k]}", turned.ravel()
    yield "scale", "grow or shrink together (scale)", centred.ravel()


def _moving_positions(problem: Problem, moves: Floats, dimension: int) -> _Positions | None:
    """Vectors of that dimension with entries in some free direction; None if fewer than two."""
    number = np.full(problem.size + 1, -1, dtype=np.int64)
    number[problem.free] = np.arange(len(problem.free))
    effort = np.linalg.norm(moves, axis=1)
    least = 1e-6 * effort.max(initial=0.0)
    places, values, names = [], [], []
    system = problem.structure.system
    for entity, blocks, state in zip(
        problem.layout.entities, system.blocks, problem.states, strict=True
    ):
        for use in entity.params:
            if use.kind != "vec" or use.tangent != dimension:
                continue
            tangents = use.tangent_start + np.arange(dimension)
            rows = np.flatnonzero(blocks.free[:, tangents].all(axis=1))
            at = number[blocks.first[rows, None] + tangents]
            if len(rows) and (effort[at] > least).any():
                places.append(at)
                values.append(state[rows, use.stored_start : use.stored_start + dimension])
                names.append(f"{entity.table}.{use.column}" if entity.table else use.column)
    if sum(map(len, places)) < 2:
        return None
    return _Positions(np.concatenate(places), np.concatenate(values).astype(np.float64), names)
