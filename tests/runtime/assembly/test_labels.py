"""Components of instances and of values, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.assembly.compiled import connected, labels_of_instances, runs_of_values
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.positions import coordinates

NONE = np.zeros(0, dtype=np.int64)


@pytest.mark.parametrize("by_rows", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_values_and_instances_have_the_component_of_their_blocks(seed: int, by_rows: bool) -> None:
    rng = np.random.default_rng(seed)
    nb = 9
    sizes = rng.integers(1, 4, nb)
    pairs = rng.integers(0, nb, (7, 2))
    pattern = BlockPattern.from_pairs(sizes, pairs[:, 0], pairs[:, 1], by_rows=by_rows)
    idle = np.zeros(nb, dtype=np.uint8)
    idle[rng.integers(nb)] = 1
    count, labels = connected(pattern.column_start, pattern.rows, NONE, NONE, idle)
    runs = runs_of_values(pattern.column_start, pattern.value_start, labels, pattern.value_count)
    assert runs[0, 0] == 0
    assert runs[-1, 1] == pattern.value_count
    assert (runs[1:, 0] == runs[:-1, 1]).all()
    assert (np.diff(runs[:, 2]) != 0).all()
    column = coordinates(pattern)[1]
    block = np.searchsorted(pattern.offsets, column, side="right") - 1
    np.testing.assert_array_equal(np.repeat(runs[:, 2], runs[:, 1] - runs[:, 0]), labels[block])

    used = np.concatenate([pairs, np.full((1, 2), -1)])
    used[2, 1] = -1  # not solved for
    at = np.where(used >= 0, pattern.offsets[used], pattern.size).astype(np.int32)
    component = np.repeat(np.where(idle, -1, labels), sizes).astype(np.int32)
    found = labels_of_instances(at, component, count)
    for blocks, label in zip(used, found, strict=True):
        moving = [int(b) for b in blocks if b >= 0 and not idle[b]]
        assert label == (labels[moving[0]] if moving else count)


def test_instances_that_use_nothing_belong_to_no_component() -> None:
    at = np.empty((3, 0), dtype=np.int32)
    assert labels_of_instances(at, np.zeros(2, dtype=np.int32), 1).tolist() == [1, 1, 1]
