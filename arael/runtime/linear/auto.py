"""Makes linear solvers by name, and chooses one by predicted cost."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.linear.analysis import ORDERINGS, Analysis, analyse, analyse_order
from arael.runtime.linear.costs import Cost, predict
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.linear.reduced import INNER, Reduced, plan_reduced

if TYPE_CHECKING:
    from arael.runtime.linear.base import LinearSolver

_BANDS = ("half_bandwidth", "block_half_bandwidth")

#: Solvers by name, with the options each of them takes.
SOLVERS: dict[str, tuple[str, ...]] = {
    "auto": ("ordering", "eliminate"),
    "dense": (),
    "band": _BANDS,
    "sparse": ("ordering",),
    "schur": ("eliminate", "reduced", "ordering"),
    "cholmod": (),
    "lapack_band": _BANDS,
}

#: Those that `auto` chooses from; they need nothing that may be missing.
CANDIDATES = ("dense", "band", "sparse", "schur")

# With more entities, orderings of the whole system take longer than the elimination of a kind of
# entities that makes up half of it, and hardly ever find a better order.
_MANY = 2000


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
        declared to have. ``eliminate`` (`schur`, `auto`): ``"auto"``, or block rows no two of which
        are coupled. ``reduced`` (`schur`): solver for what is left, ``"auto"`` or one of
        `arael.runtime.linear.reduced.INNER`.

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
    _check(name, options)
    ordering = options.pop("ordering", "auto")
    eliminate = options.pop("eliminate", "auto")
    asked = name == "schur"
    reduced = plan_reduced(pattern, single, eliminate, ordering if asked else "auto", asked)
    analysis = _analysis(pattern, "auto" if asked else ordering, name, reduced)
    costs = predict(pattern, single, analysis)
    inner = options.pop("reduced", "auto")
    if reduced is not None:
        inner = reduced.cheapest() if inner == "auto" else inner
        costs["schur"] = reduced.cost(inner)
    chosen = name
    if name == "auto":
        able = [candidate for candidate in CANDIDATES if candidate in costs]
        chosen = min(able, key=lambda candidate: costs[candidate].milliseconds)
    if chosen == "schur":
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
    return solver


def _analysis(pattern: BlockPattern, ordering: str, name: str, reduced: Reduced | None) -> Analysis:
    """Symbolic factor of the whole system; the elimination's own order where that will do."""
    if reduced is None or ordering != "auto" or name not in ("auto", "schur"):
        return analyse(pattern, ordering)
    half = 2 * int(reduced.reduction.eliminated.sum()) >= pattern.block_count
    if name == "schur" or (half and pattern.block_count > _MANY):
        return analyse_order(pattern, "eliminate_first", reduced.order())
    return analyse(pattern, ordering)


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
    }[chosen]
    return (
        f"{chosen} is predicted to factorise {pattern.size} unknowns in {mine:.3g} ms, "
        f"against {others}: {what}"
    )


def _check(name: str, options: dict[str, Any]) -> None:
    if name not in SOLVERS:
        near = closest(name, SOLVERS)
        raise AraelError(
            Diagnostic(
                "E0840",
                f"there is no linear solver {name!r}",
                origin="solver options",
                notes=(f"solvers are {', '.join(SOLVERS)}",),
                help=(f"did you mean {near[0]!r}?",) if near else (),
            )
        )
    for option in options:
        if option not in SOLVERS[name]:
            near = closest(option, SOLVERS[name])
            takes = ", ".join(SOLVERS[name]) or "no options"
            raise AraelError(
                Diagnostic(
                    "E0842",
                    f"the solver {name!r} has no option {option!r}",
                    origin="solver options",
                    notes=(f"{name!r} takes {takes}",),
                    help=(f"did you mean {near[0]!r}?",) if near else (),
                )
            )
    _one_of("ordering", options.get("ordering", "auto"), ("auto", *ORDERINGS))
    _one_of("reduced", options.get("reduced", "auto"), ("auto", *INNER))
    if isinstance(options.get("eliminate"), str):
        _one_of("eliminate", options["eliminate"], ("auto",))


def _one_of(option: str, value: Any, known: tuple[str, ...]) -> None:
    if value not in known:
        near = closest(str(value), known)
        raise AraelError(
            Diagnostic(
                "E0842",
                f"there is no {option} {value!r}",
                origin="solver options",
                notes=(f"{option} is one of {', '.join(known)}",),
                help=(f"did you mean {near[0]!r}?",) if near else (),
            )
        )
