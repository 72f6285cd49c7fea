"""Rows of a problem by their entries: values, derivatives, products, and their second derivatives.

All arrays of places are computed once per structure. Entries of fixed scalars are left out. A row
may have several entries in one column, where two ways lead to the same parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Group
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Step of the differences of Jacobians, relative to the size of a scalar: the square root of the
# noise of a Jacobian of a few operations, which balances rounding against the third derivative.
DIFFERENCE_STEP = 1e-6


class Rows:
    """Residuals of chosen groups, as rows of one sparse matrix.

    Parameters
    ----------
    problem : whose state they are evaluated at
    groups : numbers of the groups

    Attributes
    ----------
    count : number of rows
    row, column : (entries,) of each entry, by rows
    start : (count + 1,) first entry of each row
    group_of, instance_of, part_of : (count,) what a row belongs to
    """

    def __init__(self, problem: Problem, groups: Sequence[int]) -> None:
        self.problem = problem
        self.groups = tuple(groups)
        size = problem.size
        moves = np.zeros(size + problem.structure.trash, dtype=bool)
        moves[problem.free] = True
        row, column, taken = [], [], []
        group_of, instance_of, part_of = [], [], []
        first_row = first_entry = 0
        for number in self.groups:
            group = problem.layout.groups[number]
            n = len(problem.structure.active[number])
            m, entries = group.residuals, len(group.jacobian)
            instances = np.arange(n)
            group_of.append(np.full(n * m, number))
            instance_of.append(np.repeat(instances, m))
            part_of.append(np.tile(np.arange(m), n))
            if entries and n:
                table = np.array(group.jacobian, dtype=np.int64)
                at = problem.structure.placements[number].gradient_at
                columns = at[:, table[:, 1]] + table[:, 2]
                row.append((first_row + m * instances[:, None] + table[:, 0]).ravel())
                column.append(columns.ravel())
                taken.append(first_entry + np.arange(n * entries))
            first_row += n * m
            first_entry += n * entries
        self.count = first_row
        self.group_of, self.instance_of = _joined(group_of), _joined(instance_of)
        self.part_of = _joined(part_of)
        all_rows, all_columns, all_taken = _joined(row), _joined(column), _joined(taken)
        kept = moves[all_columns]
        all_rows, all_columns, all_taken = all_rows[kept], all_columns[kept], all_taken[kept]
        order = np.argsort(all_rows, kind="stable")
        self.row, self.column, self._taken = (
            all_rows[order],
            all_columns[order],
            all_taken[order],
        )
        self.start = np.searchsorted(self.row, np.arange(self.count + 1))

    def evaluate(self) -> tuple[Floats, Floats]:
        """Values (count,) and entries (entries,) at the accepted state."""
        evaluation = self.problem.evaluation
        found = [evaluation.group_rows(number) for number in self.groups]
        if not found:
            return np.zeros(0), np.zeros(0)
        values = np.concatenate([one[0].ravel() for one in found]).astype(np.float64)
        entries = np.concatenate([one[1].ravel() for one in found])[self._taken]
        return values, entries.astype(np.float64)

    def times(self, entries: Floats, x: Floats) -> Floats:
        """Product with a vector of the system."""
        return _summed(self.row, entries * x[self.column], self.count)

    def transposed(self, entries: Floats, y: Floats) -> Floats:
        """Product of the transposed matrix with a vector of rows."""
        return _summed(self.column, entries * y[self.row], self.problem.size)

    def lengths(self, entries: Floats, scale: Floats) -> Floats:
        """(count,) length of each row, of scalars measured by `scale`."""
        return np.sqrt(np.bincount(self.row, (entries * scale[self.column]) ** 2, self.count))

    def label(self, row: int) -> str:
        """The constraint that a row belongs to."""
        return self.problem.layout.groups[int(self.group_of[row])].label

    def name(self, row: int) -> str:
        """A row's instance: ``Pose.clearance at poses[3]``."""
        group, instance = int(self.group_of[row]), int(self.instance_of[row])
        place = self.problem.instance_place(group, instance)
        label = self.label(row)
        return label if place == self.problem.layout.root else f"{label} at {place}"

    # --- products of entries in the blocks of a system ---------------------------------------

    @cached_property
    def pairs(self) -> tuple[Ints, Ints, Ints]:
        """Entries p and q of each product of a row with itself, and its place in the values.

        Of the lower triangle only; of two entries in one column both orders.
        """
        lengths = np.diff(self.start)
        p = np.repeat(np.arange(len(self.row)), lengths[self.row])
        ends = np.concatenate(([0], np.cumsum(lengths[self.row])))
        q = np.arange(ends[-1]) - np.repeat(ends[:-1], lengths[self.row])
        q += self.start[self.row[p]]
        lower = self.column[p] >= self.column[q]
        p, q = p[lower], q[lower]
        return p, q, self._places(self.column[p], self.column[q])

    def _places(self, high: Ints, low: Ints) -> Ints:
        pattern = self.problem.structure.pattern
        offsets = pattern.offsets
        block_high = np.searchsorted(offsets, high, side="right") - 1
        block_low = np.searchsorted(offsets, low, side="right") - 1
        first = pattern.find(block_high, block_low)
        inner = (high - offsets[block_high]) * pattern.sizes[block_low]
        found: Ints = first + inner + (low - offsets[block_low])
        return found

    def squared(self, entries: Floats, weights: Floats) -> Floats:
        """Values of ``A' W A`` in the blocks of the system; `weights` by rows."""
        p, q, place = self.pairs
        weighted = weights[self.row] * entries
        count = self.problem.structure.pattern.value_count
        return _summed(place, weighted[p] * entries[q], count)

    # --- second derivatives ------------------------------------------------------------------

    @cached_property
    def _colours(self) -> list[tuple[Ints, tuple[Any, ...]]]:
        """Columns that no row reads together, by colour, with what their differences add to."""
        hooks = self.problem.hooks
        curved = np.array(
            [
                is_curved(self.problem.layout.groups[g])
                or (hooks is not None and g in hooks.items)  # by a function of the caller
                for g in self.groups
            ],
            dtype=bool,
        )
        if not curved.any():
            return []
        chosen = np.isin(self.group_of, np.array(self.groups)[curved])[self.row]
        colour = _colour(self.row[chosen], self.column[chosen], self.start, self.problem.size)
        p, q, place = self.pairs
        used = chosen[p]
        p, q, place = p[used], q[used], place[used]
        keys = self.row * self.problem.size + self.column
        _, inverse, times = np.unique(keys, return_inverse=True, return_counts=True)
        share = 1.0 / times[inverse]
        same = self.column[p] == self.column[q]
        found = []
        for k in range(int(colour.max()) + 1):
            columns = np.flatnonzero(colour == k)
            by_p = np.flatnonzero(colour[self.column[p]] == k)
            by_q = np.flatnonzero((colour[self.column[q]] == k) & ~same)
            # The other entry of the pair changes; half of it where both may be moved.
            entry = np.concatenate((q[by_p], p[by_q]))
            moved = np.concatenate((p[by_p], q[by_q]))
            weight = np.where(np.concatenate((same[by_p], np.zeros(len(by_q), bool))), 1.0, 0.5)
            weight = weight * share[moved]
            at = np.concatenate((place[by_p], place[by_q]))
            found.append((columns, (entry, self.column[moved], weight, at)))
        return found

    def curvature(self, weights: Floats, entries: Floats, sizes: Floats, move: Any) -> Floats:
        """Values of the sum of second derivatives of the rows, each times its weight.

        From differences of first derivatives, one evaluation for each colour.

        Parameters
        ----------
        entries : at the accepted state, which is where it is left
        sizes : (n,) of the scalars
        move : context manager ``move(step)`` at the state moved by `step`
        """
        values = np.zeros(self.problem.structure.pattern.value_count)
        for columns, (entry, moved, weight, at) in self._colours:
            step = np.zeros(self.problem.size)
            step[columns] = DIFFERENCE_STEP * sizes[columns]
            with move(step):
                there = self.evaluate()[1]
            slope = (there - entries)[entry] / step[moved]
            values += np.bincount(at, weights[self.row[entry]] * weight * slope, len(values))
        return values

    @property
    def is_curved(self) -> bool:
        """Whether some row is no linear function of plain parameters."""
        return bool(self._colours)


def is_curved(group: Group) -> bool:
    """Whether derivatives of a group depend on parameters."""
    if group.look_ups:  # what they read depends on parameters
        return True
    tape = group.tape
    depends = [False] * len(tape.ops)
    for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op == "input":
            depends[node] = args[0] < len(group.states)
        elif op != "const":
            depends[node] = any(depends[a] for a in args)
    return any(depends[node] for node in tape.outputs[group.residuals :])


def _colour(row: Ints, column: Ints, start: Ints, size: int) -> Ints:
    """(size,) colours of columns such that no row has two of one; -1 for columns without entries.

    Greedy, in order (A. Curtis, M. Powell, J. Reid, IMA J. Applied Math. 13, 1974).
    """
    found = np.full(size, -1, dtype=np.int64)
    rows_of: dict[int, list[int]] = {}
    for r, c in zip(row.tolist(), column.tolist(), strict=True):
        rows_of.setdefault(c, []).append(r)
    taken: dict[int, set[int]] = {}
    for c in sorted(rows_of):
        used: set[int] = set().union(*(taken.get(r, set()) for r in rows_of[c]))
        k = 0
        while k in used:
            k += 1
        found[c] = k
        for r in rows_of[c]:
            taken.setdefault(r, set()).add(k)
    return found


def _summed(places: Ints, values: Floats, count: int) -> Floats:
    return np.bincount(places, values, count).astype(np.float64, copy=False)


def _joined(parts: list[NDArray[Any]]) -> Ints:
    return np.concatenate(parts).astype(np.int64) if parts else np.zeros(0, dtype=np.int64)
