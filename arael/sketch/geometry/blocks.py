"""Curves from the numbers of a document's entities, as its table of kinds lists them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from arael.sketch.geometry.chains import area, chains
from arael.sketch.geometry.circular import Arc, Circle
from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.elliptic import Ellipse, EllipticArc
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.splines import Bezier, BSpline
from arael.sketch.geometry.vectors import Point

Numbers = Sequence[float]


def curve_of(kind: str, numbers: Numbers) -> Curve:
    """Curve of an entity: ``line``, ``circle``, ``arc``, ``ellipse``, ``earc``, ``bezier``, ...

    Raises KeyError for other kinds, ``point`` among them.
    """
    return _CURVES[kind](numbers)


def numbers_of(curve: Curve) -> tuple[str, list[float]]:
    """Kind and numbers of an entity with the shape of a curve; arcs run counter-clockwise."""
    if isinstance(curve, Line):
        return "line", [*curve.p1, *curve.p2]
    if isinstance(curve, Circle):
        return "circle", [*curve.center, curve.radius]
    if isinstance(curve, Ellipse):
        return "ellipse", [*curve.center, curve.rx, curve.ry, curve.rotation]
    if isinstance(curve, Arc):
        arc = curve.forward()
        return "arc", [*arc.center, *arc.start, *arc.end, arc.radius]
    if isinstance(curve, EllipticArc):
        oval = curve.forward()
        ends = [*oval.center, *oval.start, *oval.end]
        return "earc", [*ends, oval.rx, oval.ry, oval.rotation]
    assert isinstance(curve, Bezier | BSpline)
    kind = "bezier" if isinstance(curve, Bezier) else "bspline"
    return kind, [x for pole in curve.poles for x in pole]


def chain_area(blocks: Sequence[tuple[str, Numbers]]) -> float:
    """Area enclosed by curves in any order and direction; the outline's gaps are bridged."""
    curves = [curve_of(kind, numbers) for kind, numbers in blocks]
    size = max((curve.bounds().size for curve in curves), default=0.0)
    found = chains(curves, 1e-6 * size)
    return sum(abs(area(chain.curves(curves))) for chain in found)


def _pairs(numbers: Numbers) -> tuple[Point, ...]:
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))


def _bezier(n: Numbers) -> Bezier:
    p, q, r, s = _pairs(n)
    return Bezier((p, q, r, s))


_CURVES: dict[str, Callable[[Numbers], Curve]] = {
    "line": lambda n: Line((n[0], n[1]), (n[2], n[3])),
    "circle": lambda n: Circle((n[0], n[1]), n[2]),
    "arc": lambda n: Arc.between((n[0], n[1]), (n[2], n[3]), (n[4], n[5]), n[6]),
    "ellipse": lambda n: Ellipse((n[0], n[1]), n[2], n[3], n[4]),
    "earc": lambda n: EllipticArc.between(
        (n[0], n[1]), (n[2], n[3]), (n[4], n[5]), n[6], n[7], n[8]
    ),
    "bezier": _bezier,
    "bspline": lambda n: BSpline(_pairs(n)),
}
