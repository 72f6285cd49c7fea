"""The verbose trace: one line an attempt."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from arael.runtime.levenberg.diagnosis import check_linearisation, offenders
from arael.runtime.problem import Problem


class Watcher:
    """Looks on while a solve runs: checks its start, prints the trace, asks the observer.

    Parameters
    ----------
    problem : what is solved
    write : takes a line of the trace, or None
    observer : called with each record; False ends the solve
    lenient : a zero on the diagonal is no error (there is a floor under it)
    """

    def __init__(
        self,
        problem: Problem,
        write: Callable[[str], object] | None,
        observer: Callable[[Any], bool | None] | None,
        lenient: bool,
    ) -> None:
        self._problem = problem
        self._write = write
        self._observer = observer
        self._lenient = lenient

    @property
    def watches(self) -> bool:
        """Whether it wants to see each attempt."""
        return self._write is not None or self._observer is not None

    def started(self, minimiser: Any) -> None:
        """Check the first linearisation; raises SolveError."""
        if math.isfinite(minimiser.start_cost) and minimiser.vectors.sound():
            return
        diagonal = minimiser.vectors.value_array[self._problem.diagonal_at]
        if self._lenient:
            diagonal = np.where(diagonal == 0, 1, diagonal)
        gradient = minimiser.vectors.gradient_array[: self._problem.size]
        check_linearisation(self._problem, minimiser.start_cost, gradient, diagonal)

    def stepped(self, minimiser: Any, record: Any) -> bool:
        """Show one attempt; False ends the solve."""
        if self._write is not None:
            self._write(self._line(minimiser, record))
        answer = None if self._observer is None else self._observer(record)
        return answer is None or bool(answer)

    def _line(self, minimiser: Any, record: Any) -> str:
        step = round(float(record["seconds"]) * 1e6)
        head = f"{record['iteration']}/{record['retry']}: "
        if record["factored"]:
            return (
                f"{head}{shown_cost(record['cost'])}->{shown_cost(record['trial_cost'])} / "
                f"{shown_cost(record['cost'] - record['trial_cost'])}, "
                f"{_how(minimiser, record)} (step={step})"
            )
        gradient = minimiser.vectors.gradient_array[: self._problem.size]
        diagonal = minimiser.vectors.diagonal_array[: self._problem.size]
        values = minimiser.vectors.value_array[: self._problem.structure.pattern.value_count]
        counts = [
            sum(int(np.count_nonzero(~np.isfinite(a))) for a in arrays)
            for arrays in ([gradient], [diagonal], [self._problem.x], [values])
        ]
        line = (
            f"{head}Cholesky failed (damped matrix not positive-definite), "
            f"lambda={shown_lambda(record['damping'])} -> {shown_lambda(record['next_damping'])} "
            f"(step={step}) [non-finite: grad={counts[0]} diag={counts[1]} x={counts[2]} "
            f"matrix={counts[3]}] [diag<=0: {np.count_nonzero(diagonal <= 0)}]"
        )
        named = offenders(self._problem, gradient, diagonal, int(record["pivot"]))
        return "\n".join([line, *(f"    {text}" for text in named)])


def _how(minimiser: Any, record: Any) -> str:
    """What shortened the step: lambda, or the trust region and more than the least lambda."""
    lam = f"lambda={shown_lambda(record['damping'])}"
    if np.isnan(record["radius"]):
        return lam
    radius = f"radius={shown_lambda(record['radius'])}"
    return f"{radius} {lam}" if record["damping"] > minimiser.dogleg.floor else radius


def shown_cost(cost: float) -> str:
    """A cost with four decimals where they say something: ``44.5679``, ``1.3021e-7``."""
    cost = float(cost)
    if cost == 0 or 0.01 <= abs(cost) < 1e9 or not np.isfinite(cost):
        return f"{cost:.4f}"
    return short_exponent(f"{cost:.4e}")


def shown_lambda(damping: float) -> str:
    """Damping in two digits: ``2e-5``, ``1.6e-7``, ``0.01``."""
    damping = float(damping)
    if damping == 0 or 1e-3 <= damping < 1e4:
        return f"{damping:.2g}" if damping < 100 else f"{damping:.0f}"
    return short_exponent(f"{damping:.1e}").replace(".0e", "e")


def short_exponent(text: str) -> str:
    """``2e-05`` as ``2e-5``."""
    mantissa, _, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else text
