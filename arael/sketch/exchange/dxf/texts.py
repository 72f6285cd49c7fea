"""TEXT entities of DXF as lines with a text."""

from __future__ import annotations

from math import cos, radians, sin
from typing import Any

from arael.sketch.document.texts import problem_of
from arael.sketch.geometry import Affine, Line
from arael.sketch.text import width_of

# Horizontal alignments whose second point ends the base line (ALIGNED, FIT), and the part of the
# width that is left of the point for the others.
_BETWEEN = frozenset({3, 5})
_LEFT_OF = {0: 0.0, 1: 0.5, 2: 1.0, 4: 0.5}

# Part of the height of capitals below the point: base line, bottom, middle, top.
_BELOW = {0: 0.0, 1: -0.3, 2: 0.5, 3: 1.0}


def text_frame(entity: Any) -> tuple[Line, str] | None:
    """Frame and text of a TEXT entity; None if a sketch cannot hold it.

    The height of the capitals is kept, and for texts between two points their width.
    """
    text = str(entity.plain_text())
    x, y, z = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if problem_of(text) or abs(x) + abs(y) > 1e-9 * z:
        return None
    insert, second = entity.dxf.insert, entity.dxf.get("align_point", entity.dxf.insert)
    halign, valign = int(entity.dxf.get("halign", 0)), int(entity.dxf.get("valign", 0))
    if halign in _BETWEEN:
        return Line((insert[0], insert[1]), (second[0], second[1])), text
    height = float(entity.dxf.get("height", 0.0))
    if not height > 0.0:
        return None
    width = height * width_of(text)
    at = insert if halign == 0 and valign == 0 else second
    if halign == 4:  # in the middle of the whole text
        valign = 2
    turn = radians(float(entity.dxf.get("rotation", 0.0)))
    by = Affine(cos(turn), sin(turn), -sin(turn), cos(turn), at[0], at[1])
    left = -_LEFT_OF.get(halign, 0.0) * width
    low = -_BELOW.get(valign, 0.0) * height
    return Line(by((left, low)), by((left + width, low))), text
