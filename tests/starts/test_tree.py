"""The spanning tree: least variance along each path, composed exactly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from arael.starts.graph import Anchors, PoseGraph, Poses
from arael.starts.tree import tree_poses
from tests.starts import scenes


def graph_of(truth: Poses, ends: np.ndarray, edges: Poses, rotation_weight: np.ndarray):
    d = truth.dimension
    k = 3 if d == 2 else 6
    information = np.tile(np.eye(k), (len(ends), 1, 1))
    information[:, d:, d:] *= rotation_weight[:, None, None]
    none = np.zeros(len(truth), np.bool_)
    start = Poses(truth.rotation.copy(), truth.position.copy())
    return PoseGraph(start, ends[:, 0], ends[:, 1], edges, information, none, none, Anchors.none(d))


@pytest.mark.parametrize("truth", [scenes.sphere(4, 6), scenes.grid(4, 6)], ids=["3d", "2d"])
def test_without_noise_the_tree_is_the_truth(truth: Poses) -> None:
    rng = np.random.default_rng(1)
    ends = scenes.neighbours(4, 6, False)
    ends[::3] = ends[::3, ::-1]  # against the direction
    edges = scenes.measured(rng, truth, ends, 0.0, 0.0)
    graph = graph_of(truth, ends, edges, rng.uniform(1, 9, len(ends)))
    graph.poses.position[1:] = 0
    graph.poses.rotation[1:] = np.eye(truth.dimension)
    found = tree_poses(graph)
    assert abs(found.position - truth.position).max() < 1e-12
    assert abs(found.rotation - truth.rotation).max() < 1e-13


def test_each_pose_is_reached_along_the_least_sum_of_variances() -> None:
    """Against SciPy: only edges on shortest paths carry a translation that adds up."""
    rng = np.random.default_rng(2)
    n, m = 40, 120
    ends = np.concatenate([np.column_stack([np.arange(n - 1), np.arange(1, n)]),
                           rng.integers(0, n, (m, 2))])  # fmt: skip
    ends = ends[ends[:, 0] != ends[:, 1]]
    weight = rng.uniform(1, 50, len(ends))
    edges = Poses.identity(len(ends), 2)
    truth = Poses.identity(n, 2)
    least = np.full((n, n), np.inf)
    np.minimum.at(least, (ends[:, 0], ends[:, 1]), 1 / weight)
    least = np.minimum(least, least.T)
    rows, columns = np.nonzero(np.isfinite(least))
    far = dijkstra(coo_array((least[rows, columns], (rows, columns)), (n, n)), indices=0)
    # An edge off the shortest paths is overwritten: a tree that took one would be far off.
    step = far[ends[:, 1]] - far[ends[:, 0]]
    tight = np.isclose(abs(step), 1 / weight, rtol=1e-12)
    edges.position[:, 0] = np.where(tight, step, 1000.0)
    found = tree_poses(graph_of(truth, ends, edges, weight))
    assert np.allclose(found.position[:, 0], far, rtol=1e-9)


def test_a_long_chain_is_composed_as_one_after_the_other() -> None:
    rng = np.random.default_rng(3)
    n = 300
    truth = Poses.identity(n, 3)
    ends = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    edges = scenes.measured(rng, truth, ends, 0.3, 1.0)
    found = tree_poses(graph_of(truth, ends, edges, np.ones(n - 1)))
    expected = scenes.odometry(truth, edges)
    assert abs(found.position - expected.position).max() < 1e-11
    assert abs(found.rotation - expected.rotation).max() < 1e-12


def test_trees_start_at_fixed_poses_then_anchors_then_first_poses() -> None:
    ends = np.array([[0, 1], [2, 3], [5, 4]])
    truth = Poses.identity(6, 2)
    edges = Poses.identity(3, 2)
    edges.position[:] = [1, 0]
    graph = graph_of(truth, ends, edges, np.ones(3))
    graph.poses.position[:, 1] = 7
    fixed = np.array([False, True, False, False, False, False])
    at = Poses.identity(1, 2)
    at.position[:] = [50, 5]
    anchors = Anchors(np.array([3]), at, np.ones(1), np.ones(1))
    graph = replace(graph, fixed_position=fixed, fixed_rotation=fixed, anchors=anchors)
    expected = [[-1, 7], [0, 7], [49, 5], [50, 5], [0, 7], [-1, 7]]
    assert np.allclose(tree_poses(graph).position, expected)
