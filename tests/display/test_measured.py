"""Values with standard deviations: digits follow the uncertainty."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arael.display.measured import measured, rounded


@pytest.mark.parametrize(
    ("value", "sigma", "texts"),
    [
        (1700011.29991, 0.002253, ("1700011.2999", "0.0023")),
        (2.0, 0.7071, ("2.00", "0.71")),
        (9.996, 0.0996, ("10.00", "0.10")),
        (12345.6, 231.0, ("12350", "230")),
        (99.99, 12.0, ("100", "12")),
        # above its value
        (0.04, 0.146, ("0.04", "0.15")),
        (1.234, 45.0, ("1", "45")),
        (-399.3456, 8.07e10, ("-400", "8.1e+10")),
        (0.0, 0.15, ("0.00", "0.15")),
        (-0.0, 230.0, ("0", "230")),
        # large and small
        (3.2e8, 1.2e6, ("3.200e+08", "1.2e+06")),
        (1.23456789e-8, 4.5e-10, ("1.235e-08", "4.5e-10")),
        (1700011.3, 1e-12, ("1700011.30000000", "1.0e-12")),
        # without a standard deviation
        (1 / 3, 0.0, ("0.333333", "0")),
        (1 / 3, math.inf, ("0.333333", "inf")),
        (1 / 3, math.nan, ("0.333333", "nan")),
        (1 / 3, None, ("0.333333", "")),
        (math.nan, 0.1, ("nan", "0.10")),
        (math.inf, 0.1, ("inf", "0.10")),
        (None, 0.123, ("", "0.12")),
        (None, None, ("", "")),
    ],
)
def test_texts(value: float | None, sigma: float | None, texts: tuple[str, str]) -> None:
    assert measured(value, sigma) == texts


def test_digits_of_a_value_without_a_standard_deviation() -> None:
    assert measured(1 / 3, None, digits=8) == ("0.33333333", "")
    assert rounded(1 / 3, math.inf, digits=3) == "0.333"


@given(st.floats(-1e250, 1e250), st.floats(1e-250, 1e250))
def test_texts_are_rounded_to_the_standard_deviation(value: float, sigma: float) -> None:
    number, spread = measured(value, sigma)
    assert float(spread) == pytest.approx(sigma, rel=0.051)
    last = 10.0 ** (math.floor(math.log10(float(spread))) - 1)
    error = abs(float(number) - value)
    assert error <= max(0.51 * last, 1e-14 * abs(value))
    if value and abs(value) < sigma / 100:
        assert error <= 0.051 * abs(value)
