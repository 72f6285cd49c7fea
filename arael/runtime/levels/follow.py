"""Continuation: from one value of data to another, keeping to one branch of solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import Levels
from arael.runtime.levels.outcome import Outcome

Array = NDArray[np.float64]


def follow(
    levels: Levels,
    x: Array,
    set_data: Callable[[float], None],
    tolerance: Any = 1e-10,
    *,
    first: float = 1.0,
    least: float = 1e-4,
    furthest: float = np.inf,
    may_pass: Callable[[int], bool] | None = None,
    **options: Any,
) -> Outcome:
    """Move data from old to new in as many steps as it takes, solving after each of them.

    Each step starts where the secant through the last two solutions leads, unless a guard changes
    its sign on the way there: the solver keeps the signs of where it starts. A step is halved where
    the solver fails or moves further than allowed, and doubled after a success. Predictor and
    corrector as in E. Allgower, K. Georg, "Introduction to Numerical Continuation Methods", 2003,
    chapter 2, with the fraction of the way as parameter: a path that turns back ends at its turning
    point.

    Parameters
    ----------
    levels : Levels
        The solver; its exact rows depend on the data.
    x : (n,) float64
        Solution for the old data, changed in place: on return the solution for the data at the
        fraction that was reached, to which `set_data` was called last.
    set_data : callable
        ``set_data(t)`` sets the data at the fraction t of the way, 0 to 1.
    tolerance, options
        As of `Levels.solve`.
    first, least : float
        Fraction of the first step, and of the shortest.
    furthest : float
        Distance that no unknown may move in one step: what is allowed to look continuous.
    may_pass : callable, optional
        ``may_pass(guard)``: whether a secant may change the sign of a guard; none without.

    Returns
    -------
    Outcome
        Its `fraction` is 1 if the new data were reached; else `status` and `row` say what
        stopped the way there.
    """
    done, step = 0.0, min(first, 1.0)
    slope: Array | None = None
    failure: Outcome | None = None
    steps = 0
    while True:
        t = min(done + step, 1.0)
        if 1.0 - t < 1e-12:
            t = 1.0
        tried = x.copy()
        if slope is not None:
            ahead = x + (t - done) * slope
            if _same_sides(levels, x, ahead, may_pass):
                tried = ahead
        set_data(t)
        outcome = levels.solve(tried, tolerance, **options)
        steps += outcome.steps
        if outcome.solved and np.abs(tried - x).max(initial=0.0) <= furthest:
            slope = (tried - x) / (t - done)
            x[:] = tried
            done, step = t, 2 * step
            if done == 1.0:
                return replace(outcome, steps=steps)
            continue
        if outcome.status == "interrupted":
            failure = outcome
            break
        if not outcome.solved or failure is None:
            failure = outcome if not outcome.solved else replace(outcome, status="stalled")
        step = (t - done) / 2
        slope = slope if step > 0.1 * least else None
        if step < least:
            break
    set_data(done)
    return replace(failure, steps=steps, fraction=done)


def _same_sides(
    levels: Levels, x: Array, ahead: Array, may_pass: Callable[[int], bool] | None
) -> bool:
    """Whether guards have the signs at `ahead` that they have at `x`."""
    guards = levels.guards
    if guards is None:
        return True
    changed = np.flatnonzero(np.sign(guards.evaluate(x)) != np.sign(guards.evaluate(ahead)))
    return all(may_pass is not None and may_pass(guard) for guard in changed.tolist())
