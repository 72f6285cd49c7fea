"""Makes linear solvers by name, and chooses one by predicted cost."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.linear.analysis import ORDERINGS, Analysis, analyse
from arael.runtime.linear.costs import Cost, predict
from arael.runtime.linear.pattern import BlockPattern

if TYPE_CHECKING:
    from arael.runtime.linear.base import LinearSolver

_BANDS = ("half_bandwidth", "block_half_bandwidth")

#: Solvers by name, with the options each of them takes.
SOLVERS: dict[str, tuple[str, ...]] = {
    "auto": ("ordering",),
    "dense": (),
    "band": _BANDS,
    "sparse": ("ordering",),
    "cholmod": (),
    "lapack_band": _BANDS,
}

#: Those that `auto` chooses from; they need nothing that may be missing.
CANDIDATES = ("dense", "band", "sparse")


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
        declared to have.

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
    analysis = analyse(pattern, ordering)
    costs = predict(pattern, single, analysis)
    chosen = name
    if name == "auto":
        chosen = min(CANDIDATES, key=lambda candidate: costs[candidate].milliseconds)
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
    rest = sorted((costs[name].milliseconds, name) for name in CANDIDATES if name != chosen)
    mine = costs[chosen].milliseconds
    others = ", ".join(f"{name} {time:.3g} ms" for time, name in rest)
    what = {
        "dense": "nearly everything is coupled with everything, or there is little of it",
        "band": "entities are coupled with close neighbours only",
        "sparse": "couplings are few and fill-in stays low in a good order",
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
    ordering = options.get("ordering", "auto")
    if ordering != "auto" and ordering not in ORDERINGS:
        known = ["auto", *ORDERINGS]
        near = closest(str(ordering), known)
        raise AraelError(
            Diagnostic(
                "E0842",
                f"there is no ordering {ordering!r}",
                origin="solver options",
                notes=(f"orderings are {', '.join(known)}",),
                help=(f"did you mean {near[0]!r}?",) if near else (),
            )
        )
