"""Constraints that geometry satisfies already, within a tolerance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import hypot, sin

from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends
from arael.sketch.document.records import Entity
from arael.sketch.exchange.imported import Suggestion
from arael.sketch.geometry import Circle, Conic, Curve, Line, Point, angle, curve_of
from arael.sketch.geometry.chains import clusters

ANGLE = 1e-3
"""Radians within which directions count as equal."""

RELATIVE = 1e-5
"""Default tolerance, in sizes of the drawing."""


def recognised(document: Document, tolerance: float | None = None) -> list[Suggestion]:
    """Coincidences, concentric and equal circles, tangents, horizontal and vertical lines.

    Parameters
    ----------
    document
        A sketch, usually just imported.
    tolerance
        Distance within which points coincide; by default 1e-5 of the drawing. Directions count
        as equal within 0.001 radian and if the lines then move by no more than the tolerance.

    Returns
    -------
    list of Suggestion
        Each group of points at one place is a chain of coincidences, so none is redundant with
        another; nothing is applied.
    """
    curves = {
        name: curve_of(entity.kind, document.numbers_of(name).tolist())
        for name, entity in document.entities.items()
        if entity.kind != "point"
    }
    if tolerance is None:
        tolerance = RELATIVE * _size(document, curves)
    joints = _joints(document, tolerance)
    found = [one for group in joints for one in _coincident(document, group)]
    found += _directions(curves, tolerance)
    found += _tangents(document, curves, joints, tolerance)
    found += _circles_touching(curves, tolerance)
    found += _concentric(document, curves, joints, tolerance)
    found += _equal(curves, tolerance)
    return found


def _size(document: Document, curves: Mapping[str, Curve]) -> float:
    boxes = [curve.bounds() for curve in curves.values()]
    if not boxes:
        return 1.0
    return hypot(
        max(b.x_max for b in boxes) - min(b.x_min for b in boxes),
        max(b.y_max for b in boxes) - min(b.y_min for b in boxes),
    )


def _points(document: Document, entity: Entity) -> Iterator[str]:
    if entity.kind == "point":
        yield entity.name
    for point in ends(entity):
        yield f"{entity.name}.{point}"


def _at(document: Document, handle: str) -> Point:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y


def _joints(document: Document, tolerance: float) -> list[list[str]]:
    """Handles of ends and points, grouped by place."""
    handles = [h for entity in document.entities.values() for h in _points(document, entity)]
    node = clusters([_at(document, handle) for handle in handles], tolerance)
    groups: dict[int, list[str]] = {}
    for handle, n in zip(handles, node, strict=True):
        groups.setdefault(n, []).append(handle)
    # the two ends of one short curve are not to be joined
    return [list({h.split(".")[0]: h for h in g}.values()) for g in groups.values() if len(g) > 1]


def _coincident(document: Document, group: list[str]) -> Iterator[Suggestion]:
    for a, b in pairwise(group):
        p, q = _at(document, a), _at(document, b)
        yield Suggestion("coincident", (a, b), hypot(p[0] - q[0], p[1] - q[1]))


def _directions(curves: Mapping[str, Curve], tolerance: float) -> Iterator[Suggestion]:
    for name, curve in curves.items():
        if isinstance(curve, Line):
            dx, dy = abs(curve.p2[0] - curve.p1[0]), abs(curve.p2[1] - curve.p1[1])
            if dy <= min(tolerance, ANGLE * dx):
                yield Suggestion("horizontal", (name,), dy)
            elif dx <= min(tolerance, ANGLE * dy):
                yield Suggestion("vertical", (name,), dx)


def _tangents(
    document: Document,
    curves: Mapping[str, Curve],
    joints: list[list[str]],
    tolerance: float,
) -> Iterator[Suggestion]:
    """Where two ends meet in one direction; two straight lines are not tangent."""
    for group in joints:
        handles = [h for h in group if "." in h]
        for i, a in enumerate(handles):
            for b in handles[i + 1 :]:
                one, two = (curves[h.split(".")[0]] for h in (a, b))
                if isinstance(one, Line) and isinstance(two, Line):
                    continue
                turn = abs(sin(angle(_leaving(document, one, a), _leaving(document, two, b))))
                reach = min(one.bounds().size, two.bounds().size)
                if turn <= ANGLE and turn * reach <= 10.0 * tolerance:
                    yield Suggestion("tangent", (a, b), turn * reach)


def _leaving(document: Document, curve: Curve, handle: str) -> Point:
    x, y = _at(document, handle)
    p, q = curve.start, curve.end
    near = hypot(p[0] - x, p[1] - y) <= hypot(q[0] - x, q[1] - y)
    return curve.tangent_at(0.0 if near else 1.0)


def _circles_touching(curves: Mapping[str, Curve], tolerance: float) -> Iterator[Suggestion]:
    """Lines that touch a whole circle between their ends."""
    circles = [(name, c) for name, c in curves.items() if isinstance(c, Circle)]
    lines = [(name, c) for name, c in curves.items() if isinstance(c, Line)]
    if len(circles) * len(lines) > 1_000_000:
        return
    for name, line in lines:
        if not line.length() > 0.0:
            continue
        for other, circle in circles:
            distance = line.signed_distance(circle.center)
            gap = abs(abs(distance) - circle.radius)
            foot = line.nearest(circle.center, carrier=True).t
            if gap <= tolerance and 0.0 <= foot <= 1.0:
                yield Suggestion("tangent", (name, other), gap)


def _concentric(
    document: Document,
    curves: Mapping[str, Curve],
    joints: list[list[str]],
    tolerance: float,
) -> Iterator[Suggestion]:
    rounds = [(name, curve) for name, curve in curves.items() if isinstance(curve, Conic)]
    node = clusters([curve.middle for _, curve in rounds], tolerance)
    last: dict[int, tuple[str, Conic]] = {}
    for n, (name, curve) in zip(node, rounds, strict=True):
        if n in last:
            other, first = last[n]
            (x, y), (u, v) = first.middle, curve.middle
            yield Suggestion("concentric", (other, name), hypot(x - u, y - v))
        last[n] = name, curve


def _equal(curves: Mapping[str, Curve], tolerance: float) -> Iterator[Suggestion]:
    radii = sorted(
        (curve.radii[0], i, name)
        for i, (name, curve) in enumerate(curves.items())
        if isinstance(curve, Conic) and name.startswith("A")
    )
    for (r, _, a), (s, _, b) in pairwise(radii):
        if s - r <= tolerance:
            yield Suggestion("equal", (a, b), s - r)
