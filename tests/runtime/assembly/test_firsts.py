"""First writers overwrite: the result equals zeroing all blocks and adding."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import arael
from arael.runtime.assembly import firsts, shares
from arael.runtime.assembly.firsts import Firsts, plan_firsts
from arael.runtime.assembly.positions import dense_matrix
from arael.runtime.problem import Problem
from arael.scenes import SceneConfig, columns, fill, make_scene
from arael.solving import problem_of

LANES = 4
SIZE = 6  # of a block, in scalars
NOWHERE = 0


@dataclass
class Use:
    entity: int


@dataclass
class Entity:
    tangent: int


@dataclass
class Group:
    uses: list[Use]


ENTITIES = [Entity(2), Entity(3)]
PAIR = 1  # of uses 1 and 0


def lanes_of(array: np.ndarray) -> np.ndarray:
    """(n, 3) of pairs in lane order, the last instance repeated."""
    blocks = -(-len(array) // LANES)
    padded = np.concatenate((array, np.repeat(array[-1:], blocks * LANES - len(array), axis=0)))
    return padded.reshape(blocks, LANES, -1).transpose(0, 2, 1).copy()


def plan(
    places: list[list[int]], extent: int, parts: int = 1, may: list[bool] | None = None
) -> tuple:
    """Groups whose instances write to these blocks, 0 for nowhere."""
    placed = []
    for of_group in places:
        at = np.zeros((len(of_group), 3), dtype=np.int64)
        at[:, PAIR] = SIZE * np.array(of_group)
        placed.append([lanes_of(at), lanes_of(np.zeros((len(of_group), 3), dtype=np.uint8))])
    groups = [Group([Use(0), Use(1)]) for _ in places]
    found = plan_firsts(
        groups,  # type: ignore[arg-type]
        ENTITIES,  # type: ignore[arg-type]
        placed,
        [len(p) for p in places],
        range(len(places)),
        may or [True] * len(places),
        np.array([NOWHERE]),
        extent,
        parts,
    )
    return found, placed


def played(found: Firsts, placed: list, counts: list[int], extent: int) -> np.ndarray:
    """What the blocks come to if every instance adds, or stores, its number to each scalar."""
    values = np.full(extent, np.nan)
    for begin, end in found.cleared:
        values[begin:end] = 0
    number = 0
    for (block_at, _), first, count in zip(placed, found.first, counts, strict=True):
        for block in range(len(block_at)):
            for lane in range(min(LANES, count - block * LANES)):
                number += 1
                at = slice(block_at[block, PAIR, lane], block_at[block, PAIR, lane] + SIZE)
                values[at] = number if first[block, PAIR] else values[at] + number
    return values


@given(
    st.lists(st.lists(st.integers(0, 12), min_size=1, max_size=30), min_size=1, max_size=3),
    st.integers(1, 4),
    st.sampled_from([0, 7, 1000]),
)
def test_as_if_all_had_been_emptied(places: list[list[int]], parts: int, near: int) -> None:
    before, firsts._NEAR = firsts._NEAR, near
    try:
        extent = SIZE * 13 + 5
        found, placed = plan(places, extent, parts)
    finally:
        firsts._NEAR = before
    expected = np.zeros(extent)
    for number, block in enumerate((b for p in places for b in p), start=1):
        expected[SIZE * block : SIZE * (block + 1)] += number
    values = played(found, placed, [len(p) for p in places], extent)
    np.testing.assert_array_equal(values[SIZE:], expected[SIZE:])
    # The parts are the whole, one after the other.
    assert found.ends[0] == 0
    assert found.ends[-1] == len(found.cleared)
    assert len(found.ends) == parts + 1
    assert (np.diff(found.ends) >= 0).all()
    assert (found.cleared[1:, 0] >= found.cleared[:-1, 1]).all()


def test_blocks_of_one_instance_are_stored_and_not_emptied() -> None:
    found, _ = plan([list(range(1, 101))], SIZE * 101)
    assert found.first[0][:, PAIR].all()
    assert found.cleared.tolist() == [[0, SIZE]]


def test_a_block_of_two_instances_of_the_same_lanes_is_emptied() -> None:
    found, _ = plan([[1, 2, 2, 3, *range(4, 100)]], SIZE * 101)
    assert found.first[0][:, PAIR].tolist() == [0] + [1] * 24


def test_who_may_not_store_adds() -> None:
    found, _ = plan([[1, 2, 3, 4], [1, 2, 3, 4]], SIZE * 5, may=[False, True])
    assert not any(first.any() for first in found.first)
    assert found.cleared.tolist() == [[0, SIZE * 5]]


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("fine", [False, True])
def test_bearings_store_their_blocks(
    precision: str, fine: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if fine:
        monkeypatch.setattr(shares, "GRAIN", 1.0)
        monkeypatch.setattr(shares, "_ROOM", 100.0)
    model_class = arael.load("slam", precision=precision)
    model = model_class()
    fill(model, model_class.layout, columns(make_scene(SceneConfig(poses=30))))
    problem: Problem = problem_of(model)
    evaluation = problem.evaluation
    assert (evaluation.shares > 1) == fine
    (plan,) = problem.structure.plan.shares
    number = [g.label for g in problem.layout.groups].index("PointFrine.bearing")
    # Where shares end, blocks of lanes are of two poses.
    assert plan.placed[number].first[:, PAIR].mean() > (0.1 if fine else 0.7)
    emptied = (plan.cleared[:, 1] - plan.cleared[:, 0]).sum()
    assert emptied < (0.95 if fine else 0.7) * plan.value_extent
    found = []
    for threads in (1, 2, 3):
        evaluation.threads = threads
        extent = evaluation.workspace()
        for array in extent:
            array[:] = np.nan
        found.append(evaluation.linearised(extent))
    expected = Problem(problem.layout, problem.store).evaluation.linearised()
    tolerance = 1e-12 if precision == "f64" else 1e-4
    pattern = problem.structure.pattern
    matrix = dense_matrix(pattern, expected[2])
    for _, gradient, values in found:
        np.testing.assert_array_equal(gradient, found[0][1])
        np.testing.assert_array_equal(values, found[0][2])
        assert abs(gradient - expected[1]).max() < tolerance * abs(expected[1]).max()
        assert abs(dense_matrix(pattern, values) - matrix).max() < tolerance * abs(matrix).max()
