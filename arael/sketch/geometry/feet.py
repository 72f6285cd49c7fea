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
    # in units of b, first quadrant: E(s) = (r u / (s + r^2))^2 + (v / (s + 1))^2 - 1
    u, v, r2 = abs(x) / b, abs(y) / b, ratio * ratio
    sx, sy = copysign(1.0, x), copysign(1.0, y)
    found = []
    if v - 1.0 > -1.0:  # not on the long axis, up to rounding
        s = _newton(u * ratio, v, r2, max(v - 1.0, u * ratio - r2))
        found.append((sx * ratio * u / (s + r2), sy * v / (s + 1.0)))
    else:
        inner = u * ratio / (r2 - 1.0)  # cosine of the foot while inside the evolute
        c = min(inner, 1.0)
        found.append((sx * c, sqrt(1.0 - c * c)))
        if c < 1.0:
            found.append((sx * c, -sqrt(1.0 - c * c)))
        return found
    # across the long axis, from the pole s = -1 leftwards; inside the evolute only
    inside = (u * ratio) ** (2 / 3) + v ** (2 / 3) < (r2 - 1.0) ** (2 / 3)
    if inside and -1.0 - v < -1.0:  # as above
        s = _newton_left(u * ratio, v, r2, -1.0 - v)
        found.append((sx * ratio * u / (s + r2), sy * v / (s + 1.0)))
    return found


def _newton(p: float, q: float, r2: float, s: float) -> float:
    for _ in range(200):
        f, slope = _value(p, q, r2, s)
        if f <= 0.0 or slope == 0.0:
            break
        new = s - f / slope
        if not new > s:
            break
        s = new
    return s


def _newton_left(p: float, q: float, r2: float, s: float) -> float:
    for _ in range(200):
        f, slope = _value(p, q, r2, s)
        if f <= 0.0 or slope <= 0.0:
            break
        new = s - f / slope
        if not new < s or new <= -r2:
            break
        s = new
    return s


def _value(p: float, q: float, r2: float, s: float) -> tuple[float, float]:
    x, y = p / (s + r2), q / (s + 1.0)
    return x * x + y * y - 1.0, -2.0 * (x * x / (s + r2) + y * y / (s + 1.0))
