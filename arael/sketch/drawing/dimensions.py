"""Dimension lines: extension lines, arrows, arcs, leaders, and the place of the text."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import atan2, cos, degrees, hypot, pi, radians, sin, tau
from types import MappingProxyType

from arael.sketch.document.document import Document
from arael.sketch.document.records import Dimension
from arael.sketch.drawing.places import Places
from arael.sketch.drawing.primitives import Item, Path, Segment, Text, polyline
from arael.sketch.drawing.texts import dimension_text
from arael.sketch.drawing.view import View
from arael.sketch.geometry import (
    Conic,
    Curve,
    Line,
    Point,
    angle_between,
    between_edges,
    chains,
    intersect,
    project,
    to_edge,
)

SIZE = 12.0
"""Height of the text, pixels."""

_ARROW = 9.0
_FIRST, _NEXT = 26.0, 20.0


class Pen:
    """Draws the dimensions of one document in one view.

    Parameters
    ----------
    document, curves : the sketch and the curves of its entities
    view : scale and origin
    center : of the drawing, in the sketch: dimension lines are put on the side away from it
    places : rectangles that are taken
    formulas : whether values that follow an expression are marked
    """

    def __init__(
        self,
        document: Document,
        curves: Mapping[str, Curve],
        view: View,
        center: Point,
        places: Places,
        formulas: bool = True,
    ) -> None:
        self.document, self.curves, self.view = document, curves, view
        self.center, self.places, self.formulas = center, places, formulas

    def draw(self, dimension: Dimension, role: str, measured: float | None) -> Iterator[Item]:
        """Items of one dimension."""
        text = dimension_text(dimension, self.document.unit, measured, self.formulas)
        shape = _SHAPES.get(dimension.kind)
        if shape is not None:
            yield from shape(self, dimension, role, text)

    # --- parts ------------------------------------------------------------------------------

    def point(self, handle: str) -> Point:
        """Coordinates of a point."""
        at = self.document.point_at(handle)
        x, y = self.document.values[at : at + 2].tolist()
        return x, y

    def text(self, role: str, at: Point, text: str, angle: float, name: str) -> Text:
        """Text centred on a point in pixels."""
        return Text(role, at[0], at[1], text, SIZE, angle, "middle", name)

    def linear(
        self, d: Dimension, role: str, text: str, a: Point, b: Point, heading: Point
    ) -> Iterator[Item]:
        """Dimension line in a direction of the sketch, between two points."""
        n = -heading[1], heading[0]
        middle = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
        away = (middle[0] - self.center[0]) * n[0] + (middle[1] - self.center[1]) * n[1]
        side = -1.0 if away < 0 else 1.0
        # levels of the two points across the dimension line; it is counted from the outer one
        u, v = (p[0] * n[0] + p[1] * n[1] for p in (a, b))
        scale = self.view.scale
        half = 0.5 * text_width(text) + 3
        angle = atan2(heading[1], heading[0])
        upright = angle - pi if angle > pi / 2 + 1e-9 else angle
        upright = upright + pi if upright <= -pi / 2 + 1e-9 else upright
        if d.offset is not None:
            levels = [0.5 * (u + v) + d.offset]
        else:
            levels = [
                (max(u, v) if s > 0 else min(u, v)) + s * (_FIRST + k * _NEXT) / scale
                for s in (side, -side)
                for k in range(4)
            ]
        s, t = (p[0] * heading[0] + p[1] * heading[1] for p in (a, b))
        slides = [d.along] if d.along is not None else [0.0, 0.2, -0.2, 0.35, -0.35]
        w = abs(cos(upright)) * half + abs(sin(upright)) * 8
        h = abs(sin(upright)) * half + abs(cos(upright)) * 8
        # texts stand on their line, as seen when they are read
        lift = -sin(upright) * 8 / scale, cos(upright) * 8 / scale

        def text_at(level: float, slide: float) -> Point:
            along = 0.5 * (s + t) + slide * (t - s)
            x = along * heading[0] + level * n[0] + lift[0]
            y = along * heading[1] + level * n[1] + lift[1]
            return self.view((x, y))

        spots = {text_at(level, slide): level for slide in slides for level in levels[:4]}
        spots |= {text_at(level, slide): level for slide in slides for level in levels[4:]}

        def line_at(place: Point) -> tuple[Point, Point]:
            level = spots[place]
            first, last = (
                self.view((e * heading[0] + level * n[0], e * heading[1] + level * n[1]))
                for e in (s, t)
            )
            return first, last

        place = self.places.first_free(spots, w, h, line_at)
        level = spots[place]
        p = s * heading[0] + level * n[0], s * heading[1] + level * n[1]
        q = t * heading[0] + level * n[0], t * heading[1] + level * n[1]
        for foot, end in ((a, p), (b, q)):
            yield from self._extension(role, foot, end, d.name)
            self.places.take_line(self.view(foot), self.view(end))
        self.places.take_line(self.view(p), self.view(q))
        yield from self._arrowed(role, self.view(p), self.view(q), d)
        yield self.text(role, place, text, upright, d.name)

    def _extension(self, role: str, foot: Point, end: Point, name: str) -> Iterator[Item]:
        (x1, y1), (x2, y2) = self.view(foot), self.view(end)
        length = hypot(x2 - x1, y2 - y1)
        if length > 6.0:
            ux, uy = (x2 - x1) / length, (y2 - y1) / length
            ends = (x1 + 4 * ux, y1 + 4 * uy), (x2 + 4 * ux, y2 + 4 * uy)
            yield Path(role, polyline(*ends), 0.8, opacity=0.6, name=name)

    def _arrowed(self, role: str, p: Point, q: Point, d: Dimension) -> Iterator[Item]:
        length = hypot(q[0] - p[0], q[1] - p[1])
        if length < 1e-6:
            return
        ux, uy = (q[0] - p[0]) / length, (q[1] - p[1]) / length
        if length >= 3 * _ARROW:
            yield Path(role, polyline(p, q), 1.0, name=d.name)
            yield arrow(role, p, (-ux, -uy), d.name)
            yield arrow(role, q, (ux, uy), d.name)
        else:
            first, last = (
                (p[0] - 2 * _ARROW * ux, p[1] - 2 * _ARROW * uy),
                (q[0] + 2 * _ARROW * ux, q[1] + 2 * _ARROW * uy),
            )
            yield Path(role, polyline(first, last), 1.0, name=d.name)
            yield arrow(role, p, (ux, uy), d.name)
            yield arrow(role, q, (-ux, -uy), d.name)

    def angular(
        self, d: Dimension, role: str, text: str, center: Point, start: float, sweep: float,
        radius: float,
    ) -> Iterator[Item]:  # fmt: skip
        """Arc with arrows; angles as in the sketch, the radius in pixels."""
        cx, cy = self.view(center)
        half = 0.5 * text_width(text) + 3

        def at(angle: float, r: float) -> Point:
            return cx + r * cos(angle), cy - r * sin(angle)

        radii = [radius] if d.offset is not None else [radius + k * _NEXT for k in range(5)]
        middle = start + sweep * (0.5 + (d.along or 0.0))

        def text_at(r: float) -> Point:
            out = r + 4 + abs(cos(middle)) * half + abs(sin(middle)) * 8
            return at(middle, out)

        place = self.places.first_free(map(text_at, radii), half, 8)
        radius = next(r for r in radii if text_at(r) == place)
        yield Path(role, arc_segments(cx, cy, radius, start, sweep), 1.0, name=d.name)
        if abs(sweep) * radius > 2.5 * _ARROW and abs(sweep) < tau - 1e-9:
            turn = 1.0 if sweep > 0 else -1.0
            # arrows lie on the chord of their own length, not on the tangent
            bend = 0.5 * _ARROW / radius
            for angle, sign in ((start, -turn), (start + sweep, turn)):
                inner = angle - sign * bend
                direction = -sign * sin(inner), -sign * cos(inner)
                yield arrow(role, at(angle, radius), direction, d.name)
        yield self.text(role, text_at(radius), text, 0.0, d.name)

    def leader(
        self, d: Dimension, role: str, text: str, tip: Point, heading: Point, tail: Point | None
    ) -> Iterator[Item]:
        """Arrow at `tip` from outside, with the text at its end; pixels, heading outwards."""
        half = 0.5 * text_width(text) + 3
        lengths = (
            [abs(d.offset) * self.view.scale]
            if d.offset is not None
            else [24.0 + k * _NEXT for k in range(5)]
        )

        def text_at(length: float) -> Point:
            x, y = tip[0] + length * heading[0], tip[1] + length * heading[1]
            return x + (half if heading[0] >= 0 else -half), y

        place = self.places.first_free(map(text_at, lengths), half, 8)
        length = next(one for one in lengths if text_at(one) == place)
        end = tip[0] + length * heading[0], tip[1] + length * heading[1]
        yield Path(role, polyline(tail or tip, end), 1.0, name=d.name)
        yield arrow(role, tip, (-heading[0], -heading[1]), d.name)
        yield self.text(role, text_at(length), text, 0.0, d.name)

    def note(self, d: Dimension, role: str, text: str, at: Point) -> Iterator[Item]:
        """Text alone, around a point in pixels."""
        half = 0.5 * text_width(text) + 3
        spots = [(at[0], at[1] + k * 18.0) for k in (0, -1, 1, -2, 2, -3)]
        yield self.text(role, self.places.first_free(spots, half, 9), text, 0.0, d.name)


def text_width(text: str) -> float:
    """Estimated width in pixels."""
    return 0.58 * SIZE * len(text)


def arrow(role: str, tip: Point, heading: Point, name: str) -> Path:
    """Filled arrow head, pointing in a direction of the picture."""
    (x, y), (ux, uy) = tip, heading
    bx, by, w = x - _ARROW * ux, y - _ARROW * uy, 0.28 * _ARROW
    corners = (x, y), (bx - w * uy, by + w * ux), (bx + w * uy, by - w * ux)
    return Path(role, polyline(*corners, close=True), 0.0, fill=role, name=name)


def arc_segments(cx: float, cy: float, r: float, start: float, sweep: float) -> tuple[Segment, ...]:
    """Arc in pixels from angles of the sketch."""
    count = max(1, int(abs(sweep) / 0.8) + 1)
    k = 4.0 / 3.0 * (sweep / count) / 4.0
    k *= 1.0 + k * k * 0.1875  # tan(x) = x + x^3 / 3, to 1e-4 at these angles
    found: list[Segment] = [("M", (cx + r * cos(start), cy - r * sin(start)))]
    for i in range(count):
        a, b = start + sweep * i / count, start + sweep * (i + 1) / count
        ca, sa, cb, sb = cos(a), sin(a), cos(b), sin(b)
        found.append(
            (
                "C",
                (
                    cx + r * (ca - k * sa), cy - r * (sa + k * ca),
                    cx + r * (cb + k * sb), cy - r * (sb - k * cb),
                    cx + r * cb, cy - r * sb,
                ),
            )
        )  # fmt: skip
    return tuple(found)


# --- kinds ------------------------------------------------------------------------------------


def _length(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    line = pen.curves[d.args[0]]
    yield from _aligned(pen, d, role, text, line.start, line.end)


def _aligned(pen: Pen, d: Dimension, role: str, text: str, a: Point, b: Point) -> Iterator[Item]:
    length = hypot(b[0] - a[0], b[1] - a[1])
    heading = ((b[0] - a[0]) / length, (b[1] - a[1]) / length) if length > 0 else (1.0, 0.0)
    yield from pen.linear(d, role, text, a, b, heading)


def _distance(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    one, two = (pen.curves.get(arg) for arg in d.args)
    if isinstance(one, Conic) and isinstance(two, Conic) and d.mode:
        a, b = between_edges(d.mode, one, two)
    elif isinstance(two, Conic) and not isinstance(one, Conic):
        a, b = to_edge(one if isinstance(one, Line) else pen.point(d.args[0]), two)
    elif isinstance(one, Conic) and isinstance(two, Conic):
        angle = pi / 4 + (d.along or 0.0) * tau
        a, b = one.at_angle(angle - one.turned), two.at_angle(angle - two.turned)
    elif isinstance(two, Line):
        a = one.point_at(0.5) if isinstance(one, Line) else pen.point(d.args[0])
        b = project(a, two)
    else:
        a, b = pen.point(d.args[0]), pen.point(d.args[1])
    yield from _aligned(pen, d, role, text, a, b)


def _hdistance(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    a, b = sorted((pen.point(d.args[0]), pen.point(d.args[1])))
    yield from pen.linear(d, role, text, a, b, (1.0, 0.0))


def _vdistance(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    a, b = sorted((pen.point(d.args[0]), pen.point(d.args[1])), key=lambda p: p[1])
    yield from pen.linear(d, role, text, a, b, (0.0, 1.0))


def _radius(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    yield from _radial(pen, d, role, text, pen.view(_conic(pen, d).middle))


def _diameter(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    conic = _conic(pen, d)
    angle = _radial_angle(conic, d)
    opposite = pen.view(conic.at_angle(angle + pi))
    yield from _radial(pen, d, role, text, opposite)
    heading = pen.view(conic.at_angle(angle))
    length = hypot(heading[0] - opposite[0], heading[1] - opposite[1]) or 1.0
    back = (opposite[0] - heading[0]) / length, (opposite[1] - heading[1]) / length
    yield arrow(role, opposite, back, d.name)


def _conic(pen: Pen, d: Dimension) -> Conic:
    conic = pen.curves[d.args[0]]
    assert isinstance(conic, Conic)
    return conic


def _radial_angle(conic: Conic, d: Dimension) -> float:
    start, sweep = conic.span
    if d.kind == "radius_b":
        return pi / 2
    if conic.radii[0] != conic.radii[1]:
        return 0.0
    if conic.closed:
        return pi / 4 + (d.along or 0.0) * tau - conic.turned
    return start + sweep * (0.5 + (d.along or 0.0))


def _radial(pen: Pen, d: Dimension, role: str, text: str, tail: Point) -> Iterator[Item]:
    conic = _conic(pen, d)
    tip = pen.view(conic.at_angle(_radial_angle(conic, d)))
    center = pen.view(conic.middle)
    length = hypot(tip[0] - center[0], tip[1] - center[1]) or 1.0
    heading = (tip[0] - center[0]) / length, (tip[1] - center[1]) / length
    yield from pen.leader(d, role, text, tip, heading, tail)


def _sweep(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    conic = _conic(pen, d)
    start, sweep = conic.span
    away = d.offset * pen.view.scale if d.offset is not None else 20.0
    radius = max(conic.radii[0] * pen.view.scale + away, 4.0)
    center = conic.middle
    yield from pen.angular(d, role, text, center, start + conic.turned, sweep, radius)
    for angle in (start, start + sweep):
        edge = conic.at_angle(angle)
        out = radius / (pen.view.scale * (conic.radii[0] or 1.0))
        far = (center[0] + out * (edge[0] - center[0]), center[1] + out * (edge[1] - center[1]))
        if not conic.closed:
            yield from pen._extension(role, edge, far, d.name)


def _angle(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    a, b = (pen.curves[arg] for arg in d.args)
    assert isinstance(a, Line) and isinstance(b, Line)
    vertex = intersect(a, b) if a.length() > 0 and b.length() > 0 else None
    if vertex is None:
        yield from pen.note(d, role, text, pen.view(a.point_at(0.5)))
        return
    start = atan2(a.p2[1] - a.p1[1], a.p2[0] - a.p1[0])
    sweep = angle_between(a, b)
    if d.mode == "supplement":
        start, sweep = start, sweep - pi if sweep > 0 else sweep + pi
    # of the two opposite sectors the one in which the lines lie
    bisector = start + 0.5 * sweep
    reach = [
        sum(
            (p[0] - vertex[0]) * cos(bisector) + (p[1] - vertex[1]) * sin(bisector)
            for p in (line.p1, line.p2)
        )
        for line in (a, b)
    ]
    if sum(reach) < 0:
        start += pi
    far = min(
        max(hypot(p[0] - vertex[0], p[1] - vertex[1]) for p in (line.p1, line.p2))
        for line in (a, b)
    )
    yield from pen.angular(d, role, text, vertex, start, sweep, _arc_radius(pen, d, far))


def _arc_radius(pen: Pen, d: Dimension, far: float) -> float:
    if d.offset is not None:
        return max(abs(d.offset) * pen.view.scale, 6.0)
    return max(min(0.5 * far * pen.view.scale, 54.0), 22.0)


def _xangle(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    curve = pen.curves[d.args[0]]
    if isinstance(curve, Line):
        at, far = curve.p1, curve.length()
        turn = atan2(curve.p2[1] - curve.p1[1], curve.p2[0] - curve.p1[0])
    else:
        conic = _conic(pen, d)
        at, far = conic.middle, max(conic.radii)
        turn = radians((degrees(conic.turned) + 180.0) % 360.0 - 180.0)
    radius = _arc_radius(pen, d, far)
    x, y = pen.view(at)
    yield Path(role, polyline((x, y), (x + radius + 14, y)), 0.8, (3.0, 3.0), name=d.name)
    yield from pen.angular(d, role, text, at, 0.0, turn, radius)


def _total(pen: Pen, d: Dimension, role: str, text: str) -> Iterator[Item]:
    curves = [pen.curves[arg] for arg in d.args]
    if d.kind == "total_length":
        size = curves[0].bounds().size
        (first, *_) = chains(curves, 1e-6 * size)
        middle = first.links[len(first.links) // 2]
        x, y = pen.view(curves[middle.number].point_at(0.5))
        yield from pen.note(d, role, text, (x, y - 14))
        return
    box = curves[0].bounds()
    for curve in curves[1:]:
        box = box.union(curve.bounds())
    center = 0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max)
    yield from pen.note(d, role, text, pen.view(center))


_SHAPES: Mapping[str, Callable[[Pen, Dimension, str, str], Iterator[Item]]] = MappingProxyType(
    {
        "length": _length,
        "distance": _distance,
        "hdistance": _hdistance,
        "vdistance": _vdistance,
        "radius": _radius,
        "radius_b": _radius,
        "diameter": _diameter,
        "sweep": _sweep,
        "arc_length": _sweep,
        "angle": _angle,
        "xangle": _xangle,
        "total_length": _total,
        "area": _total,
    }
)
