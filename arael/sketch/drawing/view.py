"""From coordinates of a sketch to pixels."""

from __future__ import annotations

from typing import NamedTuple

from arael.sketch.document.document import Document
from arael.sketch.geometry import Bounds, Curve, Point, curve_of
from arael.sketch.text import Stroke, bounds_of, lettering


class View(NamedTuple):
    """A scale and the place of the origin; y points up in sketches and down in pixels.

    Attributes
    ----------
    scale : pixels per unit of the sketch
    x, y : pixels of the sketch's origin
    width, height : of the picture
    """

    scale: float
    x: float
    y: float
    width: float
    height: float

    def __call__(self, p: Point) -> Point:
        """Pixels of a point."""
        return self.x + self.scale * p[0], self.y - self.scale * p[1]


def curves_of(document: Document) -> dict[str, Curve]:
    """Curves of all entities but points, by name."""
    return {
        name: curve_of(entity.kind, document.numbers_of(name).tolist())
        for name, entity in document.entities.items()
        if entity.kind != "point"
    }


def lettering_of(document: Document) -> dict[str, list[Stroke]]:
    """Strokes of all texts, by the name of the frame."""
    found = {}
    for name, entity in document.entities.items():
        if entity.text:
            x1, y1, x2, y2 = document.numbers_of(name).tolist()
            found[name] = lettering(entity.text, (x1, y1), (x2, y2))
    return found


def bounds_of_document(document: Document) -> Bounds | None:
    """Rectangle around everything; None for an empty sketch."""
    curves = curves_of(document)
    boxes = [curve.bounds() for curve in curves.values()]
    for name, entity in document.entities.items():
        if entity.kind == "point":
            x, y = document.numbers_of(name).tolist()
            boxes.append(Bounds(x, y, x, y))
        elif entity.text:
            frame = curves[name]
            boxes.append(bounds_of(entity.text, frame.start, frame.end))
    if not boxes:
        return None
    found = boxes[0]
    for box in boxes[1:]:
        found = found.union(box)
    return found


def fitted(box: Bounds | None, width: float, height: float, margin: float) -> View:
    """View that shows a rectangle centred, with a margin in pixels."""
    if box is None:
        return View(1.0, 0.5 * width, 0.5 * height, width, height)
    across, up = box.x_max - box.x_min, box.y_max - box.y_min
    inner = max(width - 2 * margin, 0.2 * width), max(height - 2 * margin, 0.2 * height)
    scale = min(
        (pixels / size for pixels, size in zip(inner, (across, up), strict=True) if size > 0.0),
        default=1.0,
    )
    return at_scale(box, scale, width, height)


def at_scale(box: Bounds | None, scale: float, width: float, height: float) -> View:
    """View of a given scale, centred on a rectangle."""
    if box is None:
        return View(scale, 0.5 * width, 0.5 * height, width, height)
    x = 0.5 * width - scale * 0.5 * (box.x_min + box.x_max)
    y = 0.5 * height + scale * 0.5 * (box.y_min + box.y_max)
    return View(scale, x, y, width, height)
