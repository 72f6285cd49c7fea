"""Solve one problem in parts."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from arael.compiled_model import CompiledModel
from arael.config import LmConfig
from arael.diagnostics.records import AraelError, Diagnostic
from arael.distributed.parts.checkpoint import Checkpoint, mark_of
from arael.distributed.parts.checkpoint import read as read_checkpoint
from arael.distributed.parts.data import (
    Columns,
    columns_of,
    rows_of_share,
    whole_skeleton,
)
from arael.distributed.parts.executors import Executor
from arael.distributed.parts.graph import graph_of
from arael.distributed.parts.marginals import PartCovariance
from arael.distributed.parts.part import empty_structure
from arael.distributed.parts.requests import PartRecipe
from arael.distributed.parts.shares import Share, lenient, restricted, shares_of, skeleton
from arael.distributed.parts.split import BOUNDARY, by_labels, by_separators, part_of_instances
from arael.distributed.parts.team import Team, Traffic
from arael.io.columns import full_path
from arael.io.files import write_whole
from arael.result import Result, joined
from arael.runtime.evaluation.states import stored_scalars
from arael.runtime.failures import SolveError, refuse_required
from arael.runtime.layout import Layout
from arael.runtime.levenberg.compiled import RemoteBox, RemoteEvaluation, RemoteSolver
from arael.runtime.problem import Problem
from arael.runtime.solve import minimise
from arael.runtime.store import Store
from arael.runtime.system import System, build_system, free_scalars
from arael.schedule import chosen_passes, frozen_after, held_by
from arael.solving import result_of
from arael.statuses import ENDING

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class RemoteProblem(Problem):
    """The parameters of a problem whose constraints are evaluated in parts."""

    evaluation_type = RemoteEvaluation
    box_type = RemoteBox

    def ask(self, team: Team, guarded: bool) -> None:
        """Take costs and linearisations from parts; `guarded`: guards read parameters."""
        evaluation, box = self.evaluation, self.box
        assert isinstance(evaluation, RemoteEvaluation) and isinstance(box, RemoteBox)
        evaluation.is_guarded(guarded)
        evaluation.parts = box.parts = team


@dataclass(frozen=True)
class Split:
    """How a problem was split.

    Attributes
    ----------
    parts : number of parts
    instances : (parts,) rows of constraints of each
    interior : (parts,) scalars that each eliminates
    boundary : (parts,) scalars of the boundary that each reads
    between : scalars of the boundary
    size : scalars of the problem
    """

    parts: int
    instances: Ints
    interior: Ints
    boundary: Ints
    between: int
    size: int

    @property
    def share(self) -> float:
        """Part of all scalars that is boundary."""
        return self.between / max(self.size, 1)

    def __str__(self) -> str:
        return (
            f"{self.parts} parts of {min(self.interior, default=0)} to "
            f"{max(self.interior, default=0)} scalars; boundary of {self.between} "
            f"({100 * self.share:.2g} % of {self.size})"
        )


@dataclass
class Solved:
    """A solve in parts.

    Attributes
    ----------
    result : as of a solve on one machine
    split : how the problem was split
    traffic : bytes that were sent
    store : parameters and refs of all rows, solved
    problem, team : of the last pass
    seconds : spent on reading refs and splitting
    """

    result: Result
    split: Split
    traffic: Traffic
    store: Store
    problem: Problem
    team: Team
    seconds: float = 0.0

    def covariance(self) -> PartCovariance:
        """Marginal covariances at the solution, from the factors of the parts."""
        return PartCovariance(self.problem, self.team)

    def parameters(self) -> dict[str, NDArray[Any]]:
        """Solved parameters of all rows, by name: ``poses.pos`` (rows, 3)."""
        found = {}
        for path, table in self.store.tables.items():
            for column in table.data.values():
                if column.role == "param":
                    values = np.array(table.column(column.path))
                    found[full_path(table, column.path)] = values if path else values[0]
        return found

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the solved parameters, and nothing else, as an NPZ file."""
        arrays: dict[str, Any] = self.parameters()
        write_whole(path, lambda file: np.savez(file, **arrays))


def check_splittable(layout: Layout) -> None:
    """Refuse what a solve in parts cannot do.

    Raises
    ------
    AraelError
        E0895: sums over rows, f32, native functions; E1038: rows that hold exactly.
    """
    refuse_required(layout, "a solve in parts", "solve it on one machine")
    why = ""
    help_ = "solve it on one machine"
    if layout.precision != "f64":
        why = "parts are solved in f64, the model is f32"
        help_ = (
            "solve it in f64: `arael solve --precision f64`, or arael.load(..., precision='f64')"
        )
    elif layout.summed or layout.totals or any(group.lengths for group in layout.groups):
        why = "a constraint sums over the rows of a list, which may be in several parts"
    elif any(group.look_ups for group in layout.groups):
        why = "a constraint looks rows of a list up, which may be in several parts"
    elif any(function.native for function in layout.functions):
        why = "it calls native functions, which workers do not have"
    if why:
        raise refusal(layout, why, help_)


def refusal(layout: Layout, why: str, help_: str) -> AraelError:
    """E0895 for a model or data that cannot be solved in parts."""
    return AraelError(
        Diagnostic(
            "E0895",
            f"`{layout.name}` cannot be solved in parts: {why}",
            origin="partition",
            help=(help_,),
        )
    )


@dataclass
class Prepared:
    """A problem that is split and not yet solved."""

    compiled: CompiledModel
    layout: Layout  # of the parameters
    store: Store
    system: System
    shares: list[Share]
    split: Split
    path: str | None
    arrays: list[dict[str, NDArray[Any]] | None]
    seconds: float


def prepare(
    compiled: CompiledModel,
    data: str | os.PathLike[str] | Mapping[str, NDArray[Any]],
    partition: int | None,
    partition_by: str | None,
    frozen: frozenset[str] = frozenset(),
) -> Prepared:
    """Read parameters and refs, and split the problem.

    Parameters
    ----------
    data : an NPZ file or a folder of such, or arrays by name as they are in one
    partition : number of parts
    partition_by : name of a column of integers or strings that tables of entities have
    frozen : paths of parameters that never move
    """
    began = time.perf_counter()
    layout = compiled.layout
    check_splittable(layout)
    slim = skeleton(layout)
    columns = (
        columns_of(data, layout)
        if isinstance(data, str | os.PathLike)
        else Columns([dict(data)], "data")
    )
    store = whole_skeleton(lenient(layout), slim, columns)
    free = [free_scalars(store, entity, frozen) for entity in layout.entities]
    system = build_system(store, free)
    graph = graph_of(store, layout.groups, system)
    if partition_by is not None:
        labels = labels_of(layout, columns, store, system, partition_by)
        parts = by_labels(graph, labels, partition)
    else:
        parts = by_separators(graph, partition or 1)
    count = int(parts.max(initial=0)) + 1
    of_instances = part_of_instances(graph.blocks, parts, count)
    shares = shares_of(store, layout, system, graph, parts, of_instances)
    path = None
    if isinstance(data, str | os.PathLike):
        path = os.path.abspath(data)
    arrays: list[dict[str, NDArray[Any]] | None] = [
        rows_of_share(lenient(layout), columns, share) if path is None else None for share in shares
    ]
    return Prepared(
        compiled,
        slim,
        store,
        system,
        shares,
        _described(shares, parts, of_instances, system),
        path,
        arrays,
        time.perf_counter() - began,
    )


def _described(shares: list[Share], parts: Ints, of_instances: list[Ints], system: System) -> Split:
    sizes = system.sizes
    return Split(
        len(shares),
        np.array([sum(int((of == k).sum()) for of in of_instances) for k in range(len(shares))]),
        np.array([int(sizes[s.blocks[s.interior]].sum()) for s in shares]),
        np.array([int(sizes[s.blocks[s.boundary]].sum()) for s in shares]),
        int(sizes[parts == BOUNDARY].sum()),
        int(sizes.sum()),
    )


def labels_of(layout: Layout, columns: Columns, store: Store, system: System, name: str) -> Ints:
    """(blocks,) label of each block from a column; -1 where its table lacks it.

    Raises
    ------
    AraelError
        E0896: no table of entities has the column, or it holds neither integers nor strings.
    """
    found = np.full(len(system.sizes), -1, dtype=np.int64)
    parts, places = [], []
    names = set(columns.names())
    for entity, blocks in zip(layout.entities, system.blocks, strict=True):
        path = f"{entity.table}.{name}" if entity.table else name
        if path not in names or not entity.table:
            continue
        values = columns.take(lenient(layout), entity.table, path)
        if values.ndim != 1 or values.dtype.kind not in "iuUb":
            continue
        solved = blocks.block >= 0
        parts.append(values[solved].astype(np.str_) if values.dtype.kind == "U" else values[solved])
        places.append(blocks.block[solved])
    if not parts:
        tables = sorted({entity.table for entity in layout.entities if entity.table})
        raise AraelError(
            Diagnostic(
                "E0896",
                f"no collection with parameters has a column `{name}` of integers or strings",
                origin="--partition-by",
                notes=(f"collections with parameters are {', '.join(tables)}",),
                help=("name such a column of the data, or leave `--partition-by` out",),
            )
        )
    kinds = {p.dtype.kind == "U" for p in parts}
    joint = np.concatenate([p.astype(np.str_) if len(kinds) > 1 else p for p in parts])
    found[np.concatenate(places)] = np.unique(joint, return_inverse=True)[1]
    return found


def run(
    prepared: Prepared,
    executor: Executor,
    config: LmConfig | None = None,
    passes: Any = None,
    freeze: Any = (),
    checkpoint: str | os.PathLike[str] | None = None,
    resume: bool = False,
    **settings: Any,
) -> Solved:
    """Solve a prepared problem.

    Parameters
    ----------
    checkpoint : file that is written after each accepted attempt
    resume : go on from that file

    Raises
    ------
    SolveError
        E1001-E1007, as of a solve on one machine.
    AraelError
        E0897 a checkpoint that does not fit; E0898 the cluster is lost.
    """
    layout, store = prepared.compiled.layout, prepared.store
    base = config.with_() if config is not None else LmConfig.of()
    schedule = chosen_passes(layout, passes)
    configs = [base.with_(**{**one.config, **settings}) for one in schedule]
    frozen = held_by(layout, [freeze] if isinstance(freeze, str) else freeze)
    name = uuid4().hex
    start = _stored(prepared.layout, store)
    counts = {path: table.size for path, table in store.tables.items()}
    mark = mark_of(prepared.compiled, start, counts) if checkpoint is not None else ""
    before = read_checkpoint(checkpoint, mark) if resume and checkpoint is not None else None
    if before is not None:
        _store_values(prepared.layout, store, before.base)
    results: list[Result] = []
    traffic = Traffic()
    given: tuple[Any, ...] = ()
    model = executor.ship(prepared.compiled)
    for turn, (one, own) in enumerate(zip(schedule, configs, strict=True)):
        now = frozen_after(layout, frozen, one)
        given += tuple(one.settings)
        if before is not None and turn < before.turn:
            continue
        problem = RemoteProblem(prepared.layout, store, None, structure=empty_structure(store, now))
        sizes = problem.structure.system.sizes
        widths = [entity.stored for entity in layout.entities]
        shares = [
            restricted(share, layout, prepared.system, problem.structure.system)
            for share in prepared.shares
        ]
        recipes = [
            PartRecipe(
                f"{name}-{turn}",
                turn,
                model,
                share,
                prepared.path,
                arrays,
                now,
                given,
                _base(share, problem.states, widths) if turn or before is not None else None,
            )
            for share, arrays in zip(shares, prepared.arrays, strict=True)
        ]
        team = Team(executor, recipes, sizes, widths)
        team.traffic = traffic
        began_at = _stored(prepared.layout, store)
        attempts = 0
        if before is not None and turn == before.turn:
            attempts = before.attempts
            _start_at(prepared.layout, store, problem, before.x)
            own = own.with_(max_iters=max(1, own.max_iters - attempts))
            if own.chosen_strategy() == "damped" and before.damping > 0:
                own = own.with_(initial_lambda=before.damping)
        if checkpoint is not None:
            own = replace(
                own,
                observer=_Saving(
                    checkpoint,
                    mark,
                    turn,
                    attempts,
                    began_at,
                    prepared.layout,
                    problem,
                    own.observer,
                ),
            )
        outcome = solve_pass(problem, team, own, prepared.split)
        problem.write_back()
        results.append(result_of(outcome, one.name))
        if outcome.status in ENDING:
            break
    return Solved(
        joined(results, layout.name),
        prepared.split,
        traffic,
        store,
        problem,
        team,
        prepared.seconds,
    )


def solve_pass(problem: RemoteProblem, team: Team, config: LmConfig, split: Split) -> Any:
    """Run the loop on a problem in parts."""
    guarded = any(one[1] for one in team.describe())
    problem.ask(team, guarded)
    pattern = problem.structure.pattern
    problem.structure.partition[:] = [team.components().partition(pattern)]
    solver = RemoteSolver(pattern, team)
    solver.plan.update(
        solver="parts", n=problem.size, why=str(split), parts=split.parts, boundary=split.between
    )
    try:
        return minimise(problem, config, solver)
    except SolveError as error:
        code = error.diagnostics[0].code
        found = None
        if code in ("E1001", "E1002"):
            found = team.explain(problem.states, derivatives=code == "E1002")
        if found is None:
            raise
        named = SolveError(found)
        named.best = error.best
        raise named from None


def _base(share: Share, states: list[Floats], widths: list[int]) -> Floats:
    found = [np.zeros(0)]
    for state, rows, width in zip(states, share.entity_rows, widths, strict=True):
        found.append(state[rows, :width].ravel())
    return np.concatenate(found)


def _stored(layout: Layout, store: Store) -> Floats:
    """Stored scalars of all rows with parameters, entity by entity."""
    every = [stored_scalars(store, e, np.dtype(np.float64)).ravel() for e in layout.entities]
    return np.concatenate([np.zeros(0), *every])


def _slices(layout: Layout, store: Store, x: Floats) -> list[Floats]:
    found, first = [], 0
    for entity in layout.entities:
        rows = store.tables[entity.table].size
        found.append(x[first : first + rows * entity.stored].reshape(rows, entity.stored))
        first += rows * entity.stored
    return found


def _store_values(layout: Layout, store: Store, x: Floats) -> None:
    """Write stored scalars of all rows, as `_stored` gives them, into the store."""
    for entity, values in zip(layout.entities, _slices(layout, store, x), strict=True):
        table = store.tables[entity.table]
        for use in entity.params:
            column = table.column(use.column)
            mine = values[:, use.stored_start : use.stored_start + use.stored]
            column[...] = mine.reshape(column.shape)


def _start_at(layout: Layout, store: Store, problem: Problem, x: Floats) -> None:
    for number, values in enumerate(_slices(layout, store, x)):
        problem.evaluation.start_at(number, values)


class _Saving:
    """An observer that writes a checkpoint after each accepted attempt."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        mark: str,
        turn: int,
        attempts: int,
        base: Floats,
        layout: Layout,
        problem: Problem,
        other: Any,
    ) -> None:
        self._path, self._mark, self._turn, self._attempts = path, mark, turn, attempts
        self._base, self._layout, self._problem, self._other = base, layout, problem, other

    def __call__(self, record: Any) -> bool | None:
        self._attempts += 1
        if record["accepted"]:
            states = self._problem.states
            x = [
                state[: self._problem.store.tables[e.table].size, : e.stored].ravel()
                for e, state in zip(self._layout.entities, states, strict=True)
            ]
            Checkpoint(
                self._mark,
                self._turn,
                self._attempts,
                float(record["next_damping"]),
                float(record["radius"]),
                float(record["trial_cost"]),
                np.concatenate([np.zeros(0), *x]),
                self._base,
            ).write(self._path)
        return None if self._other is None else self._other(record)
