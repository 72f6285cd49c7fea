"""The start from a spanning tree: each pose composed along the least uncertain path."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from arael.starts.graph import PoseGraph, Poses

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Least information of a rotation [1/rad^2]: keeps variances, and sums of them, finite.
_LEAST = 1e-100


def tree_poses(graph: PoseGraph) -> Poses:
    """Poses composed along a spanning tree of each component.

    The tree of shortest paths by accumulated variance of rotation (Dijkstra): an error of rotation
    displaces all later poses, so it dominates the error at the end of a path. Roots are the fixed
    poses; in a component without one, the first anchored pose, at its measured value; otherwise the
    first pose, at its current value.
    """
    roots, at = _roots(graph)
    parent, edge = _spanning_tree(graph, roots, _variance(graph))
    along = np.flatnonzero(edge >= 0)
    used = edge[along]
    forward = graph.b[used] == along
    steps = Poses.identity(len(graph.poses), graph.dimension)
    for chosen, values in (
        (forward, graph.measured[used[forward]]),
        (~forward, graph.measured[used[~forward]].inverse()),
    ):
        steps.rotation[along[chosen]] = values.rotation
        steps.position[along[chosen]] = values.position
    steps.rotation[roots] = at.rotation
    steps.position[roots] = at.position
    return _composed(steps, parent)


def _roots(graph: PoseGraph) -> tuple[Ints, Poses]:
    """Rows of the roots of the trees, and their poses."""
    fixed = np.flatnonzero(graph.fixed_position & graph.fixed_rotation)
    first = graph.without(fixed)
    rows = np.concatenate((fixed, first))
    at = graph.poses[rows]
    row_of = {int(graph.component[row]): i + len(fixed) for i, row in enumerate(first)}
    anchors = graph.anchors
    turned = np.flatnonzero(anchors.rotation_weight > 0).tolist()  # a position alone is no pose
    for i, row in zip(turned, anchors.pose[turned].tolist(), strict=True):
        place = row_of.pop(int(graph.component[row]), None)
        if place is not None:
            rows[place] = row
            at.rotation[place] = anchors.measured.rotation[i]
            at.position[place] = anchors.measured.position[i]
    return rows, at


def _variance(graph: PoseGraph) -> Array:
    """(m,) variance of rotation of each edge, the trace of its covariance [rad^2]."""
    information = graph.rotation_information
    known: Bools = np.asarray(np.isfinite(information).all(axis=(1, 2)))
    # What has overflowed counts as none.
    values = np.linalg.eigvalsh(np.where(known[:, None, None], information, 0.0))
    found: Array = (1 / np.maximum(values, _LEAST)).sum(axis=1)
    return found


def _spanning_tree(graph: PoseGraph, roots: Ints, weight: Array) -> tuple[Ints, Ints]:
    """Parent of each pose (itself for roots) and the edge that leads to it, -1 for roots."""
    count = len(graph.poses)
    ways: list[list[tuple[int, int, float]]] = [[] for _ in range(count)]
    edges = zip(graph.a.tolist(), graph.b.tolist(), weight.tolist(), strict=True)
    for i, (a, b, w) in enumerate(edges):
        ways[a].append((b, i, w))
        ways[b].append((a, i, w))
    parent, edge = list(range(count)), [-1] * count
    best = [np.inf] * count
    done = [False] * count
    heap = [(0.0, root) for root in roots.tolist()]  # ascending: a heap
    for root in roots.tolist():
        best[root] = 0.0
    while heap:
        far, row = heapq.heappop(heap)
        if done[row]:
            continue
        done[row] = True
        for other, i, w in ways[row]:
            key = far + w
            if key < best[other]:
                best[other] = key
                parent[other], edge[other] = row, i
                heapq.heappush(heap, (key, other))
    return np.array(parent, np.int64), np.array(edge, np.int64)


def _composed(steps: Poses, parent: Ints) -> Poses:
    """Pose of each row from the step that leads to it from its parent.

    Each round doubles the number of steps that are composed (pointer doubling), so that a chain of
    4000 poses takes 12 rounds of array operations.
    """
    rotation, position = steps.rotation.copy(), steps.position.copy()
    while True:
        rows = np.flatnonzero(parent != np.arange(len(parent)))
        rows = rows[parent[rows] != parent[parent[rows]]]
        if not len(rows):
            break
        found = Poses(rotation, position)
        composed = found[parent[rows]] @ found[rows]
        rotation[rows], position[rows] = composed.rotation, composed.position
        parent = parent[parent]
    rows = np.flatnonzero(parent != np.arange(len(parent)))
    found = Poses(rotation, position)
    last = found[parent[rows]] @ found[rows]
    rotation[rows], position[rows] = last.rotation, last.position
    return found
