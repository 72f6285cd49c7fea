"""A minimal set of rows that cannot hold together, where a problem is infeasible."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from arael.runtime.constrained.loop import Loop
from arael.runtime.constrained.rows import Bools, Ints

# More violated instances than this are not tried one by one.
MAX_TRIED = 60
# Attempts of one trial.
MAX_ATTEMPTS = 100


def conflict_of(loop: Loop) -> tuple[str, ...]:
    """Names of rows that cannot hold together, though all but any one of them can.

    At a minimum of the squared violations only rows that are violated pull, so those alone
    contradict each other there. They are left out one by one, the least violated first: what the
    others do not need to contradict each other stays out (J. Chinneck, "Feasibility and
    Infeasibility in Optimization", 2008, section 6.2, deletion filter). Trials start at the
    minimum; the accepted state of the problem stays there.
    """
    limits = loop.limits
    values, _ = limits.evaluate()
    relative = limits.violations(values) / np.maximum(loop.scale, 1e-300)
    unit, names = _units(loop)
    worst = np.zeros(len(names))
    np.maximum.at(worst, unit, relative)
    chosen = np.flatnonzero(worst > loop.tolerances.rows)
    chosen = chosen[np.argsort(worst[chosen], kind="stable")]
    kept = np.zeros(len(names), dtype=bool)
    kept[chosen] = True
    if len(chosen) <= MAX_TRIED:
        saved = loop.states.saved()
        for one in chosen:
            kept[one] = False
            if _can_hold(loop, kept[unit]):
                kept[one] = True
            loop.states.back(saved)
    return tuple(names[int(k)] for k in np.flatnonzero(kept))


def _units(loop: Loop) -> tuple[Ints, list[str]]:
    """Number of the instance or bound that each row belongs to, and their names."""
    limits = loop.limits
    known: dict[str, int] = {}
    unit = [known.setdefault(limits.name(k), len(known)) for k in range(limits.count)]
    return np.array(unit, dtype=np.int64), list(known)


def _can_hold(loop: Loop, rows: Bools) -> bool:
    """Whether chosen rows can hold together, as far as a search from this state finds out."""
    trial = replace(
        loop,
        config=replace(
            loop.config, max_iters=MAX_ATTEMPTS, cost_threshold=0.0, time_limit=None, observer=None
        ),
        stepped=None,
        attempts=0,
        accepted=0,
        records=[],
        start_cost=math.nan,
    )
    return trial.lower(trial.linearise(), rows.astype(np.float64)) == ""
