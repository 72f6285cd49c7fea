"""Lettering: the strokes of a text along its frame.

A frame is a line: its start is the left end of the base line, its length the width of the text, so
that the size of the lettering follows the frame.
"""

from __future__ import annotations

from functools import lru_cache
from math import atan2, hypot, radians, sin, tan
from typing import TypeAlias

from arael.sketch.geometry import Affine, Arc, Bounds, Circle, Curve, Line, Point
from arael.sketch.text.glyphs import ABOVE, BELOW, CAPITAL, GLYPHS, SPACING, UNKNOWN

Stroke: TypeAlias = tuple[Curve, ...]
"""Lines, arcs and circles that are drawn without lifting the pen."""


def unknown_characters(text: str) -> str:
    """The characters that are drawn as a box, each once."""
    return "".join(dict.fromkeys(one for one in text if one not in GLYPHS))


@lru_cache(maxsize=4096)
def width_of(text: str) -> float:
    """Width of a text whose capitals are 1 high."""
    widths = [GLYPHS.get(one, UNKNOWN)[0] for one in text]
    return (sum(widths) + SPACING * (len(widths) - 1)) / CAPITAL


def height_of(text: str, length: float) -> float:
    """Height of the capitals of a text in a frame of a length."""
    return length / width_of(text)


def lettering(text: str, start: Point, end: Point) -> list[Stroke]:
    """Strokes of a text in the frame from `start` to `end`."""
    by = _placed(text, start, end)
    found: list[Stroke] = []
    x = 0.0
    for one in text:
        at = by.after(Affine(1.0, 0.0, 0.0, 1.0, x, 0.0))
        found += [tuple(piece.transformed(at) for piece in stroke) for stroke in strokes_of(one)]
        x += GLYPHS.get(one, UNKNOWN)[0] + SPACING
    return found


def box_of(text: str, start: Point, end: Point) -> tuple[Point, Point, Point, Point]:
    """Corners of the box of a text, counter-clockwise from the left below the base line."""
    by = _placed(text, start, end)
    right = CAPITAL * width_of(text)
    return by((0.0, BELOW)), by((right, BELOW)), by((right, ABOVE)), by((0.0, ABOVE))


def bounds_of(text: str, start: Point, end: Point) -> Bounds:
    """Rectangle around the box of a text."""
    xs, ys = zip(*box_of(text, start, end), strict=True)
    return Bounds(min(xs), min(ys), max(xs), max(ys))


def _placed(text: str, start: Point, end: Point) -> Affine:
    """From the grid of the font to the frame."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    scale = CAPITAL * width_of(text)
    return Affine(dx / scale, dy / scale, -dy / scale, dx / scale, *start)


@lru_cache(maxsize=512)
def strokes_of(character: str) -> tuple[Stroke, ...]:
    """Strokes of a character on the grid of the font."""
    strokes = GLYPHS.get(character, UNKNOWN)[1]
    return tuple(_stroke(one) for one in strokes.split("|") if one)


def _stroke(text: str) -> Stroke:
    if text.startswith("@"):
        x, y, r = (float(number) for number in text[1:].split(","))
        return (Circle((x, y), r),)
    pieces: list[Curve] = []
    before: Point | None = None
    for word in text.split():
        place, _, turn = word.partition("~")
        x, y = (float(number) for number in place.split(","))
        if before is not None:
            pieces.append(_arc(before, (x, y), radians(float(turn))) if turn else
                          Line(before, (x, y)))  # fmt: skip
        before = x, y
    return tuple(pieces)


def _arc(start: Point, end: Point, sweep: float) -> Arc:
    """The arc between two points that turns by an angle.

    Its centre lies on the bisector of the chord, to the left of it by half its length over the
    tangent of half of the sweep.
    """
    dx, dy = end[0] - start[0], end[1] - start[1]
    up = 0.5 / tan(0.5 * sweep)
    center = 0.5 * (start[0] + end[0]) - up * dy, 0.5 * (start[1] + end[1]) + up * dx
    radius = abs(0.5 * hypot(dx, dy) / sin(0.5 * sweep))
    angle = atan2(start[1] - center[1], start[0] - center[0])
    return Arc(center, radius, angle, sweep)
