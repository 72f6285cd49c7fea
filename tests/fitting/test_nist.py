"""NIST's certified regressions: 27 sets, two starts each, and starts found by the program."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import nist
from benchmarks.certified import by_fit, digits, even, ordered
from tests.public_data import public

# The standard errors of Lanczos1 are the rounding of its data: its cost is 1e-25.
_ERRORS = {"Lanczos1": 2.5}


@pytest.mark.parametrize("start", [0, 1, None], ids=["start 1", "start 2", "found"])
@pytest.mark.parametrize("name", nist.FORMULAS)
def test_eight_certified_digits(name: str, start: int | None) -> None:
    values, cost, data = nist.parsed(public(f"nist/{name}.dat").read_text())
    columns = nist.columns(name, data)
    at = None if start is None else values[:, start]
    found, sigma, converged = by_fit(name, at, columns)
    assert converged
    found = even(name, found)
    order = ordered(name, found, values[:, 2])
    assert digits(found[order], values[:, 2]) >= 8
    assert digits(sigma[order], values[:, 3]) >= _ERRORS.get(name, 8)


def test_digits_are_those_of_the_worst() -> None:
    certified = np.array([2.0, 3.0])
    assert digits(np.array([2.0, 3.003]), certified) == pytest.approx(3)
    assert digits(certified, certified) == 11
    assert digits(np.array([np.nan, 3.0]), certified) == 0


def test_equal_terms_may_come_in_any_order() -> None:
    certified = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    swapped = np.array([5.0, 6.0, 1.0, 2.0, 3.0, 4.0])
    np.testing.assert_array_equal(swapped[ordered("Lanczos1", swapped, certified)], certified)
