"""What each linear solver would cost on a pattern, before anything is computed.

The times are a model, fitted to measurements on one core with 512-bit vectors. Another machine has
other times, but the ratios, which are all that a choice needs, vary much less.
"""

from __future__ import annotations

from dataclasses import dataclass

from arael.runtime.linear.analysis import Analysis
from arael.runtime.linear.bandwidth import band_flops, half_bandwidth
from arael.runtime.linear.pattern import BlockPattern

# f32 halves the arithmetic and the traffic, but not the calls and the chains of square roots.
_SINGLE = 0.65

# Unknowns from which `dense` hands over to LAPACK, see dense.pyx.
_LAPACK = 1536


@dataclass(frozen=True)
class Cost:
    """Price of one factorisation.

    Attributes
    ----------
    flops : float
        Additions and multiplications.
    nnz : int
        Scalars of the factor.
    milliseconds : float
        Predicted time.
    """

    flops: float
    nnz: int
    milliseconds: float

    def as_dict(self) -> dict[str, float]:
        """Put the cost in the form it has in a plan."""
        return {"flops": self.flops, "nnz_l": self.nnz, "predicted_ms": self.milliseconds}


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
    scale = _SINGLE if single else 1.0
    dense_rate = 88.0 if n <= _LAPACK else 55.0
    dense = 100.0 + 16.0 * n + 0.15 * n * n + n**3 / (3 * dense_rate)
    banded = (band_flops(n, kd), n * (kd + 1))
    band = 100.0 + n / 6 * (130.0 + 1.5 * kd) + 0.25 * n * kd + banded[0] / 90.0
    lapack = 100.0 + n * (30.0 + 3.0 * kd) + banded[0] / 60.0
    # CHOLMOD pays for its index work by the scalar.
    cholmod = 20_000.0 + 150.0 * n + 8.0 * analysis.nnz + analysis.flops / 25.0
    return {
        "dense": Cost(n**3 / 3, n * (n + 1) // 2, scale * dense * 1e-6),
        "band": Cost(*banded, scale * band * 1e-6),
        "sparse": Cost(analysis.flops, analysis.nnz, scale * (100e-6 + analysis.milliseconds)),
        "lapack_band": Cost(*banded, scale * lapack * 1e-6),
        "cholmod": Cost(analysis.flops, analysis.nnz, cholmod * 1e-6),
    }
