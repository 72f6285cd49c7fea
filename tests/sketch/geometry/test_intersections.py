"""Intersections of every pair of kinds against crossings of fine polylines."""

from __future__ import annotations

import math
from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from arael.sketch.geometry import (
    Affine,
    Arc,
    Bezier,
    BSpline,
    Circle,
    Contact,
    Curve,
    Ellipse,
    EllipticArc,
    Line,
    intersections,
)
from tests.sketch.geometry.strategies import (
    ARCS,
    BEZIERS,
    BSPLINES,
    CIRCLES,
    ELLIPSES,
    ELLIPTIC_ARCS,
    LINES,
    SCALES,
)

KINDS = [LINES, CIRCLES, ARCS, ELLIPSES, ELLIPTIC_ARCS, BEZIERS, BSPLINES]
NO_SHRINKING = [Phase.explicit, Phase.reuse, Phase.generate]
PAIRS = list(combinations_with_replacement(range(len(KINDS)), 2))


def polyline_crossings(a: Curve, b: Curve, count: int = 700) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of crossings of two sampled polylines, by every pair of segments."""
    ts = np.linspace(0, 1, count + 1)
    p, q = (np.array([c.point_at(t) for t in ts]) for c in (a, b))
    d, e = np.diff(p, axis=0)[:, None], np.diff(q, axis=0)[None]
    w = q[None, :-1] - p[:-1, None]
    with np.errstate(all="ignore"):
        det = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
        t = (w[..., 0] * e[..., 1] - w[..., 1] * e[..., 0]) / det
        u = (w[..., 0] * d[..., 1] - w[..., 1] * d[..., 0]) / det
    i, j = np.nonzero((t >= 0) & (t < 1) & (u >= 0) & (u < 1))
    return (i + t[i, j]) / count, (j + u[i, j]) / count


@pytest.mark.sweep(4)
@pytest.mark.parametrize("pair", PAIRS)
def test_every_clear_crossing_is_found(pair: tuple[int, int]) -> None:
    @settings(max_examples=12, deadline=None, phases=NO_SHRINKING)
    @given(KINDS[pair[0]], KINDS[pair[1]], SCALES)
    def check(a: Curve, b: Curve, scale: float) -> None:
        found = intersections(a.scaled(scale), b.scaled(scale))
        if any(contact.kind == "overlap" for contact in found):
            return
        ts, us = polyline_crossings(a, b)
        for contact in found:
            p, q = a.point_at(contact.t), b.point_at(contact.u)
            assert math.dist(p, q) < 4e-8
            assert contact.point == pytest.approx((p[0] * scale, p[1] * scale), abs=1e-7 * scale)
        for t, u in zip(ts, us, strict=True):
            # at a shallow angle, or at an end, the polyline may cross where the curve does not
            d, e = a.derivative_at(t), b.derivative_at(u)
            sine = abs(d[0] * e[1] - d[1] * e[0]) / (math.hypot(*d) * math.hypot(*e) + 1e-300)
            ends = [x for x, c in ((t, a), (u, b)) if not c.closed]
            if sine < 0.05 or any(min(x, 1 - x) < 0.01 for x in ends):
                continue
            at = a.point_at(t)
            gaps = [math.dist(a.point_at(c.t), at) for c in found]
            assert min(gaps, default=9) < 5e-3

    check()


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.sampled_from(PAIRS), st.data())
def test_the_other_order_finds_the_same(pair: tuple[int, int], data: st.DataObject) -> None:
    a, b = (data.draw(KINDS[i]) for i in pair)
    one, two = intersections(a, b), intersections(b, a)
    if any(c.kind != "crossing" for c in (*one, *two)):
        return
    assert len(one) == len(two)
    for contact in one:
        assert min(math.dist(contact.point, other.point) for other in two) < 1e-6


def kinds(found: list[Contact]) -> list[str]:
    return [contact.kind for contact in found]


PARABOLA = Bezier(((-1, 1), (-1 / 3, -1 / 3), (1 / 3, -1 / 3), (1, 1)))  # y = x^2
TANGENT = {
    "line and circle": (Line((-2, 1), (2, 1)), Circle((0, 0), 1)),
    "line and arc": (Line((-2, 1), (2, 1)), Arc((0, 0), 1, 0, 3)),
    "line and ellipse": (Line((-3, 1), (3, 1)), Ellipse((0, 0), 2, 1)),
    "line and Bezier": (Line((-1, 0), (1, 0)), PARABOLA),
    "line and B-spline": (Line((-1, 0), (1, 0)), BSpline(PARABOLA.poles)),
    "circles outside": (Circle((0, 0), 1), Circle((3, 0), 2)),
    "circles inside": (Circle((0, 0), 3), Circle((2, 0), 1)),
    "circles inside, other order": (Circle((2, 0), 1), Circle((0, 0), 3)),
    "circle and ellipse": (Circle((0, 3), 1), Ellipse((0, 0), 4, 2)),
    "ellipses": (Ellipse((0, 3), 2, 1), Ellipse((0, 0), 4, 2)),
    "circle and Bezier": (Circle((0, -1), 1), PARABOLA),
    "ellipse and Bezier": (Ellipse((0, -1), 2, 1), PARABOLA),
    "Beziers": (Bezier(((-1, -1), (-1 / 3, 1 / 3), (1 / 3, 1 / 3), (1, -1))), PARABOLA),
    "line ends on an arc": (Line((0, 1), (-2, 1)), Arc((0, 0), 1, 0, math.pi / 2)),
}


@pytest.mark.parametrize("case", TANGENT)
@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
@pytest.mark.parametrize("turn", [0.0, 1.234])
@pytest.mark.parametrize("far", [0.0, 1e3])
def test_tangent_contacts_are_one_contact(case: str, scale: float, turn: float, far: float) -> None:
    by = Affine.shift((far * scale, -far * scale)).after(
        Affine.rotation(turn).after(Affine.scaling(scale))
    )
    a, b = (curve.transformed(by) for curve in TANGENT[case])
    assert kinds(intersections(a, b)) == ["tangent"]
    assert kinds(intersections(b, a)) == ["tangent"]


@pytest.mark.parametrize("case", [c for c in TANGENT if "ends" not in c])
def test_contacts_missed_by_a_little_are_tangent_and_by_more_are_none(case: str) -> None:
    a, b = TANGENT[case]
    up = {
        "circles outside": (-1, 0),
        "circles inside": (1, 0),
        "circles inside, other order": (-1, 0),
    }.get(case, (0, 1))
    away = -1 if isinstance(a, Line) and isinstance(b, Bezier | BSpline) else 1
    if case in ("circle and Bezier", "ellipse and Bezier", "Beziers"):
        away = -1
    for gap, expected in ((5e-10, ["tangent"]), (1e-6, [])):
        moved = a.shifted((away * gap * up[0], away * gap * up[1]))
        assert kinds(intersections(moved, b)) == expected


OVERLAPS = {
    "lines": (Line((0, 0), (2, 0)), Line((1, 0), (5, 0)), (1, 0), (2, 0)),
    "lines, other direction": (Line((0, 0), (2, 0)), Line((5, 0), (1, 0)), (1, 0), (2, 0)),
    "line within": (Line((0, 0), (4, 0)), Line((1, 0), (2, 0)), (1, 0), (2, 0)),
    "arcs": (Arc((0, 0), 1, 0, 2), Arc((0, 0), 1, 1, 2), None, None),
    "arc on a circle": (Arc((0, 0), 1, 0, 2), Circle((0, 0), 1), None, None),
    "elliptic arcs": (
        EllipticArc((0, 0), 2, 1, 0.3, 0, 2),
        EllipticArc((0, 0), 2, 1, 0.3, 1, 2),
        None,
        None,
    ),
    "parts of a Bezier": (PARABOLA.part(0, 0.6), PARABOLA.part(0.4, 1), (-0.2, 0.04), (0.2, 0.04)),
    "Bezier of a spline": (PARABOLA, BSpline(PARABOLA.poles), (-1, 1), (1, 1)),
    "straight Bezier on a line": (
        Bezier(((0, 0), (1, 0), (2, 0), (3, 0))),
        Line((1, 0), (9, 0)),
        (1, 0),
        (3, 0),
    ),
}


@pytest.mark.parametrize("case", OVERLAPS)
@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
def test_overlaps_are_given_by_their_ends(case: str, scale: float) -> None:
    a, b, start, end = OVERLAPS[case]
    found = intersections(a.scaled(scale), b.scaled(scale))
    assert kinds(found) == ["overlap", "overlap"]
    if start is not None and end is not None:
        expected = [(scale * x, scale * y) for x, y in (start, end)]
        for contact, at in zip(found, expected, strict=True):
            assert contact.point == pytest.approx(at, abs=1e-8 * scale)


def test_the_same_circle_overlaps_all_round() -> None:
    found = intersections(Circle((0, 0), 1), Circle((0, 0), 1))
    assert [(c.kind, c.t) for c in found] == [("overlap", 0), ("overlap", 1)]


def test_arcs_of_one_circle_may_share_two_stretches() -> None:
    found = intersections(Arc((0, 0), 1, 0, 4), Arc((0, 0), 1, 3, 4))
    assert kinds(found) == ["overlap"] * 4


def test_lines_that_continue_each_other_touch_in_a_point() -> None:
    found = intersections(Line((0, 0), (1, 0)), Line((1, 0), (2, 0)))
    assert [(c.point, c.t, c.u) for c in found] == [((1, 0), 1, 0)]


def test_carriers_are_searched_only_where_they_are_extended() -> None:
    line, arc = Line((0, 2), (0, 3)), Arc((0, 0), 1, 0.1, 1.0)
    assert intersections(line, arc) == []
    assert intersections(line, arc, extend_a=True) == []
    found = intersections(line, arc, extend_a=True, extend_b=True)
    assert [c.point for c in found] == [pytest.approx((0, -1)), pytest.approx((0, 1))]
    assert [c.t for c in found] == pytest.approx([-3, -1])
    parallel = intersections(Line((0, 0), (1, 0)), Line((0, 1), (1, 1)), extend_a=True)
    assert parallel == []


def test_ends_that_touch_within_the_tolerance_are_contacts() -> None:
    line = Line((0, 0), (1 - 1e-10, 0))
    assert [c.t for c in intersections(line, Line((1, -1), (1, 1)))] == [1]
    assert intersections(line, Line((1, -1), (1, 1)), tolerance=1e-12) == []


@pytest.mark.parametrize("curve", [Circle((5, 0), 6), Ellipse((5, 0), 7, 6), Line((-5, 1), (6, 1))])
def test_a_line_of_a_rounding_error_crosses_nothing(curve: Curve) -> None:
    line = Line((1e-3, 0), (math.nextafter(1e-3, 1), 0))
    assert line.length() > 0
    assert intersections(line, curve) == intersections(curve, line) == []


def test_circles_of_ellipse_kind_cross_like_circles() -> None:
    a, b = Ellipse((0, 0), 1, 1, 0.7), Ellipse((1, 0), 1, 1, -2)
    found = sorted(c.point for c in intersections(a, b))
    assert found == [pytest.approx((0.5, -math.sqrt(0.75))), pytest.approx((0.5, math.sqrt(0.75)))]


def test_four_crossings_of_ellipses() -> None:
    assert len(intersections(Ellipse((0, 0), 2, 1), Ellipse((0, 0), 1, 2))) == 4


def test_nine_crossings_of_cubics() -> None:
    a = Bezier(((0, 0), (1, 8), (0, -7), (1, 1)))
    b = Bezier(((0, 0), (8, 1), (-7, 0), (1, 1)))
    found = intersections(a, b)
    ts, _ = polyline_crossings(a, b, 1500)
    assert len(found) >= 9 and len(found) in (len(ts), len(ts) + 1, len(ts) + 2)
