"""Pictures of sketches: one layout of primitives, written as SVG, PNG or PDF."""

from arael.sketch.drawing.figure import to_image
from arael.sketch.drawing.layout import layout
from arael.sketch.drawing.primitives import Item, Layout, Path, Text
from arael.sketch.drawing.svg import to_svg
from arael.sketch.drawing.themes import STATES, THEMES, Theme
from arael.sketch.drawing.view import View, bounds_of_document, fitted

__all__ = [
    "STATES",
    "THEMES",
    "Item",
    "Layout",
    "Path",
    "Text",
    "Theme",
    "View",
    "bounds_of_document",
    "fitted",
    "layout",
    "to_image",
    "to_svg",
]
