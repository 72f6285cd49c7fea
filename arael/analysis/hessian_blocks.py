"""Blocks of the Hessian: named ones, and those of any two rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Block
from arael.runtime.problem import Problem
from arael.runtime.store.access import Walker
from arael.runtime.system import row_name

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class HessianBlocks:
    """Blocks of the Gauss-Newton Hessian ``2 J'J`` at the current values of a problem, in f64.

    A block is the sum over all constraints that read its parameters. Its rows and columns are the
    tangent scalars of its entities in the order of declaration; fixed ones have zeros. The problem
    is linearised once, in the constructor.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._values = 2.0 * np.asarray(problem.evaluation.linearised()[2], dtype=np.float64)

    def named(self, block: Block, rows: Ints) -> Floats:
        """(n, k, l) the block `block` of some rows of its table.

        Rows of an end that is absent, null or not solved for have zeros.
        """
        problem = self.problem
        walker = Walker(problem.store, block.table, rows)
        ends = [(end.entity, walker.rows(end.slot)) for end in block.ends]
        (a, at), (b, to) = ends[0], ends[-1]
        return self.between(a, at, b, to)

    def between(self, a: int, rows: Ints, b: int, columns: Ints) -> Floats:
        """(n, k, l) blocks of rows of entity `a` with rows of entity `b`; row -1 gives zeros."""
        system, pattern = self.problem.structure.system, self.problem.structure.pattern
        entities = self.problem.layout.entities
        k, m = entities[a].tangent, entities[b].tangent
        found = np.zeros((len(rows), k, m))
        i, j = _at(system.blocks[a].block, rows), _at(system.blocks[b].block, columns)
        known = np.flatnonzero((i >= 0) & (j >= 0))
        low, high = np.minimum(i[known], j[known]), np.maximum(i[known], j[known])
        nb = pattern.block_count
        keys = np.repeat(np.arange(nb), np.diff(pattern.column_start)) * nb + pattern.rows
        place = np.searchsorted(keys, low * nb + high)
        there = place < len(keys)
        there[there] = keys[place[there]] == (low * nb + high)[there]
        known, place = known[there], place[there]
        start = pattern.value_start[place][:, None] + np.arange(k * m)
        values = self._values[start]
        straight = values.reshape(len(known), k, m)
        turned = values.reshape(len(known), m, k).transpose(0, 2, 1)
        found[known] = np.where((i[known] >= j[known])[:, None, None], straight, turned)
        if a == b:  # only the lower triangle of a diagonal block is stored
            same = known[i[known] == j[known]]
            lower = np.tril(found[same])
            found[same] = lower + np.tril(lower, -1).transpose(0, 2, 1)
        found[known] *= system.blocks[a].free[rows[known]][:, :, None]
        found[known] *= system.blocks[b].free[columns[known]][:, None, :]
        return found

    def triplets(self, name: str) -> Any:
        """(n, n) scipy COO array of the pairs assigned to `triplets` of the root.

        Each pair occurs once, in the upper triangle, with the rows and columns of `hessian()`.
        """
        # imported here: start-up time
        from scipy.sparse import coo_array

        problem = self.problem
        structure = problem.structure
        pairs: dict[tuple[int, int], set[tuple[int, int]]] = {}
        for group, placement in zip(problem.layout.groups, structure.placements, strict=True):
            if group.triplets == name:
                for a, b in group.triplet_pairs:
                    rows = placement.rows[:, [a, b]].tolist()
                    ends = group.uses[a].entity, group.uses[b].entity
                    pairs.setdefault(ends, set()).update((i, j) for i, j in rows)
        column_of = np.full(problem.size + 1, -1, dtype=np.int64)
        column_of[problem.free] = np.arange(len(problem.free))
        found: list[tuple[Ints, Ints, Floats]] = []
        for (a, b), rows in pairs.items():
            at, to = np.array(sorted(rows), dtype=np.int64).reshape(-1, 2).T
            values = self.between(a, at, b, to)
            i, j = self._scalars(a, at), self._scalars(b, to)
            i, j = column_of[i][:, :, None], column_of[j][:, None, :]
            i, j = np.broadcast_arrays(i, j)
            kept = (i >= 0) & (j >= 0)
            found.append((np.minimum(i, j)[kept], np.maximum(i, j)[kept], values[kept]))
        parts = [np.concatenate([f[k] for f in found]) if found else np.zeros(0) for k in range(3)]
        n = len(problem.free)
        return coo_array((parts[2], (parts[0].astype(int), parts[1].astype(int))), shape=(n, n))

    def _scalars(self, entity: int, rows: Ints) -> Ints:
        """(n, k) scalars of the system, or the system size for a row that is not solved for."""
        first = _at(self.problem.structure.system.blocks[entity].first, rows)[:, None]
        every = first + np.arange(self.problem.layout.entities[entity].tangent)
        return np.where(first >= 0, every, self.problem.size)

    def entities_of(self, table: str) -> list[int]:
        """Entities in the rows of a table, that of the row itself first."""
        entities = self.problem.layout.entities
        found = [number for number, e in enumerate(entities) if e.table == table]
        if not found:
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{table or self.problem.layout.root}` has no parameters, so it has no block "
                    "of the Hessian",
                    origin="hessian_block",
                )
            )
        return sorted(found, key=lambda number: entities[number].prefix != "")

    def of_rows(self, a: tuple[str, int], b: tuple[str, int]) -> Floats:
        """(k, l) block of two rows, (path of the table, row) each; for all scalars in the rows."""
        parts = [
            [
                self.between(e, np.array([a[1]]), f, np.array([b[1]]))[0]
                for f in self.entities_of(b[0])
            ]
            for e in self.entities_of(a[0])
        ]
        return np.block(parts)

    def name(self, row: tuple[str, int]) -> str:
        """Name of a row for messages."""
        return row_name(self.problem.store, *row) or self.problem.layout.root


def _at(numbers: Ints, rows: Ints) -> Ints:
    """`numbers` of some rows, -1 for row -1."""
    if len(numbers) == 0:
        return np.full(len(rows), -1, dtype=np.int64)
    return np.where(rows >= 0, numbers[rows], -1)
