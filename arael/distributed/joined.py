"""Small problems of one model as one instance, which consists of independent components.

The rows of the problems follow each other; refs are shifted. The solver gives each connected
component its own damping, acceptance and end (`arael.runtime.assembly.components`), so that each
problem ends as it does alone, to rounding. What all rows share, the data of the root, must be the
same, and nothing that is solved for may belong to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.config import SMALL as OTHER_END
from arael.io import npz
from arael.io.columns import presence_name
from arael.io.npz_writer import arrays_of
from arael.result import Result
from arael.runtime.assembly.components import partition_of
from arael.runtime.layout import Group, Layout
from arael.runtime.levenberg.outcomes import Components
from arael.runtime.linear.small import SMALL
from arael.statuses import ENDING

Arrays = dict[str, NDArray[Any]]
Ints = NDArray[np.int64]


class Apart(Exception):
    """Problems cannot be solved as one instance; the text is the reason, for the report."""


def why_not(layout: Layout, options: dict[str, Any]) -> str:
    """Why problems of a model are never joined, "" if they may be."""
    tables = {table.path: table for table in layout.tables}
    root = tables[""]
    if layout.precision != "f64":
        return "it is in f32"
    if any(entity.table == "" for entity in layout.entities):
        return "the root has parameters"
    if any(column.role == "ref" for column in root.columns):
        return "the root has refs"
    if any(entity.updated for entity in layout.entities):
        return "components have updates"
    if options.get("solver", "auto") not in ("auto", "dense", "band", "sparse"):
        return f"solver={options['solver']!r} is asked for"
    if options.get("solver_options"):
        return "options of the linear solver are given"
    for group in layout.groups:
        why = _shared(group)
        if why:
            return f"constraint `{group.constraint}` {why}"
    for table in layout.tables:
        for column in table.columns:
            target = column.target
            if target is None or not tables[target.table].parent:
                continue
            if any(step.kind not in ("ref", "parent") for step in target.base):
                return f"the refs `{column.path}` lead to rows of one owner for all"
    return ""


def _shared(group: Group) -> str:
    """What a constraint reads of all rows together."""
    if group.table == "":
        return "belongs to the root"
    if group.triplets or group.index_column:
        return "numbers its instances"
    if group.moving_guard is not None:
        return "has a guard over parameters"
    if group.look_ups:
        return "looks rows up"
    for slot in group.slots:
        kinds = [step.kind for step in slot.steps]
        if "root" in kinds[:-1]:
            return "reads rows of a list of the root by number"
    owners = [one.owner for one in group.totals]
    owners += [group.slots[one.slot].table for one in group.lengths]
    if group.row_sums is not None:
        owners += [group.row_sums.slots[owner].table for owner, _ in group.row_sums.lists]
    return "reads all rows of a list of the root" if "" in owners else ""


@dataclass(frozen=True)
class Batch:
    """Problems as one instance.

    Attributes
    ----------
    model : the instance
    first : per outer collection (problems + 1,) row at which each problem begins
    counts : per table, rows of each problem
    orders : per problem and table, its rows in the order in which they are in the instance
    """

    model: Any
    first: dict[str, Ints]
    counts: dict[str, list[int]]
    orders: list[dict[str, Ints]]

    def owner(self, name: str) -> tuple[int, str]:
        """Problem of the row or scalar with a name in the instance, and its name there."""
        path, _, rest = name.partition("[")
        number, _, rest = rest.partition("]")
        row = int(number)
        problem = int(np.searchsorted(self.first[path], row, side="right")) - 1
        return problem, f"{path}[{row - self.first[path][problem]}]{rest}"

    def by_owner(self, names: Sequence[str], values: Sequence[Any]) -> list[dict[str, Any]]:
        """Numbers of each problem by their names there."""
        found: list[dict[str, Any]] = [{} for _ in self.orders]
        for name, value in zip(names, values, strict=True):
            problem, own = self.owner(name)
            found[problem][own] = value
        return found

    def put_back(self, models: Sequence[Any]) -> None:
        """Set the parameters of each problem, and the data of the root that passes set."""
        store = self.model._store
        for path, counts in self.counts.items():
            table = store.tables[path]
            ends = np.concatenate(([0], np.cumsum(counts)))
            for leaf in table.fields.leaves():
                if leaf.column.role != "param":
                    continue
                values = table.column(leaf.path)
                for number, model in enumerate(models):
                    rows = self.orders[number][path]
                    mine = values[ends[number] : ends[number + 1]]
                    model._store.tables[path].writable(leaf.path)[rows] = mine
        root = store.tables[""]
        for one in store.layout.passes:
            for setting in one.settings:
                for model in models:
                    model._store.tables[""].writable(setting.column)[0] = root.column(
                        setting.column
                    )[0]


def alike(models: Sequence[Any]) -> list[list[int]]:
    """Numbers of the problems that can be joined with each other, in the order of the first."""
    found: dict[Any, list[int]] = {}
    for number, model in enumerate(models):
        root = model._store.tables[""]
        shared = tuple(
            (path, repr(np.asarray(root.column(path)).tolist())) for path in root.data
        ) + tuple((path, bool(root.column(f"{path}?")[0])) for path in root.optionals)
        found.setdefault(shared, []).append(number)
    return list(found.values())


def join(kind: Any, models: Sequence[Any]) -> Batch:
    """One instance of the data of several, which stay as they are.

    Raises
    ------
    Apart
        Only some have bounds, or flags of components, of their own.
    AraelError
        As for writing the data of each.
    """
    layout: Layout = kind.layout
    orders: list[dict[str, Ints]] = [{} for _ in models]
    pieces = [
        dict(arrays_of(model._store, order)) for model, order in zip(models, orders, strict=True)
    ]
    counts = {
        table.path: [len(order[table.path]) for order in orders]
        for table in layout.tables
        if table.path
    }
    first = {
        path: np.concatenate(([0], np.cumsum(counts[path]))).astype(np.int64) for path in counts
    }
    shifted = _refs(layout)
    joined: Arrays = {}
    root = models[0]._store.tables[""]
    of_root = {*root.data, *(presence_name(root, path) for path in root.optionals)}
    offsets = {f"{table.path}.offsets" for table in layout.tables if table.parent}
    for name in dict.fromkeys(name for piece in pieces for name in piece):
        if name in of_root or name.rpartition(".")[0] in of_root:
            joined[name] = pieces[0][name]
            continue
        if name in offsets:
            joined[name] = _offsets([piece[name] for piece in pieces])
            continue
        one = next(piece[name] for piece in pieces if name in piece)
        if not one.ndim:  # the number of rows of a table without columns
            joined[name] = np.array(sum(int(piece[name]) for piece in pieces))
            continue
        arrays = [
            piece[name] if name in piece else _absent(name, piece, pieces) for piece in pieces
        ]
        if len({one.shape[1:] for one in arrays}) > 1:
            raise Apart("only some have flags of their own for components of a parameter")
        if name in shifted:
            begin = first[shifted[name]]
            arrays = [np.where(a >= 0, a + begin[k], a) for k, a in enumerate(arrays)]
        joined[name] = np.concatenate(arrays)
    model = kind()
    npz.adopt(model._store, joined, "group")
    outer = {t.path: first[t.path] for t in layout.tables if t.path and not t.parent}
    return Batch(model, outer, counts, orders)


def _refs(layout: Layout) -> dict[str, str]:
    """Arrays of refs that count the rows of an outer collection, with its path."""
    outer = {table.path for table in layout.tables if not table.parent}
    found = {}
    for table in layout.tables:
        lists = {held.path for held in table.values if held.refs}
        for column in table.columns:
            if column.target is None or column.target.table not in outer:
                continue
            path = column.path.rpartition(".")[0]
            name = path if path in lists else column.path
            found[f"{table.path}.{name}"] = column.target.table
    return found


def _offsets(pieces: list[Ints]) -> Ints:
    found, total = [np.zeros(1, dtype=np.int64)], 0
    for piece in pieces:
        found.append(piece[1:] + total)
        total += int(piece[-1])
    return np.concatenate(found)


def _absent(name: str, piece: Arrays, pieces: list[Arrays]) -> NDArray[Any]:
    """Flags of parameters none of which is fixed, which are not written."""
    like = next(one[name] for one in pieces if name in one)
    column = name.rpartition(".")[0]
    if not name.endswith(".fixed") or column not in piece:
        raise Apart(f"only some have `{name}`")
    return np.zeros((len(piece[column]), *like.shape[1:]), dtype=np.bool_)


@dataclass(frozen=True)
class Ended:
    """What became of one problem of a batch."""

    status: str
    statuses: tuple[str, ...]
    cost: float
    iterations: int


def solve(batch: Batch, options: dict[str, Any], time_limit: float | None) -> list[Ended]:
    """Solve the instance of a batch; the outcome of each problem.

    Raises
    ------
    Apart
        The problems are not one component each, or are not small, or the solve ended as a whole.
    AraelError
        As `arael.Model.solve`.
    """
    model, count = batch.model, len(batch.orders)
    problem = model._problem()
    partition = partition_of(problem.structure, problem.layout.groups)
    if partition is None or partition.count != count:
        raise Apart("not each is one connected problem")
    if any((of == partition.count).any() for of in partition.of_instance):
        raise Apart("some constraints read nothing that is solved for")
    sizes = np.bincount(partition.of_scalar)
    if sizes.max() > SMALL or (sizes.min() <= OTHER_END < sizes.max()):
        raise Apart(f"they have {sizes.min()} to {sizes.max()} unknowns")
    limit = None if time_limit is None else time_limit * count
    result: Result = model.solve(time_limit=limit, **{**options, "solver": "sparse"})
    passes = result.passes or (result,)
    table = [_of_pass(batch, one) for one in passes]
    found = []
    for number in range(count):
        mine = [one[of[number]] for one, of in table]
        found.append(
            Ended(
                mine[-1].status,
                tuple(one.status for one in mine),
                mine[-1].end_cost,
                sum(one.iterations for one in mine),
            )
        )
    return found


def _of_pass(batch: Batch, result: Result) -> tuple[Components, Ints]:
    """The components of a pass, and (problems,) which of them each problem is."""
    if result.status in ENDING:
        raise Apart(f"the solve ended as a whole: {result.status}")
    components = result.components
    if components is None or len(components) != len(batch.orders):
        raise Apart("not each is one connected problem in every pass")
    owners = [batch.owner(name)[0] for name in components.names]
    if sorted(owners) != list(range(len(owners))):
        raise Apart("not each is one connected problem in every pass")
    return components, np.argsort(owners).astype(np.int64)
