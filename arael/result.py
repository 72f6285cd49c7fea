"""What a solve came to."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.statuses import CONVERGED

if TYPE_CHECKING:
    from arael.analysis.influence import Influence
    from arael.analysis.propagation import Propagation
    from arael.analysis.sensitivities import Sensitivity
    from arael.analysis.verdict import Verdict
    from arael.certificates.certificate import Certificate
    from arael.notes import Note
    from arael.runtime.constrained.required import Required
    from arael.runtime.levenberg.outcomes import Components


class Plan(dict[str, Any]):
    """What the linear solver chose, why, and what came of it; reads as one line.

    ``predicted_ms`` is what a factorisation was predicted to take, ``measured_ms`` what it took.
    """

    def __str__(self) -> str:
        name = self.get("solver", self.get("name", "?"))
        facts = []
        for key, text in (("n", "n"), ("nnz_l", "nnz(L)"), ("flops", "flops")):
            if key in self:
                facts.append(f"{text} {_short(self[key])}")
        line = f"{name} ({', '.join(facts)})" if facts else str(name)
        if self.get("why"):
            line += f": {self['why']}"
        return f"{line}; it took {self['measured_ms']:.3g} ms" if "measured_ms" in self else line


@dataclass(frozen=True, repr=False)
class Result(Displayed):
    """Outcome of a solve, or of one of its passes.

    Attributes
    ----------
    status : how it ended
        ``converged`` (the linear model predicts no noticeable decrease), ``cost_threshold``,
        ``gradient_tolerance``, ``parameter_tolerance``, ``predicted_reduction``: solved.
        ``stalled`` (a decrease is predicted, but no step however short brings one, as at a jump of
        the cost), ``max_iterations``, ``time_limit``, ``driver_terminated``,
        ``observer_terminated``, ``lambda_ceiling``, ``retry_budget``, ``aborted`` (Ctrl-C): the
        best state so far.
        Where connected components were solved separately, ``converged`` if all are solved, else the
        worst of their statuses; see `components`.
        ``infeasible``: what is required (`require`, bounds) cannot hold together, as far as a
        search from the start shows; `conflict` names a minimal set.
    start_cost, end_cost : sums of squared residuals; of a schedule, at its very start and end
    iterations : attempts, including rejected ones
        If components are solved separately, attempts of the whole solve: at least the largest
        number of attempts of a component.
    accepted_iterations : accepted steps
    x : (k,) stored scalars of every entity with free parameters, in order of the system
    final_lambda : damping at the end, a good start for a warm re-solve
        Of the dogleg, its regularisation: the multiple of the largest diagonal so far that was
        added to J'J.
    plan : the chosen linear solver, the reason, and its predicted and measured times
    timing : seconds per phase; ``first_factor`` is the first factorisation apart
    history : one record per attempt, a structured array
        Fields: ``iteration`` (from 1), ``retry``, ``accepted``, ``factored``, ``pivot`` (scalar at
        which a factorisation failed, or -1), ``cost``, ``trial_cost`` (NaN without a step),
        ``predicted`` (decrease predicted for the step), ``promise`` (decrease predicted for the
        step before trust region and bounds restrict it), ``radius`` (of the trust region, in scaled
        variables; NaN where there is none), ``damping`` (lambda in effect, or regularisation),
        ``next_damping``, ``step_norm``, ``gradient`` (largest entry of 2 J'r), ``seconds``.
    passes : results of the passes, in order
    name : of the pass, or of the model
    predicted_decrease : decrease of the cost that the last linearisation that was factorised
        predicts for its undamped step, ``g' (J'J)^-1 g``; where steps were damped, that of the
        least damped one, which is a lower bound. NaN if there was no step. Where the factor before
        showed the end, of the last linearisation with that factor, before the step at the end.
    gradient_norm : ``sqrt(sum_i g_i^2 / (J'J)_ii)`` with ``g = J'r``, at the last linearisation
        In the unit of residuals: its square bounds the decrease by moving one parameter alone.
    noise_floor : rounding noise of the cost at the last linearisation, estimated
        From the machine precision, the cost and the terms of the residuals. Smaller changes of the
        cost are not significant.
    required : values, multipliers and violation of what is required, by label; None without any
    frozen : paths of parameters that the pass froze, or `freeze` did: ``poses.ea``
    components : status of each connected component of the problem
        A table `arael.runtime.levenberg.outcomes.Components`; None if the problem has only one,
        or was solved as one. Of a schedule that of its last pass.
    """

    status: str
    start_cost: float
    end_cost: float
    iterations: int
    accepted_iterations: int
    x: NDArray[np.float64]
    final_lambda: float
    plan: Plan
    timing: Mapping[str, float]
    history: NDArray[Any]
    passes: tuple[Result, ...] = field(default=())
    name: str = ""
    predicted_decrease: float = math.nan
    gradient_norm: float = math.nan
    noise_floor: float = math.nan
    components: Components | None = None
    frozen: tuple[str, ...] = ()
    checks: Any = field(default=None, repr=False, compare=False)
    required: Required | None = None

    @property
    def notes(self) -> tuple[Note, ...]:
        """Remarks on a result whose numbers mean less than they seem: `arael.Note`.

        Fewer residuals than unknowns, free directions, rows that ran off, residuals that a loss
        left no weight, parameters that the last pass froze. Empty if there is nothing to say.
        """
        found = self.checks
        if found is None:
            return ()
        notes: tuple[Note, ...] = found if isinstance(found, tuple) else found.notes()
        object.__setattr__(self, "checks", notes)
        return notes

    def __getstate__(self) -> dict[str, Any]:
        kept = {
            k: v for k, v in self.__dict__.items() if k not in ("model", "solution", "certified")
        }
        return {**kept, "checks": self.notes}

    @property
    def multipliers(self) -> Mapping[str, NDArray[np.float64]]:
        """What each `require` costs, by label: (n, m) by instance and row, ``1/unit`` of the row.

        By how much the cost would fall, to first order, for each unit by which the right-hand side
        were relaxed: lowered for ``>=``, raised for ``<=``; zero where an inequality does not act.
        Of an equality by how much it would fall if the right-hand side were raised.
        """
        return {} if self.required is None else self.required.multipliers()

    @property
    def conflict(self) -> tuple[str, ...]:
        """Of an infeasible problem, a minimal set of what cannot hold together.

        Instances (``Pose.clearance at poses[3]``) and bounds (``q.x >= 0``). Without any one of
        them the others can hold, which was tried.
        """
        return () if self.required is None else self.required.conflict

    @property
    def violation(self) -> float:
        """Largest violation of what is required, relative to the scale of its row."""
        return 0.0 if self.required is None else self.required.violation

    @property
    def cost(self) -> float:
        """Cost at the end."""
        return self.end_cost

    @property
    def converged(self) -> bool:
        """Whether the status is one of a solved problem."""
        return self.status in CONVERGED

    @property
    def seconds(self) -> float:
        """Wall time of everything, preparation and analysis included."""
        return self.timing["total"]

    def sensitivity(
        self, of: str, to: str | Iterable[str] | None = None, exact: bool = False
    ) -> Sensitivity:
        """Derivatives of a solved quantity by data, constants, fixed parameters and active bounds.

        By the implicit function theorem, with one solve for each scalar of the quantity however
        much data there is. The model must have the values of this solve.

        Parameters
        ----------
        of : a scalar (``"cam.f"``, ``"poses[3].pos.x"``), a parameter or a row, whose scalars are
            taken together, or a formula over the model (``"norm(poses[3].pos)"``)
        to : path of a column (``"views.uv"``, ``"board.square"``), of what contains columns, name
            of a constant, or several of these; None: everything but constants. A parameter stands
            for what is fixed or frozen of it, ``"k.low"`` and ``"k.high"`` for a bound it is on
        exact : False: with the Hessian of Gauss-Newton, which leaves out terms in which residuals
            multiply second derivatives; True: with all terms

        Raises
        ------
        SolveError
            E1008: directions are free; they are named.
        AraelError
            E1060: no such path, a model that was changed, no strict minimum, or a constant by which
            no derivative is taken.
        """
        found: Sensitivity = self._solution().sensitivity(of, to, exact)
        return found

    @property
    def certificate(self) -> Certificate:
        """Whether this is the global optimum; of models that are quadratic in rotations.

        Of pose graphs, landmarks, points seen from poses, hand and eye: residuals that are linear
        in rotation matrices and positions, after a turn that their norm does not see. Where the
        model's own error of a rotation is an angle, or a weight is not the same in all directions,
        it is that of the chordal twin of the model. Read anew from the model at the first access.

        Raises
        ------
        AraelError
            E1060: the model has other values now; E1061: there is none of this model.
        """
        found: Certificate | None = self.__dict__.get("certified")
        if found is None:
            found = self.__dict__["certified"] = self._model()._certificate(self)
        return found

    def escape(self, **settings: Any) -> Result:
        """Leave a minimum that is not certified along the direction of descent, and solve again.

        By the Riemannian staircase; of hand and eye by the rotations nearest to the relaxation. The
        model is solved from the lower minimum with `settings` of `arael.Model.solve`; a certified
        result is returned as it is.

        Raises
        ------
        AraelError
            As `certificate`.
        """
        found: Result = self._model()._escaped(self, settings)
        return found

    def _solution(self) -> Any:
        return self._model()._solution(self)

    def _model(self) -> Any:
        model = self.__dict__.get("model")
        if model is None:
            raise AraelError(
                Diagnostic(
                    "E1060",
                    "this result has no model: it comes from another process, or is of one pass",
                    origin="result",
                    help=("ask the result that `model.solve()` returned",),
                )
            )
        return model

    def propagate(
        self,
        uncertain: Mapping[str, Any],
        of: str | Iterable[str] | None = None,
        exact: bool = False,
    ) -> Propagation:
        """Covariance of the solution with errors of data, of constants, of fixed parameters.

        The covariance of `arael.Model.covariance` counts the errors that the residuals are whitened
        by, and takes all else as exact. What the errors of `uncertain` add to it, independent of
        these, is given separately ("consider covariance").

        Parameters
        ----------
        uncertain : standard deviations by path, ``{"board.square": 1e-3}``: one number for all
            entries of a column, which are independent, or an array of its shape
        of : parameters or formulas as in `sensitivity`, or several; None: all scalars, if they are
            not more than 300
        exact : as in `sensitivity`

        Raises
        ------
        SolveError, AraelError
            As `sensitivity`; E1060 also for standard deviations that do not fit.
        """
        found: Propagation = self._solution().propagate(uncertain, of, exact)
        return found

    def influence(self, of: str | None = None, scale: str = "known") -> Influence:
        """Leverage and Cook's distance of each observation, and those that decide a scalar.

        Parameters
        ----------
        of : a scalar, or a formula with one value; None: no scalar
        scale : as of `arael.Model.covariance`, for Cook's distance

        Raises
        ------
        SolveError, AraelError
            As `sensitivity`; E1035 an unknown scale.
        """
        found: Influence = self._solution().influence(of, scale)
        return found

    def verdict(self) -> Verdict:
        """Judge the solved model at its current values; see `arael.Model.verdict`."""
        found: Verdict = self._model().verdict()
        return found

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: no arrays."""
        found: dict[str, Any] = {
            "name": self.name,
            "status": self.status,
            "start_cost": self.start_cost,
            "end_cost": self.end_cost,
            "iterations": self.iterations,
            "accepted_iterations": self.accepted_iterations,
            "final_lambda": self.final_lambda,
            "predicted_decrease": _number(self.predicted_decrease),
            "gradient_norm": _number(self.gradient_norm),
            "noise_floor": _number(self.noise_floor),
            "seconds": self.seconds,
            "plan": _plain(self.plan),
            "timing": dict(self.timing),
        }
        if self.required is not None:
            found["required"] = self.required.to_dict()
        if self.notes:
            found["notes"] = [one.to_dict() for one in self.notes]
        if self.frozen:
            found["frozen"] = list(self.frozen)
        if self.passes:
            found["passes"] = [one.to_dict() for one in self.passes]
        elif self.components is not None:
            found["components"] = self.components.to_dict()
        return found

    def _left(self) -> str:
        """What a solve that has not converged may still gain, as the end of a line."""
        if self.converged or not math.isfinite(self.predicted_decrease):
            return ""
        if len(self.history) and self.history["accepted"][-1]:
            # Of the state before that step: at the end itself nothing was factorised.
            return (
                f"; before the last step a decrease of {self.predicted_decrease:.3g} was predicted"
            )
        left = f"a further decrease of {self.predicted_decrease:.3g} is predicted"
        if self.end_cost > 0:
            left += f" ({100 * self.predicted_decrease / self.end_cost:.3g} % of the cost)"
        return f"; {left}"

    def _sheet(self) -> Sheet:
        first, *rest = str(self).splitlines()
        passes = self.passes if len(self.passes) > 1 else ()
        rows = [
            (
                one.name,
                one.status,
                f"{one.start_cost:.6g}",
                f"{one.end_cost:.6g}",
                str(one.iterations),
                seconds_text(one.seconds),
            )
            for one in passes
        ]
        head = ("pass", "status", "start cost", "end cost", "iterations", "time")
        return Sheet(first, head, rows, [line.strip() for line in rest[len(rows) :]])

    def __repr__(self) -> str:
        return (
            f"<Result {self.status}: cost {self.start_cost:.6g} -> {self.end_cost:.6g}, "
            f"{self.iterations} iterations>"
        )

    def _line(self) -> str:
        """Status, cost, iterations and time."""
        return (
            f"{self.status}: cost {self.start_cost:.6g} -> {self.end_cost:.6g} "
            f"in {self.iterations} iterations ({self.accepted_iterations} accepted), "
            f"{seconds_text(self.seconds)}{self._left()}"
        )

    def __str__(self) -> str:
        lines = [self._line()]
        if len(self.passes) > 1:
            width = max(len(one.name) for one in self.passes)
            lines += [
                f"  {one.name:<{width}}  {one._line()}{_frozen_text(one.frozen)}"
                for one in self.passes
            ]
        elif self.components is not None:
            lines.append(f"  {self.components.summary()}")
        if self.required is not None:
            lines += [f"  {line}" for line in self.required.sentences(self.cost)]
        lines.append(f"  solver {self.plan}")
        phases = [
            f"{name} {seconds_text(self.timing[name])}"
            for name in (
                "prepare",
                "analyse",
                "first_factor",
                "linearise",
                "factor",
                "solve",
                "cost",
            )
            if name in self.timing
        ]
        lines.append(f"  time   {', '.join(phases)}")
        lines += [f"  note   {one.message}\n         {one.advice}" for one in self.notes]
        return "\n".join(lines)


def _frozen_text(frozen: tuple[str, ...]) -> str:
    return f"; frozen: {', '.join(frozen)}" if frozen else ""


def joined(passes: list[Result], name: str) -> Result:
    """The result of a schedule from those of its passes (at least one)."""
    last = passes[-1]
    if len(passes) == 1:
        whole = object.__new__(Result)  # a copy; the constructor takes twice as long
        whole.__dict__.update(last.__dict__, passes=(last,), name=name)
        return whole
    timing = {key: sum(one.timing[key] for one in passes) for key in last.timing}
    return Result(
        last.status,
        passes[0].start_cost,
        last.end_cost,
        sum(one.iterations for one in passes),
        sum(one.accepted_iterations for one in passes),
        last.x,
        last.final_lambda,
        last.plan,
        timing,
        np.concatenate([one.history for one in passes]),
        tuple(passes),
        name,
        last.predicted_decrease,
        last.gradient_norm,
        last.noise_floor,
        last.components,
        last.frozen,
        last.checks,
        last.required,
    )


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


def _number(value: float) -> float | None:
    """A number, or None for one that JSON has no form for."""
    return float(value) if math.isfinite(value) else None


def _short(value: Any) -> str:
    if not isinstance(value, int | float | np.number) or value < 10_000:
        return f"{value:g}" if isinstance(value, float) else str(value)
    return f"{float(value):.2e}".replace("e+0", "e").replace("e+", "e")


def seconds_text(value: float) -> str:
    """A duration with its unit."""
    if value >= 1:
        return f"{value:.2f} s"
    return f"{value * 1e3:.3g} ms" if value >= 1e-3 else f"{value * 1e6:.0f} us"
