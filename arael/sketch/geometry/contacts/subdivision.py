"""Two Bezier curves: boxes are halved until Newton's method is safe."""

from __future__ import annotations

from math import hypot

from arael.sketch.geometry.contacts.contact import Candidate
from arael.sketch.geometry.curve import Bounds, bounds_of
from arael.sketch.geometry.splines import Bezier
from arael.sketch.geometry.vectors import Point, between, cross, dot, subtract

_LEAF = 2.0**-7
"""Parts of the parameter at which curves are short enough for Newton's method to start."""

_MOST_LEAVES = 4000


def beziers(a: Bezier, b: Bezier, tolerance: float) -> list[Candidate]:
    """Parameters where two Bezier curves may meet, crossings and contacts."""
    found: list[Candidate] = []
    todo = [(a, bounds_of(a.poles), 0.0, 1.0, b, bounds_of(b.poles), 0.0, 1.0)]
    leaves = 0
    while todo and leaves < _MOST_LEAVES:
        p, box, t, dt, q, other, u, du = todo.pop()
        if box.apart(other, tolerance):
            continue
        if dt <= _LEAF and du <= _LEAF:
            leaves += 1
            found += _polished(a, t + 0.5 * dt, b, u + 0.5 * du, tolerance)
        elif du <= _LEAF or (dt > _LEAF and box.size >= other.size):
            for half, box_, start in _halves(p, t, dt):
                todo.append((half, box_, start, 0.5 * dt, q, other, u, du))
        else:
            for half, box_, start in _halves(q, u, du):
                todo.append((p, box, t, dt, half, box_, start, 0.5 * du))
    return found


def _halves(curve: Bezier, start: float, width: float) -> list[tuple[Bezier, Bounds, float]]:
    p, q, r, s = curve.poles
    pq, qr, rs = between(p, q), between(q, r), between(r, s)
    pqr, qrs = between(pq, qr), between(qr, rs)
    middle = between(pqr, qrs)
    first, last = (p, pq, pqr, middle), (middle, qrs, rs, s)
    return [
        (Bezier(first), bounds_of(first), start),
        (Bezier(last), bounds_of(last), start + 0.5 * width),
    ]


def _polished(a: Bezier, t: float, b: Bezier, u: float, tolerance: float) -> list[Candidate]:
    found = []
    ends = [_newton(a, t, b, u)]
    d, e = a.derivative_at(t), b.derivative_at(u)
    if abs(cross(d, e)) < 0.3 * hypot(*d) * hypot(*e):
        ends.append(_contact(a, t, b, u))
    for end in ends:
        if end is None:
            continue
        v, w = min(max(end[0], 0.0), 1.0), min(max(end[1], 0.0), 1.0)
        if hypot(*subtract(a.point_at(v), b.point_at(w))) <= tolerance:
            found.append(Candidate(v, w))
    return found


def _newton(a: Bezier, t: float, b: Bezier, u: float) -> Point | None:
    """Solve a(t) = b(u)."""
    for _ in range(30):
        d, e = a.derivative_at(t), b.derivative_at(u)
        w = subtract(b.point_at(u), a.point_at(t))
        det = cross(d, e)
        if det == 0.0:
            return t, u
        dt, du = cross(w, e) / det, cross(w, d) / det
        t, u = t + dt, u + du
        if not (abs(t - 0.5) < 1.0 and abs(u - 0.5) < 1.0):
            return None
        if abs(dt) + abs(du) < 1e-15:
            break
    return t, u


def _contact(a: Bezier, t: float, b: Bezier, u: float) -> Point | None:
    """Solve for parallel directions whose connection is perpendicular to them."""
    for _ in range(30):
        d, e = a.derivative_at(t), b.derivative_at(u)
        dd, ee = a.second_at(t), b.second_at(u)
        w = subtract(a.point_at(t), b.point_at(u))
        f, g = cross(d, e), dot(w, d)
        ft, fu = cross(dd, e), cross(d, ee)
        gt, gu = dot(d, d) + dot(w, dd), -dot(e, d)
        det = ft * gu - fu * gt
        if det == 0.0:
            return None
        dt, du = (-f * gu + g * fu) / det, (-g * ft + f * gt) / det
        t, u = t + dt, u + du
        if not (abs(t - 0.5) < 1.0 and abs(u - 0.5) < 1.0):
            return None
        if abs(dt) + abs(du) < 1e-15:
            break
    return t, u
