"""Clock offsets from rates, against known shifts."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.geometry import clock_offset


def rate(t: np.ndarray) -> np.ndarray:
    return np.sin(1.3 * t) + 0.5 * np.sin(3.7 * t + 1) + 0.2 * np.cos(0.4 * t)


@pytest.mark.parametrize("offset", [-0.83, -0.0421, 0.0, 0.3333, 0.98])
def test_an_offset_is_found_from_noisy_rates_at_other_times(offset: float) -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0, 60, 0.01)
    other = np.sort(rng.uniform(2, 57, 500))
    seen = rate(other + offset) + 0.05 * rng.normal(size=500)
    found = clock_offset(t, rate(t), other, seen, 1.0)
    assert found == pytest.approx(offset, abs=0.005)


def test_what_lies_outside_of_the_first_sensor_is_left_out() -> None:
    t = np.arange(0, 20, 0.01)
    other = np.arange(-4, 18, 0.1)
    assert clock_offset(t, rate(t), other, rate(other + 0.25), 0.5) == pytest.approx(
        0.25, abs=0.003
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 1, 2], [0, 1], [0, 1, 2], [0, 1, 2], 1), "have the shapes (3,) and (2,)"),
        (([0, 2, 1], [0, 1, 2], [0, 1, 2], [0, 1, 2], 1), "do not ascend"),
        (([0, 1, 2], [0, 1, 2], [10, 11, 12], [0, 1, 2], 1), "less than half of its samples"),
        (([0, 1, np.nan], [0, 1, 2], [0, 1, 2], [0, 1, 2], 1), "do not ascend"),
    ],
)
def test_arguments_that_do_not_fit(arguments: tuple, message: str) -> None:
    with pytest.raises(AraelError, match="E1031") as caught:
        clock_offset(*arguments)
    assert message in str(caught.value)
