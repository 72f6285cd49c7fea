"""Names of an entity's properties, and the expressions that take their place after a cut."""

from __future__ import annotations

from arael.sketch.expressions.properties import PROPERTIES
from arael.sketch.transfer.pieces import Division

_SUMMED = frozenset({"length", "sweep"})
_OF_POINTS = {"start_angle": "start", "end_angle": "end"}


def replacements(division: Division) -> dict[str, str]:
    """Old path -> new expression; what has no successor is left out, and breaks what reads it.

    The length of pieces that are all kept is their sum; of a line that lost a stretch inside, the
    distance of its ends.
    """
    old = division.old.name
    found: dict[str, str] = {}
    if not division.parts:
        return found
    names = [part.entity.name for part in division.parts]
    for point in ("p1", "p2", "start", "end", "center"):
        successor = division.successor(point)
        if successor is not None:
            found[f"{old}.{point}"] = successor
    for name in PROPERTIES[division.old.kind]:
        end = _OF_POINTS.get(name)
        if end is not None:
            successor = division.successor(end)
            if successor is not None:
                found[f"{old}.{name}"] = f"{successor.partition('.')[0]}.{name}"
        elif name in _SUMMED and not division.whole:
            ends = division.successor("p1"), division.successor("p2")
            if division.old.kind == "line" and None not in ends:
                found[f"{old}.{name}"] = f"dist({ends[0]}, {ends[1]})"
        elif name in _SUMMED:
            terms = " + ".join(f"{one}.{name}" for one in names)
            found[f"{old}.{name}"] = f"({terms})" if len(names) > 1 else terms
        else:
            found[f"{old}.{name}"] = f"{names[0]}.{name}"
    return found
