"""Copies of unknowns that very many equations read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]

#: An unknown of more equations has copies, each for so many of them.
MANY, EACH = 64, 16


def with_copies(
    n: int, indptr: Ints, indices: Ints
) -> tuple[Ints, Ints, Ints, NDArray[np.float64]]:
    """Pattern in which no unknown is read by very many equations.

    All equations of an unknown would be neighbours, and R as good as full. Instead the unknown is
    split ("stretched", J. Grcar, "Matrix stretching for linear equations", 1990) into copies
    x_1 ... x_k, each for some of its equations, with equations x_i = x_(i + 1). If every copy is
    taken times sqrt(k), lengths of vectors with equal copies, and so projections, stay what they
    are.

    Returns
    -------
    indptr, indices : the pattern with copies and their equations behind the others
    origin : (n + copies,) unknown of each copy
    share : (n + copies,) square root of the number of copies of the unknown
    """
    counts = np.bincount(indices, minlength=n)
    many = np.flatnonzero(counts > MANY)
    places = indices.copy()
    origins, pairs = [np.arange(n)], [np.empty(0)]
    share = np.ones(n)
    added = n
    for u in many.tolist():
        at = np.flatnonzero(indices == u)
        piece = np.arange(len(at)) // EACH
        copies = int(piece[-1])
        numbers = np.concatenate([[u], np.arange(added, added + copies)])
        places[at] = numbers[piece]
        origins.append(np.full(copies, u))
        pairs.append(np.column_stack([numbers[:-1], numbers[1:]]).ravel())
        share[u] = np.sqrt(copies + 1)
        added += copies
    origin = np.concatenate(origins).astype(np.int32)
    rows = indptr[-1] + 2 * np.arange(1, added - n + 1)
    return (
        np.concatenate([indptr, rows]).astype(np.int32),
        np.concatenate([places, *pairs]).astype(np.int32),
        origin,
        share[origin],
    )
