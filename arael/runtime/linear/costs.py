"""Predicted cost of each linear solver for a pattern.

The times are a model, fitted to measurements on one core with 512-bit vectors. Times differ on
other machines, but their ratios, which determine the choice, vary much less: with the kernels of
smaller instruction sets a wrong choice costs 0.04 ms at most (docs/internals/sparse.md has the
figures).
"""

from __future__ import annotations

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import Analysis
from arael.runtime.linear.bandwidth import band_flops, half_bandwidth
from arael.runtime.linear.price import SINGLE, Cost, dense_cost

__all__ = ["Cost", "predict"]

# Nanoseconds of an access that misses the second cache.
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
    scattered = _scattered(analysis)
    cholmod = 20_000.0 + 150.0 * n + 8.0 * analysis.nnz + analysis.flops / 25.0 + scattered * 1e6
    return {
        "dense": dense_cost(n, single),
        "band": band_cost(pattern, single, kd),
        "sparse": sparse_cost(single, analysis),
        "lapack_band": Cost(*banded, scale * lapack * 1e-6),
        "cholmod": Cost(analysis.flops, analysis.nnz, cholmod * 1e-6),
    }


def band_cost(pattern: BlockPattern, single: bool, reach: int | None = None) -> Cost:
    """Cost of the band solver, of half-bandwidth `reach` if given; it needs no symbolic factor."""
    n, kd = pattern.size, half_bandwidth(pattern) if reach is None else reach
    flops = band_flops(n, kd)
    # A wide band leaves the second cache.
    rate = 90.0 if kd <= _NARROW else 65.0
    nanoseconds = 100.0 + n / 6 * (130.0 + 1.5 * kd) + 0.25 * n * kd + flops / rate
    return Cost(flops, n * (kd + 1), (SINGLE if single else 1.0) * nanoseconds * 1e-6)


def sparse_cost(single: bool, analysis: Analysis) -> Cost:
    """Cost of the sparse solver with a symbolic factor."""
    milliseconds = 100e-6 + analysis.milliseconds + _scattered(analysis)
    return Cost(analysis.flops, analysis.nnz, (SINGLE if single else 1.0) * milliseconds)


def _scattered(analysis: Analysis) -> float:
    """Milliseconds for update matrices of fronts whose parents exceed the second-level cache.

    Each column of a block that is added to such a parent is a separate cache miss, which the model
    of a front does not include.
    """
    return analysis.scattered * _PLACE * 1e-6
