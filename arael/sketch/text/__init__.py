"""Texts of sketches: a single-stroke font and its lettering along a frame."""

from arael.sketch.text.glyphs import ABOVE, BELOW, CAPITAL, GLYPHS
from arael.sketch.text.lettering import (
    Stroke,
    bounds_of,
    box_of,
    height_of,
    lettering,
    strokes_of,
    unknown_characters,
    width_of,
)

__all__ = [
    "ABOVE",
    "BELOW",
    "CAPITAL",
    "GLYPHS",
    "Stroke",
    "bounds_of",
    "box_of",
    "height_of",
    "lettering",
    "strokes_of",
    "unknown_characters",
    "width_of",
]
