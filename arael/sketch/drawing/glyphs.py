"""Glyphs of constraints: badges beside what they act on, none on top of another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import cos, pi, sin

from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.document.records import Constraint
from arael.sketch.drawing.places import Places
from arael.sketch.drawing.primitives import Item, Path, Segment, disc
from arael.sketch.drawing.symbols import SYMBOLS
from arael.sketch.drawing.view import View
from arael.sketch.geometry import Conic, Curve, DegenerateError, Line, Point, intersect

HALF = 8.0
"""Half the side of a badge, pixels."""

_ON_BOTH = {"parallel", "equal", "collinear", "equal_angle", "symmetry", "image", "concentric"}


def glyphs(
    document: Document,
    curves: Mapping[str, Curve],
    view: View,
    places: Places,
    states: Mapping[str, str],
) -> Iterator[Item]:
    """Badges of all constraints; a coincidence is a ring around its point.

    One that is switched off is pale; a state (redundant, impossible, selected) changes its edge.
    """
    for constraint in document.constraints.values():
        state = states.get(constraint.name, "")
        for place in _anchors(constraint, document, curves):
            if constraint.kind == "coincident":
                x, y = view(place[0])
                yield Path(state or "glyph", disc(x, y, 6.5), 1.6 if state else 1.0,
                           opacity=0.9 if state else 0.55, name=constraint.name)  # fmt: skip
            else:
                at = places.first_free(_around(place, view), HALF + 1, HALF + 1)
                yield from _badge(constraint, at, state)


def _badge(constraint: Constraint, at: Point, state: str) -> Iterator[Item]:
    x, y = at
    role = state or "glyph"
    pale = 1.0 if constraint.active else 0.4
    edge = {"redundant": (2.0, 2.5), "impossible": (5.0, 2.5)}.get(state, ())
    yield Path(
        role if state else "glyph.edge",
        _rounded(x, y, HALF, 3.0),
        1.8 if state else 0.9,
        edge,
        "glyph.back",
        pale,
        constraint.name,
    )
    size = 0.72 * HALF
    segments: tuple[Segment, ...] = tuple(
        (c, tuple((x if i % 2 == 0 else y) + size * v for i, v in enumerate(numbers)))
        for c, numbers in SYMBOLS[constraint.kind]
    )
    yield Path(role, segments, 1.3, (), "", pale, constraint.name)


def _rounded(x: float, y: float, h: float, r: float) -> tuple[Segment, ...]:
    k = 0.45 * r
    found: list[Segment] = [("M", (x - h + r, y - h))]
    corners = ((1, -1, 0, 1), (1, 1, -1, 0), (-1, 1, 0, -1), (-1, -1, 1, 0))
    for sx, sy, ox, oy in corners:
        cx, cy = x + sx * h, y + sy * h
        # enters along the side before the corner, leaves along (ox, oy)
        ex, ey = (-sx, 0) if ox == 0 else (0, -sy)
        found += [
            ("L", (cx + ex * r, cy + ey * r)),
            ("C", (cx + ex * k, cy + ey * k, cx + ox * k, cy + oy * k, cx + ox * r, cy + oy * r)),
        ]
    return (*found, ("Z", ()))


Anchor = tuple[Point, Point]
"""A point of the sketch, and the direction to the left of the curve there (zero for points)."""


def _anchors(
    constraint: Constraint, document: Document, curves: Mapping[str, Curve]
) -> list[Anchor]:
    args = constraint.args
    if constraint.kind in ("perpendicular", "tangent") and all(arg in curves for arg in args):
        meeting = _meeting(curves[args[0]], curves[args[1]])
        if meeting is not None:
            return [(meeting, (0.0, 0.0))]
    found = []
    for arg in args:
        anchor = _anchor(arg, document, curves)
        if anchor is not None:
            found.append(anchor)
    if constraint.kind == "coincident" or constraint.kind not in _ON_BOTH:
        return found[:1]
    if constraint.kind == "symmetry":
        return found[::2]
    return found


def _anchor(handle: str, document: Document, curves: Mapping[str, Curve]) -> Anchor | None:
    curve = curves.get(handle)
    if curve is not None:
        t = 0.125 if curve.closed else 0.5
        try:
            return curve.point_at(t), curve.normal_at(t)
        except DegenerateError:
            return curve.point_at(t), (0.0, 0.0)
    parts = split_handle(handle)
    if parts is None or parts.name not in document.entities:
        return None
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return (x, y), (0.0, 0.0)


def _meeting(a: Curve, b: Curve) -> Point | None:
    """Where two curves touch or cross at a right angle, if that is on or near both."""
    try:
        if isinstance(a, Line) and isinstance(b, Line):
            at = intersect(a, b)
        else:
            conic, other = (a, b) if isinstance(a, Conic) else (b, a)
            if not isinstance(conic, Conic):
                return None
            center = conic.middle
            at = other.point_at(other.nearest(center, carrier=True).t)
    except DegenerateError:
        return None
    if at is None:
        return None
    size = max(a.bounds().size, b.bounds().size)
    near = all(curve.nearest(at).distance <= 0.02 * size for curve in (a, b))
    return at if near else None


def _around(anchor: Anchor, view: View) -> Iterator[Point]:
    (point, normal) = anchor
    x, y = view(point)
    nx, ny = normal[0], -normal[1]
    if nx == 0.0 and ny == 0.0:
        for r in (16.0, 25.0, 35.0, 47.0, 60.0):  # as on the page
            for k in (1, 3, 5, 7, 0, 2, 4, 6):
                yield x + r * cos(k * pi / 4), y - r * sin(k * pi / 4)
        return
    for level in (14.0, 32.0, 50.0, 68.0):
        for slide in (0.0, 19.0, -19.0, 38.0, -38.0, 57.0, -57.0):
            for side in (1.0, -1.0):
                yield x + side * level * nx + slide * ny, y + side * level * ny - slide * nx
