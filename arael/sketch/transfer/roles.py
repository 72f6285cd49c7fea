"""What an operand of a constraint or dimension means by an entity: its role.

``point``
    an end or centre: follows the piece that owns it
``whole``
    what holds for every piece: a direction, a centre, a radius
``carrier``
    the line or circle that a piece lies on: one piece stands for it
``contact``
    the curve where something touches it: follows the piece at the contact
``extent``
    the length between the ends: no piece has it
"""

from __future__ import annotations

from typing import Literal

from arael.sketch.document.document import Document
from arael.sketch.document.records import Constraint, Dimension

Role = Literal["point", "whole", "carrier", "contact", "extent"]

_WHOLE = frozenset(
    {"horizontal", "vertical", "parallel", "perpendicular", "collinear", "concentric", "fix"}
)
_WHOLE_DIMENSIONS = frozenset({"radius", "diameter", "radius_b", "xangle"})
_EXTENTS = frozenset({"length", "sweep", "arc_length", "total_length", "area"})


def role_of(document: Document, record: Constraint | Dimension, position: int) -> Role:
    """Role of the operand at a position."""
    arg = record.args[position]
    entity = document.entities[arg.partition(".")[0]]
    if "." in arg or entity.kind == "point":
        return "point"
    if isinstance(record, Dimension):
        if record.kind in _EXTENTS:
            return "extent"
        return "whole" if record.kind in _WHOLE_DIMENSIONS else "carrier"
    kind = record.kind
    if kind in _WHOLE:
        return "whole"
    if kind == "equal":
        return "extent" if entity.kind == "line" else "whole"
    if kind in ("tangent", "point_on"):
        return "contact"
    if kind == "symmetry":
        return "carrier" if position == 1 else "extent"
    if kind == "equal_angle":
        return "carrier"
    if kind == "image":
        return "carrier" if position == 2 else "extent"
    return "extent"
