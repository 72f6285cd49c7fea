"""The chordal problem of a model: recognised from its text, filled from its data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.certificates.blocks import BlockMatrix
from arael.certificates.framed import FramedProblem, kind_of
from arael.certificates.manifold import Manifold, minimise
from arael.certificates.newton import newton
from arael.certificates.quadratic import Frames, Residual, frames_of, matrix_of, residuals_of
from arael.certificates.reading import Reader
from arael.certificates.rigid import Unreadable
from arael.certificates.two_sided import (
    MOST_POSITIONS,
    MOST_ROTATIONS,
    TwoSidedProblem,
    fits,
    two_sided_matrices,
)
from arael.compiler.reread import typed_model
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


_SHIFT = 1e-9
"""Shift of the preconditioner, relative to the mean diagonal entry of q."""


@dataclass(frozen=True, eq=False)
class ChordalProblem(FramedProblem):
    """Costs of rotations and positions as a quadratic form of the columns of X.

    Attributes
    ----------
    q : (size, size) sparse, with ``cost = tr(X q X')``
    matrix : its blocks, for factorisations
    """

    q: Any
    matrix: BlockMatrix

    @property
    def manifold(self) -> Manifold:
        """The constraints of the rotations."""
        return Manifold(self.frames.rotations, self.frames.d)

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


def chordal_problem(compiled: Any, problem: Problem) -> ChordalProblem | TwoSidedProblem:
    """The chordal problem of a model at its data; of few rotations with data on both their sides.

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
    if all(piece.left is None for residual in residuals for piece in residual.pieces):
        q = matrix_of(frames, residuals)[0]
        return ChordalProblem(problem, frames, exact, count, q, BlockMatrix(frames.blocks, q))
    if not fits(frames):
        why = (
            f"it has data on the left of rotations, and more than {MOST_ROTATIONS} rotations or "
            f"{MOST_POSITIONS} positions"
        )
        raise _none(problem, problem.layout.name, why)
    whole, z, best = two_sided_matrices(frames, residuals)
    return TwoSidedProblem(problem, frames, exact, count, whole, z, best)


def _dimension(problem: Problem, place: tuple[str, str, str]) -> int:
    return 2 if kind_of(problem.store, place[0], place[1]) == "angle" else 3


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
            help=(
                "certificates are of pose graphs, landmarks, points seen from poses, hand and eye",
            ),
        )
    )
