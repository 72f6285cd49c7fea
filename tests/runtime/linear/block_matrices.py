"""Block patterns and positive definite values on them, for the tests of the linear solvers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern

Pairs = Sequence[tuple[int, int]]


def build(sizes: Sequence[int], pairs: Pairs) -> BlockPattern:
    """Pattern of blocks of `sizes` coupled in `pairs`; scalars are named ``block.component``."""
    names = [f"e[{i}].{k}" for i, size in enumerate(sizes) for k in range(size)]
    couples = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return BlockPattern.from_pairs(
        np.array(sizes, dtype=np.int64), couples[:, 0], couples[:, 1], names.__getitem__
    )


def chain(count: int, size: int) -> BlockPattern:
    """Odometry: each entity coupled with the next."""
    return build([size] * count, [(i, i + 1) for i in range(count - 1)])


def arrow(count: int, size: int) -> BlockPattern:
    """Everything coupled with the first entity, the worst case of the natural order."""
    return build([size] * count, [(0, i) for i in range(1, count)])


def grid(width: int, height: int, size: int) -> BlockPattern:
    """Pose graph on a grid with loop closures between neighbouring rows."""
    pairs = [(i, i + 1) for i in range(width * height - 1)]
    pairs += [(i, i + width) for i in range(width * (height - 1))]
    return build([size] * (width * height), pairs)


def slam(poses: int, landmarks: int, seed: int = 0) -> BlockPattern:
    """Poses of 6 in a chain, landmarks of 3 seen from a handful of them."""
    rng = np.random.default_rng(seed)
    pairs = [(i, i + 1) for i in range(poses - 1)]
    for landmark in range(landmarks):
        first = int(rng.integers(0, max(poses - 5, 1)))
        pairs += [(poses + landmark, min(first + k, poses - 1)) for k in range(5)]
    return build([6] * poses + [3] * landmarks, pairs)


def positive(
    pattern: BlockPattern, seed: int, dtype: type = np.float64
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Random values, and a diagonal that dominates them."""
    rng = np.random.default_rng(seed)
    values = rng.standard_normal(pattern.value_count).astype(dtype)
    full = np.abs(dense(pattern, values, np.zeros(pattern.size)))
    diagonal = full.sum(axis=1) + rng.uniform(0.5, 1.5, pattern.size)
    # What no solver may read: the diagonal itself and what lies above it.
    for block, size in enumerate(pattern.sizes):
        start = pattern.value_start[pattern.column_start[block]]
        square = values[start : start + size * size].reshape(size, size)
        square[np.triu_indices(size)] = np.nan
    return values, diagonal.astype(dtype)


def dense(
    pattern: BlockPattern, values: NDArray[np.floating], diagonal: NDArray[np.floating]
) -> NDArray[np.float64]:
    """The whole symmetric matrix, written out by the definition of the pattern."""
    matrix = np.zeros((pattern.size, pattern.size))
    offsets = pattern.offsets
    for j in range(pattern.block_count):
        for block in range(pattern.column_start[j], pattern.column_start[j + 1]):
            i = pattern.rows[block]
            shape = (pattern.sizes[i], pattern.sizes[j])
            start = pattern.value_start[block]
            part = values[start : start + shape[0] * shape[1]].reshape(shape).astype(float)
            if i == j:
                part = np.tril(part, -1)
            matrix[offsets[i] : offsets[i + 1], offsets[j] : offsets[j + 1]] = part
    lower = np.tril(matrix, -1)
    return lower + lower.T + np.diag(diagonal.astype(float))


def bundle(cameras: int, points: int, size: int = 9, first: bool = False) -> BlockPattern:
    """Cameras and points of 3 seen by two to five of them; `first`: points before cameras."""
    rng = np.random.default_rng(cameras)
    at_camera, at_point = (points, 0) if first else (0, cameras)
    pairs = []
    for point in range(points):
        start = int(rng.integers(0, cameras))
        seen = (start + rng.permutation(min(cameras, 7))[: rng.integers(2, 6)]) % cameras
        pairs += [(at_camera + int(camera), at_point + point) for camera in seen]
    sizes = [3] * points + [size] * cameras if first else [size] * cameras + [3] * points
    return build(sizes, pairs)


def branches(count: int, length: int, size: int) -> BlockPattern:
    """Trajectories of many robots that start from one place."""
    pairs = []
    for branch in range(count):
        begin = 1 + branch * length
        pairs += [(0, begin)] + [(begin + i, begin + i + 1) for i in range(length - 1)]
    return build([size] * (1 + count * length), pairs)
