"""Constructions have the properties that define them, at every scale."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from arael.sketch.geometry import (
    Arc,
    Bezier,
    BSpline,
    Circle,
    Curve,
    Ellipse,
    EllipticArc,
    Line,
    Point,
    angle_between,
    arc_tangent,
    arc_through,
    area,
    chain_area,
    chain_length,
    chains,
    chamfer,
    circle_through,
    circles_tangent_to_three,
    circles_tangent_to_two,
    corner,
    curve_of,
    elliptic_arc,
    elliptic_arc_tangent,
    elliptic_arc_through,
    fillet,
    numbers_of,
    sector_angle,
)
from arael.sketch.geometry import coordinates as c
from tests.sketch.geometry.strategies import ANGLES, CURVES, LINES, POINTS, RADII, SCALES

FEW = settings(max_examples=80, deadline=None)


def sine(a: Line, b: Line) -> float:
    (ax, ay), (bx, by) = a.tangent_at(0), b.tangent_at(0)
    return abs(ax * by - ay * bx)


@FEW
@given(POINTS, POINTS, POINTS, SCALES)
def test_a_circle_through_three_points(p: Point, q: Point, r: Point, scale: float) -> None:
    u, v = np.subtract(q, p), np.subtract(r, p)
    assume(abs(u[0] * v[1] - u[1] * v[0]) > 0.01)
    three = [(x * scale, y * scale) for x, y in (p, q, r)]
    circle = circle_through(*three)
    assert circle is not None
    for at in three:
        assert math.dist(at, circle.center) == pytest.approx(circle.radius, rel=1e-9)


def test_points_on_a_line_have_no_circle() -> None:
    assert circle_through((0, 0), (1, 1), (2, 2)) is None
    assert circle_through((0, 0), (0, 0), (2, 2)) is None


@FEW
@given(LINES, LINES, RADII, SCALES)
def test_circles_tangent_to_two_lines(a: Line, b: Line, radius: float, scale: float) -> None:
    assume(sine(a, b) > 0.05)
    a, b, radius = a.scaled(scale), b.scaled(scale), radius * scale
    found = circles_tangent_to_two(a, b, radius)
    assert len({(round(t.circle.center[0] / scale, 6), round(t.circle.center[1] / scale, 6))
                for t in found}) == 4  # fmt: skip
    for tangency in found:
        for line, at in zip((a, b), tangency.contacts, strict=True):
            assert abs(line.signed_distance(tangency.circle.center)) == pytest.approx(radius)
            assert math.dist(at, tangency.circle.center) == pytest.approx(radius)


@FEW
@given(LINES, LINES, LINES, SCALES)
def test_circles_tangent_to_three_lines(a: Line, b: Line, d: Line, scale: float) -> None:
    assume(min(sine(a, b), sine(b, d), sine(a, d)) > 0.1)
    lines = [line.scaled(scale) for line in (a, b, d)]
    found = circles_tangent_to_three(*lines)
    corners = [c.intersect(lines[i], lines[i - 1]) for i in range(3)]
    assume(all(p is not None for p in corners))
    if max(math.dist(corners[i], corners[i - 1]) for i in range(3)) > 0.1 * scale:  # type: ignore[arg-type]
        assert len(found) == 4
    for tangency in found:
        for line in lines:
            distance = abs(line.signed_distance(tangency.circle.center))
            assert distance == pytest.approx(tangency.circle.radius, rel=1e-6)


def test_the_incircle_lies_on_the_sides() -> None:
    sides = Line((0, 0), (3, 0)), Line((3, 0), (0, 4)), Line((0, 4), (0, 0))
    (inner,) = (t for t in circles_tangent_to_three(*sides) if t.on_segments)
    assert inner.circle.radius == pytest.approx(1)
    assert inner.circle.center == pytest.approx((1, 1))
    assert circles_tangent_to_two(sides[0], sides[0].shifted((0, 1)), 1) == []


@FEW
@given(POINTS, ANGLES, ANGLES, RADII, SCALES)
def test_fillets_are_tangent(at: Point, u: float, v: float, radius: float, scale: float) -> None:
    assume(abs(math.sin(u - v)) > 0.05)
    radius *= scale
    at = at[0] * scale, at[1] * scale
    a, b = (
        Line(at, (at[0] + 99 * scale * math.cos(w), at[1] + 99 * scale * math.sin(w)))
        for w in (u, v)
    )
    found = corner(a, b)
    assert found is not None
    rounded = fillet(found, radius)
    assert rounded is not None
    assert 0 < rounded.arc.sweep < math.pi
    assert rounded.arc.sweep == pytest.approx(math.pi - abs(angle_between(a, b)))
    for line, contact in zip((a, b), rounded.contacts, strict=True):
        assert line.nearest(contact).distance < 1e-8 * scale
        assert math.dist(contact, found.point) == pytest.approx(rounded.trim)
        assert abs(line.signed_distance(rounded.arc.center)) == pytest.approx(radius, rel=1e-6)
        ends = (rounded.arc.start, rounded.arc.end)
        assert min(math.dist(contact, end) for end in ends) < 1e-8 * scale
    # the arc bulges towards the corner
    assert math.dist(rounded.arc.point_at(0.5), found.point) < rounded.trim


def test_chamfers_cut_at_the_distances() -> None:
    at = corner(Line((1, 1), (4, 1)), Line((1, 5), (1, 1)))
    assert at is not None
    assert chamfer(at, 1) == Line((2, 1), (1, 2))
    assert chamfer(at, 1, 2) == Line((2, 1), (1, 3))
    assert corner(Line((0, 0), (1, 0)), Line((0, 1), (1, 1))) is None


@FEW
@given(POINTS, POINTS, POINTS, SCALES)
def test_arcs_through_a_point(p: Point, q: Point, r: Point, scale: float) -> None:
    u, v = np.subtract(q, p), np.subtract(r, p)
    assume(abs(u[0] * v[1] - u[1] * v[0]) > 0.01)
    p, q, r = ((x * scale, y * scale) for x, y in (p, q, r))
    arc = arc_through(p, q, r)
    assert arc is not None
    assert math.dist(arc.start, p) < 1e-8 * scale * max(1, arc.radius / scale)
    assert math.dist(arc.end, q) < 1e-8 * scale * max(1, arc.radius / scale)
    assert arc.nearest(r).distance < 1e-8 * scale * max(1, arc.radius / scale)
    assert arc_through(p, r, q) is not None
    assert arc_through((0, 0), (2, 0), (1, 0)) is None


@FEW
@given(POINTS, ANGLES, POINTS)
def test_arcs_tangent_at_their_start(start: Point, heading: float, end: Point) -> None:
    assume(math.dist(start, end) > 0.05)
    direction = math.cos(heading), math.sin(heading)
    arc = arc_tangent(start, direction, end)
    if arc is None or arc.radius > 1e4:
        return
    assert arc.start == pytest.approx(start, abs=1e-9)
    assert arc.end == pytest.approx(end, abs=1e-9)
    assert arc.tangent_at(0) == pytest.approx(direction, abs=1e-9)


def test_an_arc_tangent_to_its_chord_is_a_line() -> None:
    assert arc_tangent((0, 0), (1, 0), (5, 0)) is None
    back = arc_tangent((0, 0), (1, 0), (0, 2))
    assert back is not None
    assert back.sweep == pytest.approx(math.pi)


@FEW
@given(POINTS, POINTS, RADII, RADII, ANGLES, st.booleans(), st.booleans(), SCALES)
def test_elliptic_arcs_of_svg(
    p: Point, q: Point, rx: float, ry: float, turn: float, large: bool, cw: bool, scale: float
) -> None:
    assume(math.dist(p, q) > 0.05)
    p, q = ((x * scale, y * scale) for x, y in (p, q))
    arc = elliptic_arc(p, q, rx * scale, ry * scale, turn, large=large, clockwise=cw)
    assert arc is not None
    assert arc.start == pytest.approx(p, abs=1e-7 * scale)
    assert arc.end == pytest.approx(q, abs=1e-7 * scale)
    assert (arc.sweep < 0) == cw
    if arc.rx > rx * scale * 1.0001:  # scaled up: half an ellipse
        assert abs(arc.sweep) == pytest.approx(math.pi, abs=1e-5)
    else:
        assert (abs(arc.sweep) > math.pi + 1e-7) <= large
        assert (abs(arc.sweep) < math.pi - 1e-7) <= (not large)


def test_an_elliptic_arc_passes_near_the_third_point() -> None:
    arc = elliptic_arc_through((0, 0), (5, 0), (2.5, 1), 3, 1)
    assert arc is not None
    assert arc.point_at(0.5)[1] > 0
    large = elliptic_arc_through((0, 0), (5, 0), (2.5, 9), 3, 3)
    assert large is not None
    assert abs(large.sweep) > math.pi


@FEW
@given(POINTS, POINTS, ANGLES, ANGLES, st.sampled_from([0.2, 0.5, 1.0, 2.0]))
def test_elliptic_arcs_between_tangents(
    p: Point, q: Point, u: float, v: float, bulge: float
) -> None:
    assume(math.dist(p, q) > 0.1 and abs(math.sin(u - v)) > 0.05)
    d, e = (math.cos(u), math.sin(u)), (math.cos(v), math.sin(v))
    arc = elliptic_arc_tangent(p, d, q, e, bulge)
    if arc is None or max(arc.rx, arc.ry) > 1e3 or min(arc.rx, arc.ry) < 1e-3:
        return
    assert arc.start == pytest.approx(p, abs=1e-7)
    assert arc.end == pytest.approx(q, abs=1e-7)
    assert arc.tangent_at(0) == pytest.approx(d, abs=1e-6)
    assert arc.tangent_at(1) == pytest.approx(e, abs=1e-6)
    # the whole ellipse runs through a point beside the middle of the chord
    x, y = 0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])
    dx, dy = 0.5 * bulge * (p[1] - q[1]), 0.5 * bulge * (q[0] - p[0])
    whole = Ellipse(arc.center, arc.rx, arc.ry, arc.rotation)
    gaps = [whole.nearest((x + k * dx, y + k * dy)).distance for k in (1, -1)]
    assert min(gaps) == pytest.approx(0.0, abs=1e-6)


def test_elliptic_arcs_between_equal_tangents_are_circular() -> None:
    quarter = elliptic_arc_tangent((1, 0), (0, 1), (0, 1), (-1, 0))
    assert quarter is not None
    assert (quarter.rx, quarter.ry) == pytest.approx((1, 1))
    half = elliptic_arc_tangent((1, 0), (0, 1), (-1, 0), (0, -1))
    assert half is not None
    assert half.point_at(0.5) == pytest.approx((0, 1))
    most = elliptic_arc_tangent((1, 0), (0, 1), (0, -1), (1, 0))
    assert most is not None
    assert most.point_at(0.5) == pytest.approx((-math.sqrt(0.5), math.sqrt(0.5)))
    assert elliptic_arc_tangent((0, 0), (1, 0), (5, 3), (0, -1)) is None
    assert elliptic_arc_tangent((0, 0), (1, 0), (5, 0), (1, 0)) is None


@FEW
@given(st.lists(CURVES.filter(lambda curve: not curve.closed), min_size=1, max_size=4), POINTS)
def test_areas_are_those_of_the_sampled_chain(curves: list[Curve], by: Point) -> None:
    moved: list[Curve] = []
    for curve in curves:
        at = moved[-1].end if moved else (0.0, 0.0)
        moved.append(curve.shifted((at[0] - curve.start[0], at[1] - curve.start[1])))
    moved.append(Line(moved[-1].end, moved[0].start))
    xy = np.array([curve.point_at(t) for curve in moved for t in np.linspace(0, 1, 2001)])
    x, y = xy.T
    shoelace = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area(moved) == pytest.approx(shoelace, abs=2e-4)
    assert area([curve.shifted(by) for curve in moved]) == pytest.approx(area(moved), abs=1e-9)
    assert chain_length(moved) == pytest.approx(sum(m.length() for m in moved))


def test_areas_of_whole_curves() -> None:
    assert area([Circle((5, 5), 2)]) == pytest.approx(4 * math.pi)
    assert area([Ellipse((5, 5), 2, 3, 0.4)]) == pytest.approx(6 * math.pi)
    assert area([Circle((5, 5), 2).reversed()]) == pytest.approx(-4 * math.pi)
    assert area([Bezier(((0, 0), (0, 0), (1, 0), (1, 0))), Line((1, 0), (0, 0))]) == 0
    assert area([]) == 0


def test_chains_are_ordered_and_directed() -> None:
    square = [
        Line((0, 0), (1, 0)),
        Line((1, 1), (1, 0)),
        Line((0, 1), (1, 1)),
        Line((0, 1), (0, 0)),
    ]
    loose = Arc((9, 9), 1, 0, 1)
    found = chains([square[2], loose, *square[:2], square[3], Circle((4, 4), 1)], 1e-9)
    assert [(len(chain.links), chain.closed) for chain in found] == [
        (4, True),
        (1, False),
        (1, True),
    ]
    curves = found[0].curves([square[2], loose, *square[:2], square[3]])
    assert abs(area(curves)) == 1
    for a, b in zip(curves, curves[1:] + curves[:1], strict=True):
        assert math.dist(a.end, b.start) < 1e-12


def test_chains_end_where_three_ends_meet() -> None:
    star = [Line((0, 0), (math.cos(a), math.sin(a))) for a in (0, 2, 4)]
    assert [chain.closed for chain in chains(star, 1e-9)] == [False] * 3


def test_an_open_chain_starts_at_one_of_its_ends() -> None:
    path = [Line((1, 0), (2, 0)), Line((0, 0), (1, 0)), Line((3, 0), (2, 0))]
    (chain,) = chains(path, 1e-9)
    assert not chain.closed
    ordered = chain.curves(path)
    assert sorted([ordered[0].start, ordered[-1].end]) == [(0, 0), (3, 0)]


def test_angles_are_signed_and_have_sectors() -> None:
    a, b = Line((0, 0), (1, 0)), Line((0, 0), (-1, 1))
    found = angle_between(a, b)
    assert math.degrees(found) == pytest.approx(135)
    assert angle_between(b, a) == -found
    sectors = {s: math.degrees(sector_angle(found, s)) for s in ("supplement", "acute", "obtuse")}  # type: ignore[arg-type]
    assert sectors == pytest.approx({"supplement": -45, "acute": 45, "obtuse": 135})
    assert math.degrees(sector_angle(found, "closest", math.radians(50))) == pytest.approx(45)
    assert math.degrees(sector_angle(found, "closest", math.radians(-120))) == pytest.approx(-135)


@pytest.mark.parametrize("tiny", [1e-9, 1e-12])
def test_small_angles_keep_their_digits(tiny: float) -> None:
    assert angle_between(Line((0, 0), (1, 0)), Line((0, 0), (1, tiny))) == pytest.approx(tiny)


COORDINATES: dict[str, tuple[Callable[[], object], object]] = {
    "intersect": (lambda: c.intersect(Line((0, 0), (1, 0)), Line((3, 1), (3, 2))), (3, 0)),
    "midpoint": (lambda: c.midpoint(Line((0, 0), (4, 2))), (2, 1)),
    "midpoint of an arc": (lambda: c.midpoint(Arc((0, 0), 1, 0, math.pi)), (0, 1)),
    "midpoint of points": (lambda: c.midpoint((0, 0), (2, 2)), (1, 1)),
    "project": (lambda: c.project((5, 3), Line((0, 0), (1, 0))), (5, 0)),
    "project on a circle": (lambda: c.project((0, 9), Arc((0, 0), 1, -1, 0.5)), (0, 1)),
    "along": (lambda: c.along(Line((0, 0), (4, 2)), 0.25), (1, 0.5)),
    "arc_point": (lambda: c.arc_point(Arc((1, 0), 2, 0, 1), math.pi / 2), (1, 2)),
    "arc_point of an ellipse": (lambda: c.arc_point(Ellipse((0, 0), 3, 2), math.pi / 2), (0, 2)),
    "rotate": (lambda: c.rotate((2, 1), (1, 1), math.pi / 2), (1, 2)),
    "mirror": (lambda: c.mirror((2, 1), Line((0, 0), (3, 3))), (1, 2)),
    "scale": (lambda: c.scale((3, 1), (1, 1), 2), (5, 1)),
    "shift": (lambda: c.shift((3, 1), (1, 1)), (4, 2)),
    "tangent": (lambda: c.tangent(Line((0, 0), (0, 5))), (0, 1)),
    "normal": (lambda: c.normal(Line((0, 0), (0, 5))), (-1, 0)),
    "towards": (lambda: c.towards((1, 1), (1, 9), 2), (1, 3)),
    "dist": (lambda: c.distance((0, 0), (3, 4)), 5),
    "dist to a line": (lambda: c.distance((9, 3), Line((0, 0), (1, 0))), 3),
    "dist to a circle": (lambda: c.distance((9, 0), EllipticArc((0, 0), 1, 1, 0, 2, 1)), 8),
}


@pytest.mark.parametrize("name", COORDINATES)
def test_functions_of_coordinates(name: str) -> None:
    call, expected = COORDINATES[name]
    assert call() == pytest.approx(expected, abs=1e-15)


def test_parallel_lines_have_no_intersection() -> None:
    assert c.intersect(Line((0, 0), (1, 0)), Line((0, 1), (1, 1))) is None


def test_b_splines_need_four_poles() -> None:
    with pytest.raises(ValueError, match="at least 4 poles, not 3"):
        BSpline(((0, 0), (1, 0), (2, 0)))


@FEW
@given(CURVES)
def test_numbers_of_entities_are_curves_and_back(curve: Curve) -> None:
    kind, numbers = numbers_of(curve)
    again = curve_of(kind, numbers)
    forward = curve.forward() if isinstance(curve, Arc | EllipticArc) else curve
    for t in (0, 0.3, 1):
        assert math.dist(again.point_at(t), forward.point_at(t)) < 1e-7
    assert numbers_of(again)[0] == kind


def test_the_area_of_blocks_in_any_order() -> None:
    square = [("line", [0, 0, 2, 0]), ("line", [0, 0, 0, 2]), ("line", [2, 2, 2, 0])]
    top = ("arc", [1, 2, 2, 2, 0, 2, 1])
    assert chain_area([*square, top]) == pytest.approx(4 + math.pi / 2)
    assert chain_area([("circle", [0, 0, 1])]) == pytest.approx(math.pi)
