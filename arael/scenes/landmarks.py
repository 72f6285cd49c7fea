"""Landmarks of the synthetic scenes, and the poses from which each is visible."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arael.scenes.config import SceneConfig
from arael.scenes.trajectory import SPACING

Array = NDArray[np.float64]
Index = NDArray[np.int64]

NEAR, FAR = 5.0, 30.0
"""Distance of a landmark from its closest pose [m]."""
HEIGHT = 2.0
"""Landmarks are between the ground and this height [m]."""
REACH = 15
"""A landmark is visible from this many poses before and after its anchor."""
WIDE_SHARE = 0.15
WIDEST = 150


def place_landmarks(poses: Array, count: int, rng: Generator) -> tuple[Array, Index]:
    """Positions (count, 3) of landmarks around `poses` (n, 3), and each one's anchor pose (count,).

    Around a random anchor at a random bearing and distance; kept where the closest pose is between
    `NEAR` and `FAR`.
    """
    tree = cKDTree(poses[:, :2])
    kept: list[Array] = []
    anchors: list[Index] = []
    missing = count
    while missing > 0:
        anchor = rng.integers(0, len(poses), size=missing)
        angle = rng.uniform(0, 2 * np.pi, size=missing)
        distance = rng.uniform(NEAR, FAR, size=missing)
        z = rng.uniform(0, HEIGHT, size=missing)
        offset = distance[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        place = np.column_stack([poses[anchor, :2] + offset, z])
        closest = closest_distance(tree, place)
        good = (closest >= NEAR) & (closest <= FAR)
        kept.append(place[good])
        anchors.append(anchor[good])
        missing -= int(good.sum())
    return np.concatenate(kept), np.concatenate(anchors)


def closest_distance(tree: cKDTree, landmarks: Array) -> Array:
    """Distance (m,) in the plane from each of `landmarks` (m, 3) to the closest pose of `tree`."""
    distance: Array = tree.query(landmarks[:, :2])[0]
    return distance


def visibility_ranges(config: SceneConfig, count: int, rng: Generator) -> Index:
    """Number of poses before and after its anchor from which each landmark is visible."""
    low = max(REACH, min(config.poses / 4, WIDEST) / 2)
    high = max(REACH, min(config.poses / 2, WIDEST) / 2)
    wide = rng.random(count) < WIDE_SHARE
    reach = np.where(wide, rng.uniform(low, high, size=count), REACH)
    return reach.astype(np.int64)


def visible_pairs(
    config: SceneConfig, poses: Array, anchors: Index, reach: Index
) -> tuple[Index, Index]:
    """Landmark and pose (k,) of every pair within range of each other, sorted by both.

    Range is counted in poses along the path: cyclic on ``loop``; on ``eight``, which crosses
    itself, as the corresponding distance.
    """
    if config.trajectory == "eight":
        return _pairs_by_distance(poses, anchors, reach)
    return _pairs_by_index(len(poses), anchors, reach, wrap=config.trajectory == "loop")


def _pairs_by_index(count: int, anchors: Index, reach: Index, wrap: bool) -> tuple[Index, Index]:
    if wrap:  # no pose twice, for any range
        first = anchors - np.minimum(reach, (count - 1) // 2)
        last = anchors + np.minimum(reach, count // 2)
    else:
        first = np.maximum(anchors - reach, 0)
        last = np.minimum(anchors + reach, count - 1)
    sizes = last - first + 1
    landmark = np.repeat(np.arange(len(anchors)), sizes)
    ends = np.cumsum(sizes)
    pose = np.arange(ends[-1]) - np.repeat(ends - sizes - first, sizes)
    if not wrap:
        return landmark, pose
    pose %= count
    order = np.lexsort((pose, landmark))
    return landmark[order], pose[order]


def _pairs_by_distance(poses: Array, anchors: Index, reach: Index) -> tuple[Index, Index]:
    tree = cKDTree(poses[:, :2])
    near = tree.query_ball_point(poses[anchors, :2], reach * SPACING, return_sorted=True)
    sizes = np.fromiter(map(len, near), dtype=np.int64, count=len(near))
    landmark = np.repeat(np.arange(len(anchors)), sizes)
    return landmark, np.concatenate(near).astype(np.int64)
