"""Symbolic analysis of a system of rows: components, elimination order, pattern of the factor."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from arael.runtime.assembly.union_find import connected
from arael.runtime.levels.elimination_tree import factor_pattern
from arael.runtime.linear.minimum_degree import minimum_degree

Ints = NDArray[np.int32]


class Structure(NamedTuple):
    """What depends on the pattern alone; rows stand at *positions*, component by component.

    Attributes
    ----------
    row_of : (K,) row at each position
    start, unknown, source : entries of each position, and where they are among those of the rows
    column_start, column_position, column_entry : the same by unknown, positions ascending
    component_start : (C + 1,) positions of each component
    unknown_start, unknown_list : unknowns of each component
    component_of : (n,) component of each unknown, -1 if no row has it
    factor_start, factor_row : columns of L below the diagonal
    pattern_start, pattern_column : rows of L left of the diagonal, ascending
    """

    row_of: Ints
    start: Ints
    unknown: Ints
    source: Ints
    column_start: Ints
    column_position: Ints
    column_entry: Ints
    component_start: Ints
    unknown_start: Ints
    unknown_list: Ints
    component_of: Ints
    factor_start: Ints
    factor_row: Ints
    pattern_start: Ints
    pattern_column: Ints


def offsets(counts: Any) -> Ints:
    """Where each of some runs begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def analyse(
    n: int,
    indptr: Ints,
    indices: Ints,
    free: NDArray[np.bool_],
    active: NDArray[np.bool_],
    links: tuple[Ints, Ints] | None = None,
) -> Structure:
    """Analyse the rows that are `active` (m,) in the unknowns that are `free` (n,).

    `links` is the pattern of functions whose unknowns must be in one component, too: guards.
    """
    m = len(indptr) - 1
    counts = np.diff(indptr)
    rows = np.repeat(np.arange(m), counts)
    source = np.flatnonzero(active[rows] & free[indices])
    rows, unknowns = rows[source], indices[source].astype(np.int64)
    # Rows are the first nodes of a bipartite graph; unknowns follow, then links.
    ends, starts, others = m + unknowns, np.zeros(0, np.int64), np.zeros(0, np.int64)
    size = m + n
    if links is not None:
        linked = np.repeat(np.arange(len(links[0]) - 1), np.diff(links[0]))
        usable = free[links[1]]
        starts, others = size + linked[usable], m + links[1][usable].astype(np.int64)
        size += len(links[0]) - 1
    of_row = np.full(size + 1, len(ends), dtype=np.int64)
    of_row[: m + 1] = offsets(np.bincount(rows, minlength=m))
    label = connected(of_row, ends, starts, others, np.zeros(size, np.uint8))[1]
    taken = np.flatnonzero(active)
    order = elimination_order(m, n, rows, unknowns, taken)
    # Components in the order of their first row, so that renumbered unknowns change nothing.
    _, first, inverse = np.unique(label[taken], return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    component = np.full(m + n, -1)
    component[taken] = rank[inverse]
    order = order[np.argsort(component[order], kind="stable")]
    position = np.full(m, -1)
    position[order] = np.arange(len(order))

    by_position = np.argsort(position[rows], kind="stable")
    own = position[rows[by_position]]
    unknown, source = unknowns[by_position], source[by_position]
    by_unknown = np.argsort(unknown, kind="stable")
    of_unknown = np.full(n, -1)
    of_unknown[unknown] = component[order[own]]
    listed = np.argsort(of_unknown, kind="stable")[np.count_nonzero(of_unknown < 0) :]
    parts = len(first)
    start = offsets(np.bincount(own, minlength=len(order)))
    column_start = offsets(np.bincount(unknown, minlength=n))
    column_position = own[by_unknown].astype(np.int32)
    return Structure(
        order.astype(np.int32),
        start,
        unknown.astype(np.int32),
        source.astype(np.int32),
        column_start,
        column_position,
        by_unknown.astype(np.int32),
        offsets(np.bincount(component[order], minlength=parts)),
        offsets(np.bincount(of_unknown[listed], minlength=parts)),
        listed.astype(np.int32),
        of_unknown.astype(np.int32),
        *factor_pattern(start, unknown.astype(np.int32), column_start, column_position),
    )


def elimination_order(m: int, n: int, rows: Any, unknowns: Any, taken: Any) -> NDArray[np.int64]:
    """Rows that are `taken`, in an order with little fill in the factor of J J'."""
    if not len(taken):
        return np.zeros(0, dtype=np.int64)
    slot = np.full(m, -1)
    slot[taken] = np.arange(len(taken))
    shape = (len(taken), n)
    matrix = csr_array((np.ones(len(rows), np.int64), (slot[rows], unknowns)), shape=shape)
    normal = (matrix @ matrix.T).tocsr()
    normal.setdiag(0)
    normal.eliminate_zeros()
    start = normal.indptr.astype(np.int64)
    weights = np.ones(len(taken), dtype=np.int64)
    order = minimum_degree(start, normal.indices.astype(np.int64), weights)
    return np.asarray(taken[order], dtype=np.int64)
