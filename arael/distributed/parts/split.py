"""Which part each entity is of: by separators of the graph, or by a column of the data.

Entities of a *boundary* separate the parts: no instance reads the interiors of two of them. With
the interiors first, J'J is

    [ A_1            B_1 ]
    [      ...       ... ]        S = C - sum_p B_p' A_p^-1 B_p
    [           A_k  B_k ]
    [ B_1' ...  B_k' C   ]

and S, the Schur complement of all interiors, is the sum of what each part contributes
(substructuring; A. George, "Nested dissection of a regular finite element mesh", 1973; W. Gropp and
D. Keyes, "Domain decomposition on parallel computers", 1989).
"""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from arael.distributed.parts.graph import Graph
from arael.runtime.linear.dissection import apart
from arael.runtime.linear.separators import find_separator

Ints = NDArray[np.int64]

BOUNDARY = -1

# A separator with a larger part of the vertices that it splits is none.
_THIN = 3


def by_separators(graph: Graph, parts: int) -> Ints:
    """(n,) part of each vertex, `BOUNDARY` for separators; there may be fewer parts than asked for.

    The heaviest part is split until there are enough. Vertices that are joined with nearly all
    others, such as parameters of the root, are in the boundary.
    """
    found = np.full(graph.size, BOUNDARY, dtype=np.int64)
    sparse, _ = apart(graph.start)
    local = np.full(graph.size, -1, dtype=np.int64)
    whole: list[Ints] = []
    heap = [(-int(graph.weights[sparse].sum()), 0, sparse)]
    number = 1
    while heap and len(heap) + len(whole) < parts:
        _, _, vertices = heapq.heappop(heap)
        left, right = _halves(graph, vertices, local)
        if not (len(left) and len(right)):
            whole.append(vertices)
            continue
        for side in (left, right):
            heapq.heappush(heap, (-int(graph.weights[side].sum()), number, side))
            number += 1
    groups = sorted((*whole, *(one[2] for one in heap)), key=lambda v: int(v[0]) if len(v) else 0)
    for part, vertices in enumerate(groups):
        found[vertices] = part
    return with_inner_boundary(graph, found)


def _halves(graph: Graph, vertices: Ints, local: Ints) -> tuple[Ints, Ints]:
    """Both sides of a separator of some vertices; of them all and none if it is not thin."""
    local[vertices] = np.arange(len(vertices))
    start, inside = _subgraph(graph, vertices, local)
    local[vertices] = -1
    # By scalars, as those of the boundary count; a camera is read by more instances than a point.
    side = find_separator(start, inside, np.maximum(graph.sizes[vertices], 1))
    left, right, between = (vertices[side == k] for k in range(3))
    if _THIN * len(between) > len(vertices):
        return vertices, vertices[:0]
    return left, right


def _subgraph(graph: Graph, vertices: Ints, local: Ints) -> tuple[Ints, Ints]:
    length = graph.start[vertices + 1] - graph.start[vertices]
    first = np.repeat(graph.start[vertices] - (np.cumsum(length) - length), length)
    to = local[graph.neighbours[first + np.arange(int(length.sum()))]]
    owner = np.repeat(np.arange(len(vertices)), length)[to >= 0]
    start = np.searchsorted(owner, np.arange(len(vertices) + 1)).astype(np.int64)
    return start, to[to >= 0]


def by_labels(graph: Graph, labels: Ints, parts: int | None = None) -> Ints:
    """(n,) part of each vertex from labels of the data, `BOUNDARY` between different ones.

    Parameters
    ----------
    labels : (n,) label of each vertex, 0 and up; -1: that of most neighbours with one
    parts : most parts; neighbouring labels share one. By default each label is a part.
    """
    known = _spread(graph, labels.copy())
    distinct, known = np.unique(known, return_inverse=True)
    if parts is not None and parts < len(distinct):
        weight = np.bincount(known, graph.weights)
        before = np.cumsum(weight) - weight / 2
        known = np.minimum((before * parts / weight.sum()).astype(np.int64), parts - 1)[known]
    owner = np.repeat(np.arange(graph.size), np.diff(graph.start))
    crossing = known[owner] < known[graph.neighbours]
    one, other = owner[crossing], graph.neighbours[crossing]
    count = np.bincount(np.concatenate((one, other)), minlength=graph.size)
    found = np.asarray(known, dtype=np.int64)
    # Of each pair between two parts that with more such pairs: it saves others.
    found[np.where(count[one] > count[other], one, other)] = BOUNDARY
    return with_inner_boundary(graph, _renumbered(found))


def _spread(graph: Graph, labels: Ints) -> Ints:
    """Give vertices without a label that of most of their neighbours, until none changes."""
    owner = np.repeat(np.arange(graph.size), np.diff(graph.start))
    top = int(labels.max(initial=-1)) + 1
    while (labels < 0).any() and top:
        open_ = (labels[owner] < 0) & (labels[graph.neighbours] >= 0)
        if not open_.any():
            break
        votes = np.unique(owner[open_] * top + labels[graph.neighbours[open_]], return_counts=True)
        order = np.lexsort((votes[0], -votes[1]))
        vertex = votes[0][order] // top
        first = np.unique(vertex, return_index=True)[1]
        labels[vertex[first]] = votes[0][order][first] % top
    labels[labels < 0] = 0
    return labels


def with_inner_boundary(graph: Graph, parts: Ints) -> Ints:
    """Boundary vertices that only one part is around become part of it."""
    owner = np.repeat(np.arange(graph.size), np.diff(graph.start))
    found = parts.copy()
    # Those next to other boundary vertices stay: these may be next to another part.
    near = found[graph.neighbours]
    least = np.full(graph.size, np.iinfo(np.int64).max)
    most = np.full(graph.size, -2, dtype=np.int64)
    np.minimum.at(least, owner, near)
    np.maximum.at(most, owner, near)
    moved = (found == BOUNDARY) & (least == most) & (most >= 0)
    found[moved] = most[moved]
    return found


def _renumbered(parts: Ints) -> Ints:
    """The same with the numbers of parts that are left, in order."""
    inside = parts >= 0
    found = np.full(len(parts), BOUNDARY, dtype=np.int64)
    found[inside] = np.unique(parts[inside], return_inverse=True)[1]
    return found


def part_of_instances(blocks: tuple[Ints, ...], parts: Ints, count: int) -> list[Ints]:
    """Per group (instances,), the part that evaluates each.

    It is that of the interior that the instance reads. Those that read the boundary alone, or
    nothing that is solved for, go to the parts in turn, in consecutive runs.
    """
    found = []
    for read in blocks:
        known = np.append(parts, BOUNDARY)[read]
        best = known.max(axis=1, initial=BOUNDARY)
        free = np.flatnonzero(best < 0)
        best[free] = np.arange(len(free)) * count // max(len(free), 1)
        found.append(best)
    return found
