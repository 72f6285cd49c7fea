"""Layouts as SVG."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from xml.sax.saxutils import escape, quoteattr

from arael.sketch.drawing.primitives import Layout, Path, Segment, Text
from arael.sketch.drawing.themes import FONT, THEMES, Theme


def number(x: float) -> str:
    """Two decimals at most; no minus sign before zero."""
    text = f"{x:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def path_data(segments: tuple[Segment, ...]) -> str:
    """The ``d`` attribute of a path."""
    return "".join(f"{c}{' '.join(map(number, numbers))}" for c, numbers in segments)


def to_svg(drawing: Layout, theme: Theme = "light") -> str:
    """A layout as an SVG document; every text is escaped.

    Elements carry the name of their record as ``data-name``.
    """
    colours = THEMES[theme]
    width, height = number(drawing.width), number(drawing.height)
    label = quoteattr(printable(drawing.title))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" role="img" aria-label={label} '
        'stroke-linecap="round" stroke-linejoin="round" fill="none" '
        f'font-family="{escape(FONT)}" text-anchor="middle" dominant-baseline="central">',
        f"<title>{clean(drawing.title)}</title>",
        f'<rect width="{width}" height="{height}" fill="{colours["background"]}"/>',
    ]
    for item in drawing.items:
        parts.append(_path(item, colours) if isinstance(item, Path) else _text(item, colours))
    parts.append("</svg>")
    return "\n".join(parts) + "\n"


def printable(text: str) -> str:
    """Text without the characters that XML forbids."""
    return "".join(
        c if c in "\t\n" or " " <= c <= "\ud7ff" or "\ue000" <= c <= "\ufffd" or c > "\uffff"
        else "\ufffd"
        for c in text
    )  # fmt: skip


def clean(text: str) -> str:
    """Text for the content of an element."""
    return escape(printable(text))


def _named(name: str) -> str:
    return f" data-name={quoteattr(printable(name))}" if name else ""


def _path(item: Path, colours: Mapping[str, str]) -> str:
    found = [f'<path d="{path_data(item.segments)}"']
    if item.width > 0:
        found.append(f' stroke="{colours[item.role]}" stroke-width="{number(item.width)}"')
    if item.dash:
        found.append(f' stroke-dasharray="{" ".join(map(number, item.dash))}"')
        found.append(' stroke-linecap="butt"')
    if item.fill:
        found.append(f' fill="{colours[item.fill]}"')
    if item.opacity < 1.0:
        found.append(f' opacity="{number(item.opacity)}"')
    return "".join(found) + _named(item.name) + "/>"


def _text(item: Text, colours: Mapping[str, str]) -> str:
    turn = ""
    if item.angle:
        turn = (
            f' transform="rotate({number(-degrees(item.angle))} {number(item.x)} {number(item.y)})"'
        )
    anchor = "" if item.anchor == "middle" else f' text-anchor="{item.anchor}"'
    # a border in the colour of the background keeps texts readable over lines
    return (
        f'<text x="{number(item.x)}" y="{number(item.y)}" font-size="{number(item.size)}"'
        f'{anchor}{turn} fill="{colours[item.role]}" stroke="{colours["background"]}" '
        f'stroke-width="3" paint-order="stroke"{_named(item.name)}>{clean(item.text)}</text>'
    )
