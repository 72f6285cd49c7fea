"""The chordal problem of a model: recognised from its text, filled from its data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.certificates.blocks import BlockMatrix
from arael.certificates.manifold import Manifold, minimise
from arael.certificates.newton import newton
from arael.certificates.quadratic import Frames, Residual, frames_of, matrix_of, residuals_of
from arael.certificates.reading import Reader
from arael.certificates.rigid import Unreadable
from arael.certificates.values import put_positions, put_rotations
from arael.compiler.reread import typed_model
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


_SHIFT = 1e-9
"""Shift of the preconditioner, relative to the mean diagonal entry of q."""


@dataclass(frozen=True, eq=False)
class ChordalProblem:
    """Costs of rotations and positions as a quadratic form.

    Attributes
    ----------
    frames : where the unknowns lie
    q : (size, size) sparse, with ``cost = tr(X q X')``
    exact : whether it is the model itself; else its chordal twin
    residuals : number of residuals of the model
    matrix : its blocks, for factorisations
    """

    problem: Problem
    frames: Frames
    q: Any
    exact: bool
    residuals: int
    matrix: BlockMatrix

    @property
    def manifold(self) -> Manifold:
        """The constraints of the rotations."""
        return Manifold(self.frames.rotations, self.frames.d)

    def values(self) -> Floats:
        """(d, size) X at the values of the model."""
        frames = self.frames
        x = np.zeros((frames.d, frames.size))
        x[:, : frames.d] = np.eye(frames.d)
        for (table, column), first in frames.rotation.items():
            rows = np.flatnonzero(first >= 0)
            at = first[rows, None] + np.arange(frames.d)
            x[:, at] = frames.values[table, column, "R"][rows].transpose(1, 0, 2)
        for (table, column), first in frames.position.items():
            rows = np.flatnonzero(first >= 0)
            x[:, first[rows]] = frames.values[table, column, "t"][rows].T
        return x

    def put(self, x: Floats) -> None:
        """Write X into the model, turned so that the axes of the world are its own."""
        frames, store = self.frames, self.problem.store
        x = x[:, : frames.d].T @ x
        for (table, column), first in frames.rotation.items():
            rows = np.flatnonzero(first >= 0)
            at = first[rows, None] + np.arange(frames.d)
            target = store.tables[table].column(column)
            put_rotations(_kind(store, table, column), target, rows, x[:, at].transpose(1, 0, 2))
            store.tables[table].written()
        for (table, column), first in frames.position.items():
            rows = np.flatnonzero(first >= 0)
            target = store.tables[table].column(column)
            put_positions(_kind(store, table, column), target, rows, x[:, first[rows]].T)
            store.tables[table].written()

    def cost(self, y: Floats) -> float:
        """``tr(y q y')``."""
        return float(np.sum((self.q @ y.T).T * y))

    def multipliers(self, y: Floats) -> tuple[Floats, Any]:
        """Lambda at y, and ``S = q - Lambda``, sparse."""
        # imported here: start-up time
        from scipy.sparse import coo_array

        image = np.ascontiguousarray((self.q @ y.T).T)
        found = self.manifold.multipliers(y, image)
        at = self.manifold.columns
        rows = np.broadcast_to(at[:, :, None], found.shape)
        columns = np.broadcast_to(at[:, None, :], found.shape)
        blocks = coo_array((found.ravel(), (rows.ravel(), columns.ravel())), shape=self.q.shape)
        return found, (self.q - blocks.tocsr()).tocsr()

    def minimised(self, y: Floats) -> Floats:
        """A minimum of the rank of y near it."""
        if len(y) == self.frames.d:
            return newton(self.manifold, self.q, self.multipliers, y, self.frames.blocks)
        solver = self.matrix.factorised(self.q, self.matrix.mean * _pinned(self.frames))
        assert solver is not None

        def precondition(rows: Floats) -> Floats:
            return np.ascontiguousarray(np.asarray(solver.solved(rows.T)).T)

        return minimise(self.manifold, self.q, y, precondition)


def _pinned(frames: Frames) -> Floats:
    """A small shift, and a large one for the axes of the world: they stay."""
    found = np.full(frames.size, _SHIFT)
    found[: frames.d] = 1e6
    return found


def _kind(store: Any, table: str, column: str) -> str:
    return str(store.layout.table(table).column(column).param.kind)


def chordal_problem(compiled: Any, problem: Problem) -> ChordalProblem:
    """The chordal problem of a model at its data.

    Raises
    ------
    AraelError
        E1061: a constraint is not quadratic in rotations and positions, nor has a chordal twin.
    """
    typed = typed_model(compiled)
    functions = Functions(typed.functions)
    residuals: list[Residual] = []
    exact, count = True, 0
    atoms: dict[tuple[str, str, str], None] = {}
    for number, group in enumerate(problem.layout.groups):
        if not len(problem.structure.active[number]):
            continue
        count += group.residuals * len(problem.structure.active[number])
        if number >= len(typed.constraints):
            raise _none(problem, group.label, "it was added at run time")
        site = typed.constraints[number]
        if group.require:
            raise _none(problem, group.label, "it holds exactly")
        if group.loss_text or group.moving_guard is not None:
            what = "a loss" if group.loss_text else "a guard over parameters"
            raise _none(problem, group.label, f"it has {what}")
        try:
            found, same = residuals_of(
                Reader(problem, number, site, functions).residual(), _ways(problem, number)
            )
        except Unreadable as error:
            raise _none(problem, group.label, f"it has {error}") from None
        exact &= same
        residuals += found
        for one in found:
            for piece in one.pieces:
                if piece.atom is not None:
                    table = group.slots[piece.atom.slot].table
                    atoms[table, piece.atom.column, piece.atom.part] = None
    if not any(part == "R" for _, _, part in atoms):
        raise _none(problem, problem.layout.name, "no rotation is solved for")
    d = next(_dimension(problem, place) for place in atoms if place[2] == "R")
    try:
        frames = frames_of(problem, list(atoms), d)
    except Unreadable as error:
        raise _none(problem, problem.layout.name, f"it has {error}") from None
    q = matrix_of(frames, residuals)[0]
    return ChordalProblem(problem, frames, q, exact, count, BlockMatrix(frames.blocks, q))


def _dimension(problem: Problem, place: tuple[str, str, str]) -> int:
    return 2 if _kind(problem.store, place[0], place[1]) == "angle" else 3


def _ways(problem: Problem, number: int) -> Any:
    """Table and rows of a slot of a group, for all its instances."""
    group, ways = problem.layout.groups[number], problem.structure.slot_rows[number]
    return lambda slot: (group.slots[slot].table, ways[slot])


def _none(problem: Problem, label: str, why: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1061",
            f"`{label}` is not quadratic in rotations and positions: {why}",
            origin=problem.layout.name,
            help=("certificates are of pose graphs, landmarks and points seen from poses",),
        )
    )
