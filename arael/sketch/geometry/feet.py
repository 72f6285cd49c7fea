"""Feet of a point on an ellipse, and normals through it."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, copysign, hypot, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Of half a turn.
_SAMPLES = 90
#: What counts as zero where two normals are one, as a part of the numbers it comes from.
_ROUNDING = 1e-14


def ellipse_feet(x: float, y: float, rx: float, ry: float) -> list[float]:
    """Eccentric angles of the nearest point, and of another local minimum if there is one.

    The foot of (x, y) is (rx^2 x / (rx^2 + s), ry^2 y / (ry^2 + s)) with s a root of a function
    that is convex between its poles, so Newton's iteration from the side of a pole converges
    monotonically. Eberly: Distance from a point to an ellipse (2013), equation 11.
    """
    if rx < ry:  # the longer radius is taken first: exchange the axes
        return [atan2(up, across) for up, across in _feet(y, x, ry, rx)]
    return [atan2(sy, sx) for sx, sy in _feet(x, y, rx, ry)]


def ellipse_normals(x: float, y: float, rx: float, ry: float) -> list[float]:
    """Eccentric angles of the points whose normal passes through (x, y): two to four.

    Of the centre of a circle, whose normals all do, the angle 0.

    The nearest and the farthest point are among them. They are looked for between samples at equal
    steps of the angle and of the direction of the normal, which turns within ry / rx of the tips of
    a flat ellipse, and between extrema, so that two that are close are told apart; those that are
    one but for rounding are there as well.
    """

    def miss(t: Floats) -> Floats:
        # cross product of the normal and the way to (x, y), times rx ry
        return rx * np.sin(t) * (x - rx * np.cos(t)) - ry * np.cos(t) * (y - ry * np.sin(t))

    def slope(t: Floats) -> Floats:
        c, s = np.cos(t), np.sin(t)
        across, along = rx * c * (x - rx * c) + (rx * s) ** 2, ry * s * (y - ry * s) + (ry * c) ** 2
        return across + along

    # One step more than a turn: a root at half a turn is between two of them.
    steps = np.arange(-_SAMPLES, _SAMPLES + 2) * (np.pi / _SAMPLES)
    t = np.unique(np.concatenate([steps, np.arctan2(ry * np.sin(steps), rx * np.cos(steps))]))
    extrema = _roots(slope, t)
    size = max(rx, ry) * (max(rx, ry) + hypot(x, y))
    double = extrema[np.abs(miss(extrema)) <= _ROUNDING * size]
    found = _roots(miss, np.unique(np.concatenate([t, extrema])))
    return [float(angle) for angle in (*found, *double)] or [0.0]


def _roots(function: Callable[[Floats], Floats], t: Floats) -> Floats:
    """Where a function changes its sign between neighbours of `t`, by bisection to the end."""
    below = function(t) < 0.0
    at = np.flatnonzero(below[:-1] != below[1:])
    low, high, below = t[at], t[at + 1], below[at]
    while (((middle := (low + high) / 2) > low) & (middle < high)).any():
        same = (function(middle) < 0.0) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return high


def _feet(x: float, y: float, a: float, b: float) -> list[tuple[float, float]]:
    """Cosine and sine (up to a factor) of the eccentric angle at the minima; a > b."""
    if not b > 0.0:
        c = min(max(x / a, -1.0), 1.0) if a > 0.0 else 1.0
        return [(c, sqrt(1.0 - c * c))]
    ratio = a / b
    # In units of b, first quadrant, with w = s + 1, which near the long axis is small where s is
    # not: E(w) = (r u / (w + r^2 - 1))^2 + (v / w)^2 - 1.
    u, v, rest = abs(x) / b, abs(y) / b, (a - b) * (a + b) / (b * b)
    sx, sy = copysign(1.0, x), copysign(1.0, y)
    found = []
    if v > 0.0:
        w = _newton(u * ratio, v, rest, max(v, u * ratio - rest))
        found.append((sx * ratio * u / (w + rest), sy * v / w))
    else:
        inner = u * ratio / rest if rest > 0.0 else 2.0  # cosine of the foot inside the evolute
        c = min(inner, 1.0)
        found.append((sx * c, sqrt(1.0 - c * c)))
        if c < 1.0:
            found.append((sx * c, -sqrt(1.0 - c * c)))
        return found
    # across the long axis, from the pole w = 0 leftwards; inside the evolute only
    if (u * ratio) ** (2 / 3) + v ** (2 / 3) < rest ** (2 / 3):
        w = _newton_left(u * ratio, v, rest, -v)
        found.append((sx * ratio * u / (w + rest), sy * v / w))
    return found


def _newton(p: float, q: float, rest: float, w: float) -> float:
    for _ in range(200):
        f, slope = _value(p, q, rest, w)
        if f <= 0.0 or slope == 0.0:
            break
        new = w - f / slope
        if not new > w:
            break
        w = new
    return w


def _newton_left(p: float, q: float, rest: float, w: float) -> float:
    for _ in range(200):
        f, slope = _value(p, q, rest, w)
        if f <= 0.0 or slope <= 0.0:
            break
        new = w - f / slope
        if not new < w or new <= -rest:
            break
        w = new
    return w


def _value(p: float, q: float, rest: float, w: float) -> tuple[float, float]:
    x, y = p / (w + rest), q / w
    return x * x + y * y - 1.0, -2.0 * (x * x / (w + rest) + y * y / w)
