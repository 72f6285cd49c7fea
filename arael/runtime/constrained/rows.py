"""The rows of a problem that hold exactly, with names: those of `require`, then the bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.constrained.compiled import RowTable
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class Rows(RowTable):
    """Rows c(x) of a problem: equalities are zero, inequalities not negative at a solution.

    Bounds of parameters are rows with one entry, after those of the groups.

    Parameters
    ----------
    groups : their numbers; None: those of `require`
    bounds : whether bounds of parameters are among the rows

    Attributes
    ----------
    multipliers : (count,) of half of the cost, at the end of the last solve
    """

    multipliers: Floats

    def __init__(
        self, problem: Problem, groups: Sequence[int] | None = None, bounds: bool = True
    ) -> None:
        self.problem = problem
        layout = problem.layout
        self.groups = layout.required if groups is None else tuple(groups)
        hooks = problem.hooks
        described = []
        for number in self.groups:
            group = layout.groups[number]
            by_function = hooks is not None and number in hooks.items
            described.append(
                (
                    number,
                    group.residuals,
                    group.jacobian_table,
                    group.require == "equal",
                    by_function or group.is_curved,
                )
            )
        super().__init__(
            problem.evaluation,
            problem.structure,
            described,
            _bounds(problem) if bounds else (_NONE,) * 5,
        )

    @cached_property
    def group_of(self) -> Ints:
        """(group rows,) number of the group of each row."""
        return np.repeat(self.groups, self._lengths)

    @cached_property
    def instance_of(self) -> Ints:
        """(group rows,) instance of each row."""
        parts = [
            np.repeat(np.arange(len(self.problem.structure.active[n])), self._residuals(n))
            for n in self.groups
        ]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)

    @cached_property
    def _cost_rows(self) -> Rows:
        groups = [n for n, group in enumerate(self.problem.layout.groups) if not group.require]
        return Rows(self.problem, groups, bounds=False)

    def residuals(self) -> Rows:
        """The rows of the cost, for their second derivatives."""
        return self._cost_rows

    @property
    def _lengths(self) -> list[int]:
        return [len(self.problem.structure.active[n]) * self._residuals(n) for n in self.groups]

    def _residuals(self, number: int) -> int:
        return self.problem.layout.groups[number].residuals

    def name(self, row: int) -> str:
        """A row in words: ``Pose.clearance at poses[3]``, ``q.x >= 0``."""
        problem = self.problem
        if row >= self.group_rows:
            scalar, _, _, sign, limit = (each[row - self.group_rows] for each in _bounds(problem))
            name = problem.structure.system.name_of(int(scalar))
            return f"{name} {'>=' if sign > 0 else '<='} {limit:g}"
        number = int(self.group_of[row])
        label = problem.layout.groups[number].label
        place = problem.instance_place(number, int(self.instance_of[row]))
        return label if place == problem.layout.root else f"{label} at {place}"

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The rows by label, with the names of their instances in order."""
        problem = self.problem
        groups = problem.layout.groups
        ends = np.concatenate(([0], np.cumsum(self._lengths))).astype(np.int64)
        # A constraint with sums over rows, or of a struct in several places, has several groups.
        by_label: dict[str, list[int]] = {}
        for k, number in enumerate(self.groups):
            by_label.setdefault(groups[number].label, []).append(k)
        found = []
        for label, positions in by_label.items():
            group = groups[self.groups[positions[0]]]
            places = [
                (groups[self.groups[k]].table, int(row), problem.instance_place(self.groups[k], i))
                for k in positions
                for i, row in enumerate(problem.structure.active[self.groups[k]])
            ]
            order = sorted(range(len(places)), key=lambda k: places[k][:2])
            rows = np.concatenate([np.arange(ends[k], ends[k + 1]) for k in positions])
            found.append(
                Part(
                    label,
                    group.require_text,
                    tuple(places[k][2] for k in order),
                    rows.reshape(-1, group.residuals)[order],
                    group.units,
                    group.require == "equal",
                )
            )
        return tuple(found)


@dataclass(frozen=True, eq=False)
class Part:
    """The rows of one `require`, as `arael.runtime.constrained.required.Requirement`.

    Attributes
    ----------
    rows : (n, m) their numbers
    """

    label: str
    text: str
    places: tuple[str, ...]
    rows: Ints
    units: tuple[str, ...]
    equal: bool


_NONE = np.zeros(0)


def _bounds(problem: Problem) -> tuple[Any, ...]:
    """Scalar, entity, offset in its states, sign and limit of each finite bound, (bounds,) each.

    The sign is 1 for a lower bound, and -1 for an upper one.
    """
    found = [
        (one.scalars[some], np.full(len(some), one.entity), one.at[some], sign, ends[some])
        for one in problem.structure.system.bounded
        for sign, ends in ((1.0, one.low), (-1.0, one.high))
        if len(some := np.flatnonzero(np.isfinite(ends)))
    ]
    if not found:
        return (_NONE,) * 5
    scalars, entities, at, signs, limits = zip(*found, strict=True)
    lengths = [len(one) for one in scalars]
    joined = [np.concatenate(parts) for parts in (scalars, entities, at, limits)]
    return (*joined[:3], np.repeat(signs, lengths), joined[3])


def rows_of(problem: Problem) -> Rows:
    """The rows of a problem; those of its last solve, if its structure is the same."""
    known: tuple[Any, Rows] | None = problem.__dict__.get("exact_rows")
    if known is None or known[0] is not problem.structure:
        known = problem.__dict__["exact_rows"] = problem.structure, Rows(problem)
    return known[1]
