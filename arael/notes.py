"""What a solve tells beside its status: notes on results whose numbers mean less than they seem.

A solve may converge where the answer means nothing: fewer measurements than unknowns, a map that
nothing holds in place, a point that ran off under a robust loss. These checks are cheap. What
depends on the structure of a problem, its rank, is decided once for each structure, from the factor
that the solve has; the others are made when `Result.notes` is first read, from what the result
keeps. `docs/internals/notes.md` has the reasons and the times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.analysis.scattered import scattered
from arael.runtime.assembly.structure import Structure
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.problem import Problem
from arael.runtime.system import row_name

Floats = NDArray[np.float64]

Topic = Literal["underdetermined", "free", "far", "weightless", "frozen"]

_LISTED = 4
_FREE = 1e9
_FREE_SINGLE = 1e5
"""Growth of a random vector by the inverse of J'J, scaled to a unit diagonal, above which the rank
is looked at closely. A free direction makes it the inverse of the regularisation, 1e12 (8e6)."""
_UNDAMPED = 1e-9
"""Largest regularisation of a factor that shows free directions."""
_DENSE = 400
"""Up to this many scalars all free directions are found, beyond it gauge freedoms."""
_MOST = 2000
"""Up to this many scalars a solve looks for symmetries that J'J does not show: in larger problems
`free_directions` and `covariance` do. It takes a millisecond for 1000."""
_FAR = 1e5
"""Distance from the median row, relative to the median of these distances, of one that ran off."""
_FEW = 8
"""Fewest rows of a collection in which one can be far."""
_SAMPLE = 512
_WEIGHTLESS = 1e-6
"""Part of its largest information in a solve that a parameter keeps where all weights of its
residuals are 1e-3: information is in squares of weights."""


@dataclass(frozen=True)
class Note:
    """One remark on a result.

    Attributes
    ----------
    topic : ``underdetermined`` (fewer residuals than unknowns), ``free`` (directions that nothing
        determines), ``far`` (a row that ran off), ``weightless`` (a loss took all weight from the
        residuals of a parameter), ``frozen`` (parameters that the last pass did not solve for)
    message : the finding, with names
    advice : what to do about it
    """

    topic: Topic
    message: str
    advice: str

    def __str__(self) -> str:
        return self.message

    def to_dict(self) -> dict[str, str]:
        """Plain data for JSON."""
        return {"topic": self.topic, "message": self.message, "advice": self.advice}


@dataclass(frozen=True)
class Checks:
    """What the notes of a result are made from.

    Attributes
    ----------
    structural : notes on the structure of the problem
    structure : of the problem
    x : (k,) stored scalars of the solution, as `Result.x`
    information : (n,) diagonal of J'J at the end, and (n,) the largest in the solve; None without a
        loss
    """

    structural: tuple[Note, ...]
    structure: Structure
    x: NDArray[Any]
    information: tuple[Floats, Floats] | None = None

    def notes(self) -> tuple[Note, ...]:
        """All notes, the most severe first."""
        return (*self.structural, *_weightless(self), *_far(self))


# --- structure: once --------------------------------------------------------------------------


def structural_notes(
    problem: Problem, solver: LinearSolver, damping: float, determined: bool
) -> tuple[Note, ...]:
    """Notes on the numbers of residuals and unknowns, and on the rank.

    Parameters
    ----------
    problem : at its solution
    solver : of a solve
    damping : with which it factorised last; NaN if it has no factor of the whole problem
    determined : whether it is known that the cost has no symmetries
    """
    found = [*_underdetermined(problem)]
    if type(problem) is Problem and not problem.evaluation.updating:
        found += _free(problem, solver, damping, determined)
    return tuple(found)


def _underdetermined(problem: Problem) -> list[Note]:
    structure = problem.structure
    unknowns = problem.size - len(structure.system.held)
    residuals = sum(
        len(active) * group.residuals
        for active, group in zip(structure.active, problem.layout.groups, strict=True)
        if group.require != "at_least"
    )
    if residuals >= unknowns:
        return []
    return [
        Note(
            "underdetermined",
            f"{unknowns} unknowns have only {residuals} residual{'s' * (residuals != 1)}: the "
            "solution is one of many",
            "add measurements or priors, or fix parameters",
        )
    ]


def _free(problem: Problem, solver: LinearSolver, damping: float, determined: bool) -> list[Note]:
    """Free directions; those that J'J does not show only where nothing was known before."""
    grown = _growth(problem, solver, damping)
    suspicious = grown is not None
    if not suspicious and (
        determined or not looks_for_symmetries(problem) or not has_symmetries(problem)
    ):
        return []
    # imported here: start-up time
    from arael.analysis.freedom import FreeDirections
    from arael.analysis.normal import NormalEquations
    from arael.runtime.failures import SolveError

    try:
        equations = NormalEquations(problem)
        n = len(equations.free)
        basis = None if suspicious and n <= _DENSE else np.zeros((n, 0))
        directions = FreeDirections(equations, basis)
    except SolveError:
        return []
    words = [one.words for one in directions]
    if not words and suspicious and n > _DENSE:
        words = [f"one at `{problem.structure.system.name_of(grown or 0)}` and others together"]
    if not words:
        return []
    more = f"; and {len(words) - _LISTED} more" if len(words) > _LISTED else ""
    return [
        Note(
            "free",
            f"the cost is the same along {len(words)} free direction{'s' * (len(words) > 1)}: "
            f"{'; '.join(words[:_LISTED])}{more}",
            "fix as many coordinates, or add a prior or measurements; `free_directions()` lists "
            'them, and there are standard deviations for `covariance(gauge="free")` only',
        )
    ]


def looks_for_symmetries(problem: Problem) -> bool:
    """Whether a solve looks for symmetries that J'J does not show."""
    return problem.size <= _MOST and type(problem) is Problem and not problem.evaluation.updating


def extent_of(problem: Problem) -> tuple[int, ...]:
    """Number of scalars that do not move, and of the active instances of each constraint."""
    structure = problem.structure
    fixed = sum(
        int(block.free.size - np.count_nonzero(block.free)) for block in structure.system.blocks
    )
    return (fixed, *map(len, structure.active))


def has_symmetries(problem: Problem) -> bool:
    """Whether the cost of a problem of full rank may be free to turn, shift or scale."""
    layout, system = problem.layout, problem.structure.system
    if layout.required or all(group.residuals == 1 for group in layout.groups):
        return False
    # imported here: start-up time
    from arael.analysis.symmetries import symmetries

    diagonal = np.asarray(problem.evaluation.linearised()[2], dtype=np.float64)
    diagonal = diagonal[problem.diagonal_at]
    diagonal[system.held] = 1
    sigma = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    free = problem.free
    return bool(symmetries(problem, free, sigma[free], lambda: np.zeros(problem.size)))


def _growth(problem: Problem, solver: LinearSolver, damping: float) -> int | None:
    """The scalar that moves most along what seems to be free; None if nothing does."""
    if solver.plan.get("solver") == "schur_pcg":
        return None
    values = np.asarray(problem.evaluation.linearised()[2])
    if problem.layout.required:
        # imported here: start-up time
        from arael.runtime.constrained.active import add_acting

        values = add_acting(problem, values, solved=True)
    diagonal = np.array(values[problem.diagonal_at], dtype=np.float64)
    diagonal[problem.structure.system.held] = 1
    single = problem.layout.precision == "f32"
    floor = 1.2e-7 if single else 1e-12
    if not np.isfinite(diagonal).all():
        return None
    if not damping <= (1e-6 if single else _UNDAMPED):
        added = diagonal * (1 + floor)
        added[diagonal <= 0] = floor * max(float(diagonal.max(initial=0.0)), 1.0)
        failed = solver.factorise(values[: solver.pattern.value_count], added)
        if failed:
            return int(failed) - 1
    moves = np.ones(problem.size)
    moves[problem.structure.system.held] = 0
    unit = np.sqrt(np.maximum(diagonal, 0)) * moves
    z = 2 * scattered(problem.size)
    moved = np.asarray(solver.solved(z * unit), dtype=np.float64) * unit
    if not np.isfinite(moved).all():
        return int(np.argmin(np.isfinite(moved)))
    if z @ moved <= (_FREE_SINGLE if single else _FREE):
        return None
    return int(np.argmax(np.abs(moved)))


# --- a solution: when asked ---------------------------------------------------------------------


def _weightless(checks: Checks) -> list[Note]:
    """Rows whose information vanished in the solve, and that constraints with a loss read."""
    if checks.information is None:
        return []
    now, largest = checks.information
    system, layout = checks.structure.system, checks.structure.system.layout
    found: list[str] = []
    for number, (entity, blocks) in enumerate(zip(layout.entities, system.blocks, strict=True)):
        uses = [u.entity for g in layout.groups if g.loss_text for u in g.uses]
        rows = np.flatnonzero(blocks.first >= 0)
        if number not in uses or not len(rows):
            continue
        at = blocks.first[rows][:, None] + np.arange(entity.tangent)
        free = blocks.free[rows]
        ends = [np.where(free, part[at], 0.0).sum(axis=1) for part in (now, largest)]
        lost = rows[(ends[0] <= _WEIGHTLESS * ends[1]) & (ends[1] > 0)]
        found += [row_name(system.store, entity.table, int(k)) or layout.root for k in lost]
    if not found:
        return []
    return [
        Note(
            "weightless",
            f"the loss leaves the residuals of {_names(found)} a weight below 1e-3: "
            f"{'it is' if len(found) == 1 else 'they are'} not determined by what was measured",
            "start closer, begin with a wider loss in a first pass, or check the measurements",
        )
    ]


def _far(checks: Checks) -> list[Note]:
    """Rows far from all others of their collection."""
    system, layout = checks.structure.system, checks.structure.system.layout
    found: list[str] = []
    begin = 0
    for entity, blocks in zip(layout.entities, system.blocks, strict=True):
        rows = np.flatnonzero(blocks.solved & (blocks.first >= 0))
        end = begin + len(rows) * entity.stored
        values = checks.x[begin:end].reshape(len(rows), entity.stored)
        begin = end
        if len(rows) < _FEW:
            continue
        for use in entity.params:
            width = {"vec": use.stored, "real": 1, "transform": 3, "similarity": 3}.get(use.kind)
            if width is None:
                continue
            part = values[:, use.stored_start : use.stored_start + width]
            found += [
                f"{row_name(system.store, entity.table, int(rows[k]))}.{use.column}"
                for k in _outlying(np.asarray(part, dtype=np.float64))
            ]
    if not found:
        return []
    return [
        Note(
            "far",
            f"{_names(found)} {'lies' if len(found) == 1 else 'lie'} 100,000 times farther from "
            "the middle of the collection than its other rows",
            "it ran off: check its measurements, start closer, or give it a prior",
        )
    ]


def _outlying(values: Floats) -> list[int]:
    """Rows (m, k) that are far from the median row."""
    off = np.abs(values - _middle(values)).max(axis=1)
    usual = float(_middle(off))
    if not usual > 0 or off.max() <= _FAR * usual:
        return []
    return [int(k) for k in np.flatnonzero(off > _FAR * usual)]


def _middle(values: Floats) -> Floats:
    """The upper median of a sample of rows, by column; `np.median` would import `numpy.ma`."""
    sample = values[:: max(1, len(values) // _SAMPLE)]
    half = len(sample) // 2
    found: Floats = np.partition(sample, half, axis=0)[half]
    return found


def frozen_note(frozen: tuple[str, ...], name: str) -> tuple[Note, ...]:
    """The note on what the last of several passes did not solve for."""
    if not frozen:
        return ()
    return (
        Note(
            "frozen",
            f"the last pass, `{name}`, did not solve for {_names(list(frozen))}",
            "add a pass that frees it, if the solution should be a minimum for all parameters",
        ),
    )


def _names(names: list[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(f"`{name}`" for name in names[:_LISTED]) + more
