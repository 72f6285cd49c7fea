"""Dimensions of a sketch as dimension entities of DXF."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, degrees, hypot, pi, sin
from typing import Any

from arael.sketch.document.document import Document
from arael.sketch.document.records import Dimension
from arael.sketch.drawing.texts import dimension_text
from arael.sketch.exchange.dxf.names import DIMENSIONS
from arael.sketch.geometry import (
    Conic,
    Curve,
    Line,
    Point,
    angle_between,
    between_edges,
    intersect,
    project,
    to_edge,
)


def add_dimension(
    space: Any,
    document: Document,
    curves: Mapping[str, Curve],
    d: Dimension,
    size: float,
    center: Point,
) -> None:
    """Draw one dimension; total lengths and areas are texts.

    Its line is on the side away from `center`, the middle of a drawing of a certain size. The
    measured value is DXF's own; a derived or a range dimension has its text overridden.
    """
    height = size / 55.0
    override = {"dimtxt": height, "dimasz": height, "dimexe": 0.4 * height, "dimexo": 0.4 * height,
                "dimgap": 0.4 * height, "dimtad": 1, "dimlfac": 1.0, "dimscale": 1.0,
                "dimdec": 4, "dimzin": 8}  # fmt: skip
    text = dimension_text(d, document.unit)
    plain = not d.derived and d.value is not None and not d.broken
    common: dict[str, Any] = {
        "override": override,
        "dxfattribs": {"layer": DIMENSIONS},
        "text": "<>" if plain else text,
    }
    away = d.offset if d.offset is not None else 3.0 * height
    if d.kind in ("length", "distance", "hdistance", "vdistance", "radius_b"):
        ends = _ends(document, curves, d)
        if ends is not None:
            _linear(space, d, *ends, away, center, common)
    elif d.kind in ("radius", "diameter"):
        _radial(space, d, curves[d.args[0]], common)
    elif d.kind in ("angle", "sweep", "arc_length", "xangle"):
        _angular(space, d, curves, away, common)
    else:
        if d.kind == "area":
            boxes = [curves[name].bounds() for name in d.args]
            inner = boxes[0]
            for other in boxes[1:]:
                inner = inner.union(other)
            x, y = 0.5 * (inner.x_min + inner.x_max), 0.5 * (inner.y_min + inner.y_max)
        else:
            x, y = curves[d.args[0]].point_at(0.5)
        space.add_text(text, height=height, dxfattribs={"layer": DIMENSIONS}).set_placement(
            (x, y + 0.5 * height)
        )


def _point(document: Document, handle: str) -> Point:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y


def _ends(
    document: Document, curves: Mapping[str, Curve], d: Dimension
) -> tuple[Point, Point] | None:
    one = curves.get(d.args[0])
    if d.kind == "length":
        assert one is not None
        return one.start, one.end
    if d.kind == "radius_b":
        assert isinstance(one, Conic)
        return one.middle, one.at_angle(0.5 * pi)
    two = curves.get(d.args[1])
    if isinstance(two, Conic) and not isinstance(one, Conic):
        return to_edge(one if isinstance(one, Line) else _point(document, d.args[0]), two)
    if isinstance(one, Conic) and isinstance(two, Conic):
        if d.mode:
            return between_edges(d.mode, one, two)
        return one.at_angle(pi / 4 - one.turned), two.at_angle(pi / 4 - two.turned)
    if isinstance(two, Line):
        a = one.point_at(0.5) if isinstance(one, Line) else _point(document, d.args[0])
        return a, project(a, two)
    return _point(document, d.args[0]), _point(document, d.args[1])


def _linear(
    space: Any,
    d: Dimension,
    a: Point,
    b: Point,
    away: float,
    center: Point,
    common: dict[str, Any],
) -> None:
    angle = {"hdistance": 0.0, "vdistance": 0.5 * pi}.get(d.kind, atan2(b[1] - a[1], b[0] - a[0]))
    if abs((b[0] - a[0]) * cos(angle) + (b[1] - a[1]) * sin(angle)) < 1e-12:
        return  # nothing to show
    nx, ny = -sin(angle), cos(angle)
    middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
    if d.offset is None:
        # on the side away from the drawing's centre, beyond the outer of the two points
        out = (middle[0] - center[0]) * nx + (middle[1] - center[1]) * ny
        spread = 0.5 * abs((b[0] - a[0]) * nx + (b[1] - a[1]) * ny)
        away = -away - spread if out < 0 else away + spread
    base = middle[0] + away * nx, middle[1] + away * ny
    space.add_linear_dim(base=base, p1=a, p2=b, angle=degrees(angle), **common).render()


def _radial(space: Any, d: Dimension, curve: Curve, common: dict[str, Any]) -> None:
    assert isinstance(curve, Conic)
    if curve.radii[0] != curve.radii[1]:  # DXF has radii of circles only
        a, b = curve.middle, curve.at_angle(0.0)
        _linear(space, d, a, b, 0.0, a, common)
        return
    start, sweep = curve.span
    angle = 0.25 * pi if curve.closed else start + 0.5 * sweep
    add = space.add_radius_dim if d.kind == "radius" else space.add_diameter_dim
    add(center=curve.middle, radius=curve.radii[0], angle=degrees(angle), **common).render()


def _angular(
    space: Any, d: Dimension, curves: Mapping[str, Curve], away: float, common: dict[str, Any]
) -> None:
    curve = curves[d.args[0]]
    if d.kind in ("sweep", "arc_length"):
        assert isinstance(curve, Conic)
        if curve.closed:
            return
        start, sweep = curve.span
        add = space.add_angular_dim_cra if d.kind == "sweep" else space.add_arc_dim_cra
        add(
            center=curve.middle, radius=curve.radii[0], start_angle=degrees(start),
            end_angle=degrees(start + sweep), distance=away, **common,
        ).render()  # fmt: skip
        return
    if d.kind == "xangle":
        at = curve.middle if isinstance(curve, Conic) else curve.start
        turn = curve.turned if isinstance(curve, Conic) else atan2(
            curve.end[1] - curve.start[1], curve.end[0] - curve.start[0]
        )  # fmt: skip
        start, sweep, far = 0.0, turn, 4.0 * away
    else:
        other = curves[d.args[1]]
        assert isinstance(curve, Line) and isinstance(other, Line)
        vertex = intersect(curve, other)
        if vertex is None:
            return
        at = vertex
        start = atan2(curve.p2[1] - curve.p1[1], curve.p2[0] - curve.p1[0])
        sweep = angle_between(curve, other)
        if d.mode == "supplement":
            sweep = sweep - pi if sweep > 0 else sweep + pi
        far = max(hypot(p[0] - at[0], p[1] - at[1]) for p in (curve.p1, curve.p2))
    if abs(sweep) < 1e-9:
        return
    if sweep < 0:
        start, sweep = start + sweep, -sweep
    space.add_angular_dim_cra(
        center=at, radius=0.5 * far, start_angle=degrees(start), end_angle=degrees(start + sweep),
        distance=0.0, **common,
    ).render()  # fmt: skip
