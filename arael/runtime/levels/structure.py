"""Symbolic analysis of a system of rows: components, elimination order, pattern of the factor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.planning import arranged, factor_pattern, neighbours
from arael.runtime.linear.planning import minimum_degree

Ints = NDArray[np.int32]


#: An order is kept while there are at most so many times the rows that it was found for, and so
#: many times the entries of L per entry of the rows.
_GROWN = 2


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
    ordered : rows, entries and entries of L when an order with little fill was last looked for
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
    ordered: tuple[int, int, int]


def analyse(
    n: int,
    indptr: Ints,
    indices: Ints,
    free: NDArray[np.bool_],
    active: NDArray[np.bool_],
    links: tuple[Ints, Ints] | None = None,
    earlier: Structure | None = None,
) -> Structure:
    """Analyse the rows that are `active` (m,) in the unknowns that are `free` (n,).

    Parameters
    ----------
    links : pattern of functions whose unknowns must be in one component, too: guards
    earlier : of the system before rows were added or taken out: its order of elimination is kept,
        with new rows at the end, while L does not fill up
    """
    moves = np.ascontiguousarray(free).view(np.uint8)
    if earlier is not None:
        order = _continued(earlier.row_of, active)
        rows, entries, most = earlier.ordered
        if len(order) <= _GROWN * rows:
            found = _structure(n, indptr, indices, moves, order, links, earlier.ordered)
            if len(found.factor_row) * entries <= _GROWN * most * len(found.unknown):
                return found
    order = elimination_order(n, indptr, indices, moves, active)
    return _structure(n, indptr, indices, moves, order, links, None)


def _structure(
    n: int,
    indptr: Ints,
    indices: Ints,
    free: NDArray[np.uint8],
    order: NDArray[np.int64],
    links: tuple[Ints, Ints] | None,
    ordered: tuple[int, int, int] | None,
) -> Structure:
    found = arranged(n, indptr, indices, free, order, links)
    _, start, unknown, _, column_start, column_position, *_ = found
    factor = factor_pattern(start, unknown, column_start, column_position)
    if ordered is None:
        ordered = (len(order), len(unknown), len(factor[1]))
    return Structure._make([*found, *factor, ordered])


def _continued(order: Ints, active: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The rows of an order that are still active, then the other active ones."""
    kept = order[order < len(active)]
    kept = kept[active[kept]]
    new = np.array(active)
    new[kept] = False
    return np.concatenate([kept.astype(np.int64), np.flatnonzero(new)])


def elimination_order(
    n: int, indptr: Ints, indices: Ints, free: NDArray[np.uint8], active: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Active rows, in an order with little fill in the factor of J J'."""
    taken = np.flatnonzero(active)
    if not len(taken):
        return taken
    start, others = neighbours(n, indptr, indices, free, taken.astype(np.int32))
    order = minimum_degree(start, others, np.ones(len(taken), dtype=np.int64))
    return np.asarray(taken[order], dtype=np.int64)
