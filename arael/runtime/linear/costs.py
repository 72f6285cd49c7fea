"""Predicted cost of each linear solver for a pattern.

The times are a model, fitted to measurements on one core with 512-bit vectors. Times differ on
other machines, but their ratios, which determine the choice, vary much less: with the kernels of
smaller instruction sets a wrong choice costs 0.04 ms at most (docs/internals/sparse.md has the
figures).
"""

from __future__ import annotations

import numpy as np

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import Analysis
from arael.runtime.linear.bandwidth import band_flops, half_bandwidth
from arael.runtime.linear.price import SINGLE, Cost, dense_cost

__all__ = ["Cost", "predict"]

# Scalars of the second cache, and nanoseconds of an access that misses it.
_CACHE = 128 * 1024
_PLACE = 2.2

# Half-bandwidth up to which the active columns stay in the second-level cache.
_NARROW = 360


def predict(pattern: BlockPattern, single: bool, analysis: Analysis) -> dict[str, Cost]:
    """Cost of every general solver.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    analysis : Analysis
        Symbolic factor of the pattern in the best ordering.

    Returns
    -------
    dict
        Costs by the solver's name.
    """
    n = pattern.size
    kd = half_bandwidth(pattern)
    banded = (band_flops(n, kd), n * (kd + 1))
    scale = SINGLE if single else 1.0
    lapack = 100.0 + n * (30.0 + 3.0 * kd) + banded[0] / 60.0
    # The index work of CHOLMOD is per scalar.
    scattered = _scattered(pattern, analysis)
    cholmod = 20_000.0 + 150.0 * n + 8.0 * analysis.nnz + analysis.flops / 25.0 + scattered * 1e6
    return {
        "dense": dense_cost(n, single),
        "band": band_cost(pattern, single),
        "sparse": sparse_cost(pattern, single, analysis),
        "lapack_band": Cost(*banded, scale * lapack * 1e-6),
        "cholmod": Cost(analysis.flops, analysis.nnz, cholmod * 1e-6),
    }


def band_cost(pattern: BlockPattern, single: bool) -> Cost:
    """Cost of the band solver; it needs no symbolic factor."""
    n, kd = pattern.size, half_bandwidth(pattern)
    flops = band_flops(n, kd)
    # A wide band leaves the second cache.
    rate = 90.0 if kd <= _NARROW else 65.0
    nanoseconds = 100.0 + n / 6 * (130.0 + 1.5 * kd) + 0.25 * n * kd + flops / rate
    return Cost(flops, n * (kd + 1), (SINGLE if single else 1.0) * nanoseconds * 1e-6)


def sparse_cost(pattern: BlockPattern, single: bool, analysis: Analysis) -> Cost:
    """Cost of the sparse solver with a symbolic factor."""
    milliseconds = 100e-6 + analysis.milliseconds + _scattered(pattern, analysis)
    return Cost(analysis.flops, analysis.nnz, (SINGLE if single else 1.0) * milliseconds)


def _scattered(pattern: BlockPattern, analysis: Analysis) -> float:
    """Milliseconds for update matrices of fronts whose parents exceed the second-level cache.

    Each column of a block that is added to such a parent is a separate cache miss, which the model
    of a front does not include.
    """
    nodes = analysis.supernodes
    width = pattern.sizes[nodes.order].astype(np.float64)
    before = np.concatenate(([0.0], np.cumsum(width)))
    below = np.concatenate(([0.0], np.cumsum(width[nodes.rows])))
    own = np.diff(before[nodes.start])
    rows = np.diff(below[nodes.row_start])
    blocks = np.maximum(np.diff(nodes.row_start), 1)
    child = np.flatnonzero(nodes.parent >= 0)
    parent = nodes.parent[child]
    far = (own[parent] + rows[parent]) ** 2 > _CACHE
    places = rows[child] * blocks[child] / 2
    return float((places * far).sum()) * _PLACE * 1e-6
