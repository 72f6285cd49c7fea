"""Results of the connected components of a problem."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.components import Partition
from arael.runtime.levenberg.compiled import STATUSES
from arael.runtime.problem import Problem
from arael.runtime.system import row_name, row_names
from arael.statuses import CONVERGED

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_NAMES = np.array(STATUSES)
_SOLVED = np.array([status in CONVERGED for status in STATUSES])


@dataclass(frozen=True)
class ComponentOutcome:
    """Result of one component; fields as those of `Components`."""

    name: str
    rows: int
    status: str
    iterations: int
    accepted_iterations: int
    start_cost: float
    end_cost: float
    predicted_decrease: float


@dataclass(frozen=True, eq=False)
class Components:
    """Results of the connected components of a problem, as columns of one table.

    Components are numbered in the order in which the model lists their first rows. Indexing and
    iterating give `ComponentOutcome`.

    Attributes
    ----------
    rows : (n,) rows that each component consists of, as far as they are solved for
    iterations : (n,) attempts at a step, rejected ones counted
    accepted_iterations : (n,) steps taken
    start_cost, end_cost : (n,) sums of squared residuals of each
    predicted_decrease : (n,) as `Result.predicted_decrease`; NaN where there was no step
    """

    rows: Ints
    iterations: Ints
    accepted_iterations: Ints
    start_cost: Floats
    end_cost: Floats
    predicted_decrease: Floats
    _codes: Ints
    _name: Callable[[int], str] = field(repr=False)
    _all_names: Callable[[], list[str]] = field(repr=False)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, k: int) -> ComponentOutcome:
        k = range(len(self))[k]
        return ComponentOutcome(
            self.name(k),
            int(self.rows[k]),
            STATUSES[self._codes[k]],
            int(self.iterations[k]),
            int(self.accepted_iterations[k]),
            float(self.start_cost[k]),
            float(self.end_cost[k]),
            float(self.predicted_decrease[k]),
        )

    def __iter__(self) -> Iterator[ComponentOutcome]:
        return (self[k] for k in range(len(self)))

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """(n,) how each ended; see `Result.status`."""
        return _NAMES[self._codes]

    @cached_property
    def converged(self) -> NDArray[np.bool_]:
        """(n,) whether each is solved."""
        return _SOLVED[self._codes]

    def name(self, k: int) -> str:
        """Name of the first row of a component, ``epochs[17]``."""
        return self._name(k)

    @cached_property
    def names(self) -> list[str]:
        """Names of the first rows of all components."""
        return self._all_names()

    def counts(self) -> dict[str, int]:
        """Components by status, the most frequent first."""
        found = np.bincount(self._codes, minlength=len(STATUSES))
        return dict(
            Counter({s: int(n) for s, n in zip(STATUSES, found, strict=True) if n}).most_common()
        )

    def summary(self, most: int = 3) -> str:
        """``997 of 1000 components converged; epochs[17]: max_iterations``."""
        solved = int(self.converged.sum())
        line = f"{solved} of {len(self)} components converged"
        others = np.flatnonzero(~self.converged)
        if len(others):
            shown = [f"{self.name(int(k))}: {STATUSES[self._codes[k]]}" for k in others[:most]]
            if len(others) > most:
                shown.append(f"{len(others) - most} more")
            line += "; " + ", ".join(shown)
        return line

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: columns as lists."""
        return {
            "count": len(self),
            "statuses": self.counts(),
            "name": self.names,
            "rows": self.rows.tolist(),
            "status": self.status.tolist(),
            "iterations": self.iterations.tolist(),
            "accepted_iterations": self.accepted_iterations.tolist(),
            "start_cost": _numbers(self.start_cost),
            "end_cost": _numbers(self.end_cost),
            "predicted_decrease": _numbers(self.predicted_decrease),
        }


def components_of(problem: Problem, partition: Partition, ended: NDArray[Any]) -> Components:
    """The table of a solve.

    Parameters
    ----------
    ended : (count,) structured array, `Minimiser.components`
    """
    system, layout, store = problem.structure.system, problem.layout, problem.store

    @cache
    def rows() -> tuple[Ints, Ints]:
        """Entity and row of each block; only made where a name is asked for."""
        solved = [np.flatnonzero(blocks.first >= 0) for blocks in system.blocks]
        entities = np.repeat(np.arange(len(solved)), [len(found) for found in solved])
        return entities, np.concatenate(solved)

    def name(k: int) -> str:
        entities, numbers = rows()
        block = partition.first_block[k]
        table = layout.entities[entities[block]].table
        return row_name(store, table, int(numbers[block])) or layout.root

    def names() -> list[str]:
        entities, numbers = (array[partition.first_block] for array in rows())
        found = np.empty(len(entities), dtype=object)
        for entity in np.unique(entities):
            mine = np.flatnonzero(entities == entity)
            table = layout.entities[entity].table
            found[mine] = [one or layout.root for one in row_names(store, table, numbers[mine])]
        return list(found)

    return Components(
        partition.block_counts,
        ended["iterations"].copy(),
        ended["accepted"].copy(),
        ended["start_cost"].copy(),
        ended["end_cost"].copy(),
        ended["predicted_decrease"].copy(),
        ended["status"].copy(),
        name,
        names,
    )


def _numbers(values: Floats) -> list[float | None]:
    """Numbers, with None for those that JSON has no form for."""
    found: list[float | None] = values.tolist()
    for k in np.flatnonzero(~np.isfinite(values)):
        found[k] = None
    return found
