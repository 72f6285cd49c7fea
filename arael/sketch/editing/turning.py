"""Where a line starts that is to have quite another direction.

From across, the nearest solution of ``vertical`` is a line without length. So a line that deviates
by more than 30 degrees from the direction that a new relation wants is turned there first. A line
that is to be tangent to an arc at their common end is turned if it deviates by more than 60
degrees; where both ways are as far, to continue the arc. Nearer, line and arc share the change.
A line that is to be horizontal or vertical takes its figure along where that is free to turn and
other lines would have to follow: a rectangle stays one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from arael.sketch.document.document import Document
from arael.sketch.document.measures import signed
from arael.sketch.document.records import Constraint, Dimension
from arael.sketch.layout.layout import Layout
from arael.sketch.solve.turning_back import turned_along

_FAR, _FAR_TANGENT = math.radians(30.0), math.radians(60.0)
#: A line is across an arc from here on: both ways to be tangent are as far.
_ACROSS = math.radians(80.0)

#: Relations of the direction of a line to that of another.
_DIRECTIONS = frozenset(
    {"parallel", "perpendicular", "collinear", "equal_angle", "angle", "symmetry", "image"}
)

Moves = dict[int, tuple[float, float]]
"""Offset of the x of a point -> where to."""


def turned(layout: Layout, kind: str, args: tuple[str, ...]) -> Moves:
    """Places of points with which a relation of directions starts; empty if it can start as it is.

    The second operand is turned: about the end that others hold, else about its middle. Points
    that are coincident with its ends move along.
    """
    document = layout.document
    found = _wanted(layout, kind, args)
    if found is None:
        return {}
    name, direction = found
    x1, y1, x2, y2 = document.numbers_of(name).tolist()
    off = math.remainder(math.atan2(y2 - y1, x2 - x1) - direction, math.pi)
    if abs(off) < (_FAR_TANGENT if kind == "tangent" else _FAR):
        return {}
    if kind in ("horizontal", "vertical") and _has_directions(layout, name):
        whole = _as_a_whole(layout, name, -off)
        if whole:
            return whole
    if kind == "tangent" and abs(off) > _ACROSS:
        off = math.remainder(math.atan2(y2 - y1, x2 - x1) - direction, 2.0 * math.pi)
    return _about_an_end(layout, name, -off)


def turned_to(layout: Layout, dimension: Dimension) -> Moves:
    """Places with which the value of an angle starts: its line has turned, and kept its length.

    Steps of least change leave a line along its tangent, which makes it longer. Empty for what is
    no angle, and for lines both of whose ends something else holds.
    """
    if dimension.kind not in ("xangle", "angle") or dimension.value is None or dimension.derived:
        return {}
    document, name = layout.document, dimension.args[-1]
    if document.entities[name].kind != "line":
        return {}
    now = signed(document, dimension.kind, dimension.args, dimension.mode)
    wanted = dimension.value.number
    if dimension.kind == "xangle":
        off = math.remainder(math.radians(wanted - now), math.tau)
    else:  # a supplement grows as its line turns clockwise
        supplement = dimension.mode == "supplement"
        off = math.radians(wanted - abs(now)) * dimension.side * (-1.0 if supplement else 1.0)
    ends = (f"{name}.p1", f"{name}.p2")
    if abs(off) < 1e-9 or all(_is_held(layout, name, _tied(layout, end)) for end in ends):
        return {}
    return _about_an_end(layout, name, off)


def _has_directions(layout: Layout, line: str) -> bool:
    """Whether the direction of a line is tied to those of others, which would have to follow."""
    document = layout.document
    users = (
        document.constraints.get(u) or document.dimensions.get(u) for u in layout.users_of(line)
    )
    return any(one is not None and one.kind in _DIRECTIONS for one in users)


def _as_a_whole(layout: Layout, line: str, angle: float) -> Moves:
    """The figure of a line turned, which keeps its shape; empty where it is not free to turn."""
    document = layout.document
    turned = turned_along(layout, document.entities[line].at, angle)
    if turned is None:
        return {}
    values, before = layout.values_at(turned), document.values
    numbers = np.flatnonzero(layout.axis_of(np.arange(len(values))) == 1)
    moved = (values != before)[numbers] | (values != before)[numbers + 1]
    return {at: (values[at], values[at + 1]) for at in numbers[moved].tolist()}


def _about_an_end(layout: Layout, name: str, angle: float) -> Moves:
    """A line turned about the end that others hold, else about its middle."""
    document = layout.document
    x1, y1, x2, y2 = document.numbers_of(name).tolist()
    ties = [_tied(layout, f"{name}.p1"), _tied(layout, f"{name}.p2")]
    held = [_is_held(layout, name, tied) for tied in ties]
    share = {(True, False): 0.0, (False, True): 1.0}.get((held[0], held[1]), 0.5)
    px, py = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
    c, s = math.cos(angle), math.sin(angle)
    moves: Moves = {}
    for tied, x, y in zip(ties, (x1, x2), (y1, y2), strict=True):
        to = px + c * (x - px) - s * (y - py), py + s * (x - px) + c * (y - py)
        moves |= {document.point_at(handle): to for handle in tied}
    return moves


def _wanted(layout: Layout, kind: str, args: tuple[str, ...]) -> tuple[str, float] | None:
    """The line that is to be turned, and the direction (radians) that it is to have."""
    document = layout.document
    names = [arg.partition(".")[0] for arg in args]
    if kind == "tangent":
        return _wanted_tangent(layout, names)
    if any(document.entities[name].kind != "line" for name in names):
        return None
    if kind in ("horizontal", "vertical") and len(set(names)) == 1:
        return names[0], 0.0 if kind == "horizontal" else 0.5 * math.pi
    if kind in ("parallel", "collinear", "perpendicular") and len(names) == 2:
        x1, y1, x2, y2 = document.numbers_of(names[0]).tolist()
        direction = math.atan2(y2 - y1, x2 - x1)
        return names[1], direction + (0.5 * math.pi if kind == "perpendicular" else 0.0)
    return None


def _wanted_tangent(layout: Layout, names: list[str]) -> tuple[str, float] | None:
    """A line, and the direction of the arc at the end they share."""
    document = layout.document
    kinds = {document.entities[name].kind: name for name in names}
    if kinds.keys() != {"line", "arc"}:
        return None
    line, arc = kinds["line"], kinds["arc"]
    for p, one in enumerate(("p1", "p2")):
        shared = _tied(layout, f"{line}.{one}")
        for e, end in enumerate(("start", "end")):
            if f"{arc}.{end}" not in shared:
                continue
            x, y = _place(document, f"{arc}.{end}")
            cx, cy = _place(document, f"{arc}.center")
            # Arcs run counter-clockwise: a line from p1 to p2 goes on at the end, and comes in at
            # the start.
            forward = math.atan2(y - cy, x - cx) + 0.5 * math.pi
            return line, forward + (math.pi if p == e else 0.0)
    return None


def _place(document: Document, handle: str) -> tuple[float, float]:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y


def _users(layout: Layout, handle: str) -> Iterator[Constraint]:
    """Relations that involve the entity of a handle."""
    for name in layout.users_of(handle):
        one = layout.document.constraints.get(name)
        if one is not None:
            yield one


def _tied(layout: Layout, start: str) -> list[str]:
    """Handles at one place with one, by coincident relations."""
    found = {start: None}
    waiting = [start]
    while waiting:
        here = waiting.pop()
        for relation in _users(layout, here):
            if relation.kind != "coincident" or not relation.active or here not in relation.args:
                continue
            for other in relation.args:
                if other not in found:
                    found[other] = None
                    waiting.append(other)
    return list(found)


def _is_held(layout: Layout, line: str, tied: list[str]) -> bool:
    """Whether something else is at an end, or locks it."""
    if len(tied) > 1:
        return True
    return any(
        one.kind in ("lock", "fix", "point_on", "midpoint") and one.args[0] in (*tied, line)
        for one in _users(layout, line)
    )
