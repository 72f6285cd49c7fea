"""Intersections of every pair of kinds of curves."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import sqrt

from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.contacts import carriers, polynomials, subdivision
from arael.sketch.geometry.contacts.contact import Candidate, Contact
from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.splines import Bezier, BSpline
from arael.sketch.geometry.vectors import DegenerateError, cross, dot, gap, norm

RELATIVE_TOLERANCE = 1e-9
"""Default tolerance, in sizes of the larger curve."""


def intersections(
    a: Curve,
    b: Curve,
    *,
    extend_a: bool = False,
    extend_b: bool = False,
    tolerance: float | None = None,
) -> list[Contact]:
    """Contacts of two curves, by their parameter on `a`.

    Parameters
    ----------
    a, b
        Curves of any kinds.
    extend_a, extend_b
        Take the whole carrier instead: the line of a segment, the circle or ellipse of an arc.
        Splines have no carrier.
    tolerance
        Distance below which curves touch; by default 1e-9 of the larger curve, and not below the
        rounding of its coordinates.

    Returns
    -------
    list of Contact
        A stretch that both share is listed by its two ends, of kind ``overlap``. Curves that touch
        without crossing, or cross twice with a penetration below the tolerance, have one contact
        of kind ``tangent``.
    """
    if tolerance is None:
        tolerance = default_tolerance(a, b)
    if isinstance(a, Line) and isinstance(b, Line):
        clear = carriers.clear_crossing(a, b, extend_a, extend_b, tolerance)
        if clear is not None:
            return clear
    if _apart(a, b, extend_a, extend_b, tolerance):
        return []
    pair = _Pair(a, b, extend_a, extend_b, tolerance)
    touching = list(pair.ends())
    shared = pair.overlaps(touching)
    found = [pair.contact(c) for c in _candidates(a, b, tolerance)]
    found += [pair.contact(c) for c in touching]
    points = [c for c in found if c is not None and not any(s <= c.t <= e for s, e in shared)]
    contacts = pair.merged(points)
    for start, end in shared:
        contacts += [pair.overlap_end(start), pair.overlap_end(end)]
    return sorted(contacts, key=lambda c: c.t)


def default_tolerance(a: Curve, b: Curve) -> float:
    """1e-9 of the larger curve, and not below the rounding of the coordinates."""
    boxes = a.bounds(), b.bounds()
    far = max(abs(x) for box in boxes for x in box)
    return max(RELATIVE_TOLERANCE * max(box.size for box in boxes), 2e-15 * far)


def _apart(a: Curve, b: Curve, extend_a: bool, extend_b: bool, tolerance: float) -> bool:
    if (extend_a and not isinstance(a, Bezier | BSpline)) or (
        extend_b and not isinstance(b, Bezier | BSpline)
    ):
        return False
    return a.bounds().apart(b.bounds(), tolerance)


def _candidates(a: Curve, b: Curve, tolerance: float) -> list[Candidate]:
    """Where the carriers may meet, in parameters of `a` and `b`."""
    if _rank(a) > _rank(b):
        return [Candidate(c.u, c.t, c.tangent) for c in _candidates(b, a, tolerance)]
    if isinstance(a, Line) and isinstance(b, Line):
        return carriers.lines(a, b)
    if isinstance(a, Line) and isinstance(b, Conic):
        return carriers.line_and_conic(a, b, tolerance)
    if isinstance(a, Conic) and isinstance(b, Conic):
        if a.radii[0] == a.radii[1] and b.radii[0] == b.radii[1]:
            return carriers.circles(a, b, tolerance)
        ts = [b.parameter(angle) for angle in polynomials.conics_angles(a, b)]
        return [Candidate(c.u, c.t) for c in polynomials.candidates(b, ts, a)]
    if isinstance(a, Line | Conic) and isinstance(b, Bezier):
        ts = polynomials.beziers_parameters(a, b)
        return [Candidate(c.u, c.t) for c in polynomials.candidates(b, ts, a)]
    if isinstance(a, Bezier) and isinstance(b, Bezier):
        return subdivision.beziers(a, b, tolerance)
    assert isinstance(b, BSpline)
    found = []
    m = b.spans
    for k, piece in enumerate(b.beziers()):
        if isinstance(a, Line | Conic) or not a.bounds().apart(piece.bounds(), tolerance):
            found += [Candidate(c.t, (c.u + k) / m) for c in _candidates(a, piece, tolerance)]
    return found


def _rank(curve: Curve) -> int:
    return next(
        i for i, kind in enumerate((Line, Conic, Bezier, BSpline)) if isinstance(curve, kind)
    )


class _Pair:
    """Two curves, which of them are extended, and the tolerance."""

    def __init__(
        self, a: Curve, b: Curve, extend_a: bool, extend_b: bool, tolerance: float
    ) -> None:
        self.a, self.b, self.tolerance = a, b, tolerance
        self.free_a, self.free_b = extend_a or a.closed, extend_b or b.closed
        self.extend_a, self.extend_b = extend_a, extend_b

    def ends(self) -> Iterator[Candidate]:
        """Ends of either curve that lie on the other."""
        if not self.a.closed:
            for t in (0.0, 1.0):
                foot = self.b.nearest(self.a.point_at(t), carrier=self.extend_b)
                if foot.distance <= self.tolerance:
                    yield Candidate(t, foot.t)
        if not self.b.closed:
            for u in (0.0, 1.0):
                foot = self.a.nearest(self.b.point_at(u), carrier=self.extend_a)
                if foot.distance <= self.tolerance:
                    yield Candidate(foot.t, u)

    def overlaps(self, touching: list[Candidate]) -> list[tuple[float, float]]:
        """Intervals of the parameter of `a` that lie on `b`."""
        if self.a.closed and self.b.closed:
            return [(0.0, 1.0)] if self._follows(0.0, 1.0) else []
        ts = sorted({c.t for c in touching})
        if len(ts) < 2:
            return []
        if self.a.closed:
            ts.append(ts[0] + 1.0)
        found: list[tuple[float, float]] = []
        for start, end in pairwise(ts):
            length = gap(self.a.point_at(start), self.a.point_at(end))
            if (length > 4 * self.tolerance or end - start > 0.3) and self._follows(start, end):
                if found and found[-1][1] == start:
                    start = found.pop()[0]
                found.append((start, end))
        return found

    def _follows(self, start: float, end: float) -> bool:
        """Whether `a` stays on `b`: curves of degree 3 at most that agree at so many points."""
        return all(
            self.b.nearest(self.a.point_at(start + f * (end - start)), carrier=self.extend_b)
            .distance <= 2 * self.tolerance
            for f in (0.5, 0.25, 0.75, 0.1, 0.9, 0.35, 0.62, 0.82, 0.17, 0.44)
        )  # fmt: skip

    def overlap_end(self, t: float) -> Contact:
        """Contact at an end of a shared stretch."""
        point = self.a.point_at(t)
        u = self.b.nearest(point, carrier=self.extend_b).t
        return Contact(point, t, u, "overlap")

    def contact(self, candidate: Candidate) -> Contact | None:
        """The contact, if it lies on both curves: parameters just beyond an end are that end."""
        t = self._kept(self.a, candidate.t, self.free_a)
        u = self._kept(self.b, candidate.u, self.free_b)
        if t is None or u is None:
            return None
        point, other = self.a.point_at(t), self.b.point_at(u)
        if gap(point, other) > 4 * self.tolerance:
            return None
        point = 0.5 * (point[0] + other[0]), 0.5 * (point[1] + other[1])
        tangent = candidate.tangent or self._touches(t, u)
        return Contact(point, t, u, "tangent" if tangent else "crossing")

    def _kept(self, curve: Curve, t: float, free: bool) -> float | None:
        if free or 0.0 <= t <= 1.0:
            return t
        end = 0.0 if t < 0.5 else 1.0
        near = gap(curve.point_at(t), curve.point_at(end)) <= self.tolerance
        return end if near and abs(t - end) < 0.25 else None

    def _touches(self, t: float, u: float) -> bool:
        """Whether two curves that cross here penetrate each other by less than the tolerance."""
        try:
            d, e = self.a.tangent_at(t), self.b.tangent_at(u)
        except DegenerateError:
            return False
        sine = abs(cross(d, e))
        if sine > 0.05:
            return False
        if sine <= 1e-12:
            return True
        one, two = self.a.derivative_at(t), self.b.derivative_at(u)
        if not (norm(one) > 0.0 and norm(two) > 0.0):
            return False
        same = 1.0 if dot(d, e) > 0 else -1.0
        bend = abs(self.a.curvature_at(t) - same * self.b.curvature_at(u))
        return sine <= sqrt(8.0 * self.tolerance * bend)

    def merged(self, found: list[Contact]) -> list[Contact]:
        """Each point once: ends and roots, and the two roots at a contact."""
        kept: list[Contact] = []
        for contact in sorted(found, key=lambda c: (c.kind != "tangent", c.t)):
            if not any(self._same(contact, other) for other in kept):
                kept.append(contact)
        return kept

    def _same(self, a: Contact, b: Contact) -> bool:
        distance = gap(a.point, b.point)
        if distance > 8 * self.tolerance:
            if b.kind != "tangent" or abs(a.t - b.t) > 0.01:
                return False
            between = self.a.point_at(0.5 * (a.t + b.t))
            foot = self.b.nearest(between, carrier=self.extend_b)
            return foot.distance <= self.tolerance and a.kind == "tangent"
        # a point of a double curve (a loop) is two contacts: parameters differ, not by a turn
        dt, du = abs(a.t - b.t), abs(a.u - b.u)
        return _near(dt, self.a) and _near(du, self.b)


def _near(difference: float, curve: Curve) -> bool:
    if curve.closed:
        difference = min(difference % 1.0, 1.0 - difference % 1.0)
    return difference < 0.01
