"""Plans conjugate gradients on a reduced system: formed or not, preconditioner, cost."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.clusters import visibility_clusters
from arael.runtime.linear.compiled import Products, Reduction, kept_blocks, products
from arael.runtime.linear.costs import Cost
from arael.runtime.linear.reduced import Reduced, elimination_cost

if TYPE_CHECKING:
    from arael.runtime.linear.compiled import LinearSolver

#: Preconditioners.
PRECONDITIONERS = ("jacobi", "tridiagonal", "cluster")

#: Options passed to the solver.
BOUNDS = ("tolerance", "floor", "iterations")

# Expected iterations of a step, for predictions only.
EXPECTED = 30

_SINGLE = 0.65


def predict_iterative(reduction: Reduction, reduced: Reduced | None, single: bool) -> Cost:
    """Cost of a step with the formed or unformed reduced system, the lower of the two.

    Parameters
    ----------
    reduction : Reduction
    reduced : Reduced or None
        Its reduced system, if planned.
    single : bool
        f32 if true, else f64.
    """
    cost = _cost(reduction, single, None)
    if reduced is None:
        return cost
    formed = _cost(reduction, single, reduced.products)
    return min(cost, formed, key=lambda one: one.milliseconds)


def is_formed(reduction: Reduction, reduced: Reduced | None, single: bool) -> bool:
    """Whether forming the reduced system is faster."""
    if reduced is None:
        return False
    formed = _cost(reduction, single, reduced.products)
    return formed.milliseconds < _cost(reduction, single, None).milliseconds


def _cost(reduction: Reduction, single: bool, whole: Products | None) -> Cost:
    scale = _SINGLE if single else 1.0
    kept = len(reduction.kept)
    own = elimination_cost(reduction, whole or kept_blocks(reduction), single)
    sizes = reduction.sizes.astype(np.float64)
    if whole is not None:
        entries, blocks = float(whole.pattern.value_count), float(len(whole.pattern.rows))
        work, nanoseconds = 4 * entries, 10.0 * blocks + 0.6 * entries
    else:
        stored, count = float(reduction.stored_size), float(len(reduction.couplings))
        work, nanoseconds = 4 * stored, 8.0 * count + 0.9 * stored
    block = float((sizes**3 / 3).sum())
    nanoseconds = EXPECTED * (nanoseconds + 30.0 * kept + 4.0 * float((sizes**2).sum()))
    return Cost(
        own.flops + block + EXPECTED * work,
        own.nnz + (whole.pattern.value_count if whole is not None else 0),
        own.milliseconds + scale * nanoseconds * 1e-6,
    )


def iterative_solver(
    pattern: BlockPattern,
    single: bool,
    reduction: Reduction,
    reduced: Reduced | None,
    make: Callable[[BlockPattern], LinearSolver],
    options: dict[str, Any],
) -> LinearSolver:
    """Create the solver.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    reduction : Reduction
    reduced : Reduced or None
        Its reduced system, if planned.
    make : callable
        Creates a direct solver for a part of the reduced system.
    options : dict
        ``formed``, ``preconditioner``, ``tolerance``, ``floor``, ``iterations``.
    """
    # Imported here for start-up time: a program loads only the solver that it uses.
    from arael.runtime.linear.compiled import ConjugateSolver

    kind = options.get("preconditioner", "cluster")
    formed = options.get("formed", "auto")
    if formed == "auto":
        formed = is_formed(reduction, reduced, single)
    whole = reduced.products if reduced is not None else None
    if formed:
        blocks = whole if whole is not None else products(reduction)
    else:
        blocks = kept_blocks(reduction)
    parts = []
    if kind == "tridiagonal":
        parts.append(products(reduction, reach=1))
    elif kind == "cluster":
        parts.append(products(reduction, group=visibility_clusters(reduction)))
    parts.append(products(reduction, reach=0))
    bounds = {name: options[name] for name in BOUNDS if name in options}
    solver = ConjugateSolver(
        pattern,
        single,
        reduction,
        blocks,
        bool(formed),
        [(part, make(part.pattern)) for part in parts],
        **bounds,
    )
    solver.plan["preconditioner"] = kind
    return solver
