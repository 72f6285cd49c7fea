"""The font as a module of the page."""

from __future__ import annotations

import json

from arael.sketch.text.glyphs import ABOVE, BELOW, CAPITAL, GLYPHS, SPACING, UNKNOWN

_HEAD = """/**
 * The single-stroke font: width and strokes of every character. Made by `pytest --update` from
 * arael/sketch/text/glyphs.py, which describes how strokes are written.
 */
"""


def source() -> str:
    """The text of ``arael/sketch/page/geometry/font.js``."""
    numbers = {
        "CAPITAL": CAPITAL, "BELOW": BELOW, "ABOVE": ABOVE, "SPACING": SPACING,
    }  # fmt: skip
    constants = [f"export const {name} = {number:g};" for name, number in numbers.items()]
    glyphs = [
        f"  {json.dumps(one, ensure_ascii=False)}: {_written(*glyph)},"
        for one, glyph in sorted(GLYPHS.items())
    ]
    unknown = f"export const UNKNOWN = {_written(*UNKNOWN)};"
    table = [
        "/** @type {Readonly<Record<string, string>>} */",
        "export const GLYPHS = {",
        *glyphs,
        "};",
    ]
    return "\n".join([_HEAD + constants[0], *constants[1:], unknown, *table]) + "\n"


def _written(width: float, strokes: str) -> str:
    return json.dumps(f"{width:g}:{strokes}")
