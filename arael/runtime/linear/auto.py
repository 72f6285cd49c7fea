"""Creates linear solvers by name, and chooses one by predicted cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import WINS, Analysis, analyse, analyse_order
from arael.runtime.linear.compiled import Reduction, reduce
from arael.runtime.linear.costs import Cost, predict
from arael.runtime.linear.iterative import iterative_solver, predict_iterative
from arael.runtime.linear.options import SOLVERS, check_options
from arael.runtime.linear.planning import give_back, independent_set
from arael.runtime.linear.reduced import Reduced, choose_set, plan_reduced
from arael.runtime.linear.small import small_solver

if TYPE_CHECKING:
    from arael.runtime.linear.compiled import LinearSolver

__all__ = ["CANDIDATES", "SOLVERS", "make_solver"]

#: Direct solvers that `auto` chooses from; none needs an optional dependency.
CANDIDATES = ("dense", "band", "sparse", "schur")

# `schur_pcg` is chosen if it is predicted to be faster than all direct solvers by this factor: its
# iteration count is estimated, and its steps are inexact.
_MARGIN = 4.0

# It is not considered if a direct solver is predicted to take less than this many milliseconds,
# since the reduced system may then be empty or tiny.
_DIRECT_ENOUGH = 0.1

# With more entities, minimum degree on the whole system takes longer than the elimination of a kind
# of entities that makes up half of it, and rarely finds a better order.
_MANY = 2000

# An elimination is planned if it takes this part of the entities. Of poses in a chain or on a grid
# it takes half, and minimum degree eliminates them as well.
_KIND = 0.6

# To compare orderings takes so many milliseconds, and so many for each block of the matrix.
_COMPARING = 0.3, 0.5e-3

# Scalars of the matrix above which freed memory is returned to the system, which takes
# milliseconds.
_HEAVY = 500_000


def make_solver(
    name: str, pattern: BlockPattern, single: bool = False, **options: Any
) -> LinearSolver:
    """Create the linear solver `name` for a pattern.

    Parameters
    ----------
    name : str
        One of `SOLVERS`; ``"auto"`` takes the one with the lowest predicted cost, and without
        options the dense one up to `arael.runtime.linear.small.SMALL` unknowns.
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    **options
        ``ordering`` (`sparse`, `auto`): ``"auto"`` or one of
        `arael.runtime.linear.analysis.ORDERINGS`. ``half_bandwidth`` in scalars,
        ``block_half_bandwidth`` in entities (`band`, `lapack_band`): the declared band of the
        problem. ``eliminate`` (`schur`, `schur_pcg`, `auto`): ``"auto"``, or pairwise uncoupled
        block rows. ``reduced`` (`schur`): solver for the reduced system, ``"auto"`` or one of
        `arael.runtime.linear.reduced.INNER`. `schur_pcg`: ``formed``, whether the reduced system is
        formed or only applied (``"auto"``, True, False); ``preconditioner`` (``"cluster"``,
        ``"tridiagonal"``, ``"jacobi"``); ``tolerance`` (0.1) and ``floor`` (1e-6), bounds of the
        forcing term; ``iterations`` (500), the maximum per solve.

    Returns
    -------
    LinearSolver
        Its `plan` reports the choice, its reason, and the predicted costs of the other solvers.

    Raises
    ------
    AraelError
        E0840 for an unknown solver, E0841 if `cholmod` is missing, E0842 for an unknown or invalid
        option, E1020 for an entity outside the declared band.
    """
    check_options(name, options)
    small = small_solver(name, pattern, single, options)
    if small is not None:
        return small
    reduction = reduced = None
    inner = options.pop("reduced", "auto")
    analysis, eliminated = _without_elimination(pattern, name, options)
    if analysis is not None:
        options = {}
        costs = predict(pattern, single, analysis)
    else:
        if eliminated is None:
            eliminated = choose_set(pattern, options.pop("eliminate", "auto"))
        reduction = reduce(pattern, eliminated)
        ordering = options.pop("ordering", "auto")
        asked = name == "schur"
        reduced = plan_reduced(reduction, single, ordering if asked else "auto", patient=asked)
        analysis = _analysis(pattern, "auto" if asked else ordering, name, reduced)
        costs = predict(pattern, single, analysis)
        if reduced is not None:
            inner = reduced.cheapest() if inner == "auto" else inner
            costs["schur"] = reduced.cost(inner)
        costs["schur_pcg"] = predict_iterative(reduction, reduced, single)
    chosen = _cheapest(costs, reduction) if name == "auto" else name
    if chosen == "schur_pcg":
        assert reduction is not None
        solver = iterative_solver(pattern, single, reduction, reduced, _part(single), options)
    elif chosen == "schur":
        assert reduced is not None
        solver = _schur(pattern, single, reduced, inner)
    else:
        solver = _construct(chosen, pattern, single, analysis, options)
    solver.plan.update(
        asked=name,
        why=_reason(name, chosen, pattern, costs),
        precision="f32" if single else "f64",
        predicted_ms=costs[chosen].milliseconds,
        orderings=dict(analysis.tried),
        costs={candidate: cost.as_dict() for candidate, cost in costs.items()},
    )
    del reduction, reduced, analysis
    if pattern.value_count > _HEAVY:
        give_back()
    return solver


def _without_elimination(
    pattern: BlockPattern, name: str, options: Mapping[str, Any]
) -> tuple[Analysis | None, NDArray[np.bool_] | None]:
    """The symbolic factor of the whole system if `auto` need not plan an elimination.

    An elimination pays where a kind of entities makes up most of the system, as points of a bundle
    do. Otherwise minimum degree eliminates what is uncoupled first by itself, and as well. Other
    orderings are compared only if the factorisations of a solve take longer than that.

    Returns
    -------
    The factor, or None; and the entities to eliminate, if they were looked for.
    """
    if name != "auto" or any(
        not isinstance(options.get(one, "auto"), str) or options.get(one, "auto") != "auto"
        for one in ("eliminate", "ordering", "reduced")
    ):
        return None, None
    eliminated = independent_set(pattern)
    if np.count_nonzero(eliminated) >= _KIND * pattern.block_count:
        return None, eliminated
    known = analyse(pattern, "minimum_degree")
    fixed, each = _COMPARING
    if WINS * known.milliseconds < fixed + each * len(pattern.rows):
        return known, eliminated
    return analyse(pattern), eliminated


def _cheapest(costs: dict[str, Cost], reduction: Reduction | None) -> str:
    """Name of the solver that `auto` chooses."""
    able = [candidate for candidate in CANDIDATES if candidate in costs]
    direct = min(able, key=lambda candidate: costs[candidate].milliseconds)
    if (
        reduction is not None
        and _is_kind(reduction)
        and costs[direct].milliseconds >= _DIRECT_ENOUGH
        and _MARGIN * costs["schur_pcg"].milliseconds < costs[direct].milliseconds
    ):
        return "schur_pcg"
    return direct


def _is_kind(reduction: Reduction) -> bool:
    """Whether most entities are eliminated, like the points of a bundle; not poses of a graph."""
    return 2 * int(reduction.eliminated.sum()) >= len(reduction.eliminated)


def _analysis(pattern: BlockPattern, ordering: str, name: str, reduced: Reduced | None) -> Analysis:
    """Symbolic factor of the whole system; in the elimination's order if that is sufficient."""
    if reduced is None or ordering != "auto" or name not in ("auto", "schur", "schur_pcg"):
        return analyse(pattern, ordering)
    kind = _is_kind(reduced.reduction)
    if name != "auto" or (kind and pattern.block_count > _MANY):
        known = analyse_order(pattern, "eliminate_first", reduced.order())
        if name != "auto":
            return known
        return analyse(pattern, ordering, known, reduced.cost(reduced.cheapest()).milliseconds)
    return analyse(pattern, ordering)


def _part(single: bool) -> Callable[[BlockPattern], LinearSolver]:
    """Factory of direct solvers for parts of a reduced system."""

    def make(part: BlockPattern) -> LinearSolver:
        analysis = analyse(part, "minimum_degree")
        costs = predict(part, single, analysis)
        name = min(("band", "sparse"), key=lambda one: costs[one].milliseconds)
        return _construct(name, part, single, analysis, {})

    return make


def _schur(pattern: BlockPattern, single: bool, reduced: Reduced, inner: str) -> LinearSolver:
    # Imported here for start-up time: a program loads only the solver that it uses.
    from arael.runtime.linear.compiled import SchurSolver

    below = _construct(inner, reduced.pattern, single, reduced.analysis, {})
    solver = SchurSolver(pattern, single, reduced.reduction, reduced.products, below)
    solver.plan.update(
        flops=reduced.cost(inner).flops,
        reduced_costs={name: cost.as_dict() for name, cost in reduced.costs.items()},
    )
    return solver


def _construct(
    name: str,
    pattern: BlockPattern,
    single: bool,
    analysis: Analysis,
    options: dict[str, Any],
) -> LinearSolver:
    # Imported here for start-up time: a program loads only the solver that it uses.
    if name == "dense":
        from arael.runtime.linear.compiled import DenseSolver

        return DenseSolver(pattern, single)
    if name == "band":
        from arael.runtime.linear.compiled import BandSolver

        return BandSolver(pattern, single, **options)
    if name == "lapack_band":
        from arael.runtime.linear.compiled import LapackBandSolver

        return LapackBandSolver(pattern, single, **options)
    if name == "cholmod":
        from arael.runtime.linear.compiled import CholmodSolver

        return CholmodSolver(pattern, single)
    from arael.runtime.linear.compiled import SparseSolver

    return SparseSolver(pattern, single, analysis=analysis)


def _reason(asked: str, chosen: str, pattern: BlockPattern, costs: dict[str, Cost]) -> str:
    """The reason for the choice, in one sentence."""
    if asked != "auto":
        return f"{asked} was requested"
    rest = sorted(
        (costs[name].milliseconds, name) for name in CANDIDATES if name in costs and name != chosen
    )
    mine = costs[chosen].milliseconds
    others = ", ".join(f"{name} {time:.3g} ms" for time, name in rest)
    what = {
        "dense": "nearly all entities are coupled with each other, or the system is small",
        "band": "entities are coupled with close neighbours only",
        "sparse": "couplings are few and fill-in stays low in a good order",
        "schur": "many entities are uncoupled with each other and are eliminated block by block",
        "schur_pcg": "the reduced system is too large to factorise",
    }[chosen]
    does = "solve for" if chosen == "schur_pcg" else "factorise"
    unknowns = f"{pattern.size} unknown{'' if pattern.size == 1 else 's'}"
    return f"{chosen} is predicted to {does} {unknowns} in {mine:.3g} ms, against {others}: {what}"
