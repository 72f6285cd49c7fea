"""Symbols of constraints, drawn in a box from -1 to 1 (y downwards)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from arael.sketch.drawing.primitives import Segment, disc, polyline

Strokes = tuple[Segment, ...]

_LOCK = (
    *polyline((-0.62, -0.1), (0.62, -0.1), (0.62, 0.8), (-0.62, 0.8), close=True),
    ("M", (-0.38, -0.1)),
    ("C", (-0.4, -0.95, 0.4, -0.95, 0.38, -0.1)),
)

SYMBOLS: Mapping[str, Strokes] = MappingProxyType(
    {
        "horizontal": polyline((-0.8, 0), (0.8, 0)),
        "vertical": polyline((0, -0.8), (0, 0.8)),
        "parallel": (*polyline((-0.65, 0.7), (-0.05, -0.7)), *polyline((0.05, 0.7), (0.65, -0.7))),
        "perpendicular": (*polyline((0, -0.75), (0, 0.6)), *polyline((-0.75, 0.6), (0.75, 0.6))),
        "collinear": (
            *polyline((-0.9, 0.2), (-0.2, 0.2)),
            *polyline((0.2, 0.2), (0.9, 0.2)),
            *polyline((-0.55, -0.35), (0.55, -0.35)),
        ),
        "equal": (*polyline((-0.65, -0.3), (0.65, -0.3)), *polyline((-0.65, 0.3), (0.65, 0.3))),
        "equal_angle": (
            *polyline((0.75, 0.6), (-0.7, 0.6), (0.45, -0.65)),
            ("M", (0.2, 0.6)),
            ("C", (0.2, 0.2, 0.05, -0.05, -0.1, -0.1)),
        ),
        "tangent": (*disc(0, 0.2, 0.5), *polyline((-0.85, -0.36), (0.85, -0.36))),
        "smooth": (
            ("M", (-0.85, 0.45)),
            ("C", (-0.2, 0.9, -0.25, -0.55, 0.05, -0.2)),
            ("C", (0.3, 0.1, 0.4, -0.7, 0.85, -0.45)),
        ),
        "coincident": (*disc(0, 0, 0.22), *disc(0, 0, 0.65)),
        "concentric": (*disc(0, 0, 0.75), *disc(0, 0, 0.32)),
        "point_on": (*polyline((-0.85, 0.55), (0.85, -0.55)), *disc(0, 0, 0.3)),
        "midpoint": polyline((-0.7, 0.5), (0, -0.6), (0.7, 0.5), close=True),
        "symmetry": (
            *polyline((0, -0.8), (0, 0.8)),
            *polyline((-0.75, -0.4), (-0.3, 0), (-0.75, 0.4)),
            *polyline((0.75, -0.4), (0.3, 0), (0.75, 0.4)),
        ),
        "on_normal": (
            *polyline((-0.8, 0.6), (0.8, 0.6)),
            *polyline((0, 0.6), (0, -0.4)),
            *disc(0, -0.55, 0.2),
        ),
        "image": (
            *polyline((-0.75, -0.75), (0.15, -0.75), (0.15, 0.15), (-0.75, 0.15), close=True),
            *polyline((0.4, -0.2), (0.75, -0.2), (0.75, 0.75), (-0.2, 0.75), (-0.2, 0.4)),
        ),
        "lock": _LOCK,
        "fix": (*_LOCK, *disc(0, 0.35, 0.1)),
    }
)
"""One symbol for every kind of constraint of a document."""
