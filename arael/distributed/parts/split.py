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
from arael.runtime.assembly.components import graph_components
from arael.runtime.linear.dissection import apart
from arael.runtime.linear.planning import find_separator

Ints = NDArray[np.int64]

BOUNDARY = -1

# A separator with a larger part of the vertices that it splits is none.
_THIN = 3

# Several components are split until no part weighs more than so many shares, or after so many
# splits for each part.
_EVEN = 1.25
_SPLITS = 2
# Pieces of less than this part of a share are small.
_SMALL = 8


def by_separators(graph: Graph, parts: int) -> Ints:
    """(n,) part of each vertex, `BOUNDARY` for separators; there may be fewer parts than asked for.

    Vertices that are joined with nearly all others, such as parameters of the root, are in the
    boundary. Of what is left, connected components that weigh at most the share of a part are in
    one part each, and the heaviest piece of the others is split until the parts are even; where
    there is one component, until there are enough.
    """
    found = np.full(graph.size, BOUNDARY, dtype=np.int64)
    sparse, _ = apart(graph.start)
    local = np.full(graph.size, -1, dtype=np.int64)
    share = int(graph.weights[sparse].sum()) / parts
    whole: list[Ints] = []  # pieces that are not split
    light: list[int] = []  # their weights
    heap: list[tuple[int, int, Ints]] = []
    for number, vertices in enumerate(_connected(graph, sparse, local)):
        weight = int(graph.weights[vertices].sum())
        if weight > share:
            heap.append((-weight, number, vertices))
        else:
            whole.append(vertices)
            light.append(weight)
    heapq.heapify(heap)
    single, number = not whole and len(heap) == 1, graph.size
    splits = 0
    while heap and splits < _SPLITS * parts:
        if len(heap) + len(whole) >= parts:
            weights = np.array([*light, *(-one[0] for one in heap)])
            if single or _unevenness(weights, parts) < _EVEN:
                break
        heavy, _, vertices = heapq.heappop(heap)
        left, right = _halves(graph, vertices, local)
        if not (len(left) and len(right)):
            whole.append(vertices)
            light.append(-heavy)
            continue
        splits += 1
        for side in (left, right):
            heapq.heappush(heap, (-int(graph.weights[side].sum()), number, side))
            number += 1
    pieces = sorted((*whole, *(one[2] for one in heap)), key=_first)
    weights = np.array([int(graph.weights[vertices].sum()) for vertices in pieces])
    for vertices, part in zip(pieces, _packed(weights, parts), strict=True):
        found[vertices] = part
    return with_inner_boundary(graph, _renumbered(found))


def _first(vertices: Ints) -> int:
    return int(vertices[0]) if len(vertices) else 0


def _connected(graph: Graph, vertices: Ints, local: Ints) -> list[Ints]:
    """Connected components of some vertices, each ascending, in the order of their first."""
    if not len(vertices):
        return [vertices]
    local[vertices] = np.arange(len(vertices))
    start, inside = _subgraph(graph, vertices, local)
    local[vertices] = -1
    ends = np.repeat(np.arange(len(vertices)), np.diff(start))
    labels = graph_components(len(vertices), ends, inside)
    order = np.argsort(labels, kind="stable")
    found = np.split(vertices[order], np.flatnonzero(np.diff(labels[order])) + 1)
    return sorted(found, key=_first)


def _packed(weights: Ints, parts: int) -> Ints:
    """(pieces,) a part for each piece of such a weight, such that parts weigh about the same.

    Large pieces go to the lightest part, the heaviest first (R. Graham, "Bounds on multiprocessing
    timing anomalies", 1969). Small ones fill what is left in their order, so that a part has rows
    that follow each other.
    """
    share = weights.sum() / parts
    found = np.arange(len(weights))
    if len(weights) <= parts:
        return found
    loads = [(0, part) for part in range(parts)]
    large = np.flatnonzero(_SMALL * weights > share)
    for piece in large[np.argsort(-weights[large], kind="stable")]:
        load, part = heapq.heappop(loads)
        found[piece] = part
        heapq.heappush(loads, (load + int(weights[piece]), part))
    space = np.zeros(parts)
    for load, part in loads:
        space[part] = max(share - load, 0)
    small = np.flatnonzero(_SMALL * weights <= share)
    middle = np.cumsum(weights[small]) - weights[small] / 2
    ends = np.cumsum(space) * (weights[small].sum() / max(space.sum(), 1))
    found[small] = np.minimum(np.searchsorted(ends, middle), parts - 1)
    return found


def _unevenness(weights: Ints, parts: int) -> float:
    """Weight of the heaviest part, as a multiple of its share."""
    loads = np.bincount(_packed(weights, parts), weights, parts)
    return float(loads.max() * parts / max(loads.sum(), 1))


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
