"""The last digits of a fit are those of the data, not of the way to them."""

from __future__ import annotations

import numpy as np

import arael

_TRUTH = {"a1": 0.2, "b1": 1.0, "a2": 0.7, "b2": 2.5, "a3": 1.5, "b3": 6.0}
_FORMULA = "y = a1 * exp(-b1 * x) + a2 * exp(-b2 * x) + a3 * exp(-b3 * x)"


def test_rounding_of_the_cost_does_not_end_the_steps() -> None:
    # Residuals of 1e-5 beside values of 2.4: the cost is uncertain by some 1e-12 of itself.
    x = np.linspace(0.0, 1.2, 25)
    y = sum(_TRUTH[f"a{k}"] * np.exp(-_TRUTH[f"b{k}"] * x) for k in (1, 2, 3))
    data = {"x": x, "y": np.round(y, 5)}
    draw = np.random.default_rng(1)
    ends = []
    for _ in range(30):
        near = draw.uniform(0.97, 1.03, len(_TRUTH))
        start = dict(zip(_TRUTH, near * list(_TRUTH.values()), strict=True))
        ends.append(list(arael.fit(_FORMULA, data, start=start).parameters.values()))
    np.testing.assert_allclose(ends, np.tile(np.median(ends, axis=0), (30, 1)), rtol=1e-9)
