"""All that holds in a solve as one set of rows: those of `require`, then the bounds."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from arael.runtime.assembly.positions import coordinates
from arael.runtime.constrained.rows import Bools, Floats, Ints, Rows
from arael.runtime.constrained.states import States
from arael.runtime.problem import Problem


class Limits:
    """Rows c(x) that are zero (equalities) or not negative (inequalities) at a solution.

    Bounds of parameters are rows with one entry, after those of the model's `require`.

    Parameters
    ----------
    bounds : whether bounds are among the rows

    Attributes
    ----------
    rows : those of `require`
    equal : (count,) whether a row is an equality
    states : of the problem
    bounded, sign, limit : (bounds,) scalar of each bound, 1 for a lower and -1 for an upper one,
        and the limit
    """

    def __init__(self, problem: Problem, bounds: bool = True) -> None:
        self.problem = problem
        self.states = States(problem)
        self.rows = Rows(problem, problem.layout.required)
        scalars, signs, limits, entity, at = [], [], [], [], []
        for one in problem.structure.system.bounded if bounds else ():
            for sign, ends in ((1.0, one.low), (-1.0, one.high)):
                some = np.flatnonzero(np.isfinite(ends))
                scalars.append(one.scalars[some])
                limits.append(ends[some])
                at.append(one.at[some])
                signs.append(np.full(len(some), sign))
                entity.append(np.full(len(some), one.entity))
        self.bounded: Ints = _of(scalars, np.int64)
        self.sign: Floats = _of(signs, np.float64)
        self.limit: Floats = _of(limits, np.float64)
        self._entity, self._at = _of(entity, np.int64), _of(at, np.int64)
        groups = problem.layout.groups
        equal = [groups[int(g)].require == "equal" for g in self.rows.group_of]
        self.equal: Bools = np.zeros(self.count, dtype=bool)
        self.equal[: self.rows.count] = equal

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.rows.count + len(self.bounded)

    def evaluate(self) -> tuple[Floats, Floats]:
        """Values of all rows, and the entries of those of `require`, at the accepted state."""
        values, entries = self.rows.evaluate()
        if not len(self.bounded):
            return values, entries
        states = self.problem.states
        there = np.empty(len(self.bounded))
        for number in set(self._entity.tolist()):
            own = self._entity == number
            there[own] = states[number].reshape(-1)[self._at[own]]
        return np.concatenate((values, self.sign * (there - self.limit))), entries

    def settle(self, multipliers: Floats, tolerance: Floats) -> None:
        """Put scalars that are held by a bound exactly on it."""
        if not len(self.bounded):
            return
        first = self.rows.count
        values, _ = self.evaluate()
        held = (multipliers[first:] > 0.0) & (np.abs(values[first:]) <= tolerance[first:])
        held |= values[first:] < 0.0
        if not held.any():
            return
        saved = self.states.saved()
        widths = [entity.state for entity in self.problem.layout.entities]
        for k in np.flatnonzero(held):
            number = int(self._entity[k])
            row, column = divmod(int(self._at[k]), widths[number])
            saved[number][row, column] = self.limit[k]
        self.states.back(saved)

    def times(self, entries: Floats, x: Floats) -> Floats:
        """Product of the derivatives with a step."""
        found = self.rows.times(entries, x)
        if len(self.bounded):
            found = np.concatenate((found, self.sign * x[self.bounded]))
        return found

    def transposed(self, entries: Floats, y: Floats) -> Floats:
        """Product of the transposed derivatives with a vector of rows."""
        found = self.rows.transposed(entries, y)
        if len(self.bounded):
            np.add.at(found, self.bounded, self.sign * y[self.rows.count :])
        return found

    def lengths(self, entries: Floats, scale: Floats) -> Floats:
        """(count,) lengths of the derivatives of the rows, of scalars measured by `scale`."""
        found = self.rows.lengths(entries, scale)
        return np.concatenate((found, scale[self.bounded])) if len(self.bounded) else found

    def add_squares(
        self, entries: Floats, weights: Floats, values: Floats, diagonal: Floats
    ) -> None:
        """Add ``A' W A`` to the blocks of a system and to its diagonal."""
        more = self.rows.squared(entries, weights[: self.rows.count])
        values += more
        diagonal += more[self.problem.diagonal_at]
        if len(self.bounded):
            np.add.at(diagonal, self.bounded, weights[self.rows.count :])

    @cached_property
    def _lower(self) -> tuple[Ints, Ints, Ints]:
        row, column = coordinates(self.problem.structure.pattern)
        lower = np.flatnonzero(row > column)
        return row[lower], column[lower], lower

    def product(self, values: Floats, diagonal: Floats, x: Floats) -> Floats:
        """Product of a matrix in blocks, its diagonal apart, with a vector."""
        row, column, lower = self._lower
        v, n = values[lower], len(x)
        found: Floats = diagonal * x
        found += np.bincount(row, v * x[column], n)
        found += np.bincount(column, v * x[row], n)
        return found

    def violations(self, values: Floats) -> Floats:
        """(count,) by how much each row is violated, not negative."""
        found: Floats = np.where(self.equal, np.abs(values), np.maximum(0.0, -values))
        return found

    def name(self, row: int) -> str:
        """A row in words: ``Pose.clearance at poses[3]``, ``q.x >= 0``."""
        if row < self.rows.count:
            return self.rows.name(row)
        k = row - self.rows.count
        name = self.problem.structure.system.name_of(int(self.bounded[k]))
        return f"{name} {'>=' if self.sign[k] > 0 else '<='} {self.limit[k]:g}"


def limits_of(problem: Problem) -> Limits:
    """The rows of a problem; those of its last solve, if its structure is the same."""
    known: tuple[Any, Limits] | None = problem.__dict__.get("exact_rows")
    if known is None or known[0] is not problem.structure:
        known = problem.__dict__["exact_rows"] = problem.structure, Limits(problem)
    return known[1]


def _of(parts: list[Any], dtype: Any) -> Any:
    return np.concatenate(parts).astype(dtype) if parts else np.zeros(0, dtype)
