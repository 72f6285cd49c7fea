"""Start values of a fit: linear parameters eliminated, the others searched.

For given nonlinear parameters the best linear ones are a linear least-squares problem, so that the
search is over the nonlinear ones alone: variable projection (G. Golub and V. Pereyra, "The
differentiation of pseudo-inverses and nonlinear least squares problems whose variables separate",
1973). The search tries a fixed sequence of points that fills their space evenly (M. Roberts, "The
unreasonable effectiveness of quasirandom sequences", 2018) over scales drawn from the data, follows
the best of them by variable projection, and solves from several.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from arael.fitting.curve import Curve, Points
from arael.fitting.scales import exponents, quantiles
from arael.runtime.failures import SolveError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_ROWS = 240
"""Points that the search looks at, spread over all."""
_TRIALS = (0, 240, 800, 2000, 3000)
"""Points of the sequence by the number of nonlinear parameters."""
_SOLVED = 12
"""Candidates from which a solve starts."""
_AGREE = 4
"""Solves that end at the least cost before the others are left out."""
_MIRRORED = 8
"""Most parameters whose signs are tried, in all combinations."""
_TURNS = (2 * np.pi, 360.0)
"""Periods of phases that are recognised."""
_SAME = 1e-9
"""Largest relative difference of the costs of equivalent values."""
_STEPS = 40
"""Steps from each candidate before it is solved."""
_SWEEP = 80
"""Values tried along each parameter."""


def find_start(curve: Curve, formula: str, predicts: str | None) -> Array:
    """Start values of all parameters, near the least cost that was found.

    Given starts are kept, fixed parameters as well.

    Parameters
    ----------
    curve : the model of the fit
    formula : text of the formula that predicts, or of the residual
    predicts : the predicted column
    """
    if not curve.own:
        return _best_of(curve, _candidates(curve, formula, predicts))
    # Each group alone, all groups together as one: the better of the two.
    points = curve.points
    parts = [np.flatnonzero(points.group == k) for k in range(len(points.groups))]
    alone = [_single(curve, points.part(rows), formula, predicts) for rows in parts if len(rows)]
    pooled = _single(curve, points, formula, predicts)
    shared, rest = len(curve.shared), len(curve.own)
    own = np.concatenate([one[shared:] for one in alone])
    middle = np.median([one[:shared] for one in alone], axis=0)
    tries = [
        np.concatenate([middle, own]),
        np.concatenate([pooled[:shared], own]),
        np.concatenate([pooled[:shared], np.tile(pooled[shared:], len(own) // rest)]),
    ]
    return _best_of(curve, tries)


def _single(curve: Curve, points: Points, formula: str, predicts: str | None) -> Array:
    """The best parameters of some of the points as one group; ``(shared, own)``."""
    one = Points(points.columns, points.sigma, np.zeros(points.size, dtype=np.int64))
    parameters = tuple(replace(p, own=False) for p in (*curve.shared, *curve.own))
    alone = Curve(curve.formula, (), parameters, one, curve.loss)
    if not alone.free.any():
        return np.array([p.start if p.start is not None else 1.0 for p in parameters])
    return _best_of(alone, _candidates(alone, formula, predicts))


def _best_of(curve: Curve, tries: list[Array]) -> Array:
    """The end of the best solve, each a short one, from several starts."""
    best, least, agreeing = tries[0], np.inf, 0
    for start in tries:
        if not np.isfinite(curve.cost(start)):
            continue
        curve.put(start)
        with contextlib.suppress(SolveError):
            curve.model.solve(rel_precision=1e-6, max_iters=200)
        found = curve.get()
        cost = curve.cost(found)
        if cost < least * (1 - 1e-6):
            agreeing = 0
        if cost < least:
            best, least = found, cost
        agreeing += cost <= least * (1 + 1e-5)
        if agreeing >= _AGREE:
            break
    return _upright(curve, best, least)


def _upright(curve: Curve, found: Array, least: float) -> Array:
    """The equivalent values that people expect: the fewest negative ones, and small phases.

    Data cannot tell the signs of f and phi in ``cos(f * t + phi)``, nor turns of phi.
    """
    searched = [k for k, p in enumerate(curve.parameters) if p.start is None and not p.fixed]
    if not 0 < len(searched) <= _MIRRORED:
        return found
    low = np.array([p.low for p in curve.parameters])
    high = np.array([p.high for p in curve.parameters])

    def is_equivalent(tried: Array) -> bool:
        if not ((low <= tried) & (tried <= high)).all():
            return False
        with np.errstate(over="ignore", invalid="ignore"):
            return abs(curve.cost(tried) - least) <= _SAME * least

    best, signed = found, []
    for k in searched:
        for turn in _TURNS:
            tried = best.copy()
            tried[k] -= turn * (np.round(best[k] / turn) or 1.0)
            if is_equivalent(tried):
                best = tried if abs(tried[k]) < abs(best[k]) else best
                break
        else:
            signed.append(k)
    folded = best
    for signs in product((1.0, -1.0), repeat=len(searched)):
        tried = folded.copy()
        tried[searched] *= signs
        if (tried[signed] < 0).sum() < (best[signed] < 0).sum() and is_equivalent(tried):
            best = tried
    return best


def _candidates(curve: Curve, formula: str, predicts: str | None) -> list[Array]:
    """Start values to solve from, those of least cost first."""
    points = curve.points
    every = points.size <= _ROWS
    rows = np.unique(np.linspace(0, points.size - 1, _ROWS).astype(np.int64))
    seen = points if every else points.part(rows)
    reduced = Curve(curve.formula, (), curve.shared, seen) if curve.loss or not every else curve
    base = np.array([np.clip(p.start or 0.0, p.low, p.high) for p in curve.parameters])
    ones = np.array(
        [np.clip(1.0 if p.start is None else p.start, p.low, p.high) for p in curve.parameters]
    )
    searched = np.array([p.start is None and not p.fixed for p in curve.parameters])
    if not searched.any():
        return [ones]
    names = tuple(points.columns)
    units = exponents(formula, predicts, curve.names, names)
    spread = [
        quantiles(unit, points.columns, p.low, p.high)
        for unit, p in zip(units, curve.parameters, strict=True)
    ]
    probes = _sequence(4, len(spread))
    at = np.column_stack([values(u) for values, u in zip(spread, probes.T, strict=True)])
    linear = _linear(reduced, np.where(searched, at, ones), searched)
    bent = np.flatnonzero(searched & ~linear)

    def projected(q: Array) -> tuple[float, Array]:
        x = base.copy()
        x[bent] = q
        return _projected(reduced, x, linear)

    if not len(bent):
        return [projected(np.zeros(0))[1], ones]
    ways = [spread[k] for k in bent]
    count = _TRIALS[min(len(bent), len(_TRIALS) - 1)]
    places = _sequence(count, len(bent))
    trials = np.column_stack([way(u) for way, u in zip(ways, places.T, strict=True)])
    costs = np.array([projected(q)[0] for q in trials])
    order = np.argsort(costs, kind="stable")[:_SOLVED]
    chosen = [trials[k] for k in order if np.isfinite(costs[k])]
    if len(bent) > 1:
        chosen = [_swept(q, ways, lambda q: projected(q)[0]) for q in chosen[:2]] + chosen
    return [*(_descended(reduced, projected(q)[1], linear, bent) for q in chosen), ones]


def _linear(curve: Curve, at: Array, searched: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Parameters in which the residuals are linear together, at several places (k, p).

    A derivative that does not change with a parameter has no product with it. Of two parameters
    that have one, the one with fewer such products is taken.
    """
    size = len(searched)
    depends = np.zeros((size, size), dtype=bool)
    for x in at:
        with np.errstate(all="ignore"):
            before = curve(x)[1]
            for k in np.flatnonzero(searched):
                other = x.copy()
                other[k] = 1.7 * x[k] + (0.3 if x[k] == 0 else 0.0)
                after = curve(other)[1]
                both = np.isfinite(before) & np.isfinite(after)
                change = np.where(both, np.abs(after - before), 0.0).max(axis=0)
                size_of = np.where(both, np.abs(before) + np.abs(after), 0.0).max(axis=0)
                depends[:, k] |= change > 1e-9 * size_of
    depends |= depends.T
    linear = np.zeros(size, dtype=bool)
    free = [k for k in np.flatnonzero(searched) if not depends[k, k]]
    for k in sorted(free, key=lambda k: int(depends[k].sum())):
        if not depends[k, linear].any():
            linear[k] = True
    return linear


def _projected(curve: Curve, x: Array, linear: NDArray[np.bool_]) -> tuple[float, Array]:
    """The least cost over the linear parameters, and all parameters there."""
    with np.errstate(all="ignore"):
        x = np.where(linear, 0.0, x)
        residuals, matrix = curve(x)
        if not np.isfinite(residuals).all():
            # The formula has no value at zero, or nowhere.
            return np.inf, x
        part = matrix[:, linear]
        if part.shape[1]:
            if not np.isfinite(part).all():
                return np.inf, x
            length = np.sqrt((part**2).sum(axis=0))
            length[length == 0] = 1.0
            best = np.linalg.lstsq(part / length, -residuals, rcond=1e-12)[0] / length
            best = np.clip(best, curve.low[linear], curve.high[linear])
            residuals = residuals + part @ best
            x = x.copy()
            x[linear] = best
        cost = float(residuals @ residuals)
        return (cost if np.isfinite(cost) else np.inf), x


def _descended(curve: Curve, x: Array, linear: NDArray[np.bool_], bent: NDArray[np.int64]) -> Array:
    """Lower the projected cost by damped Gauss-Newton steps over the nonlinear parameters.

    The derivative of the projected residuals without the change of the projection: L. Kaufman, "A
    variable projection method for solving separable nonlinear least squares problems", 1975.
    """
    cost, x = _projected(curve, x, linear)
    damping = 1e-2
    for _ in range(_STEPS):
        with np.errstate(all="ignore"):
            residuals, matrix = curve(x)
        if not np.isfinite(matrix).all() or not cost < np.inf:
            break
        basis = np.linalg.qr(matrix[:, linear])[0]
        part = matrix[:, bent] - basis @ (basis.T @ matrix[:, bent])
        length = np.sqrt((part**2).sum(axis=0))
        length[length == 0] = 1.0
        square = (part / length).T @ (part / length)
        slope = (part / length).T @ residuals
        lowered = False
        while not lowered and damping < 1e8:
            step = np.linalg.solve(square + damping * np.eye(len(bent)), -slope) / length
            trial = x.copy()
            trial[bent] = np.clip(x[bent] + step, curve.low[bent], curve.high[bent])
            found, trial = _projected(curve, trial, linear)
            lowered = found < cost
            damping *= 0.2 if lowered else 5
        if not lowered:
            break
        small = cost - found <= 1e-9 * cost
        x, cost = trial, found
        if small:
            break
    return x


def _swept(q: Array, ways: list[Callable[[Array], Array]], cost: Callable[[Array], float]) -> Array:
    """The best found along one parameter after the other, twice."""
    best, least = q, cost(q)
    u = (np.arange(_SWEEP) + 0.5) / _SWEEP
    for _ in range(2):
        for k, way in enumerate(ways):
            for value in way(u):
                trial = best.copy()
                trial[k] = value
                found = cost(trial)
                if found < least:
                    best, least = trial, found
    return best


def _sequence(count: int, size: int) -> Array:
    """Points (count, size) that fill the unit cube evenly: multiples of powers of 1/phi."""
    phi = 2.0
    for _ in range(60):
        phi = (1 + phi) ** (1 / (size + 1))
    steps = phi ** -np.arange(1.0, size + 1)
    return np.asarray((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1)
