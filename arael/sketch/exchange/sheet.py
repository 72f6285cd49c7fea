"""Drawings with dimensions as PDF at full size, and as PNG."""

from __future__ import annotations

from typing import Literal

from arael.sketch.document.document import Document
from arael.sketch.drawing import Theme, View, bounds_of_document, layout, to_image
from arael.sketch.exchange.units import MILLIMETRES

_LARGEST = 4000.0
_PER_MM = 96.0 / 25.4
_MARGIN = 70.0


def to_sheet(document: Document, kind: Literal["png", "pdf"], theme: Theme = "light") -> bytes:
    """A drawing without glyphs of constraints.

    A PDF is at full size as long as the sheet is between 5 cm and 1 m; otherwise, and as a PNG, the
    drawing is scaled to fit.
    """
    box = bounds_of_document(document)
    if kind == "png" or box is None:
        drawing = layout(document, width=1000, height=700, glyphs=False)
        return to_image(drawing, kind, theme)
    scale = _PER_MM * MILLIMETRES[document.unit]
    width = scale * (box.x_max - box.x_min) + 2 * _MARGIN
    height = scale * (box.y_max - box.y_min) + 2 * _MARGIN
    if max(width, height) > _LARGEST or max(width, height) < 200.0:
        return to_image(layout(document, width=1000, height=700, glyphs=False), kind, theme)
    x, y = _MARGIN - scale * box.x_min, height - _MARGIN + scale * box.y_min
    view = View(scale, x, y, width, height)
    return to_image(layout(document, view=view, glyphs=False), kind, theme)
