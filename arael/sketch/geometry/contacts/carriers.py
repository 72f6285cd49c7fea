"""Closed formulas: lines and conics."""

from __future__ import annotations

from math import acos, atan2, copysign, dist, hypot, sqrt

from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.contacts.contact import Candidate, Contact
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point, cross, direction_angle, subtract


def lines(a: Line, b: Line) -> list[Candidate]:
    """Crossing of two lines; parallel ones have none."""
    d, e = a.derivative_at(0.0), b.derivative_at(0.0)
    # in units of their lengths: the test for parallels is one of angles
    m, n = hypot(*d), hypot(*e)
    if not (m > 0.0 and n > 0.0):
        return []
    d, e = (d[0] / m, d[1] / m), (e[0] / n, e[1] / n)
    sine = cross(d, e)
    if abs(sine) < 1e-15:
        return []
    w = subtract(b.p1, a.p1)
    return [Candidate(cross(w, e) / sine / m, cross(w, d) / sine / n)]


def clear_crossing(
    a: Line, b: Line, extend_a: bool, extend_b: bool, tolerance: float
) -> list[Contact] | None:
    """Contacts of two lines at an angle of more than 17 degrees; None if they are closer to it.

    Most pairs of lines are like this, and need no search for overlaps and touching ends.
    """
    d, e = a.derivative_at(0.0), b.derivative_at(0.0)
    m, n = hypot(*d), hypot(*e)
    if not (m > 0.0 and n > 0.0):
        return None
    det = cross(d, e)
    if abs(det) <= 0.3 * m * n:
        return None
    w = subtract(b.p1, a.p1)
    t, u = cross(w, e) / det, cross(w, d) / det
    if not extend_a:
        if not -tolerance <= t * m <= m + tolerance:
            return []
        t = min(max(t, 0.0), 1.0)
    if not extend_b:
        if not -tolerance <= u * n <= n + tolerance:
            return []
        u = min(max(u, 0.0), 1.0)
    return [Contact(a.point_at(t), t, u, "crossing")]


def line_and_conic(line: Line, conic: Conic, tolerance: float) -> list[Candidate]:
    """Up to two crossings, or the contact of a tangent, by the support function of the ellipse."""
    rx, ry = conic.radii
    p, q = conic.local(line.p1), conic.local(line.p2)
    length = dist(p, q)  # which is 0 for a line of some rounding errors, too
    if not length > 0.0:
        return []
    d = (q[0] - p[0]) / length, (q[1] - p[1]) / length
    n = -d[1], d[0]
    away = p[0] * n[0] + p[1] * n[1]
    support = hypot(rx * n[0], ry * n[1])
    if abs(away) > support + tolerance:
        return []
    if abs(abs(away) - support) <= tolerance:
        side = copysign(1.0, away)
        angle = atan2(side * ry * n[1], side * rx * n[0])
        x, y = side * rx * rx * n[0] / support, side * ry * ry * n[1] / support
        s = (x - p[0]) * d[0] + (y - p[1]) * d[1]
        return [Candidate(s / length, conic.parameter(angle), True)]
    # the ellipse as the unit circle
    px, py, dx, dy = p[0] / rx, p[1] / ry, d[0] / rx, d[1] / ry
    speed = hypot(dx, dy)
    offset = abs(px * dy - py * dx) / speed
    foot = -(px * dx + py * dy) / speed
    half = sqrt(max((1.0 - offset) * (1.0 + offset), 0.0))
    found = []
    for s in ((foot - half) / speed, (foot + half) / speed):
        angle = atan2(py + s * dy, px + s * dx)
        found.append(Candidate(s / length, conic.parameter(angle)))
    return found


def circles(a: Conic, b: Conic, tolerance: float) -> list[Candidate]:
    """Up to two crossings of circles, or their contact; concentric ones have none."""
    (r, _), (s, _) = a.radii, b.radii
    w = subtract(b.middle, a.middle)
    d = hypot(*w)
    if not d > 0.0 or d > r + s + tolerance or d < abs(r - s) - tolerance:
        return []
    heading = direction_angle(w)
    if abs(d - r - s) <= tolerance or abs(d - abs(r - s)) <= tolerance:
        inner = d < max(r, s)
        first = heading if not inner or r >= s else heading + acos(-1.0)
        second = _toward(b, a, first)
        return [Candidate(a.parameter(first - a.turned), b.parameter(second), True)]
    along = 0.5 * (d + (r - s) * (r + s) / d)
    half = acos(max(-1.0, min(1.0, along / r)))
    return [
        Candidate(a.parameter(angle - a.turned), b.parameter(_toward(b, a, angle)))
        for angle in (heading - half, heading + half)
    ]


def _toward(conic: Conic, other: Conic, angle: float) -> float:
    """Angle on `conic` of the point of the circle `other` in a direction of the plane."""
    point: Point = other.at_angle(angle - other.turned)
    x, y = conic.local(point)
    return atan2(y, x)
