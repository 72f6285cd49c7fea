"""The scatter plan: which instances are active, and where their contributions are added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import add_counts
from arael.runtime.assembly.invariants import check_pattern, check_placements
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement, pattern_and_placements
from arael.runtime.assembly.positions import diagonal_positions, row_and_column_positions
from arael.runtime.assembly.share_invariants import check_shares
from arael.runtime.assembly.shares import Execution, Shares, plan_shares
from arael.runtime.compiled import read_only
from arael.runtime.layout import Entity, Group, Layout
from arael.runtime.store.access import Ints
from arael.runtime.system import System


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class ScatterPlan:
    """Where the contributions of every active instance go. All arrays are read-only.

    It depends on rows, references, guards over data and on which rows are solved for; not on
    values, held scalars or the number of threads. Evaluation takes `shares_for`, linear solvers
    take `pattern`, and the Jacobian takes `placements`.

    Attributes
    ----------
    groups, entities : of the layout
    active : per group (n,) int64, its active instances as rows of its table, ascending
    pattern : the blocks of the lower triangle of J'J
    placements : per group, offsets of its active instances, in the order of `active`
    trash : scalars behind the gradient for what is not solved for; its square behind the values
    behind : how often leads stand behind what they are coupled with, less how often before; the
        values lie by rows if it is positive
    """

    groups: tuple[Group, ...]
    entities: tuple[Entity, ...]
    active: tuple[Ints, ...]
    pattern: BlockPattern
    placements: tuple[Placement, ...]
    trash: int
    behind: int
    _shares: dict[Execution, Shares] = field(default_factory=dict, compare=False, repr=False)
    _diagonal_at: Ints | None = field(default=None, compare=False, repr=False)
    _counts: NDArray[np.int32] | None = field(default=None, compare=False, repr=False)

    @property
    def diagonal_at(self) -> Ints:
        """(size,) int64, offset of each diagonal scalar in the values."""
        if self._diagonal_at is None:
            self._diagonal_at = diagonal_positions(self.pattern)
            read_only(self._diagonal_at)
        return self._diagonal_at

    @property
    def counts(self) -> NDArray[np.int32]:
        """How often instances add to each block off the diagonal, by its place in the values."""
        if self._counts is None:
            nowhere = self.pattern.value_count
            self._counts = np.zeros(nowhere + 1, dtype=np.int32)
            for one in self.placements:
                add_counts(self._counts, one.block_at, one.turn, nowhere, 1)
        return self._counts

    def take_counts(self) -> NDArray[np.int32]:
        """`counts`, for a caller who changes them: this plan counts again if it is asked again."""
        counts, self._counts = self.counts, None
        return counts

    def values_of(self, scalars: Ints) -> Ints:
        """Offsets of all values in the rows and columns of some scalars, without the diagonal."""
        return row_and_column_positions(self.pattern, scalars)[1]

    @property
    def shares(self) -> tuple[Shares, ...]:
        """What `shares_for` has computed."""
        return tuple(self._shares.values())

    def shares_for(self, execution: Execution) -> Shares:
        """The same plan in lane order, split into shares; computed once for each execution.

        The split follows from problem and machine, never from the number of threads of a solve, so
        that sums have the same bits on any number of threads.
        """
        found = self._shares.get(execution)
        if found is None:
            found = self._shares[execution] = plan_shares(
                self.groups, self.entities, self.pattern, self.placements, self.trash, execution
            )
        return found

    def check(self) -> None:
        """Raise `BrokenPlan` unless all invariants hold; see `invariants.py`, which lists them."""
        check_pattern(self.pattern)
        check_placements(
            self.groups, self.entities, self.active, self.pattern, self.placements, self.trash
        )
        for execution, shares in self._shares.items():
            check_shares(
                self.groups,
                self.entities,
                self.pattern,
                self.placements,
                self.trash,
                execution,
                shares,
            )


def scatter_plan(
    layout: Layout,
    slot_rows: Sequence[list[Ints]],
    active: Sequence[Ints],
    system: System,
    known: ScatterPlan | None = None,
) -> ScatterPlan:
    """Compute the plan of the active instances of a model.

    Parameters
    ----------
    slot_rows : per group, the row of each slot of its active instances
    active : per group, its active rows, ascending
    system : the order of blocks and scalars
    known : an earlier plan for the same system; its pattern is kept if it has the same blocks
    """
    before = None if known is None else known.pattern
    pattern, placements, behind = pattern_and_placements(
        layout.groups, layout.coupled, slot_rows, active, system, before
    )
    read_only(*active, pattern.sizes, pattern.column_start, pattern.rows, pattern.value_start)
    for p in placements:
        read_only(*p.in_order())
    trash = max((entity.tangent for entity in layout.entities), default=1)
    return ScatterPlan(
        tuple(layout.groups),
        tuple(layout.entities),
        tuple(active),
        pattern,
        tuple(placements),
        trash,
        behind,
        _diagonal_at=known._diagonal_at if known is not None and known.pattern is pattern else None,
    )


__all__ = ["Execution", "ScatterPlan", "Shares", "scatter_plan"]
