"""Motions of the whole map that leave the cost as it is, although residuals may change.

A residual that is a vector turns with the map (``p1 - p0 - v dt``): its square stays, so the cost
has a gauge freedom, but J'J at residuals that are not zero does not show it. Here the *cost* is
tested. Each parameter has candidate motions b_k(x), the generators of turns, shifts and scale:

    vector p        w x p     e     p          (a position, or a velocity that turns along)
    rotation R      w x R     R w              (in the world, in the body)
    transform T     all of these

A combination ``xi(x) = sum_k w_k b_k(x)`` with constant w is a symmetry of the cost f if ``grad f
(x) . xi(x) = 0`` at every x. At more random x than there are candidates that is a linear system for
w: its null space holds the symmetries, up to rounding. Second derivatives are not needed. What is
fixed must not move: ``xi = 0`` there, which is how a datum of fixed coordinates enters.

Not every symmetry is a freedom: ``|p - c|^2`` does not change when p turns about c, yet its minimum
is one point, where ``xi = 0``. A symmetry counts where it moves the minimum that the linear model
predicts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.analysis.scattered import scattered
from arael.geometry import quat_to_matrix, rotation_matrix
from arael.geometry.charts import euler_rates, tangent_basis
from arael.runtime.layout import ParamUse
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

AXES = "xyz"
_POINTS_MORE = 4
"""Random states beyond the number of candidates: chance does not make a null space."""
_SHORT = 0.1
"""Longest random move of a parameter: radians, or part of the size of its column."""
_NONE = 1e-5
"""Smallest singular value of as many states as candidates that excludes any symmetry."""
_EXACT = 1e-12
_EXACT_SINGLE = 2e-6
"""Relative derivative of the cost along a symmetry, from rounding; 1e-16 and 1e-8 are usual, and
1e-4 where the cost changes."""
_HELD = 1e-14
"""Square of the relative size of a motion of what is fixed that is rounding."""
_CLEAR = 1e-6
"""Relative size above which a coefficient is not zero."""
_FIXED_POINT = 0.1
"""Length of a motion at the minimum, relative to that at present, below which it has none there."""
_FELT = 1e-3
"""Length in sigmas below which a motion by 1 rad, or 100 %, is none."""
_LIGHT = 1e-9
"""Weight of a scalar that no residual changes with, relative to the mean of its column."""
_MOST = 80
"""Most candidates; a model with more kinds of parameters is not tested."""
_CHUNK = 100_000

_ORDER = ("turn", "scale", "shift", "body")
_POSITIONS = ("vec", "transform", "similarity")

Kind = Literal["translation", "rotation", "scale", ""]


@dataclass(frozen=True)
class Symmetry:
    """A motion that does not change the cost.

    Attributes
    ----------
    kind : "" for a combination of turns and scale, or of the parameters' own frames
    words : description with the moving parameters
    vector : (n,) its derivative by the motion, of each free scalar: positions move by 1, angles
        by 1 rad, sizes by 100 %
    rate : by how much a residual can change relative to its size, at most
    """

    kind: Kind
    words: str
    vector: Floats
    rate: float = 0.0


@dataclass(frozen=True)
class _Column:
    """A parameter of an entity, and its candidates."""

    name: str
    use: ParamUse
    entity: int
    first: Ints  # (rows,) its first scalar in the system, -1 if the row is not solved for
    free: NDArray[np.bool_]  # (rows, tangent)
    used: NDArray[np.bool_]  # (rows,) whether a constraint reads the row
    tags: tuple[tuple[str, int], ...]  # family and axis of each candidate

    @cached_property
    def rows(self) -> Ints:
        """Rows of which something is free."""
        return np.flatnonzero(self.free.any(axis=1))

    @cached_property
    def scalars(self) -> Ints:
        """(rows, tangent) scalars in the system, -1 of rows that are not solved for."""
        every = self.first[:, None] + np.arange(self.use.tangent)
        return np.where(self.first[:, None] >= 0, every, -1)

    def moves(self, stored: Floats) -> Floats:
        """(m, tangent, k) candidates at the stored values (m, stored) of some rows."""
        return _moves(self.use.kind, np.asarray(stored, dtype=np.float64))


def symmetries(
    problem: Problem, free: Ints, sigma: Floats, step_to_minimum: Callable[[], Floats]
) -> list[Symmetry]:
    """The symmetries of the cost among the candidates; translations first, then turns and scale.

    The state of `problem` moves and is restored.

    Parameters
    ----------
    free : scalars of the system that may move, ascending
    sigma : (n,) change of each that changes residuals by one sigma
    step_to_minimum : returns a step (size,) from the present state, of Gauss-Newton
    """
    columns = list(_columns(problem, free))
    tags = [(k, *tag) for k, column in enumerate(columns) for tag in column.tags]
    if not tags or len(tags) > _MOST or problem.evaluation.updating or not len(free):
        return []
    weights, size = _null_space(problem, columns, len(tags))
    if not weights.shape[1]:
        return []
    order = sorted(range(len(tags)), key=lambda k: (_ORDER.index(tags[k][1]), tags[k][2]))
    rows = np.zeros((weights.shape[1], len(tags)))
    reduced = _echelon(weights.T[:, order], size[order])
    rows[: len(reduced), order] = reduced
    # Velocities turn with the map; what is shifted, be it by a turn about another point, is placed.
    shifts = [k for k, tag in enumerate(tags) if tag[1] == "shift" and rows[:, k].any()]
    placed = {tags[k][0] for k in shifts}
    stored = _stored(problem)
    moved = _moved(problem, step_to_minimum())
    found = []
    for row in rows:
        here, there = (_along(problem.size, columns, at, row)[free] for at in (stored, moved))
        least = max(_FIXED_POINT * float(np.linalg.norm(here / sigma)), _FELT)
        if np.linalg.norm(there / sigma) > least:
            found.append(_described(columns, tags, row, here, placed))
    found.sort(key=lambda one: ("translation", "rotation", "scale", "").index(one.kind))
    return _centred(found)


# --- candidates ------------------------------------------------------------------------------


def _columns(problem: Problem, free: Ints) -> Iterator[_Column]:
    moves = np.zeros(problem.size + 1, dtype=bool)
    moves[free] = True
    used = _rows_in_use(problem)
    for number, (entity, blocks) in enumerate(
        zip(problem.layout.entities, problem.structure.system.blocks, strict=True)
    ):
        first = np.asarray(blocks.first)
        for use in entity.params:
            if not use.tangent or use.column in entity.updated or not len(first):
                continue
            at = first + use.tangent_start
            every = at[:, None] + np.arange(use.tangent)
            own = moves[np.where(first[:, None] >= 0, every, problem.size)]
            tags = _tags(use)
            if tags and own.any():
                name = f"{entity.table}.{use.column}" if entity.table else use.column
                start = np.where(first >= 0, at, -1)
                yield _Column(name, use, number, start, own, used[number], tags)


def _rows_in_use(problem: Problem) -> list[NDArray[np.bool_]]:
    """Per entity, the rows that some active constraint reads."""
    found = [np.zeros(len(b.first), dtype=bool) for b in problem.structure.system.blocks]
    for group, placement in zip(problem.layout.groups, problem.structure.placements, strict=True):
        for k, use in enumerate(group.uses):
            rows = placement.rows[:, k]
            found[use.entity][rows[rows >= 0]] = True
    return found


def _tags(use: ParamUse) -> tuple[tuple[str, int], ...]:
    """Family and axis of the candidates of a parameter, in the order of `_moves`."""
    body = tuple(("body", k) for k in range(use.tangent))
    turns, shifts = tuple(("turn", k) for k in range(3)), tuple(("shift", k) for k in range(3))
    if use.kind == "vec" and use.tangent == 3:
        return (*turns, ("scale", 0), *shifts)
    if use.kind == "vec" and use.tangent == 2:
        return (("turn", 2), ("scale", 0), *shifts[:2])
    if use.kind == "real":
        return (("scale", 1), ("body", 0))
    if use.kind == "angle":
        return (("turn", 2),)
    if use.kind in ("rotation", "quaternion", "euler"):
        return (*turns, *body)
    if use.kind == "direction":
        return turns
    if use.kind in ("transform", "similarity"):
        return (*turns, ("scale", 0), *shifts, *body)
    return ()


def _moves(kind: str, stored: Floats) -> Floats:
    """(m, tangent, k) the candidates at stored values (m, s); steps are in the body frame."""
    m, width = stored.shape
    if kind == "vec" and width == 3:
        return np.concatenate([_turned(stored), stored[:, :, None], _unit(m, 3)], axis=2)
    if kind == "vec":
        turned = np.stack([-stored[:, 1], stored[:, 0]], axis=1)
        return np.concatenate([turned[:, :, None], stored[:, :, None], _unit(m, 2)], axis=2)
    if kind == "real":
        return np.stack([stored, np.ones_like(stored)], axis=2)
    if kind == "angle":
        return np.ones((m, 1, 1))
    if kind == "direction":
        found: Floats = np.swapaxes(tangent_basis(stored), 1, 2) @ _turned(stored)
        return found
    if kind == "euler":
        # The body turns by W times the rates of roll, pitch and yaw.
        back = np.swapaxes(rotation_matrix(stored), 1, 2)
        both: Floats = np.concatenate([back, _unit(m, 3)], axis=2)
        return np.asarray(np.linalg.pinv(euler_rates(stored)) @ both)
    if kind in ("rotation", "quaternion"):
        back = np.swapaxes(quat_to_matrix(stored), 1, 2)
        return np.concatenate([back, _unit(m, 3)], axis=2)
    tangent = width - 1
    place, turn = stored[:, :3], quat_to_matrix(stored[:, 3:7])
    size = stored[:, 7] if kind == "similarity" else np.ones(m)
    back = np.swapaxes(turn, 1, 2)
    by_size = back / size[:, None, None]
    found = np.zeros((m, tangent, 7 + tangent))
    found[:, :3, :3] = by_size @ _turned(place)
    found[:, 3:6, :3] = back
    found[:, :3, 3] = (by_size @ place[:, :, None])[:, :, 0]
    if kind == "similarity":
        found[:, 6, 3] = 1
    found[:, :3, 4:7] = by_size
    found[:, :, 7:] = np.eye(tangent)
    return found


def _unit(m: int, k: int) -> Floats:
    return np.broadcast_to(np.eye(k), (m, k, k))


def _turned(p: Floats) -> Floats:
    """(m, 3, 3) ``e_k x p`` by columns."""
    return np.stack([np.cross(np.eye(3)[k], p) for k in range(3)], axis=2)


# --- the test --------------------------------------------------------------------------------


def _null_space(problem: Problem, columns: list[_Column], count: int) -> tuple[Floats, Floats]:
    """(count, s) coefficients of the symmetries, and (count,) sizes of the candidates in sigmas."""
    evaluation = problem.evaluation
    start = [np.array(state) for state in _stored(problem)]
    diagonal = np.asarray(evaluation.linearised()[2], dtype=np.float64)[problem.diagonal_at]
    moves = np.zeros(problem.size, dtype=bool)
    for column in columns:
        at = column.scalars
        moves[at[column.free & (at >= 0)]] = True
    diagonal = np.where(moves & (diagonal > 0), diagonal, 0.0)
    reach = _reach(columns, start, diagonal)
    # At a state as any other: at zero, turns and scale move nothing.
    usual = _moved(problem, reach * scattered(problem.size))
    size, gram = _norms(columns, usual, diagonal, count)
    acts = size > 0
    # What is fixed stays: only combinations that do not move it.
    inverse = np.where(acts, 1 / np.where(acts, size, 1.0), 0.0)
    values, vectors = np.linalg.eigh(gram * inverse[:, None] * inverse)
    kept = vectors[:, values <= _HELD * max(float(values.max(initial=0.0)), 1.0)]
    kept = kept[:, np.linalg.norm(kept[acts], axis=0) > _CLEAR] if kept.shape[1] else kept
    kept = _acting(kept, acts)
    if not kept.shape[1]:
        return np.zeros((count, 0)), size
    basis = kept * inverse[:, None]
    rows: list[Floats] = []
    try:
        count_kept = kept.shape[1]
        for turn in range(count_kept + _POINTS_MORE):
            if turn == count_kept and np.linalg.svd(np.array(rows), compute_uv=False).min() > _NONE:
                return np.zeros((count, 0)), size
            for number, values in enumerate(start):
                evaluation.start_at(number, values)
            evaluation.moved_by(reach * scattered(problem.size, 1 + turn))
            gradient = np.where(moves, np.asarray(evaluation.linearised()[1], dtype=float), 0.0)
            if not np.isfinite(gradient).all():
                return np.zeros((count, 0)), size
            products = _products(columns, _stored(problem), gradient, count)
            squares = gradient**2 / np.where(diagonal > 0, diagonal, 1.0)
            whole = np.sqrt(squares[diagonal > 0].sum())
            rows.append(products @ basis / (whole if whole > 0 else 1.0))
    finally:
        for number, values in enumerate(start):
            evaluation.start_at(number, values)
    single = problem.layout.precision == "f32"
    s, vt = np.linalg.svd(np.array(rows), full_matrices=True)[1:]
    null = vt[np.count_nonzero(s > (_EXACT_SINGLE if single else _EXACT)) :]
    return np.asarray(basis @ null.T), size


def _acting(kept: Floats, acts: NDArray[np.bool_]) -> Floats:
    """An orthonormal basis of combinations of candidates that move something."""
    if not kept.shape[1]:
        return kept
    u, s, _ = np.linalg.svd(np.where(acts[:, None], kept, 0.0), full_matrices=False)
    found: Floats = u[:, s > _CLEAR]
    return found


def _stored(problem: Problem) -> list[NDArray[Any]]:
    return [
        state[: len(block.free), : entity.stored]
        for entity, block, state in zip(
            problem.layout.entities, problem.structure.system.blocks, problem.states, strict=True
        )
    ]


def _values(column: _Column, stored: list[NDArray[Any]], rows: Ints) -> Floats:
    begin = column.use.stored_start
    return np.asarray(
        stored[column.entity][rows, begin : begin + column.use.stored], dtype=np.float64
    )


def _norms(
    columns: list[_Column], stored: list[NDArray[Any]], diagonal: Floats, count: int
) -> tuple[Floats, Floats]:
    """Size of each candidate in sigmas, and products of candidates over what is fixed."""
    size, gram = np.zeros(count), np.zeros((count, count))
    at = 0
    for column in columns:
        part = slice(at, at + len(column.tags))
        at = part.stop
        scalars = column.scalars
        known = diagonal[scalars[column.free & (scalars >= 0)]]
        mean = float(known.mean()) if len(known) and known.mean() > 0 else 1.0
        rows = np.flatnonzero(column.free.any(axis=1) | column.used)
        for begin in range(0, len(rows), _CHUNK):
            some = rows[begin : begin + _CHUNK]
            moves = column.moves(_values(column, stored, some))
            free = column.free[some]
            weight = np.where(free, diagonal[scalars[some]], 0.0)
            weight = np.where(free & (weight == 0), mean * _LIGHT, weight)
            size[part] += np.einsum("mtk,mtk,mt->k", moves, moves, weight)
            held = np.where(free, 0.0, mean) * column.used[some, None]
            if held.any():
                gram[part, part] += np.einsum("mtk,mtl,mt->kl", moves, moves, held)
    return np.sqrt(size), gram


def _reach(columns: list[_Column], stored: list[NDArray[Any]], diagonal: Floats) -> Floats:
    """Longest random move of each scalar: by which residuals change by about one sigma."""
    found = np.zeros(len(diagonal))
    for column in columns:
        scalars = column.scalars
        rows = np.flatnonzero(column.first >= 0)
        free = column.free[rows]
        some = np.asarray(free.any(axis=1), dtype=np.bool_)
        partly = some & ~np.asarray(free.all(axis=1), dtype=np.bool_)
        if 2 * np.count_nonzero(partly) < np.count_nonzero(some):
            # A datum: a turn about the line through a point and a coordinate holds it here only.
            free = free & ~partly[:, None]
        at = scalars[rows][free]
        felt = diagonal[at] > 0
        sigma = np.where(felt, 1 / np.sqrt(np.where(felt, diagonal[at], 1.0)), 0.0)
        most = _SHORT
        if column.use.kind in ("vec", "real") and felt.any():
            with np.errstate(over="ignore"):
                size = float(np.sqrt(np.square(_values(column, stored, rows)).mean()))
            # The upper median; `np.median` would import `numpy.ma`.
            most = max(_SHORT * size, float(np.sort(sigma[felt])[np.count_nonzero(felt) // 2]))
        found[at] = np.minimum(most, sigma)
    return found


def _products(
    columns: list[_Column], stored: list[NDArray[Any]], gradient: Floats, count: int
) -> Floats:
    """(count,) derivative of half the cost along each candidate."""
    found, at = np.zeros(count), 0
    for column in columns:
        part = slice(at, at + len(column.tags))
        at = part.stop
        rows = column.rows
        for begin in range(0, len(rows), _CHUNK):
            some = rows[begin : begin + _CHUNK]
            own = gradient[column.scalars[some]] * column.free[some]
            moves = column.moves(_values(column, stored, some))
            found[part] += np.tensordot(own, moves, axes=([0, 1], [0, 1]))
    return found


# --- in words --------------------------------------------------------------------------------


def _echelon(rows: Floats, size: Floats) -> Floats:
    """Reduced row echelon form; entries below `_CLEAR` of their row, in units of `size`, are 0."""
    rows = np.array(rows)
    scale = np.where(size > 0, size, 0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        norms = np.linalg.norm(rows * scale, axis=1)
    rows = rows[norms > 0] / norms[norms > 0, None]
    done = 0
    for k in range(rows.shape[1]):
        if done == len(rows):
            break
        lead = done + int(np.argmax(np.abs(rows[done:, k])))
        if abs(rows[lead, k]) * scale[k] <= _CLEAR:
            continue
        rows[[done, lead]] = rows[[lead, done]]
        rows[done] /= rows[done, k]
        others = np.arange(len(rows)) != done
        rows[others] -= rows[others, k][:, None] * rows[done]
        done += 1
        rest = np.linalg.norm(rows[done:] * scale, axis=1)
        rows[done:] /= np.where(rest > 0, rest, 1.0)[:, None]
    found = rows[:done]
    sizes = np.abs(found) * scale
    found[sizes <= _CLEAR * sizes.max(axis=1, initial=0.0)[:, None]] = 0
    return found


def _moved(problem: Problem, step: Floats) -> list[NDArray[Any]]:
    """Stored values after a step; the state is restored."""
    start = [np.array(state) for state in _stored(problem)]
    problem.evaluation.moved_by(step)
    found = [np.array(state) for state in _stored(problem)]
    for number, values in enumerate(start):
        problem.evaluation.start_at(number, values)
    return found


def _along(size: int, columns: list[_Column], stored: list[NDArray[Any]], w: Floats) -> Floats:
    """(size,) derivative of all scalars along a combination of the candidates."""
    whole, at = np.zeros(size), 0
    for column in columns:
        own = w[at : at + len(column.tags)]
        at += len(column.tags)
        if not own.any():
            continue
        rows = column.rows
        moved = column.moves(_values(column, stored, rows)) @ own
        whole[column.scalars[rows][column.free[rows]]] = moved[column.free[rows]]
    return whole


def _described(
    columns: list[_Column],
    tags: list[tuple[int, str, int]],
    w: Floats,
    vector: Floats,
    placed: set[int],
) -> Symmetry:
    by_family = {family: np.zeros((len(columns), 3)) for family in _ORDER}
    for (k, family, axis), weight in zip(tags, w, strict=True):
        by_family[family][k, min(axis, 2)] += weight
    moves = {
        family: np.asarray(part.any(axis=1), dtype=np.bool_) for family, part in by_family.items()
    }
    kind = _kind(moves, by_family)
    rate = max((abs(x) for (_, family, _), x in zip(tags, w, strict=True) if family != "shift"))
    return Symmetry(kind, _words(kind, columns, moves, by_family, placed), vector, rate)


def _kind(moves: dict[str, NDArray[np.bool_]], by_family: dict[str, Floats]) -> Kind:
    if moves["body"].any() or (moves["turn"].any() and moves["scale"].any()):
        return ""
    if moves["turn"].any():
        return "rotation"
    if moves["scale"].any():
        return "scale"
    along = np.abs(by_family["shift"]).any(axis=0)
    return "translation" if np.count_nonzero(along) == 1 else ""


def _words(
    kind: Kind,
    columns: list[_Column],
    moves: dict[str, NDArray[np.bool_]],
    by_family: dict[str, Floats],
    placed: set[int],
) -> str:
    every = [k for k in range(len(columns)) if any(part[k] for part in moves.values())]
    if kind == "":
        return f"{_listed(columns, every)} change together"
    moving = [k for k in every if columns[k].use.kind in _POSITIONS] or every
    places = [k for k in moving if k in placed] or moving
    along = [k for k in moving if k not in places]
    with_them = f", {_listed(columns, along)} with them" if along else ""
    names = _listed(columns, places)
    if kind == "translation":
        axis = int(np.argmax(np.abs(by_family["shift"]).sum(axis=0)))
        return f"{names} move together along {AXES[axis]}"
    if kind == "scale":
        return f"{names} grow or shrink together (scale){with_them}"
    return f"{names} turn together{_axis(columns, every, by_family['turn'])}{with_them}"


def _listed(columns: list[_Column], chosen: list[int]) -> str:
    return ", ".join(f"`{columns[k].name}`" for k in chosen)


def _axis(columns: list[_Column], every: list[int], turns: Floats) -> str:
    """The axis of a turn in words; nothing in the plane."""
    if all(columns[k].use.kind == "angle" or columns[k].use.stored == 2 for k in every):
        return ""
    lead = turns[int(np.argmax(np.abs(turns).any(axis=1)))]
    if np.count_nonzero(lead) == 1:
        return f" about {AXES[int(np.argmax(np.abs(lead)))]}"
    return f" about the axis ({', '.join(f'{x:.3g}' for x in lead / np.linalg.norm(lead))})"


def _centred(found: list[Symmetry]) -> list[Symmetry]:
    """Turns and scale about the middle of the map, where the map may move."""
    shifts = [one.vector for one in found if one.kind == "translation"]
    if not shifts:
        return found
    basis = np.linalg.qr(np.column_stack(shifts))[0]
    return [
        one
        if one.kind in ("translation", "")
        else replace(one, vector=one.vector - basis @ (basis.T @ one.vector))
        for one in found
    ]
