"""Clusters of kept entities with many common eliminated ones, for a preconditioner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.linear.compiled import Reduction

Ints = NDArray[np.int64]


def visibility_clusters(reduction: Reduction, largest: int = 12) -> Ints:
    """Cluster kept entities by the number of shared eliminated ones, largest first.

    Only consecutive entities in the list of an eliminated one are counted, which are far fewer than
    all pairs and give similar clusters. After A. Kushal and S. Agarwal, "Visibility based
    preconditioning for bundle adjustment", CVPR 2012, with single linkage and bounded groups.

    Parameters
    ----------
    reduction : Reduction
    largest : int
        Maximum entities of a group.

    Returns
    -------
    (nk,) int64
        Number of each kept entity's group.
    """
    count = len(reduction.kept)
    kept = reduction.couplings["kept"].astype(np.int64)
    same = reduction.entity_of[1:] == reduction.entity_of[:-1]
    # Kept entities of one eliminated entity ascend.
    keys = np.sort(kept[:-1][same] * max(count, 1) + kept[1:][same])
    change = np.flatnonzero(np.diff(keys, prepend=-1))
    ties = np.diff(np.append(change, len(keys)))
    strongest = change[np.argsort(-ties, kind="stable")]
    leader = list(range(count))
    size = [1] * count

    def find(i: int) -> int:
        while leader[i] != i:
            leader[i] = leader[leader[i]]
            i = leader[i]
        return i

    for key in keys[strongest].tolist():
        a, b = find(key // count), find(key % count)
        if a != b and size[a] + size[b] <= largest:
            leader[b] = a
            size[a] += size[b]
    return np.array([find(i) for i in range(count)], dtype=np.int64)
