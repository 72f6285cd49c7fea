"""The loop of a solve with exact rows: sequential quadratic programming on Gauss-Newton blocks.

With ``f = |r|^2 / 2`` and rows c, each step solves the quadratic problem of `quadratic.py` at the
state: ``H = J'J`` of the cost and the second derivatives of the rows times their multipliers (and
of the residuals, where Gauss-Newton converges slowly), damped where that is not positive definite
along the rows or where the last step failed. A step is accepted if it lowers the exact penalty
function ``f + sum_i nu_i v_i`` of the violations v as promised, if necessary after a second-order
correction. J. Nocedal, S. Wright, "Numerical Optimization", 2nd ed., 2006, chapter 18.

Where the linear rows contradict each other, steps lower the violations alone, until they can be
removed, or are at a minimum: then the problem is infeasible there.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arael.config import LmConfig
from arael.diagnostics.records import Diagnostic
from arael.runtime.constrained.limits import Limits
from arael.runtime.constrained.quadratic import WEIGHT, Quadratic, Step
from arael.runtime.constrained.rows import Floats, Rows
from arael.runtime.failures import SolveError, listed
from arael.runtime.levenberg.compiled import RECORD
from arael.runtime.levenberg.diagnosis import check_linearisation
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.problem import Problem


@dataclass(frozen=True)
class Tolerances:
    """What counts as exact, by precision of the model.

    Attributes
    ----------
    rows : of rows, relative to their scale
    optimal : of the first-order conditions, relative to the residuals
    noise : rounding of the cost, relative
    """

    rows: float
    optimal: float
    noise: float


F64 = Tolerances(1e-9, 1e-8, 1e-15)
F32 = Tolerances(2e-5, 2e-3, 1e-6)

# Rejections in a row after which violations alone are lowered, or the solve has stalled.
MAX_DAMPING = 1e10
FIRST_DAMPING = 1e-4
# Convergence of Gauss-Newton slower than this per step takes second derivatives of residuals too.
SLOW = 0.2
# More colours than this make second derivatives of the residuals more expensive than more steps.
MAX_COLOURS = 64


@dataclass
class Linearisation:
    """What is known at the accepted state."""

    cost: float  # f
    gradient: Floats
    values: Floats
    diagonal: Floats  # of the cost alone
    metric: Floats  # positive diagonal by which steps are measured
    rows: Floats
    entries: Floats
    lengths: Floats
    weights: Floats
    violations: Floats
    sizes: Floats  # of the scalars


@dataclass
class Loop:
    """A solve of `problem`; `run` returns its status.

    Attributes
    ----------
    multipliers : (rows,) of f, at the end
    scale : (rows,) magnitude of the terms of each row, the largest so far
    reach : part of the violations that a step is to remove, less than 1 where rows are too curved
    """

    problem: Problem
    limits: Limits
    solver: LinearSolver
    config: LmConfig
    stepped: Callable[[Any], bool] | None = None
    multipliers: Floats = field(default_factory=lambda: np.zeros(0))
    attempts: int = 0
    accepted: int = 0
    factorisations: int = 0
    damping: float = 0.0
    reach: float = 1.0
    start_cost: float = math.nan
    records: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.states = self.limits.states
        self.tolerances = F32 if self.problem.layout.precision == "f32" else F64
        count = self.limits.count
        self.multipliers = np.zeros(count)
        self.scale = np.zeros(count)
        self.penalties = np.zeros(count)
        self.worst = math.inf
        self.optimality = math.inf
        self.residuals: Rows | None = None
        self.second_order = False
        self._began = self._last = time.perf_counter()
        self._workspace = self.problem.evaluation.workspace()

    # --- the loop ----------------------------------------------------------------------------

    def run(self) -> str:
        """Solve; the accepted state of the problem is the best one found."""
        here = self.linearise()
        self.start_cost = 2.0 * here.cost
        self._check(here)
        retry = 0
        curved = True
        last_optimality = math.inf
        quiet = 0
        while True:
            ended = self._ended(here)
            if ended:
                return ended
            hessian = self._hessian(here, curved)
            step = self._quadratic(here, hessian).solve(
                self._aim(here.rows), self.multipliers, self._tolerance()
            )
            if step is None:
                if curved and self._has_curvature():
                    curved = False
                elif not self._raise():
                    return self._restored(here) or "stalled"
                continue
            if not step.holds and self._feasible(here.violations):
                if not self._raise():  # rows contradict each other within their tolerance
                    return "stalled"
                continue
            if not step.holds:
                status = self._restored(here)
                if status:
                    return status
                here, retry = self.linearise(), 0
                continue
            self.optimality = self._optimality(here, step.multipliers)
            feasible = self._feasible(here.violations)
            if feasible and self.optimality <= 1.0:
                self.multipliers = step.multipliers
                self._polish(here, step)
                self.limits.settle(self.multipliers, self._tolerance())
                return "converged"
            y = 1.5 * np.abs(step.multipliers)
            # Where multipliers are small, violations still count like the cost of removing them.
            least = here.weights / WEIGHT * here.violations
            self.penalties = np.maximum(np.maximum(y, least), 0.5 * (self.penalties + y))
            outcome, there = self._attempt(here, hessian, step, retry)
            if outcome == "ended":
                return "observer_terminated"
            if outcome == "rejected":
                retry += 1
                if curved and self._has_curvature() and self.damping > 1e-2:
                    curved = False
                if not self._raise():
                    return self._restored(here) or "stalled"
                continue
            assert there is not None
            self.multipliers = step.multipliers
            slow = self.optimality > SLOW * last_optimality and feasible
            if (slow or retry > 2) and not self.second_order:
                self.second_order = self._takes_second_order()
            quiet = quiet + 1 if outcome == "noise" else 0
            if quiet > 8:
                return "stalled"
            last_optimality = self.optimality
            here, retry, curved = self.linearise(), 0, True

    def _check(self, here: Linearisation) -> None:
        """Raise SolveError if a solve cannot start here: E1001-E1004, E1019."""
        limits, problem = self.limits, self.problem
        fixed = np.bincount(limits.rows.row, minlength=limits.count) == 0
        fixed[limits.rows.count :] = False
        noise = 1e-9 * np.abs(here.rows).max(initial=1.0)
        false = np.flatnonzero(fixed & (here.violations > noise))
        if len(false):
            raise _never(limits, here, false)
        finite = np.isfinite(here.rows).all() and np.isfinite(here.entries).all()
        squares = limits.transposed(here.entries**2, np.ones(limits.count))
        check_linearisation(
            problem,
            2.0 * here.cost if finite else math.nan,
            here.gradient,
            np.where(here.diagonal > 0, here.diagonal, here.diagonal + np.abs(squares))
            + self.config.min_diagonal,
        )

    def _ended(self, here: Linearisation) -> str:
        config = self.config
        if self.attempts >= config.max_iters:
            return "max_iterations"
        limit = config.time_limit
        if limit is not None and time.perf_counter() - self._began >= limit:
            return "time_limit"
        low = 2.0 * here.cost <= config.cost_threshold != 0.0
        return "cost_threshold" if low and self._feasible(here.violations) else ""

    def linearise(self) -> Linearisation:
        """Evaluate cost, rows and derivatives at the accepted state."""
        problem, limits = self.problem, self.limits
        cost, gradient, values = problem.evaluation.linearised(self._workspace)
        gradient = np.array(gradient, dtype=np.float64)
        values = np.array(values, dtype=np.float64)
        diagonal = values[problem.diagonal_at]
        moving = np.zeros(problem.size, dtype=bool)
        moving[problem.free] = True
        own = diagonal[moving]
        largest = float(own.max(initial=0.0))
        largest = largest if largest > 0.0 else 1.0
        # What the cost does not depend on must not move for nothing: rows may be curved along it.
        metric = np.maximum(diagonal, np.where(diagonal > 0.0, 1e-8, 1e-2) * largest)
        metric[~moving] = 1.0
        rows, entries = limits.evaluate()
        lengths = limits.lengths(entries, np.ones(problem.size))
        sizes = self.states.sizes()
        typical = float(sizes.max(initial=0.0)) or 1.0
        scale = limits.lengths(entries, np.maximum(sizes, 1e-6 * typical))
        self.scale = np.maximum(self.scale, scale)
        along = limits.lengths(entries, np.sqrt(metric))
        safe = np.where(lengths > 0, lengths, 1.0)
        weights = np.where(lengths > 0, WEIGHT * (along / safe) ** 2 / safe**2, 1.0)
        return Linearisation(
            0.5 * float(cost),
            gradient,
            values,
            diagonal,
            metric,
            rows,
            entries,
            lengths,
            weights,
            limits.violations(rows),
            sizes,
        )

    def _tolerance(self) -> Floats:
        return self.tolerances.rows * np.maximum(self.scale, 1e-300)

    def _aim(self, rows: Floats) -> Floats:
        """Rows with the violations that a step is to remove."""
        if self.reach == 1.0:
            return rows
        return np.where(self.limits.equal | (rows < 0.0), self.reach * rows, rows)

    def _feasible(self, violations: Floats) -> bool:
        return bool((violations <= self._tolerance()).all())

    def _has_curvature(self) -> bool:
        return self.second_order or bool(self.multipliers.any() and self.limits.rows.is_curved)

    def _hessian(self, here: Linearisation, curved: bool) -> tuple[Floats, Floats]:
        """Values and diagonal of the Hessian of the Lagrangian, or of Gauss-Newton's part of it."""
        values, diagonal = here.values, here.diagonal
        if not (curved and self._has_curvature()):
            return values, diagonal
        values = values.copy()
        rows = self.limits.rows
        sizes = np.maximum(here.sizes, 1e-2)
        y = self.multipliers[: rows.count]
        if y.any() and rows.is_curved:
            values += rows.curvature(-y, here.entries, sizes, self.states.moved)
        if self.second_order and self.residuals is not None:
            residuals, entries = self.residuals.evaluate()
            values += self.residuals.curvature(residuals, entries, sizes, self.states.moved)
        diagonal = values[self.problem.diagonal_at]
        return values, diagonal

    def _takes_second_order(self) -> bool:
        problem = self.problem
        if problem.hooks is not None or problem.layout.precision == "f32":
            return False
        groups = [n for n, group in enumerate(problem.layout.groups) if not group.require]
        self.residuals = Rows(problem, groups)
        return 0 < len(self.residuals._colours) <= MAX_COLOURS

    def _quadratic(self, here: Linearisation, hessian: tuple[Floats, Floats]) -> Quadratic:
        values, diagonal = hessian
        damped = diagonal + max(self.damping, 1e-12) * here.metric
        return Quadratic(
            self.limits, self.solver, here.entries, values, damped, here.gradient, here.weights
        )

    def _optimality(self, here: Linearisation, y: Floats) -> float:
        """The first-order conditions, relative to their tolerance: at most 1 where they hold."""
        limits = self.limits
        root = np.sqrt(here.metric)
        forces = np.abs(limits.transposed(np.abs(here.entries), np.abs(y)))
        left = np.abs(here.gradient - limits.transposed(here.entries, y)) / root
        scale = max(math.sqrt(2.0 * here.cost), float((forces / root).max(initial=0.0)))
        sizes = here.sizes
        floor = 1e-13 if self.tolerances is F64 else 1e-5
        tolerance = max(
            self.tolerances.optimal * scale,
            floor * math.sqrt(float(here.metric @ sizes**2)),
            1e-300,
        )
        slack = np.where(limits.equal, 0.0, y * np.maximum(here.rows, 0.0))
        weight = 2.0 * here.cost + float(np.abs(y) @ self.scale)
        complementarity = float(slack.sum()) / max(self.tolerances.optimal * weight, 1e-300)
        return max(float(left.max(initial=0.0)) / tolerance, complementarity)

    # --- attempts ----------------------------------------------------------------------------

    def _merit(self, cost: float, violations: Floats) -> float:
        return cost + float(self.penalties @ violations)

    def _attempt(
        self, here: Linearisation, hessian: tuple[Floats, Floats], step: Step, retry: int
    ) -> tuple[str, Floats | None]:
        """Try a step; ``accepted``, ``noise`` (within rounding), ``rejected`` or ``ended``."""
        limits = self.limits
        before = self._merit(here.cost, here.violations)
        noise = self.tolerances.noise * (here.cost + float(self.penalties @ self.scale))
        saved = self.states.saved()
        d = step.step
        product = limits.product(*hessian, d)
        left = limits.violations(here.rows + limits.times(here.entries, d))
        promise = -float(here.gradient @ d) - 0.5 * float(d @ product)
        promise += float(self.penalties @ (here.violations - left))
        trial = self._moved(d)
        if trial is not None and self._enough(before, trial, promise, noise):
            return self._accept(here, d, promise, trial, noise, retry), d
        if trial is not None and promise > noise:
            corrected = self._corrected(here, hessian, step, trial[2])
            if corrected is not None:
                self.states.back(saved)
                again = self._moved(corrected)
                if again is not None and self._enough(before, again, promise, noise):
                    return self._accept(here, corrected, promise, again, noise, retry), corrected
        self.states.back(saved)
        cost = math.nan if trial is None else 2.0 * trial[0]
        return self._record(here, d, promise, cost, False, retry) or "rejected", None

    def _enough(
        self, before: float, trial: tuple[float, Floats, Floats], promise: float, noise: float
    ) -> bool:
        after = self._merit(trial[0], trial[1])
        if promise <= 10.0 * noise:
            return abs(promise) <= 10.0 * noise and after <= before + 100.0 * noise
        return before - after >= 1e-4 * promise - noise

    def _accept(
        self,
        here: Linearisation,
        d: Floats,
        promise: float,
        trial: tuple[float, Floats, Floats],
        noise: float,
        retry: int,
    ) -> str:
        gain = self._merit(here.cost, here.violations) - self._merit(trial[0], trial[1])
        self.accepted += 1
        if gain > 0.25 * promise:
            self.reach = min(1.0, 4.0 * self.reach)
        if self.damping > 0.0 and gain > 0.25 * promise:
            self.damping *= 0.1 if gain > 0.75 * promise else 0.4
            if self.damping < 1e-9:
                self.damping = 0.0
        ended = self._record(here, d, promise, 2.0 * trial[0], True, retry)
        return ended or ("noise" if promise <= 10.0 * noise else "accepted")

    def _moved(self, step: Floats) -> tuple[float, Floats, Floats] | None:
        """Move; cost, violations and rows there, None if they are not finite."""
        self.attempts += 1
        problem = self.problem
        problem.evaluation.moved_by(step)
        cost = 0.5 * float(problem.evaluation.total_cost())
        rows, _ = self.limits.evaluate()
        if not (math.isfinite(cost) and np.isfinite(rows).all()):
            return None
        return cost, self.limits.violations(rows), rows

    def _corrected(
        self, here: Linearisation, hessian: tuple[Floats, Floats], step: Step, rows: Floats
    ) -> Floats | None:
        """The step with the rows as they turned out, a second-order correction."""
        linear = self.limits.times(here.entries, step.step)
        found = self._quadratic(here, hessian).solve(
            self._aim(rows) - linear, step.multipliers, self._tolerance()
        )
        return None if found is None or not found.holds else found.step

    def _polish(self, here: Linearisation, step: Step) -> None:
        """Take the last step too, if it does not raise violations or cost."""
        saved = self.states.saved()
        trial = self._moved(step.step)
        self.attempts -= 1
        worse = trial is None or (
            (trial[1] > np.maximum(here.violations, 0.1 * self._tolerance())).any()
            or trial[0]
            > here.cost
            + float(np.abs(step.multipliers) @ here.violations)
            + self.tolerances.noise * here.cost
        )
        if worse:
            self.states.back(saved)

    def _raise(self) -> bool:
        """More damping; False if there is no more."""
        self.reach *= 0.3
        self.damping = max(FIRST_DAMPING, 10.0 * self.damping)
        return self.damping <= MAX_DAMPING

    def _record(
        self,
        here: Linearisation,
        d: Floats,
        promise: float,
        cost: float,
        accepted: bool,
        retry: int,
    ) -> str:
        now = time.perf_counter()
        record = np.zeros((), dtype=RECORD)
        record["iteration"], record["retry"] = self.accepted + (not accepted), retry
        record["accepted"], record["factored"], record["pivot"] = accepted, 1, -1
        record["cost"], record["trial_cost"] = 2.0 * here.cost, cost
        record["predicted"] = record["promise"] = 2.0 * promise
        record["radius"] = math.nan
        record["damping"] = record["next_damping"] = self.damping
        record["step_norm"] = math.sqrt(float(d @ d))
        record["gradient"] = 2.0 * float(np.abs(here.gradient).max(initial=0.0))
        record["seconds"], self._last = now - self._last, now
        self.records.append(record)
        if self.stepped is not None and not self.stepped(record):
            return "ended"
        return ""

    # --- violations alone --------------------------------------------------------------------

    def _restored(self, here: Linearisation) -> str:
        """Lower the violations until all rows hold; else the status of the end."""
        self.damping, self.reach = 0.0, 1.0
        status = self.lower(here, np.ones(self.limits.count), 1e-2)
        self.multipliers = np.zeros(self.limits.count)
        self.penalties = np.zeros(self.limits.count)
        return status

    def lower(self, here: Linearisation, counted: Floats, enough: float = 0.0) -> str:
        """Make the squares of the violations least, by Levenberg's method.

        Parameters
        ----------
        counted : (rows,) factors of their weights; 0 leaves a row out
        enough : part of the weighted squares at which to stop

        Returns
        -------
        "" where the rows hold, or enough was gained; else ``infeasible``, or why it ended
        """
        limits = self.limits
        damping, first, curved = 1e-6, math.nan, True
        zero = np.zeros(limits.count)
        while True:
            some = counted > 0.0
            if self._feasible(np.where(some, here.violations, 0.0)):
                return ""
            ended = self._ended(here)
            if ended:
                return ended
            weights = counted * here.weights / WEIGHT
            total = 0.5 * float(weights @ here.violations**2)
            first = total if math.isnan(first) else first
            if total <= enough * first:
                return ""
            values = np.zeros_like(here.values)
            if curved and limits.rows.is_curved:
                # Where rows stay violated, their curvature decides how far a step may go.
                pull = weights * np.where(limits.equal, here.rows, np.minimum(here.rows, 0.0))
                values += limits.rows.curvature(
                    pull[: limits.rows.count],
                    here.entries,
                    np.maximum(here.sizes, 1e-2),
                    self.states.moved,
                )
            quadratic = Quadratic(
                limits,
                self.solver,
                here.entries,
                values,
                values[self.problem.diagonal_at] + damping * here.metric,
                np.zeros_like(here.gradient),
                weights,
            )
            found = quadratic.minimum(here.rows, zero)
            if found is None:
                damping, curved = damping if curved else 10.0 * damping, False
                continue
            d, t = found
            promise = total - 0.5 * float(weights @ limits.violations(t) ** 2)
            if promise <= 1e-12 * total or damping > MAX_DAMPING:
                return "infeasible"
            saved = self.states.saved()
            trial = self._moved(d)
            after = math.inf if trial is None else 0.5 * float(weights @ trial[1] ** 2)
            accepted = total - after >= 1e-4 * promise
            cost = math.nan if trial is None else 2.0 * trial[0]
            if accepted:
                self.accepted += 1
            else:
                self.states.back(saved)
            if self._record(here, d, promise, cost, accepted, 0):
                return "observer_terminated"
            if accepted:
                damping = max(1e-9, 0.1 * damping if total - after > 0.5 * promise else damping)
                here, curved = self.linearise(), True
            else:
                damping *= 10.0


def _never(limits: Limits, here: Linearisation, false: Any) -> SolveError:
    """E1019 for rows that nothing that moves can change, and that do not hold."""
    at = int(false[0])
    group = limits.problem.layout.groups[int(limits.rows.group_of[at])]
    names = list(dict.fromkeys(limits.name(int(k)) for k in false))
    return SolveError(
        Diagnostic(
            "E1019",
            f"{listed(names)} {'does' if len(names) == 1 else 'do'} not hold, and no parameter "
            "that moves can change that",
            origin=group.where,
            notes=(f"`{group.require_text}` is off by {here.violations[at]:.6g}",),
            help=("correct the data, free a parameter that it reads, or give it a guard",),
        )
    )
