"""The recipes beside SciPy minimise the same cost from the same start."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from benchmarks import recipes


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    "make",
    [recipes.calibration, recipes.hand_eye, recipes.alignment, recipes.epochs],
    ids=lambda make: make.__name__,
)
def test_both_sides_have_the_same_cost(make: object) -> None:
    one = make(np.random.default_rng(1))  # type: ignore[operator]
    model = one.fill(arael.loads(one.model, interpret=True))
    start = one.residuals(one.start)
    assert model.cost() == pytest.approx(start @ start, rel=1e-9)
    if one.sparsity is not None:
        assert one.sparsity.shape == (len(start), len(one.start))
