"""Where on a spline a point is."""

from __future__ import annotations

import numpy as np
import pytest

from arael.sketch.document.records import Entity
from arael.sketch.layout.operands import Operand
from arael.sketch.layout.splines import basis_of, nearest, pieces, poles_of


@pytest.mark.sweep(4)
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("count", [4, 5, 9])
def test_the_place_of_a_point_of_a_spline_is_found_again(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    kind = "bezier" if count == 4 else "bspline"
    curve = Operand(Entity(name="S0", kind=kind, at=0, size=2 * count), "", 0)
    values = rng.uniform(-10.0, 10.0, 2 * count)
    for t in rng.uniform(0.0, 1.0, 30):
        piece = int(rng.integers(pieces(curve)))
        at = point(values, curve, piece, t)
        found = nearest(values, curve, at)
        assert point(values, curve, *found) == pytest.approx(at, abs=1e-12)


def point(values: np.ndarray, curve: Operand, piece: int, t: float) -> tuple[float, float]:
    """By the weights of the poles, as the equations have it."""
    weights = t ** np.arange(4) @ basis_of(curve, piece).T
    x, y = (weights @ values[np.array(poles_of(curve, piece)) + k] for k in (0, 1))
    return float(x), float(y)
