"""The cost of a model as a quadratic form of rotation matrices and positions: the chordal problem.

The unknowns are the columns of ``X = [R_0, R_1, t_1, R_2, t_2, ...]``, d rows. ``R_0`` stands for
the axes of the world, in which everything that is fixed is given, so that every residual is linear:
``X E_i`` with a sparse ``E_i`` of data. With weights w the cost is

    f(X) = sum_i w_i |X E_i|^2 = tr(X Q X'),    Q = sum_i w_i E_i E_i'

as in D. Rosen, L. Carlone, A. Bandeira and J. Leonard, "SE-Sync: a certifiably correct algorithm
for synchronization over the special Euclidean group", IJRR 2019. A residual of a point in the axes
of a pose is first turned into the axes of the world, which its norm does not see; the error of a
rotation, ``2 sin(angle / 2)`` long, has half the square of ``R_b - R_a M``.

Weights that are no multiples of the identity, and errors that are angles, are replaced: by a weight
with the same mean variance, by the chordal error. That is another problem, the chordal twin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.certificates.rigid import (
    Atom,
    Error,
    Letter,
    Point,
    Unreadable,
    Weighted,
    Word,
    has_left,
    inverse,
    is_linear,
    joined,
)
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_ISOTROPIC = 1e-9
"""Largest spread of a weight, relative to it, at which it is a multiple of the identity."""


@dataclass(frozen=True, eq=False)
class Piece:
    """One part of a linear residual: ``sign left R right``, ``sign left t``, or ``sign right``.

    Attributes
    ----------
    atom : the parameter; None: the axes of the world
    right : (n, d) or (n, d, d); None of a position
    left : (n, d, d); None: no data on this side
    """

    sign: float
    atom: Atom | None
    right: Floats | None
    left: Floats | None = None


@dataclass(frozen=True, eq=False)
class Residual:
    """A linear residual of all instances of a constraint, and its weight (n,)."""

    pieces: tuple[Piece, ...]
    weight: Floats
    ways: Any


@dataclass(frozen=True)
class Frames:
    """Where the unknowns lie among the columns of X.

    Attributes
    ----------
    d : dimension
    rotation, position : (table, column) -> first column of each row, -1 where it is fixed
    fixed_rotation, fixed_position : the values of all rows
    size : number of columns
    blocks : (k,) number of columns of each block: rotation and position of one row are one
    rotations : (m,) first columns of the rotations, that of the world first
    """

    d: int
    rotation: dict[tuple[str, str], Ints]
    position: dict[tuple[str, str], Ints]
    values: dict[tuple[str, str, str], Floats]
    size: int
    blocks: Ints
    rotations: Ints


def linear_pieces(error: Point | Error) -> tuple[Piece, ...]:
    """A point or an error of a rotation as a linear residual of the same norm.

    Without data on the left of parameters, if there is one.

    Raises
    ------
    Unreadable
    """
    return _of_point(error) if isinstance(error, Point) else _of_rotation(error)


def _of_point(point: Point) -> tuple[Piece, ...]:
    frames: list[Word] = [()]
    for term in point.terms:
        for k, letter in enumerate(term.word):
            if letter.inverse:
                frames.append(inverse(term.word[: k + 1]))
    turned = [point.moved(frame).terms for frame in frames]
    for one_sided in (True, False):
        for terms in turned:
            if all(_fits(t.word, t.atom, one_sided) for t in terms):
                return tuple(_piece(t.sign, t.word, t.atom, t.data) for t in terms)
    raise Unreadable("a point whose parts no one turn makes linear")


def _of_rotation(error: Error) -> tuple[Piece, ...]:
    word = error.word
    if error.size == 1:  # rotations of the plane commute
        data = tuple(one for one in word if one.data is not None)
        moving = [one for one in word if one.atom is not None]
        back = tuple(one for one in moving if one.inverse)
        word = joined(data, back, tuple(one for one in moving if not one.inverse))
    splits: list[tuple[Word, Word]] = []
    for turn in range(max(len(word), 1)):
        shifted = joined(word[turn:], word[:turn])
        splits += [(shifted[k:], inverse(shifted[:k])) for k in range(len(shifted) + 1)]
    eye = np.eye(2 if error.size == 1 else 3)[None]
    for one_sided in (True, False):
        for ahead, behind in splits:
            if _fits(ahead, None, one_sided) and _fits(behind, None, one_sided):
                return _piece(1.0, ahead, None, eye), _piece(-1.0, behind, None, eye)
    raise Unreadable("a product of rotations that no split makes linear")


def _fits(word: Word, position: Atom | None, one_sided: bool) -> bool:
    """Whether a term is linear, with data on the right alone if it is to be one-sided."""
    if position is not None:
        return not word if one_sided else all(letter.data is not None for letter in word)
    return is_linear(word) and not (one_sided and has_left(word))


def _piece(sign: float, word: Word, atom: Atom | None, data: Floats | None) -> Piece:
    right, letters = data, list(word)
    while atom is None and letters and letters[-1].data is not None:
        right = _applied(letters.pop(), right)
    left = letters[0].data if letters else None
    turn = next((letter.atom for letter in letters if letter.atom is not None), None)
    return Piece(sign, turn if atom is None else atom, right, left)


def _applied(letter: Letter, right: Floats | None) -> Floats:
    assert letter.data is not None and right is not None
    if right.ndim == 3:
        found: Floats = letter.data @ right
        return found
    turned: Floats = np.einsum("nij,nj->ni", letter.data, right)
    return turned


def residuals_of(weighted: Weighted, ways: Any) -> tuple[list[Residual], bool]:
    """Linear residuals with scalar weights, and whether these are the constraint itself.

    Raises
    ------
    Unreadable
    """
    found, exact = [], True
    for error, weight in zip(weighted.errors, weighted.weights, strict=True):
        information = weight.transpose(0, 2, 1) @ weight
        size = error.size
        mean = np.trace(information, axis1=1, axis2=2) / size
        spread = np.abs(information - mean[:, None, None] * np.eye(size)).max(axis=(1, 2))
        even = spread <= _ISOTROPIC * mean
        if not even.all():
            exact = False
            mean = np.where(even, mean, _mean_weight(information))
        for other, mixed in zip(weighted.errors, weighted.weights, strict=True):
            if other is not error and np.abs(weight.transpose(0, 2, 1) @ mixed).max(initial=0) > (
                _ISOTROPIC * mean.max(initial=0)
            ):
                exact = False
        if isinstance(error, Error):
            exact &= error.chordal
            mean = mean / 2
        found.append(Residual(linear_pieces(error), mean, ways))
    return found, exact


def _mean_weight(information: Floats) -> Floats:
    """(n,) the weight whose variance is the mean of the variances; 0 where one is infinite."""
    size = information.shape[1]
    values = np.linalg.eigvalsh(information)
    sound = values[:, 0] > 1e-12 * values[:, -1]
    safe = np.where(sound[:, None], values, 1.0)
    if not (sound | (values[:, -1] == 0)).all():
        raise Unreadable("a weight that measures some directions only")
    return np.where(sound, size / (1 / safe).sum(axis=1), 0.0)


def matrix_of(frames: Frames, residuals: Sequence[Residual]) -> tuple[Any, Any]:
    """Q, and E with ``Q = E E'``: sparse, (size, size) and (size, residuals)."""
    # imported here: start-up time
    from scipy.sparse import coo_array

    d = frames.d
    rows, columns, values = [], [], []
    first = 0
    for residual in residuals:
        n = len(residual.weight)
        wide = 1
        root = np.sqrt(residual.weight)
        for piece in residual.pieces:
            if piece.right is not None and piece.right.ndim == 3:
                wide = d
        for piece in residual.pieces:
            for chosen, start, right in placed(frames, piece, residual.ways, n):
                factor, ahead = piece.sign * root[chosen], first + wide * chosen
                if right is None:
                    rows.append(start)
                    columns.append(ahead)
                    values.append(factor)
                    continue
                flat = right.reshape(len(chosen), d, -1)  # a vector is one column
                shape = flat.shape
                rows.append(np.broadcast_to((start[:, None] + np.arange(d))[:, :, None], shape))
                across = ahead[:, None, None] + np.arange(shape[2])
                columns.append(np.broadcast_to(across, shape))
                values.append(factor[:, None, None] * flat)
        first += n * wide
    row, column, value = (
        np.concatenate([part.ravel() for part in one]) for one in (rows, columns, values)
    )
    e = coo_array((value, (row, column)), shape=(frames.size, first)).tocsr()
    return (e @ e.T).tocsr(), e


def placed(
    frames: Frames, piece: Piece, ways: Any, n: int
) -> list[tuple[Ints, Ints, Floats | None]]:
    """Instances, first column of the piece for each, and what its columns are multiplied by."""
    every, world = np.arange(n), np.zeros(n, dtype=np.int64)
    right = (
        None if piece.right is None else np.broadcast_to(piece.right, (n, *piece.right.shape[1:]))
    )
    if piece.atom is None:
        return [(every, world, right)]
    table, rows = ways(piece.atom.slot)
    place = table, piece.atom.column
    start = (frames.rotation if piece.atom.part == "R" else frames.position)[place][rows]
    free, fixed = np.flatnonzero(start >= 0), np.flatnonzero(start < 0)
    found: list[tuple[Ints, Ints, Floats | None]] = []
    if len(free):
        found.append((free, start[free], None if right is None else right[free]))
    if len(fixed):
        own = frames.values[(*place, piece.atom.part)][rows[fixed]]
        if right is not None:
            chosen = right[fixed]
            own = (own @ chosen.reshape(len(own), frames.d, -1)).reshape(chosen.shape)
        found.append((fixed, world[fixed], own))
    return found


def frames_of(problem: Problem, atoms: Sequence[tuple[str, str, str]], d: int) -> Frames:
    """Columns of X for the parameters that the residuals read."""
    store = problem.store
    rotation: dict[tuple[str, str], Ints] = {}
    position: dict[tuple[str, str], Ints] = {}
    values: dict[tuple[str, str, str], Floats] = {}
    moves: dict[tuple[str, str, str], NDArray[np.bool_]] = {}
    for table, column, part in atoms:
        values[table, column, part] = values_of(store, table, column, part)
        moves[table, column, part] = _moving(problem, table, column, part)
    size, blocks, rotations = d, [d], [0]
    pairs: dict[
        str, dict[str, list[str]]
    ] = {}  # a rotation and a position of one table are one block
    for table, column, part in atoms:
        pairs.setdefault(table, {}).setdefault(part, []).append(column)
    for table, parts in pairs.items():
        count = store.tables[table].size
        for column in parts.get("R", []):
            rotation[table, column] = np.full(count, -1, dtype=np.int64)
        for column in parts.get("t", []):
            position[table, column] = np.full(count, -1, dtype=np.int64)
        for row in range(count):
            begin = size
            for column in parts.get("R", []):
                if moves[table, column, "R"][row]:
                    rotation[table, column][row] = size
                    rotations.append(size)
                    size += d
            for column in parts.get("t", []):
                if moves[table, column, "t"][row]:
                    position[table, column][row] = size
                    size += 1
            if size > begin:
                blocks.append(size - begin)
    return Frames(
        d,
        rotation,
        position,
        values,
        size,
        np.array(blocks, dtype=np.int64),
        np.array(rotations, dtype=np.int64),
    )


def _moving(problem: Problem, table: str, column: str, part: str) -> NDArray[np.bool_]:
    """(rows,) whether a rotation or a position moves; Unreadable where a part of it does."""
    for entity, blocks in zip(
        problem.layout.entities, problem.structure.system.blocks, strict=True
    ):
        if entity.table != table:
            continue
        for use in entity.params:
            if use.column == column:
                first, count = use.tangent_start, use.tangent
                if use.kind == "transform":
                    first, count = (first + 3, 3) if part == "R" else (first, 3)
                free = np.asarray(blocks.free)[:, first : first + count]
                every, some = free.all(axis=1), free.any(axis=1)
                if (every != some).any():
                    raise Unreadable(f"`{table}.{column}`, of which a part is fixed")
                if np.isfinite(_bounds(problem, blocks, use)).any():
                    raise Unreadable(f"bounds of `{table}.{column}`")
                return np.asarray(every, dtype=bool)
    raise Unreadable(f"`{table}.{column}`")


def _bounds(problem: Problem, blocks: Any, use: Any) -> Floats:
    system = problem.structure.system
    at = blocks.first[blocks.first >= 0]
    scalars = at[:, None] + np.arange(use.tangent_start, use.tangent_start + use.tangent)
    return np.concatenate([system.low[scalars].ravel(), system.high[scalars].ravel()])


def values_of(store: Any, table: str, column: str, part: str) -> Floats:
    """(rows, d, d) rotations, or (rows, d) positions, of a column."""
    # imported here: start-up time
    from arael.certificates.values import positions_of, rotations_of

    found = np.asarray(store.tables[table].column(column), dtype=np.float64)
    kind = store.layout.table(table).column(column).param.kind
    return rotations_of(kind, found) if part == "R" else positions_of(kind, found)
