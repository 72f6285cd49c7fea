"""NIST's certified regressions: 27 sets, two starts each, and starts found by the program."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import nist
from benchmarks.certified import by_fit, digits, even, ordered
from tests.public_data import held, public

# The standard errors of Lanczos1 are the rounding of its data: its cost is 1e-25.
_ERRORS = {"Lanczos1": 2.5}

SETS = held(nist.FORMULAS, "nist/{}.dat")
QUICK = ("BoxBOD", "DanWood", "Eckerle4", "MGH10", "MGH17", "Misra1a", "Misra1b", "Roszman1")
"""Sets whose starts are searched in the default suite; others take up to two seconds."""


@pytest.mark.parametrize("start", [0, 1], ids=["start 1", "start 2"])
@pytest.mark.parametrize("name", SETS)
def test_eight_certified_digits(name: str, start: int) -> None:
    check(name, start)


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in SETS],
)
def test_eight_certified_digits_from_starts_found(name: str) -> None:
    check(name, None)


def check(name: str, start: int | None) -> None:
    """Compare a fit with what is certified."""
    values, _, data = nist.parsed(public(f"nist/{name}.dat").read_text())
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
