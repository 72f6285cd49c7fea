"""Choice of the dependent equations by priority."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.components import graph_components
from arael.runtime.orthogonal.exchange import reduce_by_priority

#: Equations and their scaled factors.
Combination = tuple[NDArray[np.int32], NDArray[np.float64]]

#: Scaled multipliers up to this part of the largest are not exchanged: the equations that
#: remained would be worse conditioned by the inverse of it.
LEAST = 1e-8

#: Multipliers up to this part of the largest are rounding errors.
NEGLIGIBLE = 1e-10


@dataclass
class Settled:
    """Dependent equations and their dependencies, all scaled."""

    dependent: NDArray[np.int32]
    rows: dict[int, Combination]
    #: Of `rows`, the equations that have a pivot in the factor.
    swapped: dict[int, Combination] = field(default_factory=dict)


def settle(
    found: list[tuple[int, NDArray[np.int32], NDArray[np.float64]]], priority: NDArray[np.int32]
) -> Settled:
    """Exchange dependent equations with less important ones that they depend on.

    Parameters
    ----------
    found : equation without a pivot, equations with a pivot, their scaled factors
        -1 instead of an equation: the sum of the others is zero
    priority : (m,) int32, the largest number is the least important; then the later equation
    """
    rows: dict[int, Combination] = {}
    for group in _groups(found):
        if any(_improves(item, priority) for item in group):
            rows.update(_exchanged(group, priority))
        else:
            rows.update({i: (equations, factors) for i, equations, factors in group})
    without = {i for i, _, _ in found}
    return Settled(
        np.array(sorted(rows), dtype=np.int32),
        rows,
        {i: row for i, row in rows.items() if i not in without},
    )


def _improves(
    item: tuple[int, NDArray[np.int32], NDArray[np.float64]], priority: NDArray[np.int32]
) -> bool:
    """Whether a dependent equation is more important than one that it depends on."""
    i, equations, factors = item
    if i < 0:
        return True
    used = equations[np.abs(factors) > LEAST * np.max(np.abs(factors), initial=0.0)]
    theirs = priority[used]
    return bool(np.any((theirs > priority[i]) | ((theirs == priority[i]) & (used > i))))


def _groups(
    found: list[tuple[int, NDArray[np.int32], NDArray[np.float64]]],
) -> list[list[tuple[int, NDArray[np.int32], NDArray[np.float64]]]]:
    """Dependencies that have equations in common, directly or through others."""
    used = [equations for _, equations, _ in found]
    ends = np.concatenate([np.zeros(0, dtype=np.int64), *used])
    owners = np.repeat(np.arange(len(found)), [len(equations) for equations in used])
    nodes = len(found) + int(ends.max(initial=-1)) + 1
    labels = graph_components(nodes, owners, len(found) + ends)
    groups: dict[int, list[tuple[int, NDArray[np.int32], NDArray[np.float64]]]] = {}
    for k, item in enumerate(found):
        groups.setdefault(int(labels[k]), []).append(item)
    return list(groups.values())


def _exchanged(
    group: list[tuple[int, NDArray[np.int32], NDArray[np.float64]]], priority: NDArray[np.int32]
) -> dict[int, Combination]:
    """Dependencies of the least important equations of a group."""
    own = [i for i, _, _ in group if i >= 0]
    used = np.unique(np.concatenate([own, *(item[1] for item in group)])).astype(np.int32)
    columns = used[np.lexsort((used, priority[used]))][::-1].astype(np.int32)
    place = np.empty(int(used[-1]) + 1, dtype=np.int32)
    place[columns] = np.arange(len(columns))
    table: list[Combination] = []
    for i, equations, factors in group:
        if i >= 0:
            equations, factors = np.append(equations, i), np.append(factors, -1.0)
        at = place[equations]
        order = np.argsort(at)
        table.append((at[order], factors[order]))
    rows: dict[int, Combination] = {}
    for pivot, at, row in reduce_by_priority(table, len(columns), LEAST):
        kept = (np.abs(row) > NEGLIGIBLE * np.abs(row[at != pivot]).max(initial=0.0)) & (
            at != pivot
        )
        equations = columns[at[kept]]
        order = np.argsort(equations)
        rows[int(columns[pivot])] = (equations[order], row[kept][order])
    return rows
