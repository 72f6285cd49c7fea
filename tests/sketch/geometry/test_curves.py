"""Every kind of curve against sampling and independent implementations."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.integrate import quad
from scipy.interpolate import BSpline as ReferenceSpline
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from arael.sketch.geometry import (
    Affine,
    Arc,
    Bezier,
    BSpline,
    Circle,
    Curve,
    DegenerateError,
    Ellipse,
    EllipticArc,
    Line,
    Point,
)
from arael.sketch.geometry.splines import poles_through
from tests.sketch.geometry.strategies import BSPLINES, CURVES, POINTS, SCALES

FEW = settings(max_examples=60, deadline=None)


def points(curve: Curve, count: int = 400) -> np.ndarray:
    return np.array([curve.point_at(t) for t in np.linspace(0, 1, count + 1)])


@FEW
@given(CURVES, POINTS)
def test_nearest_is_not_beaten_by_a_sampled_point(curve: Curve, point: Point) -> None:
    t, distance = curve.nearest(point)
    assert math.dist(curve.point_at(t), point) == pytest.approx(distance, abs=1e-12)
    assert 0 <= t <= 1
    gaps = np.hypot(*(points(curve) - point).T)
    k = int(np.argmin(gaps))
    found = minimize_scalar(
        lambda s: math.dist(curve.point_at(s), point),
        bounds=(max(k - 1, 0) / 400, min(k + 1, 400) / 400),
        method="bounded",
        options={"xatol": 1e-12},
    )
    assert distance <= found.fun + 1e-9


@FEW
@given(CURVES, SCALES)
def test_length_agrees_with_quadrature_at_every_scale(curve: Curve, scale: float) -> None:
    def speed(t: float) -> float:
        return math.hypot(*curve.derivative_at(t))

    # joints of spans and cusps are the places where the speed is not smooth
    breaks = np.linspace(0, 1, 41)
    reference = sum(quad(speed, a, b, epsabs=1e-12, limit=200)[0] for a, b in pairwise(breaks))
    assert curve.length() == pytest.approx(reference, rel=1e-8)
    assert curve.scaled(scale).length() == pytest.approx(scale * curve.length(), rel=1e-9)


@FEW
@given(CURVES)
def test_bounds_are_those_of_the_sampled_curve(curve: Curve) -> None:
    found = points(curve, 2000)
    box = curve.bounds()
    low, high = found.min(0), found.max(0)
    assert np.all(np.array(box[:2]) <= low + 1e-12)
    assert np.all(np.array(box[2:]) >= high - 1e-12)
    np.testing.assert_allclose(box, [*low, *high], atol=2e-3)


@FEW
@given(CURVES)
def test_derivatives_are_those_of_differences(curve: Curve) -> None:
    t, h = 0.37, 1e-5
    p, q, r = (np.array(curve.point_at(t + k * h)) for k in (-1, 0, 1))
    np.testing.assert_allclose(curve.derivative_at(t), (r - p) / (2 * h), atol=2e-5)
    np.testing.assert_allclose(curve.second_at(t), (p - 2 * q + r) / h**2, rtol=1e-3, atol=0.05)


@FEW
@given(CURVES)
def test_pieces_of_a_split_are_the_curve(curve: Curve) -> None:
    pieces = curve.split(0.3, 0.71)
    assert len(pieces) >= (2 if curve.closed else 3)
    for piece in pieces:
        for s in (0, 0.4, 1):
            expected = curve.point_at(piece.start + s * (piece.end - piece.start))
            assert math.dist(piece.curve.point_at(s), expected) < 1e-11
    assert sum(p.curve.length() for p in pieces) == pytest.approx(curve.length(), rel=1e-9)


@FEW
@given(CURVES)
def test_reversed_travels_the_same_points(curve: Curve) -> None:
    back = curve.reversed()
    for t in (0, 0.23, 1):
        assert math.dist(back.point_at(t), curve.point_at(1 - t)) < 1e-12
    assert back.length() == pytest.approx(curve.length(), rel=1e-12)


@FEW
@given(CURVES, POINTS, POINTS)
def test_affine_images_are_the_images_of_points(curve: Curve, u: Point, v: Point) -> None:
    skewed = Affine(1 + u[0] / 3, v[0] / 5, 0.3, 1.2 + v[1] / 4, *u)
    maps = [skewed, Affine.rotation(1.1, u), Affine.scaling(2.5, v)]
    if math.dist(u, v) > 0.1:
        maps.append(Affine.mirror(u, v))
    for by in maps:
        image = curve.transformed(by)
        for t in (0, 0.37, 1):
            at = by(curve.point_at(t))
            gap = image.nearest(at).distance if curve.closed else math.dist(image.point_at(t), at)
            assert gap < 1e-7 if curve.closed else gap < 1e-11


@FEW
@given(CURVES)
def test_samples_stay_within_the_tolerance(curve: Curve) -> None:
    tolerance = 1e-3
    polyline = curve.sample(tolerance)
    assert math.dist(polyline[0], curve.start) < 1e-12
    assert math.dist(polyline[-1], curve.end) < 1e-12
    segments = [Line(a, b) for a, b in pairwise(polyline)]
    for t in np.linspace(0.003, 0.997, 31):
        at = curve.point_at(t)
        assert min(segment.nearest(at).distance for segment in segments) <= tolerance * 1.0001


@FEW
@given(CURVES)
def test_normal_curvature_and_offset_agree(curve: Curve) -> None:
    t, d = 0.413, 1e-3
    if math.hypot(*curve.derivative_at(t)) < 0.3:
        return  # close to a cusp
    n = curve.normal_at(t)
    assert math.hypot(*n) == pytest.approx(1)
    x, y = curve.point_at(t)
    assert curve.offset_point(t, d) == pytest.approx((x + d * n[0], y + d * n[1]))
    h = 1e-5
    a, b = curve.tangent_at(t - h), curve.tangent_at(t + h)
    turn = math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
    step = math.hypot(*curve.derivative_at(t)) * 2 * h
    assert curve.curvature_at(t) == pytest.approx(turn / step, rel=2e-3, abs=1e-2)


@FEW
@given(BSPLINES)
def test_b_splines_are_those_of_scipy(curve: BSpline) -> None:
    m = curve.spans
    knots = np.concatenate([[0] * 3, np.arange(m + 1), [m] * 3]) / m
    reference = ReferenceSpline(knots, np.array(curve.poles), 3)
    for t in (0, 0.1, 0.5, 0.77, 1):
        np.testing.assert_allclose(curve.point_at(t), reference(t), atol=1e-12)
        np.testing.assert_allclose(curve.derivative_at(t), reference(t, 1), atol=1e-9)


def test_a_spline_through_points_is_the_natural_one() -> None:
    points = [(0.0, 0.0), (4.0, 8.0), (10.0, -4.0), (10.0, -4.0), (3.0, 1.0), (-2.0, 5.0)]
    curve = BSpline(poles_through(points))
    assert curve.spans == len(points) - 1
    reference = CubicSpline(np.arange(6), np.array(points), bc_type="natural")
    for t in np.linspace(0, 1, 23):
        np.testing.assert_allclose(curve.point_at(float(t)), reference(5 * t), atol=1e-12)
    # by hand: slopes 1.5, 0, -1.5 in y at equal steps
    poles = poles_through([(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)])
    assert np.array(poles)[:, 1] == pytest.approx([0, 0.5, 1.5, 0.5, 0])


def test_a_b_spline_cut_at_knots_stays_b_splines() -> None:
    curve = BSpline(tuple((float(i), float(i * i % 5)) for i in range(9)))
    first, last = (piece.curve for piece in curve.split(2 / 6))
    assert isinstance(last, BSpline) and len(last.poles) == 7
    assert isinstance(first, BSpline) and len(first.poles) == 5
    with pytest.raises(ValueError, match="split it"):
        curve.part(0.1, 0.9)


@pytest.mark.parametrize("ratio", [1 + 1e-12, 1.01, 2, 1e3, 1e6])
@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
def test_feet_on_thin_and_nearly_round_ellipses(ratio: float, scale: float) -> None:
    ellipse = Ellipse((3 * scale, -2 * scale), scale * ratio, scale, 0.4)
    for angle in np.linspace(-3, 3, 13):
        on = ellipse.at_angle(angle)
        assert ellipse.nearest(on).distance <= 2e-15 * scale * ratio + 2e-8 * scale
        t = ellipse.parameter(angle)
        outside = ellipse.offset_point(t, -2 * scale)  # to the right: outwards
        assert ellipse.nearest(outside).distance == pytest.approx(2 * scale, rel=1e-9)


def test_feet_of_the_centre_and_of_points_on_the_axes() -> None:
    assert Circle((1, 1), 2).nearest((1, 1)).distance == 2
    ellipse = Ellipse((0, 0), 3, 2)
    assert ellipse.nearest((0, 0)).distance == 2
    assert ellipse.nearest((5, 0)).distance == 2
    assert ellipse.nearest((0, -5)).distance == 3
    # the other side of the long axis is nearer on the arc that is left
    lower = EllipticArc((0, 0), 3, 2, 0, math.pi, math.pi)
    assert lower.nearest((0.2, 0.1)).distance == pytest.approx(2.095, abs=0.01)


def test_parameters_off_an_arc_lie_beyond_its_nearer_end() -> None:
    arc = Arc((0, 0), 1, 0, 1.0)
    assert arc.parameter(-0.1) == pytest.approx(-0.1)
    assert arc.parameter(1.1) == pytest.approx(1.1)
    assert arc.nearest((1, -1)).t == 0
    assert arc.nearest((1, -1), carrier=True).t == pytest.approx(-math.pi / 4)


def test_arcs_between_points_run_counter_clockwise() -> None:
    arc = Arc.between((0, 0), (1, 0), (0, 1))
    assert (arc.angle, arc.sweep) == (0, math.pi / 2)
    assert Arc.between((0, 0), (0, 1), (1, 0)).sweep == pytest.approx(3 * math.pi / 2)
    assert Arc.between((0, 0), (1, 0), (2, 0)).sweep == 2 * math.pi
    oval = EllipticArc.between((0, 0), (2, 0), (0, 1), 2, 1, 0)
    assert oval.sweep == pytest.approx(math.pi / 2)
    assert oval.end == pytest.approx((0, 1))


def test_a_mirrored_arc_runs_clockwise_until_it_is_turned_forward() -> None:
    arc = Arc((2, 0), 1, 0.1, 1.0).mirrored((0, 0), (0, 1))
    assert arc.sweep == -1.0
    assert arc.forward().sweep == 1.0
    assert arc.forward().start == pytest.approx(arc.end)


def test_a_collapsed_line_has_no_direction() -> None:
    line = Line((1, 1), (1, 1))
    assert line.nearest((2, 1)) == (0, 1)
    with pytest.raises(DegenerateError, match="no direction"):
        line.tangent_at(0)


def test_tangents_of_repeated_poles_are_their_limits() -> None:
    curve = Bezier(((0, 0), (0, 0), (1, 1), (1, 1)))
    assert curve.tangent_at(0) == pytest.approx((math.sqrt(0.5),) * 2)
    assert curve.tangent_at(1) == pytest.approx((math.sqrt(0.5),) * 2)


def test_a_line_of_any_size_has_its_foot() -> None:
    for size in (1e-200, 1e-6, 1e6, 1e150):
        assert Line((0, 0), (size, 0)).nearest((size / 4, size)).t == pytest.approx(0.25)


@pytest.mark.parametrize("y", [1e-12, 1e-17, 4.7e-212, 5e-324, 0.0])
def test_the_foot_of_a_point_next_to_the_long_axis_of_an_ellipse(y: float) -> None:
    found = Ellipse((0.0, 0.0), 9.0, 4.0, 0.0).nearest((0.0, y))
    assert found.distance == pytest.approx(4.0)
