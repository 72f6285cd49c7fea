"""A few thousand of the random commands that `many` runs any number of."""

from __future__ import annotations

import pytest

from tests.sketch.properties.many import Tally, life


@pytest.mark.sweep(4)
@pytest.mark.parametrize("seed", range(4))
def test_random_commands_are_undone_and_redone_bit_by_bit(seed: int) -> None:
    tally = Tally()
    life(seed, 120, tally)
    assert tally.faults == []
    assert tally.done > 60


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(1000, 1010), 1028])
def test_many_random_commands_are_undone_and_redone_bit_by_bit(seed: int) -> None:
    tally = Tally()
    life(seed, 150, tally)
    assert tally.faults == []
