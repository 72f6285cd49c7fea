"""Cubic pieces of splines: their bases, and where on them a point is."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.sketch.layout.operands import Operand
from arael.sketch.layout.plan import Values

if TYPE_CHECKING:
    from arael.sketch.geometry.splines import BSpline
    from arael.sketch.geometry.vectors import Point

Basis = NDArray[np.float64]


def pieces(curve: Operand) -> int:
    """How many cubic pieces a spline has."""
    return 1 if curve.entity.kind == "bezier" else curve.entity.size // 2 - 3


@lru_cache(maxsize=256)
def basis(count: int, piece: int) -> Basis:
    """Weights of the four poles of a piece of a clamped uniform cubic B-spline, by powers of t.

    Row i holds the coefficients of 1, t, t^2, t^3 in the weight of the i-th pole of the piece, t
    from 0 to 1 within it. A Bezier curve is the B-spline of four poles. Cox-de Boor recursion on
    polynomials (de Boor, A Practical Guide to Splines, 1978, ch. IX).
    """
    knots = np.clip(np.arange(count + 4) - 3.0, 0.0, count - 3.0)
    span = piece + 3
    polynomials: dict[int, NDArray[np.float64]] = {span: np.array([1.0, 0.0, 0.0, 0.0])}
    for degree in (1, 2, 3):
        raised: dict[int, NDArray[np.float64]] = {}
        for i in range(span - degree, span + 1):
            total = np.zeros(4)
            for j, ascending in ((i, True), (i + 1, False)):
                if j not in polynomials:
                    continue
                low, high = knots[j], knots[j + degree]
                old = polynomials[j]
                by_t = np.concatenate([[0.0], old[:3]])
                if ascending:
                    total += (by_t + (piece - low) * old) / (high - low)
                else:
                    total += ((high - piece) * old - by_t) / (high - low)
            raised[i] = total
        polynomials = raised
    return np.array([polynomials[i] for i in range(span - 3, span + 1)])


def basis_of(curve: Operand, piece: int) -> Basis:
    """Of one piece of a spline."""
    return basis(curve.entity.size // 2, piece)


def poles_of(curve: Operand, piece: int) -> tuple[int, int, int, int]:
    """Offsets of the poles of a piece."""
    first = curve.entity.at + 2 * piece
    return first, first + 2, first + 4, first + 6


def nearest(values: Values, curve: Operand, point: Point) -> tuple[int, float]:
    """Piece and its parameter, within [0, 1], of the point of a spline nearest to a point."""
    spline = _spline(values, curve)
    return spline.span_at(spline.nearest(point).t)


def nearest_on(values: Values, curve: Operand, piece: int, point: Point) -> tuple[float, float]:
    """Parameter of the point of a piece nearest to a point, and the distance.

    A spline that crosses itself has a point on two pieces.
    """
    found = _spline(values, curve).bezier(piece).nearest(point)
    return found.t, found.distance


def _spline(values: Values, curve: Operand) -> BSpline:
    # imported here: start-up time
    from arael.sketch.geometry.splines import BSpline

    numbers = values[curve.entity.at : curve.entity.at + curve.entity.size].tolist()
    # A Bezier curve is the B-spline of four poles.
    return BSpline(tuple(zip(numbers[::2], numbers[1::2], strict=True)))
