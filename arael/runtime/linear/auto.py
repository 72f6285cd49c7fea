"""Makes linear solvers by name, and chooses one by predicted cost."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from arael.runtime.linear.analysis import Analysis, analyse, analyse_order
from arael.runtime.linear.costs import Cost, predict
from arael.runtime.linear.heap import give_back
from arael.runtime.linear.iterative import iterative_solver, predict_iterative
from arael.runtime.linear.options import SOLVERS, check_options
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.linear.reduced import Reduced, choose_set, plan_reduced
from arael.runtime.linear.reduction import Reduction, reduce

if TYPE_CHECKING:
    from arael.runtime.linear.base import LinearSolver

__all__ = ["CANDIDATES", "SOLVERS", "make_solver"]

#: Direct solvers that `auto` chooses from; they need nothing that may be missing.
CANDIDATES = ("dense", "band", "sparse", "schur")

# `schur_pcg` is taken where it is predicted to be this many times as fast as all direct ones: its
# iterations are a guess, and its steps are not finished.
_MARGIN = 4.0

# Nor is it considered where a direct solver is predicted to take less than so many milliseconds:
# nothing or next to nothing may be left to iterate on then.
_DIRECT_ENOUGH = 0.1

# Milliseconds below which predictions do not tell solvers apart: from Python, a step of 2 to 30
# unknowns takes 5 to 8 microseconds with any of them.
_TINY = 0.001

# With more entities, minimum degree on the whole system takes longer than the elimination of a kind
# of entities that makes up half of it, and hardly ever finds a better order.
_MANY = 2000

# With more entities of one kind, such as the poses of a graph, the order of the elimination stands
# for that of the whole: within 3 % of the best one's time on all public graphs.
_ALIKE = 500

# Scalars of the matrix from which giving memory back is worth its milliseconds.
_HEAVY = 500_000


def make_solver(
    name: str, pattern: BlockPattern, single: bool = False, **options: Any
) -> LinearSolver:
    """Make the linear solver `name` for a pattern.

    Parameters
    ----------
    name : str
        One of `SOLVERS`; ``"auto"`` takes the one with the lowest predicted cost.
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    **options
        ``ordering`` (`sparse`, `auto`): ``"auto"`` or one of
        `arael.runtime.linear.analysis.ORDERINGS`. ``half_bandwidth`` in scalars,
        ``block_half_bandwidth`` in entities (`band`, `lapack_band`): the band the problem is
        declared to have. ``eliminate`` (`schur`, `schur_pcg`, `auto`): ``"auto"``, or block rows
        no two of which are coupled. ``reduced`` (`schur`): solver for what is left, ``"auto"`` or
        one of `arael.runtime.linear.reduced.INNER`. `schur_pcg`: ``formed``, whether the reduced
        system is formed or only applied (``"auto"``, True, False); ``preconditioner``
        (``"cluster"``, ``"tridiagonal"``, ``"jacobi"``); ``tolerance`` (0.1) and ``floor`` (1e-6),
        bounds of the forcing term; ``iterations`` (500), the most of one solve.

    Returns
    -------
    LinearSolver
        Its `plan` tells what was chosen and why, and what the other solvers would have cost.

    Raises
    ------
    AraelError
        E0840 for an unknown solver, E0841 where `cholmod` is missing, E0842 for an unknown or
        impossible option, E1020 for an entity outside the declared band.
    """
    check_options(name, options)
    reduction = reduce(pattern, choose_set(pattern, options.pop("eliminate", "auto")))
    ordering = options.pop("ordering", "auto")
    asked = name == "schur"
    reduced = plan_reduced(reduction, single, ordering if asked else "auto", patient=asked)
    analysis = _analysis(pattern, "auto" if asked else ordering, name, reduced)
    costs = predict(pattern, single, analysis)
    inner = options.pop("reduced", "auto")
    if reduced is not None:
        inner = reduced.cheapest() if inner == "auto" else inner
        costs["schur"] = reduced.cost(inner)
    costs["schur_pcg"] = predict_iterative(reduction, reduced, single)
    chosen = _cheapest(costs, reduction) if name == "auto" else name
    if chosen == "schur_pcg":
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


def _cheapest(costs: dict[str, Cost], reduction: Reduction) -> str:
    """Name of the solver that `auto` takes."""
    able = [candidate for candidate in CANDIDATES if candidate in costs]
    direct = min(able, key=lambda candidate: costs[candidate].milliseconds)
    if (
        _is_kind(reduction)
        and costs[direct].milliseconds >= _DIRECT_ENOUGH
        and _MARGIN * costs["schur_pcg"].milliseconds < costs[direct].milliseconds
    ):
        return "schur_pcg"
    return direct


def _is_kind(reduction: Reduction) -> bool:
    """Whether most entities are eliminated, like the points of a bundle; not poses of a graph."""
    return 2 * int(reduction.eliminated.sum()) >= len(reduction.eliminated)


def _analysis(pattern: BlockPattern, ordering: str, name: str, reduced: Reduced | None) -> Analysis:
    """Symbolic factor of the whole system; the elimination's own order where that will do."""
    if reduced is None or ordering != "auto" or name not in ("auto", "schur", "schur_pcg"):
        return analyse(pattern, ordering)
    kind = _is_kind(reduced.reduction)
    if name != "auto" or pattern.block_count > (_MANY if kind else _ALIKE):
        known = analyse_order(pattern, "eliminate_first", reduced.order())
        if name != "auto" or not kind:
            return known
        return analyse(pattern, ordering, known, reduced.cost(reduced.cheapest()).milliseconds)
    return analyse(pattern, ordering)


def _part(single: bool) -> Callable[[BlockPattern], LinearSolver]:
    """Maker of direct solvers for parts of a reduced system."""

    def make(part: BlockPattern) -> LinearSolver:
        analysis = analyse(part, "minimum_degree")
        costs = predict(part, single, analysis)
        name = min(("band", "sparse"), key=lambda one: costs[one].milliseconds)
        return _construct(name, part, single, analysis, {})

    return make


def _schur(pattern: BlockPattern, single: bool, reduced: Reduced, inner: str) -> LinearSolver:
    from arael.runtime.linear.schur import SchurSolver

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
    # Imported here, so that a program loads only the solver it uses.
    if name == "dense":
        from arael.runtime.linear.dense import DenseSolver

        return DenseSolver(pattern, single)
    if name == "band":
        from arael.runtime.linear.band import BandSolver

        return BandSolver(pattern, single, **options)
    if name == "lapack_band":
        from arael.runtime.linear.lapack_band import LapackBandSolver

        return LapackBandSolver(pattern, single, **options)
    if name == "cholmod":
        from arael.runtime.linear.cholmod import CholmodSolver

        return CholmodSolver(pattern, single)
    from arael.runtime.linear.sparse import SparseSolver

    return SparseSolver(pattern, single, analysis=analysis)


def _reason(asked: str, chosen: str, pattern: BlockPattern, costs: dict[str, Cost]) -> str:
    """Why this solver, in a sentence."""
    if asked != "auto":
        return f"{asked} was asked for"
    rest = sorted(
        (costs[name].milliseconds, name) for name in CANDIDATES if name in costs and name != chosen
    )
    mine = costs[chosen].milliseconds
    others = ", ".join(f"{name} {time:.3g} ms" for time, name in rest)
    what = {
        "dense": "nearly everything is coupled with everything, or there is little of it",
        "band": "entities are coupled with close neighbours only",
        "sparse": "couplings are few and fill-in stays low in a good order",
        "schur": "many entities are coupled only with others than themselves and go block by block",
        "schur_pcg": "what is left when many entities have gone is too large to factorise",
    }[chosen]
    if mine < _TINY:
        what = "so few unknowns that the choice hardly matters"
    does = "solve for" if chosen == "schur_pcg" else "factorise"
    unknowns = f"{pattern.size} unknown{'' if pattern.size == 1 else 's'}"
    return f"{chosen} is predicted to {does} {unknowns} in {mine:.3g} ms, against {others}: {what}"
