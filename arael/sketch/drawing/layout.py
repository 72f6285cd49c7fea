"""A document as a layout of primitives."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from math import floor, hypot, log10

from msgspec import structs

from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.records import Dimension, Entity
from arael.sketch.drawing.dimensions import Pen
from arael.sketch.drawing.glyphs import glyphs as constraint_glyphs
from arael.sketch.drawing.outlines import outline, stroke_outline
from arael.sketch.drawing.places import Places
from arael.sketch.drawing.primitives import (
    Item,
    Layout,
    Path,
    Segment,
    Text,
    disc,
    polyline,
    square,
)
from arael.sketch.drawing.texts import number_text
from arael.sketch.drawing.themes import CONSTRUCTION_DASH, STATES, STYLE_DASHES
from arael.sketch.drawing.view import View, bounds_of_document, curves_of, fitted
from arael.sketch.geometry import Curve, Point
from arael.sketch.text import box_of, lettering

_RANK = {"impossible": 4, "redundant": 3, "selected": 2, "free": 1}

Measure = Callable[[Dimension], float]


def layout(
    document: Document,
    states: Mapping[str, str] | None = None,
    *,
    view: View | None = None,
    width: float = 640.0,
    height: float = 440.0,
    dimensions: bool = True,
    glyphs: bool = True,
    points: bool = True,
    scale_bar: bool = True,
    formulas: bool = True,
    measure: Measure | None = None,
) -> Layout:
    """Primitives of a drawing of a sketch.

    Parameters
    ----------
    document
        The sketch.
    states
        By name of an entity, point (``L0.p1``), constraint or dimension: ``free``, ``defined``,
        ``redundant``, ``impossible``, ``selected``. What is not listed is drawn as defined.
    view
        Scale and origin; by default everything is shown in `width` by `height` pixels.
    dimensions, glyphs, points, scale_bar
        What to draw besides the curves.
    formulas
        Whether ``ƒ`` marks dimensions that follow an expression.
    measure
        Current value of a derived dimension; by default the one that was last stored.
    """
    given = states or {}
    curves = curves_of(document)
    box = bounds_of_document(document)
    if view is None:
        margin = 64.0 if dimensions and document.dimensions else 34.0
        view = fitted(box, width, height, min(margin, 0.2 * min(width, height)))
    center = (0.5 * (box.x_min + box.x_max), 0.5 * (box.y_min + box.y_max)) if box else (0.0, 0.0)
    places = Places()
    items: list[Item] = []
    items += _curves(document, curves, view, given)
    if dimensions or glyphs:
        _take_curves(places, curves, view)
        _take_letters(places, document, curves, view)
    marks = list(_points(document, view, given)) if points else []
    for mark in marks:
        places.take(*mark[0], 4.0, 4.0)
    if dimensions:
        pen = Pen(document, curves, view, center, places, formulas)
        for dimension in document.dimensions.values():
            role = given.get(dimension.name, "")
            if role in ("", "free", "defined"):
                role = "derived" if dimension.derived or not dimension.active else "dimension"
            items += pen.draw(dimension, role, measure(dimension) if measure else None)
    if glyphs:
        items += constraint_glyphs(document, curves, view, places, given)
    items += [item for _, shapes in marks for item in shapes]
    if scale_bar and box is not None:
        items += _scale_bar(document.unit, view)
    return Layout(view.width, view.height, tuple(items), title_of(document))


def _take_curves(places: Places, curves: Mapping[str, Curve], view: View) -> None:
    """Mark the curves themselves, so that texts and badges keep off them."""
    for curve in curves.values():
        points = [view(p) for p in curve.sample(2.0 / view.scale)]
        for (x1, y1), (x2, y2) in pairwise(points):
            count = min(int(hypot(x2 - x1, y2 - y1) / 12.0) + 1, 200)
            for i in range(count):
                f = (i + 0.5) / count
                places.take(x1 + f * (x2 - x1), y1 + f * (y2 - y1), 1.5, 1.5)


def _take_letters(
    places: Places, document: Document, curves: Mapping[str, Curve], view: View
) -> None:
    """Mark the boxes of texts: squares along their middle."""
    for name, entity in document.entities.items():
        if not entity.text:
            continue
        frame = curves[name]
        box = box_of(entity.text, frame.start, frame.end)
        a, b, d = view(box[0]), view(box[1]), view(box[3])
        height = hypot(d[0] - a[0], d[1] - a[1])
        length = hypot(b[0] - a[0], b[1] - a[1])
        if height > view.height:
            continue
        count = min(int(length / max(height, 1.0)) + 1, 200)
        for i in range(count):
            f = (i + 0.5) / count
            x = 0.5 * (a[0] + d[0]) + f * (b[0] - a[0])
            y = 0.5 * (a[1] + d[1]) + f * (b[1] - a[1])
            if 0.0 < x < view.width and 0.0 < y < view.height:
                places.take(x, y, 0.5 * height, 0.5 * height)


def title_of(document: Document) -> str:
    """What the sketch holds, for people who do not see it."""
    kinds = Counter(entity.kind for entity in document.entities.values())
    names = {"earc": "elliptic arc", "bezier": "Bezier curve", "bspline": "B-spline"}
    parts = [_many(count, names.get(kind, kind)) for kind, count in kinds.items()]
    parts += [
        _many(len(table), name)
        for table, name in (
            (document.constraints, "constraint"),
            (document.dimensions, "dimension"),
        )
        if table
    ]
    return f"Sketch: {', '.join(parts)}" if parts else "Empty sketch"


def _many(count: int, name: str) -> str:
    return f"{count} {name}{'' if count == 1 else 's'}"


def _curves(
    document: Document, curves: Mapping[str, Curve], view: View, states: Mapping[str, str]
) -> Iterator[Item]:
    halos: list[Item] = []
    strokes: list[Item] = []
    for name, curve in curves.items():
        entity = document.entities[name]
        state = states.get(name, "defined")
        look = STATES.get(state, STATES["defined"])
        segments = outline(curve, view)
        if entity.text:
            letters = _letters(entity.text, curve, view)
            strokes.append(structs.replace(_stroke(entity, state, letters, name), dash=()))
            if entity.quiet and not look.halo:
                continue
            entity = replace(entity, construction=True)
        if look.halo:
            halos.append(Path(f"halo.{state}", segments, look.halo, look.halo_dash, "", 0.55, name))
        strokes.append(_stroke(entity, state, segments, name))
    # construction lies behind the outline
    strokes.sort(key=lambda item: not document.entities[item.name].construction)
    yield from halos
    yield from strokes


def _letters(text: str, frame: Curve, view: View) -> tuple[Segment, ...]:
    """Path of a text in its frame."""
    strokes = lettering(text, frame.start, frame.end)
    return tuple(segment for stroke in strokes for segment in stroke_outline(stroke, view))


def _stroke(entity: Entity, state: str, segments: tuple, name: str) -> Path:  # type: ignore[type-arg]
    look = STATES.get(state, STATES["defined"])
    dash = STYLE_DASHES[entity.style]
    if not entity.construction:
        return Path(state, segments, look.width, dash, name=name)
    role = "construction" if state == "defined" else state
    return Path(role, segments, 1.1, dash or CONSTRUCTION_DASH, name=name)


def _points(
    document: Document, view: View, states: Mapping[str, str]
) -> Iterator[tuple[Point, list[Item]]]:
    """Marks of points, one for every place: of the state that matters most."""
    found: dict[tuple[int, int], tuple[int, Point, str, str, bool]] = {}
    values = document.values
    for name, entity in document.entities.items():
        single = entity.kind == "point"
        if entity.quiet and not single:
            continue
        for point, at in point_offsets(entity).items():
            if entity.kind in ("bezier", "bspline") and not point.startswith("pole"):
                continue
            handle = name if single else f"{name}.{point}"
            state = states.get(handle, states.get(name, "defined"))
            place = view((float(values[at]), float(values[at + 1])))
            key = round(place[0]), round(place[1])
            rank = _RANK.get(state, 0) + (10 if single else 0)
            if key not in found or rank > found[key][0]:
                found[key] = rank, place, state, handle, single
    for _, place, state, handle, single in found.values():
        yield place, _mark(place, state, handle, 3.4 if single else 2.7)


def _mark(place: Point, state: str, handle: str, r: float) -> list[Item]:
    look = STATES.get(state, STATES["defined"])
    x, y = place
    if look.end == "ring":
        return [Path(state, disc(x, y, r + 0.3), 1.4, fill="background", name=handle)]
    if look.end == "square":
        return [Path(state, square(x, y, r + 1.3), 1.6, fill="background", name=handle)]
    if look.end == "diamond":
        s = r + 2.2
        corners = (x - s, y), (x, y - s), (x + s, y), (x, y + s)
        shape = polyline(*corners, close=True)
        return [Path(state, shape, 1.6, fill="background", name=handle)]
    if look.end == "cross":
        s = r + 1.8
        strokes = (*polyline((x - s, y - s), (x + s, y + s)),
                   *polyline((x - s, y + s), (x + s, y - s)))  # fmt: skip
        return [Path(state, strokes, 2.2, name=handle)]
    return [Path(state, disc(x, y, r), 0.0, fill=state, name=handle)]


def _scale_bar(unit: str, view: View) -> Iterator[Item]:
    """A round length of 60 to 150 pixels in the lower left corner."""
    if not view.scale > 0.0 or view.width < 260:
        return
    raw = 60.0 / view.scale
    power = 10.0 ** floor(log10(raw))
    length = next(f * power for f in (1, 2, 5, 10) if f * power >= raw)
    x, y, w = 16.0, view.height - 16.0, length * view.scale
    yield Path("note", polyline((x, y - 4), (x, y), (x + w, y), (x + w, y - 4)), 1.2)
    yield Text("note", x + w + 8, y - 2, f"{number_text(length)} {unit}", 11.0, 0.0, "start")
