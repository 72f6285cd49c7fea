"""Curves of every kind for property tests, at any scale."""

from __future__ import annotations

from math import pi

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
)

COORDINATES = st.floats(-2, 2).map(lambda x: round(x, 3))
POINTS = st.tuples(COORDINATES, COORDINATES)
RADII = st.floats(0.1, 2).map(lambda x: round(x, 3))
ANGLES = st.floats(-7, 7).map(lambda x: round(x, 3))
SWEEPS = st.one_of(st.floats(0.05, 2 * pi), st.floats(-2 * pi, -0.05))

LINES = st.builds(Line, POINTS, POINTS).filter(lambda line: line.length() > 0.05)
CIRCLES = st.builds(Circle, POINTS, RADII)
ARCS = st.builds(Arc, POINTS, RADII, ANGLES, SWEEPS)
ELLIPSES = st.builds(Ellipse, POINTS, RADII, RADII, ANGLES)
ELLIPTIC_ARCS = st.builds(EllipticArc, POINTS, RADII, RADII, ANGLES, ANGLES, SWEEPS)


def spread(poles: tuple[Point, ...]) -> bool:
    """Whether the poles do not all lie together."""
    return max(abs(x - poles[0][0]) + abs(y - poles[0][1]) for x, y in poles) > 0.2


BEZIERS = st.builds(Bezier, st.tuples(POINTS, POINTS, POINTS, POINTS).filter(spread))
BSPLINES = st.builds(BSpline, st.lists(POINTS, min_size=4, max_size=8).map(tuple).filter(spread))
CURVES: st.SearchStrategy[Curve] = st.one_of(
    LINES, CIRCLES, ARCS, ELLIPSES, ELLIPTIC_ARCS, BEZIERS, BSPLINES
)
SCALES = st.sampled_from([1e-6, 1e-3, 1.0, 1e3, 1e6])
