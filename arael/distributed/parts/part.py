"""One part: its constraints at given states, and the elimination of its interior.

With the interior i and the boundary b of the part, A = J'J of its rows:

    S = A_bb - A_bi A_ii^-1 A_ib,    r = -A_bi A_ii^-1 g_i,    x_i = A_ii^-1 (g_i - A_ib x_b)

S may be singular, since other parts hold the boundary too. So not A is factorised but

    M = A + D,   D_bb = diag(A_bb) (1 where that is 0),   D_ii: the damping,

with b last in the order of elimination. Its Cholesky factor L contains that of S + D_bb, which is
well conditioned: L_bb L_bb' = S + D_bb. D_bb is of the size of what S was computed from, so that
its subtraction loses no more digits than the elimination itself. The sweeps with M are those of the
part: L y = (g_i, 0) forward has r = L_bb y_b, and L' x = (y_i, L_bb' x_b) backward has the wanted
x_i. So a step takes one sweep forward and one backward, as on one machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.distributed.parts.shares import Share
from arael.runtime.assembly.components import Partition, any_partition_of
from arael.runtime.assembly.positions import row_and_column_positions
from arael.runtime.assembly.structure import Structure, structure_of_chosen
from arael.runtime.evaluation.compiled import ComponentLanes
from arael.runtime.layout import Layout
from arael.runtime.levenberg.compiled import curvature_of
from arael.runtime.linear.analysis import analyse_order
from arael.runtime.linear.compiled import SparseSolver
from arael.runtime.linear.planning import adjacency, minimum_degree
from arael.runtime.problem import Problem
from arael.runtime.store import Store, Table

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Reduced:
    """What a part contributes to the boundary system.

    Attributes
    ----------
    matrix : (b, b) S
    right : (b,) r
    """

    matrix: Floats
    right: Floats


class PartProblem(Problem):
    """A problem whose messages name rows as the whole data set numbers them."""

    share: Share

    def instance_name(self, group: int, instance: int) -> str:
        """Name of an instance of a constraint: ``PointFrine.bearing[17]``."""
        one = self.layout.groups[group]
        row = self.share.rows[one.table][self.structure.active[group][instance]]
        return f"{one.label}[{row}]"


def number_as_whole(store: Store, share: Share) -> None:
    """Let the rows of a part have the names that they have in the whole data set."""
    for path, table in store.tables.items():
        if path:
            table.row_name = partial(_row_name, table, share)  # type: ignore[method-assign]
            table.row_names = partial(_row_names, table, share)  # type: ignore[method-assign]


def _row_name(table: Table, share: Share, row: int) -> str:
    if not table.layout.parent:
        return f"{table.layout.path}[{share.rows[table.layout.path][row]}]"
    owner = table.parent.row_name(int(table.parent_rows()[row]))
    return f"{owner}.{table.layout.field}[{share.places[table.layout.path][row]}]"


def _row_names(table: Table, share: Share, rows: Ints) -> list[str]:
    return [_row_name(table, share, int(row)) for row in rows]


class Part:
    """One part of a problem.

    Parameters
    ----------
    layout : the model, with refs that may be null (`shares.lenient`)
    store : the rows of the part
    kernels : of the model, or None
    frozen : paths of parameters that do not move
    """

    def __init__(
        self,
        layout: Layout,
        store: Store,
        kernels: Any,
        share: Share,
        frozen: frozenset[str] = frozenset(),
    ) -> None:
        self.share = share
        self.structure = structure_of_chosen(store, share.active, frozen)
        self.problem = PartProblem(layout, store, kernels, structure=self.structure)
        self.problem.share = share
        system = self.structure.system
        self.solved = [blocks.first >= 0 for blocks in system.blocks]
        self.widths = [entity.stored for entity in layout.entities]
        scalar_block = np.repeat(np.arange(len(system.sizes)), system.sizes)
        self.interior = np.flatnonzero(share.interior[scalar_block])
        self.boundary = np.flatnonzero(share.boundary[scalar_block])
        self.idle = np.flatnonzero(~(share.interior | share.boundary)[scalar_block])
        self._workspace = self.problem.evaluation.workspace()
        self._partition: Partition | None = None
        self._chosen: tuple[Bools, ComponentLanes] | None = None
        self._solver: SparseSolver | None = None
        self._values: Floats = np.zeros(0)
        self._diagonal: Floats = np.zeros(0)
        self._corner: list[tuple[Any, ...]] = []
        self._held: tuple[Ints, Ints] = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
        self._factor: Floats = np.zeros((0, 0))  # L_bb
        self._swept_at: Ints = np.zeros(0, dtype=np.int64)  # places of y_b in the solver's memory

    # --- states ------------------------------------------------------------------------------

    def move_to(self, x: Floats) -> None:
        """Let the rows that are solved for have the stored scalars `x`, entity by entity."""
        first = 0
        states = self.problem.states
        for number, (solved, width) in enumerate(zip(self.solved, self.widths, strict=True)):
            rows = len(solved)
            count = int(solved.sum()) * width
            values = states[number][:rows, :width].copy()
            values[solved] = x[first : first + count].reshape(-1, width)
            self.problem.evaluation.start_at(number, values)
            first += count

    def cost(self) -> float:
        """Sum of squared residuals at the present states; guards are evaluated there."""
        return self.problem.cost()

    @property
    def partition(self) -> Partition:
        """Connected components of what this part evaluates."""
        if self._partition is None:
            share = self.share
            idle = (~(share.interior | share.boundary)).astype(np.uint8)
            groups = self.problem.layout.groups
            self._partition = any_partition_of(self.structure, groups, idle)
        return self._partition

    def costs(self, active: Bools) -> Floats:
        """(components + 1,) sum of squared residuals of each component of `partition`.

        Those that are not active may lack some. The last is of instances that read nothing that is
        solved for.
        """
        return self.problem.evaluation.component_costs(self._lanes(active))

    def _lanes(self, active: Bools) -> ComponentLanes:
        """The lanes of the active components (components + 1,); those before are narrowed."""
        known = self._chosen
        if known is None or (active & ~known[0]).any():
            known = np.ones_like(active), self.problem.evaluation.component_lanes(self.partition)
        if not np.array_equal(active, known[0]):
            known[1].keep(active)
        self._chosen = active, known[1]
        return known[1]

    def linearise(self, active: Bools | None = None) -> tuple[float, Floats, Floats]:
        """Cost, J'r and the diagonal of J'J at the present states, (n,) each.

        With `active` (components + 1,) what belongs to other components is 0, and so is the cost.
        """
        lanes = None if active is None else self._lanes(active)
        cost, gradient, values = self.problem.evaluation.linearised(self._workspace, lanes)
        self._values = values
        self.gradient = np.array(gradient)
        self._diagonal = np.array(values[self.problem.diagonal_at])
        if active is None:
            return float(cost), self.gradient, self._diagonal
        ended = ~active[self.partition.of_scalar]
        self.gradient[ended] = self._diagonal[ended] = 0
        return 0.0, self.gradient, self._diagonal

    def curvature(self, step: Floats, apart: bool = False) -> Floats:
        """``step' H step`` with the present linearisation: (1,), or `apart` (components,)."""
        partition = self.partition if apart else None
        return curvature_of(self.problem.box, self._values, step, partition)

    # --- elimination -------------------------------------------------------------------------

    @property
    def solver(self) -> SparseSolver:
        """The linear solver, with the boundary last in its order."""
        if self._solver is None:
            pattern = self.structure.pattern
            late = np.flatnonzero(self.share.boundary)
            early = np.flatnonzero(~self.share.boundary)
            order = _order_with_last(pattern, early, late)
            analysis = analyse_order(pattern, "boundary last", order)
            self._solver = SparseSolver(pattern, analysis=analysis)
            place = np.full(pattern.size, -1, dtype=np.int64)
            place[self.boundary] = np.arange(len(self.boundary))
            self._corner = _fronts_of(self._solver, place)
            self._swept_at = _places_of_sweeps(self._corner, len(self.boundary))
        return self._solver

    def eliminate(self, damped: Floats, right: Floats, held: Ints | None = None) -> int:
        """Factorise with the damped diagonal (interior,), and sweep as `sweep` does.

        Parameters
        ----------
        held : scalars of the part that stand at a bound: their rows and columns are left out

        Returns
        -------
        0, or 1 + the scalar that failed
        """
        own, system = self._diagonal, self._values
        if held is not None and len(held):
            own, system = own.copy(), system.copy()
            own[held] = 0
            system[self._positions_of(held)] = 0
        shift = np.where(own[self.boundary] > 0, own[self.boundary], 1.0)
        diagonal = np.ones(len(own))
        diagonal[self.interior] = damped
        diagonal[self.boundary] = own[self.boundary] + shift
        failed = self.solver.factor_forward(system, diagonal, self._whole(right))
        if failed:
            return int(failed)
        self._factor = self._factor_of_boundary()
        self._shift = shift
        return 0

    def _positions_of(self, held: Ints) -> Ints:
        """Values of J'J in the rows and columns of some scalars; kept, since few factors differ."""
        if not np.array_equal(held, self._held[0]):
            pattern = self.structure.pattern
            self._held = held, np.asarray(row_and_column_positions(pattern, held)[1])
        return self._held[1]

    def complement(self) -> Floats:
        """(b, b) S of the last factor."""
        matrix = self._factor @ self._factor.T
        matrix[np.diag_indices_from(matrix)] -= self._shift
        return np.asarray(matrix)

    def sweep(self, right: Floats) -> None:
        """Sweep forward over the interior, with the right-hand side (interior,)."""
        self.solver.forward(self._whole(right))

    def swept(self) -> Floats:
        """(b,) r: what the last sweep adds to the right-hand side of the boundary."""
        return np.asarray(self._factor @ self.solver.parts()[1][self._swept_at])

    def substituted(self, boundary: Floats) -> Floats:
        """(interior,) solution of the last sweep, from that of the boundary (b,).

        What `swept` reads is overwritten.
        """
        self.solver.parts()[1][self._swept_at] = self._factor.T @ boundary
        return np.asarray(self.solver.backward()[self.interior])

    def _whole(self, right: Floats) -> Floats:
        whole = np.zeros(self.structure.system.size)
        whole[self.interior] = right
        return whole

    def _factor_of_boundary(self) -> Floats:
        """(b, b) columns and rows of the boundary of the factor, in the order of the boundary."""
        size = len(self.boundary)
        found = np.zeros((size, size))
        storage = self.solver.parts()[1]
        for k, at, tall, panel, low, count, inner, rows in self._corner:
            triangle = np.tril(storage[at : at + k * tall].reshape(k, tall)[:, :k].T)
            # Columns of the interior in the same front come before.
            own = inner >= 0
            found[np.ix_(inner[own], inner[own])] = triangle[np.ix_(own, own)]
            if count:
                below = storage[panel : panel + k * low].reshape(k, low)[:, :count].T
                found[np.ix_(rows, inner[own])] = below[:, own]
        return found


def _order_with_last(pattern: Any, early: Ints, late: Ints) -> Ints:
    """The blocks `early` by minimum degree while the others stay, then the blocks `late`."""
    start, neighbours = adjacency(pattern)
    both = np.concatenate((early, late))
    local = np.empty(len(both), dtype=np.int64)
    local[both] = np.arange(len(both))
    length = np.diff(start)[both]
    first = np.repeat(start[both] - (np.cumsum(length) - length), length)
    to = local[neighbours[first + np.arange(int(length.sum()))]]
    part_start = np.concatenate(([0], np.cumsum(length))).astype(np.int64)
    weights = np.maximum(pattern.sizes[both], 1)
    order = minimum_degree(part_start, to, weights, staying=len(late))
    return np.concatenate((both[order], late))


def _fronts_of(solver: SparseSolver, place: Ints) -> list[tuple[Any, ...]]:
    """The fronts with columns of the boundary; `place` is that of a scalar there, -1 outside."""
    table, _, _, strips, scalar = solver.parts()
    ends = table[:, 14]
    found = []
    for s in range(1, len(table)):
        k, count, tall, low, first, at, panel = (int(x) for x in table[s, :7])
        inner = place[scalar[first : first + k]]
        if not (inner >= 0).any():
            continue
        rows = np.concatenate(
            [np.zeros(0, dtype=np.int64)]
            + [np.arange(a, a + n) for a, n in strips[ends[s - 1] : ends[s]].tolist()]
        )
        found.append((k, at, tall, panel, low, count, inner, place[scalar[rows]]))
    return found


def _places_of_sweeps(fronts: list[tuple[Any, ...]], size: int) -> Ints:
    """(size,) where `SparseSolver.forward` leaves y of the boundary: behind the rows of panels."""
    found = np.zeros(size, dtype=np.int64)
    for k, _, _, panel, low, count, inner, _ in fronts:
        own = inner >= 0
        found[inner[own]] = (panel + count + low * np.arange(k))[own]
    return found


def empty_structure(store: Store, frozen: frozenset[str]) -> Structure:
    """The structure of a store without constraints: only the system."""
    found = structure_of_chosen(store, (), frozen)
    found.partition.append(None)  # the parts know its components
    return found
