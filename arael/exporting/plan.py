"""What is fixed when a solver is exported: rows, blocks, the pattern of J'J and of its factor."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.exporting.c_functions import ConstraintFunction, Functions
from arael.model import Model
from arael.runtime.linear.planning import minimum_degree
from arael.solving import problem_of

# Index tables of so many scalars have some megabytes; beyond, a plan that is made when the program
# runs is the better choice.
MAX_SCALARS = 20_000

MAX_ROWS = 1_000_000


@dataclass(frozen=True)
class Plan:
    """Rows and blocks of a solver.

    Blocks are in the order of elimination.

    Attributes
    ----------
    rows : by table, the most rows it may have
    first_row : by number of the entity in the layout, the number of its first row among all rows of
        all entities
    position : block of each entity row
    sizes, first : scalars of each block, and the first of them in the system
    column_start, block_row, value_start : lower triangle of the factor by block columns, the
        diagonal first, rows ascending
    values : scalars of all blocks
    update : for each pair of rows of each column, in turn, offset of the block that it changes
    flops : operations of a factorisation and of a substitution
    """

    rows: dict[str, int]
    first_row: dict[int, int]
    position: list[int]
    sizes: list[int]
    first: list[int]
    column_start: list[int]
    block_row: list[int]
    value_start: list[int]
    values: int
    update: list[int]
    flops: int

    @property
    def scalars(self) -> int:
        """Scalars that are solved for, fixed ones included."""
        return sum(self.sizes)


def plan_of(functions: Functions, sizes: Mapping[str, int], model: Model | None) -> Plan:
    """Plan a solver.

    Parameters
    ----------
    functions : of the model
    sizes : rows of collections by path; those of `model` where it is left out
    model : whose rows, and whose refs if `sizes` is empty, the solver is for

    Raises
    ------
    AraelError
        E1503: a size is missing, wrong or too large, or a constraint needs what has no fixed size.
    """
    rows = _rows(functions, sizes, model)
    first_row, total, owner = {}, 0, []
    for one in functions.used:
        first_row[one.number] = total
        count = rows[one.entity.table]
        owner += [one.entity.tangent] * count
        total += count
    scalars = sum(owner)
    if scalars > MAX_SCALARS:
        raise _error(
            f"the solver would have {scalars} scalars, more than {MAX_SCALARS}",
            "a problem of this size is solved with index tables made at run time, as arael does",
        )
    if not scalars:
        raise _error("no constraint reads a parameter", "leave out --size")
    exact = model is not None and not sizes
    pairs: set[tuple[int, int]] = set()
    for function in functions.constraints:
        if exact:
            assert model is not None
            pairs |= _pairs_of_data(functions, function, first_row, model)
        else:
            pairs |= _all_pairs(functions, function, first_row, rows)
    return _factor(rows, first_row, owner, pairs)


def _rows(functions: Functions, sizes: Mapping[str, int], model: Model | None) -> dict[str, int]:
    collections = [table.path for table in functions.layout.tables if table.path]
    for name, size in sizes.items():
        if name not in collections:
            near = closest(name, collections)
            hint = f"did you mean `{near[0]}`?" if near else f"there are {', '.join(collections)}"
            raise _error(f"there is no collection `{name}`", hint)
        if not 1 <= size <= MAX_ROWS:
            raise _error(
                f"`{name}` has {size} rows, expected at least 1 and at most {MAX_ROWS}",
                f"write {name}=10",
            )
    needed = {""}
    for function in functions.constraints:
        group = function.group
        if group.totals:
            raise _error(
                f"`{group.label}` sums over a collection, which a solver of fixed size does not do",
                "leave the constraint out with --constraint, or export without --size",
            )
        needed |= {group.table, *(slot.table for slot in group.slots)}
    rows = {"": 1}
    for path in (p for p in collections if p in needed):
        if path in sizes:
            rows[path] = sizes[path]
        elif model is not None:
            rows[path] = max(model._store.tables[path].size, 1)
        else:
            raise _error(
                f"the size of `{path}` is missing",
                f"write --size {','.join(f'{p}=10' for p in collections if p in needed)}, or give "
                "a data file",
            )
    return rows


def _all_pairs(
    functions: Functions,
    function: ConstraintFunction,
    first_row: Mapping[int, int],
    rows: Mapping[str, int],
) -> set[tuple[int, int]]:
    """Pairs of entity rows that refs of any value may couple."""
    places = [
        range(first_row[one.number], first_row[one.number] + rows[one.entity.table])
        for one in function.sets
    ]
    found: set[tuple[int, int]] = set()
    for a in range(len(places)):
        for b in range(a):
            found |= {(i, j) for i, j in product(places[a], places[b]) if i != j}
    return found


def _pairs_of_data(
    functions: Functions,
    function: ConstraintFunction,
    first_row: Mapping[int, int],
    model: Model,
) -> set[tuple[int, int]]:
    structure = problem_of(model).structure
    group = function.group
    numbers = {(g.label, g.table, g.prefix): n for n, g in enumerate(functions.layout.groups)}
    slots = structure.slot_rows[numbers[group.label, group.table, group.prefix]]
    ways = [
        first_row[one.number] + np.asarray(slots[use.slot])
        for use, one in zip(group.uses, function.sets, strict=True)
    ]
    found: set[tuple[int, int]] = set()
    for a in range(len(ways)):
        for b in range(a):
            found |= {(int(i), int(j)) for i, j in zip(ways[a], ways[b], strict=True) if i != j}
    return found


def _factor(
    rows: dict[str, int],
    first_row: dict[int, int],
    sizes: list[int],
    pairs: Iterable[tuple[int, int]],
) -> Plan:
    """Order the blocks by minimum degree, and find the pattern of the factor."""
    count = len(sizes)
    beside: list[set[int]] = [set() for _ in range(count)]
    for a, b in pairs:
        beside[a].add(b)
        beside[b].add(a)
    start = np.cumsum([0, *map(len, beside)]).astype(np.int64)
    neighbours = np.array([j for one in beside for j in sorted(one)], dtype=np.int64)
    order = [int(k) for k in minimum_degree(start, neighbours, np.array(sizes, dtype=np.int64))]
    position = [0] * count
    for place, row in enumerate(order):
        position[row] = place
    below: list[set[int]] = [
        {position[j] for j in beside[row] if position[j] > place} for place, row in enumerate(order)
    ]
    for column in range(count):  # what is below in a column is coupled once it is eliminated
        if below[column]:
            parent = min(below[column])
            below[parent] |= below[column] - {parent}
    ordered = [sizes[row] for row in order]
    column_start, block_row, value_start, at = [0], [], [], 0
    offsets: dict[tuple[int, int], int] = {}
    for column in range(count):
        for row in (column, *sorted(below[column])):
            offsets[row, column] = at
            block_row.append(row)
            value_start.append(at)
            at += ordered[row] * ordered[column]
        column_start.append(len(block_row))
    update, flops = [], 0
    for column in range(count):
        under, n = sorted(below[column]), ordered[column]
        flops += n**3 // 3 + sum(ordered[r] for r in under) * n * (n + 4)
        for q, j in enumerate(under):
            for i in under[q:]:
                update.append(offsets[i, j])
                flops += 2 * ordered[i] * ordered[j] * n
    first = [0, *np.cumsum(ordered).tolist()][:-1]
    return Plan(
        rows, first_row, position, ordered, first, column_start, block_row, value_start, at,
        update, flops,
    )  # fmt: skip


def _error(message: str, help: str) -> AraelError:
    return AraelError(Diagnostic("E1503", message, help=(help,)))
