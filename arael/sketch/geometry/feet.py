"""Feet of a point on an ellipse."""

from __future__ import annotations

from math import atan2, copysign, sqrt


def ellipse_feet(x: float, y: float, rx: float, ry: float) -> list[float]:
    """Eccentric angles of the nearest point, and of another local minimum if there is one.

    The foot of (x, y) is (rx^2 x / (rx^2 + s), ry^2 y / (ry^2 + s)) with s a root of a function
    that is convex between its poles, so Newton's iteration from the side of a pole converges
    monotonically. Eberly: Distance from a point to an ellipse (2013), equation 11.
    """
    if rx < ry:  # the longer radius is taken first: exchange the axes
        return [atan2(up, across) for up, across in _feet(y, x, ry, rx)]
    return [atan2(sy, sx) for sx, sy in _feet(x, y, rx, ry)]


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
