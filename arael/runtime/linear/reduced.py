"""Plans a block elimination: eliminated entities, solver of the reduced system, costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import Analysis, analyse
from arael.runtime.linear.compiled import Products, Reduction, products
from arael.runtime.linear.costs import Cost, predict
from arael.runtime.linear.planning import independent_set, named_set

Ints = NDArray[np.int64]

#: Solvers for the reduced system.
INNER = ("dense", "band", "sparse")

# Maximum number of products, which bounds the size of their list.
_TOO_MANY = 100_000_000

# Scalars of the stored blocks that fit the second-level cache, f64.
_CACHE = 128 * 1024

_SINGLE = 0.65


@dataclass(frozen=True)
class Reduced:
    """A planned elimination and the solver for the reduced system.

    Attributes
    ----------
    reduction : Reduction
    products : Products
        All blocks of the reduced system.
    analysis : Analysis
        Symbolic factor of the reduced system.
    costs : dict
        Cost of each solver for the reduced system alone.
    elimination : Cost
        Of forming the reduced system.
    """

    reduction: Reduction
    products: Products
    analysis: Analysis
    costs: dict[str, Cost]
    elimination: Cost

    @property
    def pattern(self) -> BlockPattern:
        """Pattern of the reduced system."""
        return self.products.pattern

    def cheapest(self) -> str:
        """Name of the direct solver for the reduced system with the lowest predicted cost."""
        return min(INNER, key=lambda name: self.costs[name].milliseconds)

    def cost(self, inner: str) -> Cost:
        """Cost of the whole factorisation with the named solver for the reduced system."""
        own, rest = self.elimination, self.costs[inner]
        return Cost(
            own.flops + rest.flops, own.nnz + rest.nnz, own.milliseconds + rest.milliseconds
        )

    def order(self) -> Ints:
        """Equivalent elimination order of the whole system: the eliminated entities first."""
        gone = np.flatnonzero(self.reduction.eliminated)
        return np.concatenate((gone, self.reduction.kept[self.analysis.supernodes.order]))


def product_count(reduction: Reduction) -> int:
    """Count the pairs of stored blocks that meet at an eliminated entity, each with itself too."""
    m = np.diff(reduction.entities["couplings"])
    return int((m * (m + 1) // 2).sum())


def choose_set(pattern: BlockPattern, eliminate: str | Sequence[int] | Ints) -> NDArray[np.bool_]:
    """Entities to eliminate: those named, or an independent set found in the pattern."""
    if isinstance(eliminate, str):
        return independent_set(pattern)
    return named_set(pattern, eliminate)


def plan_reduced(
    reduction: Reduction, single: bool, ordering: str = "auto", patient: bool = True
) -> Reduced | None:
    """Plan the reduced system of an elimination and predict its cost.

    Parameters
    ----------
    reduction : Reduction
    single : bool
        f32 if true, else f64.
    ordering : str
        For the sparse solver of the reduced system.
    patient : bool
        Whether to plan regardless of time; otherwise None is returned if the elimination would be
        disproportionate.
    """
    if not patient and product_count(reduction) > _TOO_MANY:
        return None
    blocks = products(reduction)
    analysis = analyse(blocks.pattern, ordering)
    costs = predict(blocks.pattern, single, analysis)
    return Reduced(reduction, blocks, analysis, costs, elimination_cost(reduction, blocks, single))


def elimination_cost(reduction: Reduction, blocks: Products, single: bool) -> Cost:
    """Predicted cost of forming the reduced system, fitted to measurements like `costs`."""
    d = reduction.entities["size"][:-1].astype(np.float64)
    of = reduction.entity_of
    width = reduction.couplings["width"].astype(np.float64)
    _, height, wide, depth, _, count = blocks.tasks.astype(np.float64).T
    work = depth * height * wide * count
    far = 6.0 if reduction.stored_size > _CACHE * (2 if single else 1) else 0.0
    nanoseconds = (
        float((26.0 + 1.3 * d * d + 0.13 * d * d * d).sum())
        + float((5.0 + 0.13 * d[of] * d[of] * width).sum())
        + float((8.0 + 0.1 * height * wide + (1.3 + far) * count + work / 43.0).sum())
    )
    flops = float((d**3 / 3).sum() + (d[of] ** 2 * width).sum() + work.sum())
    nnz = reduction.stored_size + int((d * (d + 1) / 2).sum())
    return Cost(flops, nnz, nanoseconds * 1e-6 * (_SINGLE if single else 1.0))
