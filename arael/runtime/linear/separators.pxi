"""Vertex separators of a weighted graph, by the multilevel method.

The graph is coarsened by contracting a heavy matching until it is small, split there by growing a
region, and the separator is refined on each level during uncoarsening. After G. Karypis, V. Kumar,
"A fast and high quality multilevel scheme for partitioning irregular graphs", SIAM J. Sci. Comput.
20 (1998); refinement by moving separator vertices to a side (C. Ashcraft, J. Liu, "Applications of
the Dulmage-Mendelsohn decomposition and network flow to graph bisection improvement", 1998, section
1).
"""

import numpy as np

cdef enum:
    SEPARATOR = 2
    COARSE = 200        # vertices of the coarsest graph
    SEEDS = 6           # regions grown there
    PASSES = 6          # refinements on each level
    PATIENCE = 60       # moves without improvement that end a pass

cdef double TOLERANCE = 0.95


cdef class _Level:
    """A graph with weights on vertices and edges, and the map to the next coarser one."""

    cdef Py_ssize_t n
    cdef long long[::1] start
    cdef int[::1] to, edge, weight, coarse
    cdef long long total

    def __init__(self, start, to, edge, weight):
        self.n = len(weight)
        self.start, self.to, self.edge, self.weight = start, to, edge, weight
        self.total = int(np.sum(weight))


def find_separator(start, neighbours, weights):
    """Split a graph into two sides of similar weight with no edge between them.

    Parameters
    ----------
    start : (n + 1,) int64
    neighbours : (start[n],) int
        Both directions of each edge, no loops.
    weights : (n,) int

    Returns
    -------
    (n,) int8
        Side of each vertex, 0 or 1, or 2 for the separator.
    """
    cdef _Level graph = _Level(
        np.ascontiguousarray(start, dtype=np.int64),
        np.ascontiguousarray(neighbours, dtype=np.intc),
        np.ones(len(neighbours), dtype=np.intc),
        np.ascontiguousarray(weights, dtype=np.intc),
    )
    direct = _part(graph)
    if graph.n <= COARSE:
        return direct
    found = _multilevel(graph)
    # Fronts of a breadth-first search through the original graph leave parts that are easier to
    # split again; a slightly heavier separator is accepted for this.
    return found if _quality(graph, found) < TOLERANCE * _quality(graph, direct) else direct


cdef _multilevel(_Level graph):
    """Coarsen, split the coarsest graph, refine during uncoarsening."""
    levels = [graph]
    cdef _Level fine = graph, coarse
    cdef signed char[::1] side, finer
    cdef Py_ssize_t v
    while fine.n > COARSE:
        coarse = _coarsen(fine)
        if coarse.n > 0.9 * fine.n:
            break
        levels.append(coarse)
        fine = coarse
    found = _part(fine)
    for index in range(len(levels) - 2, -1, -1):
        fine = levels[index]
        side = found
        found = np.empty(fine.n, dtype=np.int8)
        finer = found
        for v in range(fine.n):
            finer[v] = side[fine.coarse[v]]
        _refine(fine, found)
    return found


cdef _Level _coarsen(_Level g):
    """Contract a matching of heavy edges; the lightest vertices choose first."""
    cdef Py_ssize_t n = g.n, i, v, u, p, q, count = 0, entries = 0, best
    cdef int[::1] weight = g.weight, to = g.to, edge = g.edge
    cdef long long[::1] start = g.start
    cdef long long[::1] sequence = np.argsort(np.asarray(weight), kind="stable").astype(np.int64)
    partner = np.full(n, -1, dtype=np.int64)
    cdef long long[::1] mate = partner
    coarse_of = np.full(n, -1, dtype=np.intc)
    cdef int[::1] coarse = coarse_of
    cdef long long limit = max(g.total // 20, 1)
    cdef int heaviest
    for i in range(n):
        v = sequence[i]
        if mate[v] >= 0:
            continue
        best, heaviest = v, 0
        for p in range(start[v], start[v + 1]):
            u = to[p]
            if mate[u] < 0 and weight[u] + weight[v] <= limit and (
                edge[p] > heaviest or (edge[p] == heaviest and weight[u] < weight[best])
            ):
                best, heaviest = u, edge[p]
        mate[v] = best
        mate[best] = v
    for v in range(n):
        if v <= mate[v]:
            coarse[v] = <int>count
            coarse[mate[v]] = <int>count
            count += 1
    g.coarse = coarse
    starts = np.zeros(count + 1, dtype=np.int64)
    heavier = np.zeros(count, dtype=np.intc)
    ends = np.empty(len(g.to), dtype=np.intc)
    edges = np.empty(len(g.to), dtype=np.intc)
    cdef long long[::1] cs = starts
    cdef int[::1] cw = heavier, ct = ends, ce = edges
    cdef long long[::1] seen = np.full(count, -1, dtype=np.int64)
    for v in range(n):
        if v > mate[v]:
            continue
        i = coarse[v]
        cs[i] = entries
        for q in range(1 if mate[v] == v else 2):
            u = v if q == 0 else mate[v]
            cw[i] += weight[u]
            for p in range(start[u], start[u + 1]):
                best = coarse[to[p]]
                if best == i:
                    continue
                if seen[best] >= cs[i]:
                    ce[seen[best]] += edge[p]
                else:
                    seen[best] = entries
                    ct[entries], ce[entries] = <int>best, edge[p]
                    entries += 1
    cs[count] = entries
    return _Level(starts, ends[:entries].copy(), edges[:entries].copy(), heavier)


cdef _part(_Level g):
    """Grow a region over half of the graph from several vertices; keep the best separator."""
    cdef Py_ssize_t seed, tries = min(<Py_ssize_t>SEEDS, g.n), last
    best = None
    least = 0.0
    queue = np.empty(g.n, dtype=np.int64)
    for attempt in range(2 * tries):
        parts = np.ones(g.n, dtype=np.int8)
        seed = (attempt // 2 * g.n) // tries
        if attempt % 2:
            # Start at a peripheral vertex: fronts are shorter there.
            last = _grow(g, seed, g.total, parts, queue)
            parts[:] = 1
            seed = last
        _grow(g, seed, (g.total + 1) // 2, parts, queue)
        _refine(g, parts)
        quality = _quality(g, parts)
        if best is None or quality < least:
            best, least = parts, quality
    return best


cdef Py_ssize_t _grow(_Level g, Py_ssize_t seed, long long enough, parts, queued):
    """Assign a region around the seed to side 0, and its front to the separator.

    Breadth-first; in a disconnected graph it continues with any remaining vertex. Returns the last
    vertex reached.
    """
    cdef signed char[::1] side = parts
    cdef long long[::1] queue = queued
    cdef Py_ssize_t head = 0, tail = 1, i = 0, v = seed, p
    cdef long long grown = 0
    side[seed] = SEPARATOR
    queue[0] = seed
    while grown < enough:
        if head == tail:
            while side[i] != 1:
                i += 1
            side[i] = SEPARATOR
            queue[tail] = i
            tail += 1
        v = queue[head]
        head += 1
        side[v] = 0
        grown += g.weight[v]
        for p in range(g.start[v], g.start[v + 1]):
            if side[g.to[p]] == 1:
                side[g.to[p]] = SEPARATOR
                queue[tail] = g.to[p]
                tail += 1
    return v


cdef double _quality(_Level g, parts):
    """Weight of the separator plus a penalty for the imbalance of the sides."""
    weights = np.bincount(parts, weights=np.asarray(g.weight), minlength=3)
    return float(weights[2] * (1.0 + abs(weights[0] - weights[1]) / max(g.total, 1)))


cdef void _refine(_Level g, parts):
    """Move vertices out of the separator while that lowers its cost."""
    cdef signed char[::1] side = parts
    cdef long long[::1] outside0 = np.zeros(g.n, dtype=np.int64)
    cdef long long[::1] outside1 = np.zeros(g.n, dtype=np.int64)
    cdef char[::1] locked = np.zeros(g.n, dtype=np.int8)
    cdef int[::1] members = np.empty(g.n, dtype=np.intc)
    # A move changes one vertex and those it pulls into the separator; a log allows undoing it.
    cdef int[::1] log = np.empty(8 * g.n + 16, dtype=np.intc)
    cdef Py_ssize_t _
    with nogil:
        for _ in range(PASSES):
            if not _pass(g, side, outside0, outside1, locked, members, log):
                break


cdef bint _pass(
    _Level g, signed char[::1] side, long long[::1] outside0, long long[::1] outside1,
    char[::1] locked, int[::1] members, int[::1] log
) noexcept nogil:
    """One round of moves, of which the best prefix is kept; returns whether it improved."""
    cdef Py_ssize_t v, u, p, i, k, count = 0, logged = 0, kept = 0, waited = 0, best_at
    cdef long long weight[3]
    cdef long long gain, best_gain, limit
    cdef double quality, least
    cdef int target, best_target
    weight[0] = weight[1] = weight[2] = 0
    for v in range(g.n):
        locked[v] = 0
        weight[side[v]] += g.weight[v]
        if side[v] == SEPARATOR:
            members[count] = <int>v
            count += 1
            outside0[v] = outside1[v] = 0
            for p in range(g.start[v], g.start[v + 1]):
                u = g.to[p]
                if side[u] == 0:
                    outside0[v] += g.weight[u]
                elif side[u] == 1:
                    outside1[v] += g.weight[u]
    limit = (g.total * 6) // 10
    least = _price(weight, g.total)
    quality = least
    while count > 0 and waited < PATIENCE and logged + 2 * g.n < 8 * g.n + 16:
        # The best move: v leaves the separator for `target`, its neighbours on the other side
        # enter.
        best_at = -1
        best_gain = 0
        best_target = 0
        for i in range(count):
            v = members[i]
            if locked[v]:
                continue
            for target in range(2):
                if weight[target] + g.weight[v] > limit:
                    continue
                gain = g.weight[v] - (outside1[v] if target == 0 else outside0[v])
                if (
                    best_at < 0 or gain > best_gain
                    or (gain == best_gain and weight[target] < weight[best_target])
                ):
                    best_at, best_gain, best_target = i, gain, target
        if best_at < 0:
            break
        v = members[best_at]
        count -= 1
        members[best_at] = members[count]
        locked[v] = 1
        _move(g, side, outside0, outside1, v, best_target, weight)
        log[logged] = <int>v
        logged += 1
        for p in range(g.start[v], g.start[v + 1]):
            u = g.to[p]
            if side[u] == 1 - best_target:
                _move(g, side, outside0, outside1, u, SEPARATOR, weight)
                outside0[u] = outside1[u] = 0
                for k in range(g.start[u], g.start[u + 1]):
                    if side[g.to[k]] == 0:
                        outside0[u] += g.weight[g.to[k]]
                    elif side[g.to[k]] == 1:
                        outside1[u] += g.weight[g.to[k]]
                members[count] = <int>u
                count += 1
                log[logged] = <int>(-u - 1)
                logged += 1
        # The side each pulled vertex came from is the other one than v went to.
        log[logged] = best_target
        logged += 1
        quality = _price(weight, g.total)
        waited += 1
        if quality < least - 1e-9:
            least = quality
            kept = logged
            waited = 0
    # Undo the moves after the best state in reverse order; each log entry ends with its target.
    while logged > kept:
        logged -= 1
        target = log[logged]
        while True:
            logged -= 1
            if log[logged] < 0:
                side[-log[logged] - 1] = <signed char>(1 - target)
            else:
                side[log[logged]] = SEPARATOR
                break
    return kept > 0


cdef inline double _price(const long long* weight, long long total) noexcept nogil:
    """Weight of the separator plus a penalty for the imbalance of the sides."""
    return weight[2] * (1.0 + <double>abs(weight[0] - weight[1]) / <double>max(total, 1))


cdef inline void _move(
    _Level g, signed char[::1] side, long long[::1] outside0, long long[::1] outside1,
    Py_ssize_t v, int target, long long* weight
) noexcept nogil:
    """Change the side of v, and update its neighbours in the separator."""
    cdef Py_ssize_t p, u
    cdef int source = side[v]
    weight[source] -= g.weight[v]
    weight[target] += g.weight[v]
    side[v] = <signed char>target
    for p in range(g.start[v], g.start[v + 1]):
        u = g.to[p]
        if side[u] != SEPARATOR:
            continue
        if source == 0:
            outside0[u] -= g.weight[v]
        elif source == 1:
            outside1[u] -= g.weight[v]
        if target == 0:
            outside0[u] += g.weight[v]
        elif target == 1:
            outside1[u] += g.weight[v]
