"""Initial values of a model: the candidates, and the choice by cost."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.session import session_of
from arael.solving import current_problem
from arael.starts.chordal import chordal_poses
from arael.starts.columns import graph_of, has_landmarks, put, residuals_of, rotation_column
from arael.starts.graph import PoseGraph, Poses
from arael.starts.landmarks import place_landmarks
from arael.starts.relaxation import Coupling, SingularError
from arael.starts.tree import tree_poses

if TYPE_CHECKING:
    from arael.runtime.problem import Problem

How = Literal["auto", "file", "tree", "chordal"]
WAYS: tuple[How, ...] = get_args(How)

# `auto` stops at a start with a cost per residual below this: noise alone gives about 1, and the
# solver reduces the rest.
_NEAR = 10.0

# No start is computed if the file's values cost less than this per residual, the noise level at the
# optimum: a wrong start costs many times as much.
_AT_NOISE = 1.0


@dataclass(frozen=True)
class Start:
    """The chosen start.

    Attributes
    ----------
    chosen : ``file`` (the given values), ``tree`` or ``chordal``
    costs : cost of the model at each computed start, by name
    seconds : total time
    """

    chosen: str
    costs: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {"chosen": self.chosen, "costs": dict(self.costs), "seconds": self.seconds}

    def __str__(self) -> str:
        others = [f"{n} {c:.6g}" for n, c in self.costs.items() if n != self.chosen]
        beside = f" ({', '.join(others)})" if others else ""
        return f"start: {self.chosen}, cost {self.costs[self.chosen]:.6g}{beside}"


def can_initialise(model: Any) -> bool:
    """Whether `initialise` supports a model: whether it is a pose graph by its columns."""
    return bool(rotation_column(model._store))


def initialise(model: Any, how: How = "auto") -> Start:
    """Set initial values of the poses of a pose graph, computed from its measurements.

    Fixed poses and parts of poses keep their values. Landmarks follow from the poses. Edges and
    anchors whose ref to a pose is null are left out. A component without fixed or anchored poses
    keeps the value of its first pose.

    Parameters
    ----------
    model : an instance of `pose_graph_2d`, `pose_graph_3d`, or of a model with their collections
    how : ``tree`` composes poses along the least uncertain paths; ``chordal`` relaxes rotations
        to matrices and solves two sparse linear systems; ``file`` keeps the given values; ``auto``
        uses the one of least cost: it skips the tree if the cost of the chordal start is already
        near the noise level, and keeps the file's values without computing a start if their cost
        is below 1 per residual, which is the noise level

    Returns
    -------
    Start

    Raises
    ------
    AraelError
        E0843 the model is not a pose graph; E0844 the measurements do not determine a chordal start
        (``auto`` then skips it); E1010 unknown method; E1040 another thread is solving it.
    """
    if not isinstance(how, str) or how not in WAYS:
        raise AraelError(
            Diagnostic(
                "E1010",
                f"there is no start `{how}`",
                origin="initialise",
                help=(f"choose one of {', '.join(WAYS)}",),
            )
        )
    store = getattr(model, "_store", None)
    if store is None:
        raise wrong_argument("initialise", "model", "an instance of a model", model)
    rotation = rotation_column(store)
    if not rotation:
        raise AraelError(
            Diagnostic(
                "E0843",
                f"`{store.layout.root}` of {store.layout.source} is not a pose graph: "
                "there is no start to compute for it",
                origin="initialise",
                help=("set start values in the data, or use `pose_graph_2d` or `pose_graph_3d`",),
            )
        )

    began = time.perf_counter()
    store.check_complete()
    with store.use.solving(), session_of(model).held() as session:
        chosen, costs = _choose(model, how, session, rotation)
    return Start(chosen, costs, time.perf_counter() - began)


def _choose(model: Any, how: str, session: Any, rotation: str) -> tuple[str, dict[str, float]]:
    store = model._store
    problem = current_problem(model, session, frozenset())
    costs = {"file": problem.cost()}
    near = _NEAR * residuals_of(store)
    at_noise = how == "auto" and costs["file"] < _AT_NOISE * residuals_of(store)
    if how == "file" or at_noise or not store.tables["edges"].size:
        return "file", costs
    graph = graph_of(store, rotation)
    if np.count_nonzero(graph.fixed_position & graph.fixed_rotation) == len(graph.poses):
        return "file", costs
    # `put` does not change fixed parts, so the columns are restored directly.
    columns: dict[str, tuple[str, ...]] = {"poses": ("t", rotation)}
    if has_landmarks(store):
        columns["landmarks"] = ("t",)
    before = {
        (table, path): store.tables[table].column(path).copy()
        for table, paths in columns.items()
        for path in paths
    }
    found: dict[str, Poses] = {}
    placed = "file"
    try:
        for name in ("chordal", "tree") if how == "auto" else (how,):
            try:
                found[name] = _poses(name, graph, problem)
            except SingularError:
                if how != "auto":
                    raise _undetermined(store) from None
                continue
            put(store, found[name], rotation, graph)
            place_landmarks(store)
            placed = name
            _load(problem, columns)
            costs[name] = problem.cost()
            if costs[name] < min(costs["file"], near):
                break
    except BaseException:
        _restore(store, before)
        raise
    chosen = how if how != "auto" else min(costs, key=lambda n: _comparable(costs[n]))
    if chosen != placed:
        _restore(store, before)
        if chosen != "file":
            put(store, found[chosen], rotation, graph)
            place_landmarks(store)
    return chosen, costs


def _poses(name: str, graph: PoseGraph, problem: Problem) -> Poses:
    """Poses of a start by its name."""
    if name == "tree":
        return tree_poses(graph)
    return chordal_poses(graph, _coupling(problem))


def _load(problem: Problem, columns: dict[str, tuple[str, ...]]) -> None:
    """Take over the changed columns; all else only if guards or data may follow from them."""
    layout = problem.layout
    read = any((table, path) in layout.readers for table in columns for path in columns[table])
    if read or any(group.guard is not None for group in layout.groups):
        problem.refresh()
    else:
        problem.load_values()


def _coupling(problem: Problem) -> Coupling | None:
    """The pattern of a problem if its blocks are poses as a whole, else None."""
    structure = problem.structure
    for entity, blocks in zip(problem.layout.entities, structure.system.blocks, strict=True):
        if entity.table != "poses" or not {"t", "th", "q"} > {use.column for use in entity.params}:
            continue
        if np.count_nonzero(blocks.block >= 0) == structure.pattern.block_count:
            return Coupling(structure.pattern, blocks.block)
    return None


def _restore(store: Any, before: dict[tuple[str, str], Any]) -> None:
    for (table, path), values in before.items():
        store.tables[table].column(path)[...] = values


def _comparable(cost: float) -> float:
    """A cost, infinite if it is NaN."""
    return math.inf if math.isnan(cost) else cost


def _undetermined(store: Any) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0844",
            "the measurements do not determine a chordal start: its linear system is singular",
            origin=f"{store.layout.root} of {store.layout.source}",
            help=(
                "every edge needs information about position and rotation: look for zeros in `u`",
                "start from the tree, or from the values in the file",
            ),
        )
    )
