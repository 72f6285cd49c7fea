"""The price of a factorisation, and of the dense one, which needs no analysis."""

from __future__ import annotations

from dataclasses import dataclass

# f32 halves the arithmetic and the traffic, but not the calls and the chains of square roots.
SINGLE = 0.65


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


def dense_cost(n: int, single: bool) -> Cost:
    """Price of a dense factorisation of `n` unknowns; fitted as described in `costs`."""
    nanoseconds = 100.0 + 16.0 * n + 0.15 * n * n + n**3 / (3 * 80.0)
    scale = SINGLE if single else 1.0
    return Cost(n**3 / 3, n * (n + 1) // 2, scale * nanoseconds * 1e-6)
