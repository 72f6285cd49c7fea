"""What a drawing is made of: paths and texts in pixels, y downwards, with roles instead of colours.

A layout is data: SVG, PNG and PDF are written from it, and it can be encoded as JSON for a canvas.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import msgspec

Segment: TypeAlias = tuple[str, tuple[float, ...]]
"""A path command of SVG in absolute coordinates: ``M x y``, ``L x y``, ``C`` (6 numbers), ``Z``."""

Dash: TypeAlias = tuple[float, ...]


class Path(msgspec.Struct, frozen=True, tag="path"):
    """A stroked or filled path.

    Attributes
    ----------
    role : what it is: a key of the theme's colours
    segments : path commands
    width : of the stroke, pixels; 0 for none
    dash : lengths of dashes and gaps; empty for a solid stroke
    fill : role of the filling, empty for none
    opacity : of both
    name : of the record it belongs to, empty for none
    """

    role: str
    segments: tuple[Segment, ...]
    width: float = 1.0
    dash: Dash = ()
    fill: str = ""
    opacity: float = 1.0
    name: str = ""


class Text(msgspec.Struct, frozen=True, tag="text"):
    """One line of text, centred on its place.

    Attributes
    ----------
    role : a key of the theme's colours
    x, y : of its centre
    text : any text
    size : of the font, pixels
    angle : radians, counter-clockwise as seen
    anchor : which point of the text is at x
    name : of the record it belongs to
    """

    role: str
    x: float
    y: float
    text: str
    size: float = 12.0
    angle: float = 0.0
    anchor: Literal["start", "middle", "end"] = "middle"
    name: str = ""


Item: TypeAlias = Path | Text


class Layout(msgspec.Struct, frozen=True):
    """A drawing: its size in pixels, and its items from back to front."""

    width: float
    height: float
    items: tuple[Item, ...]
    title: str = ""


def polyline(*points: tuple[float, float], close: bool = False) -> tuple[Segment, ...]:
    """Segments of straight lines."""
    found: list[Segment] = [("L" if i else "M", tuple(p)) for i, p in enumerate(points)]
    return (*found, ("Z", ())) if close else tuple(found)


_K = 0.5522847498307936
"""Distance of the inner poles of a Bezier curve that stands for a quarter of the unit circle."""


def disc(x: float, y: float, r: float) -> tuple[Segment, ...]:
    """Segments of a circle."""
    k = _K * r
    return (
        ("M", (x + r, y)),
        ("C", (x + r, y + k, x + k, y + r, x, y + r)),
        ("C", (x - k, y + r, x - r, y + k, x - r, y)),
        ("C", (x - r, y - k, x - k, y - r, x, y - r)),
        ("C", (x + k, y - r, x + r, y - k, x + r, y)),
        ("Z", ()),
    )


def square(x: float, y: float, half: float) -> tuple[Segment, ...]:
    """Segments of a square about a centre."""
    return polyline(
        (x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half),
        close=True,
    )  # fmt: skip
