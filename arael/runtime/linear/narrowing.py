"""What is left of a problem when most of its components have ended.

A component that has ended is out of all passes over vectors and lanes, but its rows stay in the
arrays: in the factorisation as rows of the identity, in the move to the trial state with a step of
zero. When that has been done in vain often enough, the loop narrows: solver, states, totals and
bounds are restricted to the components that are left.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.compiled import LinearSolver

if TYPE_CHECKING:
    from arael.runtime.assembly.components import Partition
    from arael.runtime.linear.compiled import RemainingSolver

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: A loop narrows when it has passed over so many scalars in vain since it last did: a constant, and
#: a multiple of those that remain. Each takes about 20 ns an attempt; to narrow takes 2 ms, and
#: 0.2 us for each that remains. So it never takes longer than what was lost before. Counted, not
#: measured, so that a solve has the same bits each time.
CONSTANT, MULTIPLE = 100_000, 10

_NEVER = 2**62


def limits(whole: LinearSolver) -> tuple[int, int]:
    """`CONSTANT` and `MULTIPLE`, such as never to narrow a problem in parts.

    Its parts leave out components that have ended, and are asked no more when all of theirs have.
    """
    return (_NEVER, 0) if whole.plan.get("solver") == "parts" else (CONSTANT, MULTIPLE)


def remaining_solver(whole: LinearSolver, partition: Partition, kept: Bools) -> RemainingSolver:
    """A solver of the same kind as `whole` for some components.

    Parameters
    ----------
    whole : LinearSolver
    partition : Partition
    kept : (count,) bool, the components that are solved for
    """
    # Imported here for start-up time: most solves are never narrowed.
    from arael.runtime.linear.compiled import RemainingSolver

    pattern = whole.pattern
    blocks = kept[partition.of_block]
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    # A block in which nothing moves may be coupled with one of another component.
    entries = np.flatnonzero(blocks[columns] & blocks[pattern.rows])
    number = np.cumsum(blocks) - 1
    sizes = pattern.sizes[blocks]
    lengths = pattern.sizes[columns[entries]] * pattern.sizes[pattern.rows[entries]]
    begin = pattern.value_start[entries]
    order = np.argsort(begin, kind="stable")
    place = np.empty(len(entries), dtype=np.int64)
    place[order] = np.cumsum(lengths[order]) - lengths[order]
    counts = np.bincount(number[columns[entries]], minlength=len(sizes))
    part = BlockPattern(
        sizes,
        np.concatenate(([0], np.cumsum(counts))).astype(np.int64),
        number[pattern.rows[entries]],
        place,
    )
    inner = _same_kind(whole, part)
    inner.use_threads(whole.threads)
    scalars = _runs(pattern.offsets[:-1][blocks], sizes)
    return RemainingSolver(pattern, inner, scalars, _runs(begin[order], lengths[order]))


def _same_kind(whole: LinearSolver, part: BlockPattern) -> LinearSolver:
    # Imported here for start-up time: most solves are never narrowed.
    from arael.runtime.linear.auto import make_solver
    from arael.runtime.linear.compiled import BandSolver, DenseSolver
    from arael.runtime.linear.small import SMALL

    name = whole.plan["solver"]
    if name == "dense" or part.size <= SMALL:
        return DenseSolver(part, whole.single)
    if name == "band":
        # Without the analysis that compares solvers.
        return BandSolver(part, whole.single)
    options = {"ordering": "minimum_degree"} if name == "sparse" else {}
    return make_solver(name, part, whole.single, **options)


def _runs(begin: Ints, lengths: Ints) -> Ints:
    """(m, 3) begin in the whole, begin in the part, and length of runs without a gap."""
    first = np.ones(len(begin), dtype=bool)
    first[1:] = begin[1:] != begin[:-1] + lengths[:-1]
    at = np.flatnonzero(first)
    place = np.cumsum(lengths) - lengths
    ends = np.append(place[at[1:]], lengths.sum())
    return np.ascontiguousarray(np.stack((begin[at], place[at], ends - place[at]), axis=1))
