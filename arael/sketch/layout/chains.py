"""Lengths and areas of chains of curves, as sums of rows."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from arael.sketch.layout.operands import Operand, cross, place, sweep_of, towards, turn
from arael.sketch.layout.plan import Constant, Row, Values
from arael.sketch.layout.splines import basis_of, pieces, poles_of

Part = tuple[Row, float]

#: Whether two points, by offsets, are one place.
Same = Callable[[int, int], bool]

_ORIGIN = Constant((0.0, 0.0))

#: Kinds whose length is a sum of rows of the model.
WITH_LENGTH = ("line", "circle", "arc")


def apart(a: int, b: int) -> bool:
    """`Same` where nothing is known of joints."""
    return a == b


def length_of(curve: Operand) -> list[Part]:
    """Rows that add up to the length of a curve; none for the kinds that have no such rows."""
    kind = curve.entity.kind
    if kind == "line":
        return [(Row("Distance", curve.line), 1.0)]
    if kind == "circle":
        return [(Row("ScalarValue", (curve.circle.r,)), 2 * math.pi)]
    if kind == "arc":
        return [(Row("ArcLength", (curve.center, *curve.ends, curve.circle.r)), 1.0)]
    return []


def area_of(curves: list[Operand], values: Values, same: Same) -> list[Part]:
    """Rows that add up to the area inside a closed chain of curves, which is positive."""
    turned = directions(curves, values, same)
    parts = [
        (row, factor if forwards else -factor)
        for curve, forwards in zip(curves, turned, strict=True)
        for row, factor in _forward_area(curve)
    ]
    if _signed_area(curves, turned, values) < 0:
        parts = [(row, -factor) for row, factor in parts]
    return parts


def measured_area(curves: list[Operand], values: Values, same: Same = apart) -> float:
    """Area inside a closed chain of curves."""
    return abs(_signed_area(curves, directions(curves, values, same), values))


def measured_length(curve: Operand, values: Values) -> float:
    """Length of a line, circle or arc."""
    if curve.entity.kind == "line":
        return math.hypot(*towards(values, *curve.line))
    return float(values[curve.circle.r]) * sweep_of(values, curve)


def size_of(curves: list[Operand], values: Values) -> float:
    """A length of a chain: half the extent of its points, or a radius."""
    found = 0.0
    for curve in curves:
        if curve.entity.kind == "circle":
            found = max(found, abs(float(values[curve.circle.r])))
        elif curve.entity.kind == "ellipse":
            found = max(found, abs(float(values[curve.ellipse.rx])))
        for end in curve.ends:
            found = max(found, math.hypot(*towards(values, curves[0].entity.at, end)) / 2)
    return found or 1.0


def directions(curves: list[Operand], values: Values, same: Same) -> list[bool]:
    """Whether each curve of a chain, in any order, runs forwards along it.

    The chain leaves the first curve by its end, and goes on with the curve that has an end in the
    same place; without one, amid a change or where no joint holds the outline, with the nearest.
    """
    found = [True] * len(curves)
    if not all(curve.ends for curve in curves):
        return found
    here = curves[0].ends[1]
    left = dict.fromkeys(range(1, len(curves)))
    while left:
        _, _, k, backwards = min(
            (
                not same(here, end),
                math.dist(place(values, here), place(values, end)),
                k,
                bool(which),
            )
            for k in left
            for which, end in enumerate(curves[k].ends)
        )
        found[k] = not backwards
        here = curves[k].ends[0] if backwards else curves[k].ends[1]
        del left[k]
    return found


def _forward_area(curve: Operand) -> list[Part]:
    """Area between a curve and the origin."""
    kind = curve.entity.kind
    if kind == "line":
        return [(Row("LineArea", curve.line), 1.0)]
    if kind == "circle":
        # A whole turn: both ends are in one place.
        rim = Constant((1.0, 0.0))
        return [(Row("ArcArea", (_ORIGIN, rim, rim, curve.circle.r)), 1.0)]
    if kind == "arc":
        start, end = curve.ends
        bulge = Row("ArcArea", (curve.center, start, end, curve.circle.r))
        return [(Row("LineArea", (start, end)), 1.0), (bulge, 1.0)]
    if kind == "ellipse":
        # Twice the half between opposite points: a whole turn cannot be told from none by rounding.
        ends = (Constant((1.0, 0.0)), Constant((-1.0, 0.0)))
        return [(Row("EllipseArcArea", (_ORIGIN, *ends, *curve.ellipse[1:])), 2.0)]
    if kind == "earc":
        start, end = curve.ends
        bulge = Row("EllipseArcArea", (curve.center, start, end, *curve.ellipse[1:]))
        return [(Row("LineArea", (start, end)), 1.0), (bulge, 1.0)]
    parts: list[Part] = []
    if curve.is_spline:
        for piece in range(pieces(curve)):
            poles = poles_of(curve, piece)
            weights = _area_weights(curve.entity.size // 2, piece, curve)
            parts += [
                (Row("LineArea", (poles[i], poles[j])), weights[i][j])
                for i in range(4)
                for j in range(i + 1, 4)
                if abs(weights[i][j]) > 1e-14
            ]
    return parts


def _area_weights(count: int, piece: int, curve: Operand) -> list[list[float]]:
    return _weights(tuple(map(tuple, basis_of(curve, piece).tolist())))


@lru_cache(maxsize=256)
def _weights(basis: tuple[tuple[float, ...], ...]) -> list[list[float]]:
    """Factors w of 0.5 cross(pole i, pole j), i < j, in half the integral of x dy - y dx."""
    rows = np.array(basis)
    powers = np.arange(4)
    # integral over 0 .. 1 of t^a * d/dt t^b
    product = powers[None, :] / np.maximum(powers[:, None] + powers[None, :], 1)
    full = rows @ product @ rows.T
    return (full - full.T).tolist()  # type: ignore[no-any-return]


def _signed_area(curves: list[Operand], turned: list[bool], values: Values) -> float:
    total = 0.0
    for curve, forwards in zip(curves, turned, strict=True):
        found = 0.0
        for row, factor in _forward_area(curve):
            if row.struct == "LineArea":
                a, b = (place(values, use) for use in row.uses if isinstance(use, int))
                found += factor * 0.5 * cross(a, b)
            else:
                sweep, square = _turn_and_square(curve, values)
                found += factor * 0.5 * square * (sweep - math.sin(sweep))
        total += found if forwards else -found
    return total


def _turn_and_square(curve: Operand, values: Values) -> tuple[float, float]:
    """Sweep of a round curve by its parameter, and the product of its radii."""
    if curve.is_circular:
        return sweep_of(values, curve), float(values[curve.circle.r]) ** 2
    _, rx, ry, rot = curve.ellipse
    a, b = float(values[rx]), float(values[ry])
    if not curve.ends:
        return math.pi, a * b
    c, s = math.cos(values[rot]), math.sin(values[rot])
    rounded = []
    for end in curve.ends:
        u = towards(values, curve.center, end)
        rounded.append((b * (c * u[0] + s * u[1]), a * (c * u[1] - s * u[0])))
    found = turn(*rounded)
    return (found if found > 0 else found + 2 * math.pi), a * b
