"""Offsets between the clocks of sensors, from what both of them measure."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from arael.diagnostics.records import AraelError, Diagnostic
from arael.geometry.arrays import Array, as_numbers, as_scalar

# Candidates are this part of the longer of the two median intervals apart.
_STEP = 0.5
# At a candidate, this part of the second sensor's samples is within the times of the first.
_OVERLAP = 0.5


def clock_offset(
    times: ArrayLike,
    rates: ArrayLike,
    other_times: ArrayLike,
    other_rates: ArrayLike,
    span: float,
) -> float:
    """Offset of another clock, at which two sensors have measured the same rates: a start.

    Of the candidates, that with the least mean squared difference is returned, refined by the
    parabola through it and its neighbours. Angular rates serve best: the magnitude of a rigid
    body's rate is the same in all frames, so that sensors need not be aligned.

    Parameters
    ----------
    times, rates : (n,) of the first sensor, times ascending
    other_times, other_rates : (m,) of the other sensor
    span : largest offset that is considered, either way

    Returns
    -------
    What is added to times of the other sensor to have those of the first.

    Raises
    ------
    AraelError
        E1031: arrays of other shapes, times that do not ascend, or less than half of the other
        sensor's samples within the times of the first at every candidate.
    """
    t, r = _samples(times, rates, "times", "rates")
    other_t, other_r = _samples(other_times, other_rates, "other_times", "other_rates")
    span = as_scalar(span, "span")
    step = _STEP * max(float(np.median(np.diff(t))), float(np.median(np.diff(other_t))))
    count = int(np.ceil(abs(span) / step))
    candidates = step * np.arange(-count, count + 1)
    misfits = np.array([_misfit(t, r, other_t + offset, other_r) for offset in candidates])
    if not np.isfinite(misfits).any():
        raise _refused(
            "the other sensor has less than half of its samples within the times of the first",
            "measure both over the same time, or widen `span`",
        )
    best = int(np.nanargmin(np.where(np.isfinite(misfits), misfits, np.nan)))
    before, after = max(best - 1, 0), min(best + 1, len(misfits) - 1)
    a, b, c = misfits[before], misfits[best], misfits[after]
    bend = a - 2 * b + c
    if before == best or after == best or not np.isfinite(bend) or bend <= 0:
        return float(candidates[best])
    return float(candidates[best] + 0.5 * step * (a - c) / bend)


def _misfit(t: Array, r: Array, at: Array, seen: Array) -> float:
    inside = (at >= t[0]) & (at <= t[-1])
    if inside.sum() < max(_OVERLAP * len(at), 2):
        return np.inf
    return float(np.mean((np.interp(at[inside], t, r) - seen[inside]) ** 2))


def _samples(times: ArrayLike, values: ArrayLike, name: str, other: str) -> tuple[Array, Array]:
    t, v = as_numbers(times, name), as_numbers(values, other)
    if t.ndim != 1 or t.shape != v.shape or len(t) < 3:
        raise _refused(
            f"`{name}` and `{other}` have the shapes {t.shape} and {v.shape}",
            "give one rate for each time, of three times or more",
        )
    if not (np.isfinite(t).all() and np.isfinite(v).all() and (np.diff(t) > 0).all()):
        raise _refused(
            f"`{name}` do not ascend, or a number is not finite", "sort by time, drop duplicates"
        )
    return t, v


def _refused(message: str, advice: str) -> AraelError:
    where = "arael.geometry.clock_offset"
    return AraelError(Diagnostic("E1031", message, origin=where, help=(advice,)))
