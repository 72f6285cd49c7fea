"""Geometry of SVG files.

Parsed by expat with entity declarations refused, so that a file can neither grow in memory nor
reach for other files; nothing is ever loaded from the network.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import pi
from typing import NamedTuple, cast
from xml.parsers import expat

from arael.sketch.document.records import STYLES, Style
from arael.sketch.document.texts import problem_of
from arael.sketch.exchange.building import Collector, Found
from arael.sketch.exchange.imported import Imported
from arael.sketch.exchange.problems import (
    MAX_BYTES,
    MAX_DEPTH,
    MAX_ENTITIES,
    over_limit,
    unreadable,
)
from arael.sketch.exchange.svg.paths import NUMBER, PathError, path_curves, simplest, transform_of
from arael.sketch.geometry import (
    Affine,
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

_PX = 25.4 / 96.0
"""Millimetres of a pixel of CSS."""

_LENGTHS = {"": _PX, "px": _PX, "mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72, "pc": 25.4 / 6}

# What is defined for use elsewhere, not drawn where it stands.
_HIDDEN = {"defs", "symbol", "clipPath", "mask", "pattern", "marker", "metadata", "filter"}
_SILENT = {"svg", "g", "a", "switch", "title", "desc", "style", *_HIDDEN}


class _Frame(NamedTuple):
    """State of an open element."""

    by: Affine
    hidden: bool
    construction: bool
    dashed: bool


def from_svg(data: bytes, origin: str = "the picture", tolerance: float | None = None) -> Imported:
    """Curves of paths and basic shapes, in millimetres, y upwards.

    Read are ``path``, ``line``, ``circle``, ``ellipse``, ``rect``, ``polyline``, ``polygon`` with
    transforms, ``viewBox`` and physical units; texts, images and references are counted in the
    notes. A point is a path without extent. Texts that arael wrote come back as texts.

    Raises
    ------
    AraelError
        E1302: no SVG, damaged, or with entity declarations; E1303: too large, too deeply nested.
    """
    if len(data) > MAX_BYTES:
        raise over_limit(f"{len(data):,} bytes", MAX_BYTES, origin)
    if not data.strip():
        raise unreadable("SVG", "the file is empty", origin)
    reader = _Reader(Collector(origin))
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.EntityDeclHandler = reader.refuse_entity
    parser.ExternalEntityRefHandler = reader.refuse_reference
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise unreadable(
            "SVG", f"{expat.ErrorString(error.code)}, line {error.lineno}", origin
        ) from None
    except ValueError as error:
        raise unreadable("SVG", str(error), origin) from None
    if not reader.is_svg:
        raise unreadable("SVG", "the outermost element is not `svg`", origin)
    found = reader.collector.imported("mm", tolerance)
    found.notes += reader.notes
    return found


@dataclass
class _Reader:
    collector: Collector

    def __post_init__(self) -> None:
        self.frames: list[_Frame] = []
        self.is_svg = False
        self.elements = 0
        self.notes: list[str] = []

    # --- handlers of expat --------------------------------------------------------------------

    def refuse_entity(self, name: str, *_: object) -> None:
        raise unreadable("SVG", f"it declares the entity `{name[:40]}`", self.collector.origin)

    def refuse_reference(self, *_: object) -> int:
        raise unreadable("SVG", "it refers to another file", self.collector.origin)

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.elements += 1
        if self.elements > 2 * MAX_ENTITIES:
            raise over_limit("too many elements", 2 * MAX_ENTITIES, self.collector.origin)
        if len(self.frames) >= 4 * MAX_DEPTH:
            raise over_limit("elements are nested too deeply", 4 * MAX_DEPTH, self.collector.origin)
        tag = name.rpartition(" ")[2]
        if not self.frames:
            self.is_svg = tag == "svg"
            outer = _Frame(_page(attributes) if self.is_svg else Affine(), False, False, False)
        else:
            outer = self.frames[-1]
        frame = self._frame(outer, tag, attributes)
        self.frames.append(frame)
        if frame.hidden or not self.is_svg:
            return
        shape = _SHAPES.get(tag)
        if shape is not None:
            self._shape(tag, shape, attributes, frame)
        elif tag not in _SILENT:
            self.collector.left_out[f"`{tag[:30]}` element"] += 1

    def end(self, name: str) -> None:
        self.frames.pop()

    # ------------------------------------------------------------------------------------------

    def _frame(self, outer: _Frame, tag: str, attributes: dict[str, str]) -> _Frame:
        by = outer.by
        if "transform" in attributes and self.frames:
            try:
                by = by.after(transform_of(attributes["transform"]))
            except (PathError, ValueError, OverflowError) as error:
                self._note(tag, str(error))
        style = attributes.get("style", "")
        hidden = (
            outer.hidden
            or tag in _HIDDEN
            or attributes.get("display") == "none"
            or re.search(r"display\s*:\s*none", style) is not None
        )
        construction = outer.construction or attributes.get("class") == "construction"
        dashes = attributes.get("stroke-dasharray", "")
        match = re.search(r"stroke-dasharray\s*:\s*([^;]+)", style)
        dashes = match[1].strip() if match else dashes
        dashed = outer.dashed if not dashes else dashes != "none"
        return _Frame(by, hidden, construction, dashed)

    def _shape(
        self,
        tag: str,
        shape: Callable[[dict[str, str]], Iterator[Curve]],
        attributes: dict[str, str],
        frame: _Frame,
    ) -> None:
        style = attributes.get("data-style", "")
        if style not in STYLES:
            style = "dashed" if frame.dashed and not frame.construction else "solid"
        text = _text_of(attributes, frame)
        if text is not None:
            self.collector.add(
                Found(text[0], frame.construction, cast("Style", style), text=text[1])
            )
            return
        curves: list[Curve] = []
        try:
            for curve in shape(attributes):
                curves.append(curve)
        except (PathError, ValueError, OverflowError) as error:
            self._note(tag, str(error))
        for curve in curves if "data-name" not in attributes else _joined(curves):
            placed = simplest(curve.transformed(frame.by))
            if isinstance(placed, Ellipse) and abs(placed.rx - placed.ry) <= 1e-12 * placed.rx:
                placed = Circle(placed.center, placed.rx)
            self.collector.add(Found(placed, frame.construction, cast("Style", style)))

    def _note(self, tag: str, reason: str) -> None:
        if len(self.notes) < 20:
            self.notes.append(f"`{tag[:30]}` element: {reason[:120]}")


def _text_of(attributes: dict[str, str], frame: _Frame) -> tuple[Line, str] | None:
    """Frame and text of a path that arael wrote; None if it is none, or was mirrored since."""
    text = attributes.get("data-text", "")
    numbers = attributes.get("data-frame", "").split()
    by = frame.by
    if problem_of(text) or len(numbers) != 4 or by.factor is None or by.determinant > 0.0:
        return None
    if not all(re.fullmatch(NUMBER, number) for number in numbers):
        return None
    x1, y1, x2, y2 = map(float, numbers)
    found = Line(by((x1, y1)), by((x2, y2)))
    return (found, text) if found.p1 != found.p2 else None


def _joined(curves: list[Curve]) -> list[Curve]:
    """Pieces of one curve of ours: a B-spline is written as its spans, a long arc in parts."""
    arcs = [c for c in curves if isinstance(c, Arc)]
    ovals = [c for c in curves if isinstance(c, EllipticArc)]
    if len(arcs) == len(curves) > 1:
        whole = sum(arc.sweep for arc in arcs)
        return [Arc(arcs[0].center, arcs[0].radius, arcs[0].angle, whole)]
    if len(ovals) == len(curves) > 1:
        a, whole = ovals[0], sum(oval.sweep for oval in ovals)
        return [EllipticArc(a.center, a.rx, a.ry, a.rotation, a.angle, whole)]
    if len(curves) > 1 and all(isinstance(c, Bezier) for c in curves):
        spline = _spline([c for c in curves if isinstance(c, Bezier)])
        return [spline] if spline is not None else curves
    return curves


def _spline(pieces: list[Bezier]) -> BSpline | None:
    """The uniform B-spline with these spans, if there is one: solved from the ends inwards."""
    m = len(pieces)
    # polar forms at the knots: pole i is f(k[i], k[i+1], k[i+2]) of a span that holds them
    poles: list[Point] = []
    knots = [float(min(max(i - 2, 0), m)) for i in range(m + 5)]
    for i in range(m + 3):
        u, v, w = knots[i : i + 3]
        k = min(max(i - 1, 0), m - 1)
        k = min(k, m - 1)
        poles.append(_polar(pieces[k], u - k, v - k, w - k))
    found = BSpline(tuple(poles))
    size = found.bounds().size
    for k, piece in enumerate(pieces):
        for p, q in zip(found.bezier(k).poles, piece.poles, strict=True):
            if abs(p[0] - q[0]) + abs(p[1] - q[1]) > 1e-9 * size:
                return None
    return found


def _polar(piece: Bezier, u: float, v: float, w: float) -> Point:
    row = list(piece.poles)
    for argument in (u, v, w):
        row = [
            ((1 - argument) * a[0] + argument * b[0], (1 - argument) * a[1] + argument * b[1])
            for a, b in itertools.pairwise(row)
        ]
    return row[0]


# --- the page and the basic shapes --------------------------------------------------------------


def _length(text: str | None) -> float | None:
    """A length in millimetres; None for percentages and what is no length."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*([a-z]*)\s*", text or "")
    if match is None or match[2] not in _LENGTHS:
        return None
    return float(match[1]) * _LENGTHS[match[2]]


def _page(attributes: dict[str, str]) -> Affine:
    """From user units to millimetres with y upwards and the lower left corner as the origin."""
    width, height = _length(attributes.get("width")), _length(attributes.get("height"))
    box = [float(x) for x in re.findall(NUMBER, attributes.get("viewBox", ""))]
    if len(box) != 4 or not (box[2] > 0 and box[3] > 0):
        return Affine(_PX, 0.0, 0.0, -_PX, 0.0, height or 0.0)
    x, y, w, h = box
    sx = width / w if width else None
    sy = height / h if height else None
    if sx is None and sy is None:
        sx = sy = _PX
    across, up = sx or sy or _PX, sy or sx or _PX
    if attributes.get("preserveAspectRatio", "").strip() != "none":
        across = up = min(across, up)
    return Affine(across, 0.0, 0.0, -up, -across * x, up * (y + h))


def _number(attributes: dict[str, str], name: str) -> float:
    """A coordinate in user units."""
    text = attributes.get(name, "0")
    match = re.fullmatch(rf"\s*({NUMBER})\s*([a-z]*)\s*", text)
    if match is None or match[2] not in _LENGTHS:
        raise PathError(f"`{name}` is not a length: {text[:30]!r}")
    return float(match[1]) * (_LENGTHS[match[2]] / _PX if match[2] else 1.0)


def _path(attributes: dict[str, str]) -> Iterator[Curve]:
    yield from path_curves(attributes.get("d", ""))


def _line(a: dict[str, str]) -> Iterator[Curve]:
    yield Line((_number(a, "x1"), _number(a, "y1")), (_number(a, "x2"), _number(a, "y2")))


def _circle(a: dict[str, str]) -> Iterator[Curve]:
    yield Circle((_number(a, "cx"), _number(a, "cy")), abs(_number(a, "r")))


def _ellipse(a: dict[str, str]) -> Iterator[Curve]:
    center = _number(a, "cx"), _number(a, "cy")
    yield Ellipse(center, abs(_number(a, "rx")), abs(_number(a, "ry")), 0.0)


def _points(a: dict[str, str]) -> list[Point]:
    numbers = [float(x) for x in re.findall(NUMBER, a.get("points", ""))]
    return list(zip(numbers[::2], numbers[1::2], strict=False))


def _polyline(a: dict[str, str]) -> Iterator[Curve]:
    points = _points(a)
    for p, q in itertools.pairwise(points):
        yield Line(p, q)


def _polygon(a: dict[str, str]) -> Iterator[Curve]:
    points = _points(a)
    yield from _polyline(a)
    if len(points) > 2 and points[0] != points[-1]:
        yield Line(points[-1], points[0])


def _rect(a: dict[str, str]) -> Iterator[Curve]:
    x, y, w, h = (_number(a, name) for name in ("x", "y", "width", "height"))
    if not (w > 0 and h > 0):
        return
    rx = _number(a, "rx") if "rx" in a else _number(a, "ry")
    ry = _number(a, "ry") if "ry" in a else rx
    rx, ry = min(abs(rx), 0.5 * w), min(abs(ry), 0.5 * h)
    sides = [
        ((x + rx, y), (x + w - rx, y)),
        ((x + w, y + ry), (x + w, y + h - ry)),
        ((x + w - rx, y + h), (x + rx, y + h)),
        ((x, y + h - ry), (x, y + ry)),
    ]
    centers = [(x + w - rx, y + ry), (x + w - rx, y + h - ry), (x + rx, y + h - ry),
               (x + rx, y + ry)]  # fmt: skip
    for i, ((p, q), center) in enumerate(zip(sides, centers, strict=True)):
        if p != q:
            yield Line(p, q)
        if rx > 0 and ry > 0:
            yield simplest(EllipticArc(center, rx, ry, 0.0, (i - 1) * 0.5 * pi, 0.5 * pi))


_SHAPES: dict[str, Callable[[dict[str, str]], Iterator[Curve]]] = {
    "path": _path,
    "line": _line,
    "circle": _circle,
    "ellipse": _ellipse,
    "rect": _rect,
    "polyline": _polyline,
    "polygon": _polygon,
}
