"""Block sparse Cholesky: multifrontal, on the block pattern.

Front by front, children before parents: zero the front's columns, copy the blocks of the matrix,
add the corresponding columns of the children's update matrices, factor them (`potrf`, `trsm`), form
the front's update matrix (`syrk`) and add the rest of the children's to it. Each step is a dense
kernel on columns of whole blocks; index work is by runs of blocks. After J. Liu, "The multifrontal
method for sparse matrix solution", SIAM Review 34 (1992).

The right-hand side is a row below each front's panel and below its update matrix, so that the
forward sweep adds a few rows to the same products while the data is in the cache. `solve` with an
existing factor writes its forward sweep to the same rows; both use the same backward sweep.

Threads first process bundles of subtrees, then parts of rows and columns of the wide fronts above;
the backward sweep is parallel over bundles.
"""

import numpy as np

from libc.math cimport isfinite
from libc.string cimport memset

from arael.runtime.address cimport address, table_address, writable
from arael.runtime.parallel.compiled cimport claim, distribute, release

from arael.runtime.compiled import aligned_parts
from arael.runtime.linear.analysis import analyse
from arael.runtime.linear.planning import place_blocks, plan_fronts
from arael.runtime.records import check_record, probe_of


cdef struct Front:
    long long columns           # k
    long long below             # r
    long long tall              # leading dimension of the triangle
    long long low               # leading dimension of the panel and of the update matrix
    long long first             # first column in the order of elimination
    long long triangle          # places in the factor
    long long panel
    long long update            # offset in the workspace of a thread, or
    long long shared            # in the shared workspace; see `Stacks`
    long long bundled           # whether it may be in a bundle
    long long blocks            # ends of its lists, begun by the front before
    long long children
    long long inside            # runs before this one go to columns of the parent
    long long runs
    long long strips


FRONT = np.dtype([(name, np.int64) for name in (
    "columns", "below", "tall", "low", "first", "triangle", "panel", "update", "shared", "bundled",
    "blocks", "children", "inside", "runs", "strips",
)])
probe = probe_of(FRONT)
check_record("Front", FRONT, (<const Front*>address(probe, FRONT))[0], sizeof(Front))


# Work of the threads: bundles of subtrees ...
cdef struct Values:
    void* solver
    const void* values
    const void* diagonal
    const void* b               # right-hand side, or NULL


# ... or sweep over ...
cdef struct Sweep:
    void* solver
    void* b


# ... and columns of one front.
cdef struct Columns:
    void* solver
    Py_ssize_t front
    bint update                 # of its update matrix, not of its own


cdef enum:
    WIDE_FRONT = 100_000              # scalars of a front above which its assembly is parallel ...
    PIECES = 32                 # ... in so many pieces


cdef const long long* longs(array) except? NULL:
    return <const long long*>address(array, np.int64)


cdef order_scalars(pattern, sequence, found):
    """Original scalar at each place of the elimination, for an order of blocks."""
    cdef const long long* offset = longs(pattern.offsets)
    cdef const long long* order = longs(sequence)
    cdef long long* to = <long long*>writable(found, np.int64)
    cdef Py_ssize_t i, k, place = 0
    for i in range(len(sequence)):
        for k in range(offset[order[i]], offset[order[i] + 1]):
            to[place] = k
            place += 1


cdef class SparseSolver(LinearSolver):
    """Cholesky factorisation of a sparse block matrix in a fill-reducing order.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    ordering : str
        ``"auto"``, or one of `arael.runtime.linear.analysis.ORDERINGS`.
    analysis : Analysis, optional
        Symbolic factor of the same pattern, if it is already known.
    """

    cdef object _keep
    cdef Py_ssize_t _count
    cdef const Front* _fronts           # with an additional first front of zeros
    cdef const long long* _blocks       # (nblocks, 4), see `table_of`
    cdef const long long* _children
    cdef const int* _runs
    cdef const int* _strips
    cdef const long long* _scalar       # original scalar at each place of the elimination
    cdef void* _factor_storage
    cdef void* _inverse                 # 1 / diagonal of the factor
    cdef void* _x                       # solution in the order of elimination
    cdef Py_ssize_t _widest             # scalars of a front's part of it
    cdef Py_ssize_t _large              # fronts with more columns go to BLAS
    # Members that depend on the number of threads.
    cdef object _alone, _together, _stacks, _hold
    cdef void* _waiting                 # update matrices of roots of bundles
    cdef void** _workspaces                   # of each thread: stacks, then a front's part of x
    cdef int* _busy
    cdef int _workspace_count
    cdef Py_ssize_t _behind             # scalars of the stacks
    cdef Py_ssize_t _bundles
    cdef const long long* _ends         # [bundles + 2] of their lists; the last is the top
    cdef const long long* _sequence     # [count] fronts of each
    cdef long long* _failed             # [bundles] front that failed, or 0
    cdef long long* _pivot              # its scalar + 1

    def __init__(self, pattern, bint single=False, ordering="auto", analysis=None):
        super().__init__(pattern, single)
        if analysis is None:
            analysis = analyse(pattern, ordering)
        dtype = self.dtype
        pad = PAD_BYTES // dtype.itemsize
        nodes = analysis.supernodes
        fronts = plan_fronts(nodes, pattern.sizes, pad, large)
        block_start, blocks = place_blocks(pattern, nodes, fronts, pad)
        self._large = large
        if fronts.columns.max(initial=0) > self._large:
            load_blas()
        ns = len(nodes.parent)
        table = np.zeros((ns + 1, len(FRONT.names)), dtype=np.int64)
        scalar = np.empty(self.n, dtype=np.int64)
        self._fill_table(table, fronts, block_start)
        order_scalars(pattern, nodes.order, scalar)
        # Each factorisation empties a front before it is assembled.
        storage, inverse, x = aligned_parts((fronts.storage, self.n, self.n), dtype)
        self._alone, self._together = fronts.alone, fronts.together
        self._widest += 2 * pad
        children = np.append(fronts.children, 0).astype(np.int64)
        self._keep = (table, blocks, children, fronts.runs, fronts.strips, scalar, storage, inverse,
                      x)
        self._count = ns
        self._fronts = <const Front*>table_address(table, len(FRONT.names))
        self._blocks = <const long long*>table_address(blocks, 4)
        self._children = <const long long*>address(children, np.int64)
        self._runs = <const int*>address(fronts.runs, np.int32)
        self._strips = <const int*>address(fronts.strips, np.int32)
        self._scalar = <const long long*>address(scalar, np.int64)
        self._factor_storage = writable(storage, dtype)
        self._inverse = writable(inverse, dtype)
        self._x = writable(x, dtype)
        self.use_threads(1)
        self.plan = {
            "solver": "sparse",
            "n": self.n,
            "ordering": analysis.ordering,
            "nnz_l": analysis.nnz,
            "flops": analysis.flops,
            "supernodes": ns,
            "bundles": fronts.bundles,
        }

    cdef _fill_table(self, table, fronts, block_start):
        """Sizes, places and ends of lists of all fronts; `use_threads` adds where updates wait."""
        cdef Front* front = <Front*>writable(table, np.int64)
        cdef Py_ssize_t ns = len(table) - 1, s
        cdef const long long* columns = longs(fronts.columns)
        cdef const long long* below = longs(fronts.below)
        cdef const long long* tall = longs(fronts.tall)
        cdef const long long* low = longs(fronts.low)
        cdef const long long* first = longs(fronts.first)
        cdef const long long* triangle = longs(fronts.triangle)
        cdef const long long* panel = longs(fronts.panel)
        cdef const long long* bundle = longs(fronts.bundle)
        cdef const long long* blocks = longs(block_start)
        cdef const long long* children = longs(fronts.child_start)
        cdef const long long* inside = longs(fronts.run_inside)
        cdef const long long* runs = longs(fronts.run_start)
        cdef const long long* strips = longs(fronts.strip_start)
        self._widest = 0
        for s in range(ns + 1):
            front[s].blocks, front[s].children = blocks[s], children[s]
            front[s].runs, front[s].strips = runs[s], strips[s]
            if s == ns:
                break
            front[s + 1].columns, front[s + 1].below = columns[s], below[s]
            front[s + 1].tall, front[s + 1].low = tall[s], low[s]
            front[s + 1].first, front[s + 1].triangle = first[s], triangle[s]
            front[s + 1].panel, front[s + 1].bundled = panel[s], bundle[s] >= 0
            front[s + 1].inside = inside[s]
            self._widest = max(self._widest, tall[s] + low[s])

    def use_threads(self, int threads):
        """Set the number of threads of `factor` and `solve`, and allocate a workspace for each."""
        self.threads = threads
        stacks = self._together if threads > 1 else self._alone
        cdef int count = max(1, min(threads, stacks.bundles))
        if stacks is self._stacks and count == self._workspace_count:
            return
        cdef Front* front = <Front*>writable(self._keep[0], np.int64)
        cdef const long long* update = <const long long*>address(stacks.update, np.int64)
        cdef const unsigned char* shared = <const unsigned char*>address(stacks.shared, np.bool_)
        cdef Py_ssize_t s
        for s in range(self._count):
            front[s + 1].update, front[s + 1].shared = update[s], shared[s]
        extents = (stacks.shared_extent, *[stacks.extent + self._widest] * count)
        waiting, *workspaces = aligned_parts(extents, self.dtype)
        places = np.zeros(count, dtype=np.uintp)
        busy = np.zeros(count, dtype=np.intc)
        sequence = 1 + stacks.sequence
        failures = np.zeros((2, stacks.bundles + 1), dtype=np.int64)
        self._hold = (waiting, workspaces, places, busy, sequence, failures, stacks.ends)
        self._workspace_count, self._bundles, self._behind = count, stacks.bundles, stacks.extent
        self._waiting = writable(waiting, self.dtype)
        self._workspaces = <void**>writable(places, np.uintp, count)
        for s in range(count):
            self._workspaces[s] = writable(workspaces[s], self.dtype)
        self._busy = <int*>writable(busy, np.intc, count)
        self._ends = <const long long*>address(stacks.ends, np.int64)
        self._sequence = <const long long*>address(sequence, np.int64)
        self._failed = <long long*>writable(failures, np.int64)
        self._pivot = self._failed + self._bundles + 1
        self._stacks = stacks

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        return self.factor_with(values, diagonal, NULL)

    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b
    ) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal, <const float*>b)
        return self._factor(<const double*>values, <const double*>diagonal, <const double*>b)

    cdef void solve(self, void* b) noexcept nogil:
        cdef Sweep work
        work.solver, work.b = <void*>self, b
        distribute(self.threads, self._bundles, descend_bundle, &work)
        descend_bundle(&work, self._bundles)
        self.finish(b)

    cdef void finish(self, void* b) noexcept nogil:
        cdef Sweep work
        work.solver, work.b = <void*>self, b
        ascend_bundle(&work, self._bundles)
        distribute(self.threads, self._bundles, ascend_bundle, &work)

    def factor_forward(self, values, diagonal, b):
        """Factorise, and sweep forward as `forward` does; 0 or 1 + the scalar that failed."""
        v, d = self._system(values, diagonal)
        rhs = self._right(b)
        cdef size_t pv = v.ctypes.data, pd = d.ctypes.data, pb = rhs.ctypes.data
        cdef Py_ssize_t status
        with nogil:
            status = self.factor_with(<const void*>pv, <const void*>pd, <const void*>pb)
        return status

    def forward(self, b):
        """Sweep forward, L y = b (n,). The y of a front is behind the rows of its panel."""
        rhs = self._right(b)
        cdef size_t pb = rhs.ctypes.data
        cdef Sweep work
        with nogil:
            work.solver, work.b = <void*>self, <void*>pb
            distribute(self.threads, self._bundles, descend_bundle, &work)
            descend_bundle(&work, self._bundles)

    def backward(self):
        """Sweep backward, L' x = y with the y of the panels; x (n,)."""
        x = np.empty(self.n, dtype=self.dtype)
        cdef size_t px = x.ctypes.data
        with nogil:
            self.finish(<void*>px)
        return x

    def _right(self, b):
        rhs = np.ascontiguousarray(b, dtype=self.dtype)
        if rhs.shape != (self.n,):
            raise ValueError(
                f"expected a right-hand side of {self.n} rows, found shape {rhs.shape}"
            )
        return rhs

    def parts(self):
        """The factor in its memory layout, for use outside of a solve.

        Returns
        -------
        fronts : (ns + 1, 15) int64, see `Front`; the first row is zero
        storage : triangles and panels, column by column
        runs, strips : moves of each front's rows, see `Fronts`
        scalar : (n,) int64, original scalar at each place of the elimination
        """
        table, _, _, runs, strips, scalar, storage = self._keep[:7]
        return table, storage, runs, strips, scalar

    cdef Py_ssize_t _factor(
        self, const real* values, const real* diagonal, const real* rhs
    ) noexcept nogil:
        cdef Py_ssize_t i, b, s, first = 0, found = 0, status
        cdef Values work
        work.solver, work.values, work.diagonal, work.b = <void*>self, values, diagonal, rhs
        distribute(self.threads, self._bundles, factor_bundle, &work)
        for b in range(self._bundles):
            if self._failed[b] and (first == 0 or self._failed[b] < self._failed[first - 1]):
                first = b + 1
        if first:
            return self._pivot[first - 1]
        # One thread visits the fronts in another order, but failures within bundles have priority.
        for i in range(self._ends[self._bundles], self._ends[self._bundles + 1]):
            s = self._sequence[i]
            if found and not self._fronts[s].bundled:
                continue
            status = self._front(s, self.threads, values, diagonal, rhs, <real*>self._workspaces[0])
            if status and self._fronts[s].bundled:
                return status
            if status:
                found = status
        return found

    cdef void _factor_bundle(
        self, Py_ssize_t b, const real* values, const real* diagonal, const real* rhs
    ) noexcept nogil:
        cdef Py_ssize_t i
        cdef int place = claim(self._busy, self._workspace_count)
        self._failed[b] = 0
        for i in range(self._ends[b], self._ends[b + 1]):
            self._pivot[b] = self._front(
                self._sequence[i], 1, values, diagonal, rhs, <real*>self._workspaces[place])
            if self._pivot[b]:
                self._failed[b] = self._sequence[i]
                break
        release(self._busy, place)

    cdef Py_ssize_t _front(
        self, Py_ssize_t s, int threads, const real* values, const real* diagonal, const real* rhs,
        real* workspace
    ) noexcept nogil:
        """Assemble and factor a front whose children are done; 0 or 1 + the failing scalar."""
        cdef Py_ssize_t i, status
        cdef const Front* f = self._fronts + s
        cdef real* storage = <real*>self._factor_storage
        cdef real* triangle = storage + f.triangle
        cdef real* side = storage + f.panel + f.below
        cdef Columns columns
        columns.solver, columns.front, columns.update = <void*>self, s, False
        memset(triangle, 0, f.columns * f.tall * sizeof(real))
        memset(storage + f.panel, 0, f.columns * f.low * sizeof(real))
        put(self._blocks, (f - 1).blocks, f.blocks, values, storage)
        for i in range(f.columns):
            triangle[i * (f.tall + 1)] = diagonal[self._scalar[f.first + i]]
        if rhs != NULL:
            for i in range(f.columns):
                side[i * f.low] = rhs[self._scalar[f.first + i]]
        if threads > 1 and f.columns * (f.columns + f.below) > WIDE_FRONT:
            distribute(threads, PIECES, extend_piece, &columns)
        else:
            self._extend_columns(s, 0, f.columns, workspace)
        status = eliminate_front(
            f, threads, triangle, storage + f.panel, self._update(f, workspace),
            <real*>self._inverse + f.first, self._large,
        )
        if status:
            return 1 + self._scalar[f.first + status - 1]
        columns.update = True
        if threads > 1 and f.below * f.below > WIDE_FRONT:
            distribute(threads, PIECES, extend_piece, &columns)
        elif f.below:
            self._extend_update(s, 0, f.below, workspace)
        return 0

    cdef real* _update(self, const Front* f, real* workspace) noexcept nogil:
        """Address of a front's update matrix, within `workspace`."""
        return (<real*>self._waiting if f.shared else workspace) + f.update

    cdef void _extend_columns(
        self, Py_ssize_t s, Py_ssize_t begin, Py_ssize_t end, real* workspace
    ) noexcept nogil:
        """Add the children's update matrices to some of a front's columns."""
        cdef Py_ssize_t i
        cdef const Front* f = self._fronts + s
        cdef const Front* c
        cdef real* storage = <real*>self._factor_storage
        for i in range((f - 1).children, f.children):
            c = self._fronts + self._children[i] + 1
            tile_extend_columns(
                self._runs + 3 * (c - 1).runs, c.inside - (c - 1).runs, c.runs - (c - 1).runs,
                f.columns, <const real*>self._update(c, workspace), c.low, storage + f.triangle,
                f.tall, storage + f.panel, f.low, begin, end, c.below, f.below)

    cdef void _extend_update(
        self, Py_ssize_t s, Py_ssize_t begin, Py_ssize_t end, real* workspace
    ) noexcept nogil:
        """Add the children's update matrices to some columns of a front's update matrix."""
        cdef Py_ssize_t i
        cdef const Front* f = self._fronts + s
        cdef const Front* c
        for i in range((f - 1).children, f.children):
            c = self._fronts + self._children[i] + 1
            tile_extend_update(
                self._runs + 3 * (c - 1).runs, c.inside - (c - 1).runs, c.runs - (c - 1).runs,
                f.columns, <const real*>self._update(c, workspace), c.low,
                self._update(f, workspace),
                f.low, begin, end, c.below, f.below)

    cdef void _descend(self, Py_ssize_t s, const real* b, real* workspace) noexcept nogil:
        """The forward sweep over a front whose children are done.

        The contributions of a front to the rows below it are stored in place of its update matrix.
        """
        cdef Py_ssize_t i, j, k, to
        cdef bint zero
        cdef const Front* f = self._fronts + s
        cdef const Front* c
        cdef const int* run
        cdef const real* from_
        cdef real* storage = <real*>self._factor_storage
        cdef real* side = storage + f.panel + f.below
        cdef real* x = <real*>self._x + f.first
        cdef real* update = self._update(f, workspace)
        for i in range(f.columns):
            x[i] = b[self._scalar[f.first + i]]
        for k in range((f - 1).children, f.children):
            c = self._fronts + self._children[k] + 1
            from_ = self._update(c, workspace)
            for j in range((c - 1).runs, c.inside):
                run = self._runs + 3 * j
                to = run[2]
                for i in range(run[1]):
                    x[to + i] += from_[run[0] + i]
        # Of a unit vector most fronts have zeros: only those on its path to the root are read.
        zero = True
        for i in range(f.columns):
            if x[i] != 0:
                zero = False
                break
        if not zero:
            tile_forward(f.columns, f.columns, storage + f.triangle, f.tall,
                         <const real*>self._inverse + f.first, x)
        for i in range(f.columns):
            side[i * f.low] = x[i]
        if f.below == 0:
            return
        if zero:
            memset(update, 0, f.below * sizeof(real))
        else:
            tile_multiply(f.below, f.columns, storage + f.panel, f.low, x, update)
        for k in range((f - 1).children, f.children):
            c = self._fronts + self._children[k] + 1
            from_ = self._update(c, workspace)
            for j in range(c.inside, c.runs):
                run = self._runs + 3 * j
                to = run[2] - f.columns
                for i in range(run[1]):
                    update[to + i] += from_[run[0] + i]

    cdef void _ascend(self, Py_ssize_t s, real* b, real* work) noexcept nogil:
        """The backward sweep over a front whose parent is done."""
        cdef Py_ssize_t i
        cdef const Front* f = self._fronts + s
        cdef const real* storage = <const real*>self._factor_storage
        cdef real* x = <real*>self._x
        tile_ascend(
            self._strips + 2 * (f - 1).strips, f.strips - (f - 1).strips, f.below, f.columns,
            storage + f.triangle, f.tall, storage + f.panel, f.low,
            <const real*>self._inverse + f.first, x, x + f.first, work)
        for i in range(f.first, f.first + f.columns):
            b[self._scalar[i]] = x[i]

    cdef void _descend_bundle(self, Py_ssize_t k, const real* b) noexcept nogil:
        cdef Py_ssize_t i
        cdef int place = claim(self._busy, self._workspace_count)
        for i in range(self._ends[k], self._ends[k + 1]):
            self._descend(self._sequence[i], b, <real*>self._workspaces[place])
        release(self._busy, place)

    cdef void _ascend_bundle(self, Py_ssize_t k, real* b) noexcept nogil:
        cdef Py_ssize_t i
        cdef int place = claim(self._busy, self._workspace_count)
        cdef real* work = <real*>self._workspaces[place] + self._behind
        for i in range(self._ends[k + 1] - 1, self._ends[k] - 1, -1):
            self._ascend(self._sequence[i], b, work)
        release(self._busy, place)


cdef void factor_bundle(void* work, Py_ssize_t b) noexcept nogil:
    cdef Values* v = <Values*>work
    if (<SparseSolver>v.solver).single:
        (<SparseSolver>v.solver)._factor_bundle(b, <const float*>v.values,
                                                <const float*>v.diagonal, <const float*>v.b)
    else:
        (<SparseSolver>v.solver)._factor_bundle(b, <const double*>v.values,
                                                <const double*>v.diagonal, <const double*>v.b)


cdef void descend_bundle(void* work, Py_ssize_t k) noexcept nogil:
    cdef Sweep* w = <Sweep*>work
    if (<SparseSolver>w.solver).single:
        (<SparseSolver>w.solver)._descend_bundle(k, <const float*>w.b)
    else:
        (<SparseSolver>w.solver)._descend_bundle(k, <const double*>w.b)


cdef void ascend_bundle(void* work, Py_ssize_t k) noexcept nogil:
    cdef Sweep* w = <Sweep*>work
    if (<SparseSolver>w.solver).single:
        (<SparseSolver>w.solver)._ascend_bundle(k, <float*>w.b)
    else:
        (<SparseSolver>w.solver)._ascend_bundle(k, <double*>w.b)


cdef void extend_piece(void* work, Py_ssize_t item) noexcept nogil:
    cdef Columns* c = <Columns*>work
    if (<SparseSolver>c.solver).single:
        extend_part(<SparseSolver>c.solver, c, item,
                    <float*>(<SparseSolver>c.solver)._workspaces[0])
    else:
        extend_part(<SparseSolver>c.solver, c, item,
                    <double*>(<SparseSolver>c.solver)._workspaces[0])


cdef void extend_part(
    SparseSolver solver, const Columns* c, Py_ssize_t item, real* workspace
) noexcept nogil:
    cdef const Front* f = solver._fronts + c.front
    cdef Py_ssize_t n = f.below if c.update else f.columns
    cdef Py_ssize_t begin = n * item // PIECES, end = n * (item + 1) // PIECES
    if c.update:
        solver._extend_update(c.front, begin, end, workspace)
    else:
        solver._extend_columns(c.front, begin, end, workspace)


cdef Py_ssize_t eliminate_front(
    const Front* f, int threads, real* triangle, real* panel, real* update, real* inverse,
    Py_ssize_t large
) noexcept nogil:
    """Factor the columns of a front and form its update matrix; 0 or 1 + the failing column."""
    cdef Py_ssize_t k = f.columns, r = f.below, i, status
    if k <= large:
        if is_shared(threads, k):
            status = factor_triangle(threads, k, triangle, f.tall, inverse)
        else:
            status = tile_potrf(k, k, DENSE, triangle, f.tall, inverse)
        if status == 0:
            divide_rows(threads, r + 1, k, triangle, f.tall, inverse, panel, f.low)
            if r > 0:
                outer_product(threads, r + 1, r, k, panel, f.low, update, f.low)
        return status
    status = blas_potrf(<int>k, triangle, <int>f.tall)
    # Optimised LAPACKs do not check for NaN, which then is on the diagonal of the factor.
    for i in range(k if status == 0 else status - 1):
        if not isfinite(<double>triangle[i * (f.tall + 1)]):
            return i + 1
        inverse[i] = 1 / triangle[i * (f.tall + 1)]
    if status == 0:
        blas_trsm(<int>(r + 1), <int>k, triangle, <int>f.tall, panel, <int>f.low)
        if r > 0:
            blas_syrk(<int>r, <int>k, panel, <int>f.low, <real>0, update, <int>f.low)
            # The last row, with the preceding rows since the last possible split.
            tile_syrk(r // PIECE * PIECE, r + 1, r, k, panel, f.low, update, f.low)
    return status
