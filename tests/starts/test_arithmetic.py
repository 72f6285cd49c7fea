"""The compiled loops over edges and poses, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.store import rotations
from arael.starts import arithmetic
from arael.starts.chordal import _projected
from arael.starts.graph import Anchors, PoseGraph, Poses


def turned(count: int, seed: int = 0) -> np.ndarray:
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return rotations.matrix_from_quaternion(q / np.linalg.norm(q, axis=1, keepdims=True))


@pytest.mark.parametrize("size", [3, 6])
def test_information_and_whether_it_couples(size: int) -> None:
    u = np.triu(np.random.default_rng(1).normal(size=(5, size, size)))
    found, coupled = arithmetic.information_of(u)
    assert np.allclose(found, u.transpose(0, 2, 1) @ u)
    assert coupled
    d = size // 2 if size == 6 else 2
    u[:, :d, d:] = 0
    assert not arithmetic.information_of(u)[1]


@pytest.mark.parametrize("size", [3, 6])
def test_marginal_information_is_the_inverse_of_the_covariance_of_rotations(size: int) -> None:
    u = np.triu(np.random.default_rng(2).normal(size=(5, size, size))) + 2 * np.eye(size)
    information, d = u.transpose(0, 2, 1) @ u, 2 if size == 3 else 3
    found, left = arithmetic.marginal_of(information)
    assert left is None
    assert np.allclose(found, np.linalg.inv(np.linalg.inv(information)[:, d:, d:]))


def test_positions_that_are_not_measured_leave_the_rotations_their_information() -> None:
    """One edge measures no position along one axis, the other all of them."""
    information = np.stack([np.diag([0.0, 4, 9, 1, 2, 3]), np.eye(6) + 0.1])
    left = arithmetic.marginal_of(information)[1]
    assert left is not None
    assert left.tolist() == [True, False]
    poses = Poses.identity(2, 3)
    none, ends = (
        np.zeros(2, np.bool_),
        np.array([0, 0]),
    )
    graph = PoseGraph(
        poses, ends[0], ends[0] + 1, poses, information, none, none, Anchors.none(3), True
    )
    found = graph.rotation_information
    assert np.allclose(found[0], np.diag([1.0, 2, 3]))
    assert np.allclose(found[1], np.linalg.inv(np.linalg.inv(information[1])[3:, 3:]))


def test_edges_without_an_end_are_seen() -> None:
    a, b = np.array([0, 1, 2]), np.array([3, 0, 1])
    assert arithmetic.all_there(a, b)
    assert not arithmetic.all_there(a, np.array([3, -1, 1]))
    assert not arithmetic.all_there(np.array([0, 1, -1]), b)
    assert arithmetic.all_there(a[:0], b[:0])


def test_rotations_as_quaternions_and_back() -> None:
    r = turned(50)
    r[:3] = np.eye(3), np.diag([1.0, -1, -1]), np.diag([-1.0, -1, 1])
    q = arithmetic.quaternions(r)
    assert (q[:, 0] >= 0).all()
    assert np.allclose(q, rotations.quaternion_from_matrix(r))
    assert np.allclose(arithmetic.matrices(q), r)
    angle = np.random.default_rng(0).uniform(-3, 3, (9, 2))[:, 0]
    assert np.allclose(arithmetic.angles(arithmetic.planar(angle)), angle)


def test_relaxed_matrices_are_projected_as_by_svd() -> None:
    """Nearly rotations, any matrices, reflections, singular ones, and none at all."""
    rng = np.random.default_rng(3)
    x = np.concatenate(
        [turned(20) + 0.1 * rng.normal(size=(20, 3, 3)), rng.normal(size=(40, 3, 3))]
    )
    x[5:8] *= [[[1e-8]], [[1e8]], [[-1]]]
    x[8, 2] = x[8, 1]
    found = _projected(x)
    u, _, vt = np.linalg.svd(x)
    sign = np.ones((60, 3))
    sign[:, 2] = np.sign(np.linalg.det(u @ vt))
    expected = ((u * sign[:, None, :]) @ vt).transpose(0, 2, 1)
    assert (np.linalg.det(x) < 0).sum() > 5
    assert np.allclose(np.linalg.det(found), 1)
    apart = np.arange(60) != 8  # of a singular one the nearest rotation is not unique
    assert np.allclose(found[apart], expected[apart], atol=1e-9)
    assert np.allclose(_projected(np.zeros((1, 2, 1))), np.eye(2))


def test_weights_below_the_limit_are_reported() -> None:
    information = np.stack(
        [np.eye(3), np.diag([1.0, 1, 9]), turned(1)[0] @ np.diag([1.0, 2, 2.9]) @ turned(1)[0].T]
    )
    weight, below = arithmetic.spatial_weights(information, 1e-3)
    trace = np.trace(information, axis1=1, axis2=2)[:, None, None]
    assert np.allclose(weight, 0.5 * trace * np.eye(3) - information)
    assert below is not None
    assert below.tolist() == [False, True, False]
    assert arithmetic.spatial_weights(information[:1], 1e-3)[1] is None


def test_edges_that_the_pattern_lacks_are_refused() -> None:
    pattern = BlockPattern.from_pairs(np.full(3, 2), np.array([0]), np.array([1]))
    ends = np.array([0, 1, 2]), np.array([1, 0, 2])
    places = arithmetic.places_of(pattern, np.arange(3), *ends)
    assert places.tolist() == [pattern.value_start[1]] * 2 + [-1]
    assert arithmetic.places_of(pattern, np.array([0, 1, -1]), np.array([1]), np.array([2])) == [-1]
    with pytest.raises(LookupError):
        arithmetic.places_of(pattern, np.arange(3), np.array([1]), np.array([2]))


def test_held_poses_are_fixed_ones_and_the_first_of_what_nothing_holds() -> None:
    component = np.array([0, 0, 2, 2, 4, 4, 6])
    fixed = np.array([False, True, False, False, False, False, False])
    poses, weight = np.array([3, 5]), np.array([2.0, 0.0])
    found = arithmetic.held_of(component, fixed, poses, weight)
    # Of the first component its second pose, of the second none, for it is anchored; an anchor
    # without weight holds nothing.
    assert found.tolist() == [False, True, False, False, True, False, True]
    with pytest.raises(IndexError, match="pose 7 of 7"):
        arithmetic.held_of(component, fixed, np.array([7]), np.array([1.0]))


def test_poses_of_a_solution_keep_the_values_of_poses_without_a_block() -> None:
    rng = np.random.default_rng(5)
    at = rng.normal(size=(4, 3, 2))
    solution = np.asfortranarray(rng.normal(size=(9, 2)))
    block_of = np.array([2, -1, 0, 1])
    found, sound = arithmetic.poses_of(solution, block_of, at)
    assert sound
    np.testing.assert_array_equal(found[1], at[1])
    np.testing.assert_array_equal(found[[2, 3, 0]], solution.reshape(3, 3, 2))
    solution[4, 1] = np.nan
    assert not arithmetic.poses_of(solution, block_of, at)[1]
