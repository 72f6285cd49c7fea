"""What is not a matrix is refused, with its place."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.orthogonal import RankQR
from tests.runtime.orthogonal.matrices import sparse


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_an_entry_that_is_not_finite_is_reported_by_its_equation(wrong: float) -> None:
    made = sparse(np.array([[1.0, 2], [3, 4], [5, 6]]))
    factor = made.factored()
    entries = made.entries.copy()
    entries[3] = wrong
    with pytest.raises(ValueError, match="equation 1 has an entry that is not finite"):
        factor.factor(entries)
    with pytest.raises(ValueError, match="no factor"):
        _ = factor.rank
    factor.factor(made.entries)
    assert factor.rank == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1, 2, [0], []), "not negative"),
        ((2, 2, [0, 1], [0]), "ascending array of 3 places"),
        ((2, 2, [0, 2, 1], [0, 1]), "ascending array of 3 places"),
        ((1, 2, [0, 2], [0]), "expected 2 indices"),
        ((1, 2, [0, 2], [0, 2]), "expected indices from 0 to 1, found 0 to 2"),
        ((1, 2, [0, 2], [-1, 1]), "found -1 to 1"),
        ((1, 2, [0, 2], [0, 1], [1, 2]), "expected 1 priorities"),
    ],
)
def test_arrays_that_are_no_pattern(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        RankQR(*arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda q: q.factor([1.0]), "expected 2 entries"),
        (lambda q: q.factor([1.0, 1.0], [1.0]), "expected 2 scales"),
        (lambda q: q.factor([1.0, 1.0], [1.0, 0.0]), "the scale of unknown 1 is 0.0"),
        (lambda q: q.least_norm([1.0]), "expected right-hand sides of 2 numbers"),
        (lambda q: q.dependency_of([0], [1.0, 2.0]), "expected 1 values"),
    ],
)
def test_arrays_of_another_length(use: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        use(sparse(np.eye(2)).factored())  # type: ignore[operator]


def test_nothing_is_asked_of_what_has_no_factor() -> None:
    made = sparse(np.eye(2)).analysed()
    with pytest.raises(ValueError, match=r"call factor\(entries\) first"):
        made.null_vectors()
    with pytest.raises(ValueError, match="no factor"):
        made.least_norm([0.0, 0.0])
