"""What a solve came to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

CONVERGED = frozenset(
    {
        "converged",
        "cost_threshold",
        "gradient_tolerance",
        "parameter_tolerance",
        "predicted_reduction",
    }
)

# Statuses that end the whole schedule, not only the pass they end.
ENDING = frozenset({"aborted", "time_limit", "observer_terminated", "driver_terminated"})


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
class Result:
    """Outcome of a solve, or of one of its passes.

    Attributes
    ----------
    status : how it ended
        ``converged`` (small steps, or nothing left but rounding), ``cost_threshold``,
        ``gradient_tolerance``, ``parameter_tolerance``, ``predicted_reduction``: solved.
        ``max_iterations``, ``time_limit``, ``driver_terminated``, ``observer_terminated``,
        ``lambda_ceiling``, ``retry_budget``, ``aborted`` (Ctrl-C): the best state so far.
    start_cost, end_cost : sums of squared residuals; of a schedule, at its very start and end
    iterations : attempts at a step, rejected ones counted
    accepted_iterations : steps taken
    x : (k,) stored scalars of every entity that was solved for, in order of the system
    final_lambda : damping at the end, a good start for a warm re-solve
    plan : what the linear solver chose and why, what that was predicted to take and what it took
    timing : seconds per phase; ``first_factor`` is the first factorisation apart
    history : one record an attempt, a structured array
        Fields: ``iteration`` (from 1), ``retry``, ``accepted``, ``factored``, ``pivot`` (scalar at
        which a factorisation failed, or -1), ``cost``, ``trial_cost`` (NaN without a step),
        ``predicted`` (reduction promised), ``damping`` (lambda in effect), ``next_damping``,
        ``step_norm``, ``gradient`` (largest entry of 2 J'r), ``seconds``.
    passes : results of the passes, in order
    name : of the pass, or of the model
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

    @property
    def cost(self) -> float:
        """Cost at the end."""
        return self.end_cost

    @property
    def converged(self) -> bool:
        """Whether the status says that the problem is solved."""
        return self.status in CONVERGED

    @property
    def seconds(self) -> float:
        """Wall time of everything, preparation and analysis included."""
        return self.timing["total"]

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
            "seconds": self.seconds,
            "plan": _plain(self.plan),
            "timing": dict(self.timing),
        }
        if self.passes:
            found["passes"] = [one.to_dict() for one in self.passes]
        return found

    def __repr__(self) -> str:
        return (
            f"<Result {self.status}: cost {self.start_cost:.6g} -> {self.end_cost:.6g}, "
            f"{self.iterations} iterations>"
        )

    def __str__(self) -> str:
        lines = [
            f"{self.status}: cost {self.start_cost:.6g} -> {self.end_cost:.6g} "
            f"in {self.iterations} iterations ({self.accepted_iterations} accepted), "
            f"{_seconds(self.seconds)}"
        ]
        if len(self.passes) > 1:
            width = max(len(one.name) for one in self.passes)
            lines += [f"  {one.name:<{width}}  {str(one).splitlines()[0]}" for one in self.passes]
        lines.append(f"  solver {self.plan}")
        phases = [
            f"{name} {_seconds(self.timing[name])}"
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
        return "\n".join(lines)


def joined(passes: list[Result], name: str) -> Result:
    """The result of a schedule from those of its passes (at least one)."""
    last = passes[-1]
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
    )


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


def _short(value: Any) -> str:
    if not isinstance(value, int | float | np.number) or value < 10_000:
        return f"{value:g}" if isinstance(value, float) else str(value)
    return f"{float(value):.2e}".replace("e+0", "e").replace("e+", "e")


def _seconds(value: float) -> str:
    if value >= 1:
        return f"{value:.2f} s"
    return f"{value * 1e3:.3g} ms" if value >= 1e-3 else f"{value * 1e6:.0f} us"
