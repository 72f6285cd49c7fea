# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Block sparse Cholesky: multifrontal, on the block pattern.

Front by front, children before parents: zero the front's columns, put the blocks of the matrix
there, add what the children's update matrices say about them, factor them (`potrf`, `trsm`), form
the front's own update matrix (`syrk`) and add the rest of the children's to it. Each step is a
dense kernel on columns of whole blocks; index work is by runs of blocks. After J. Liu, "The
multifrontal method for sparse matrix solution", SIAM Review 34 (1992).
"""

import numpy as np

from libc.math cimport isfinite
from libc.string cimport memset

from arael.runtime.linear cimport blas, tiles
from arael.runtime.linear.base cimport LinearSolver
from arael.runtime.linear.blas cimport real
from arael.runtime.linear.blocks cimport address, put

from arael.runtime.linear.analysis import analyse
from arael.runtime.linear.blas import load as load_blas
from arael.runtime.linear.fronts import plan_fronts
from arael.runtime.linear.memory import aligned, leading
from arael.runtime.linear.scatter import place_blocks


cdef struct Front:
    long long columns           # k
    long long below             # r
    long long tall              # leading dimension of the triangle
    long long low               # leading dimension of the panel and of the update matrix
    long long first             # first column in the order of elimination
    long long triangle          # places in the factor
    long long panel
    long long update            # place in the stack of its parity
    long long parity
    long long blocks            # ends of its lists, begun by the front before
    long long children
    long long inside            # runs before this one go to columns of the parent
    long long runs
    long long strips


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
        Symbolic factor of the same pattern, where it is already known.
    """

    cdef object _keep
    cdef Py_ssize_t _count
    cdef const Front* _fronts           # one more than there are: the first holds zeros
    cdef const long long* _blocks       # (nblocks, 6), see `place_blocks`
    cdef const long long* _children
    cdef const int* _runs
    cdef const int* _strips
    cdef const long long* _scalar       # original scalar at each place of the elimination
    cdef void* _factor_storage
    cdef void* _inverse                 # 1 / diagonal of the factor
    cdef void* _work                    # n scalars, then the rows of the widest front
    cdef Py_ssize_t _strip_room
    cdef Py_ssize_t _large              # fronts with more columns go to BLAS
    cdef void* _stack[2]

    def __init__(self, pattern, bint single=False, ordering="auto", analysis=None):
        super().__init__(pattern, single)
        if analysis is None:
            analysis = analyse(pattern, ordering)
        pad = tiles.PAD_BYTES // self.dtype.itemsize
        nodes = analysis.supernodes
        fronts = plan_fronts(nodes, pattern.sizes, pad)
        block_start, blocks = place_blocks(pattern, nodes, fronts, pad)
        self._large = tiles.large
        if fronts.columns.max(initial=0) > self._large:
            load_blas()
        ns = len(nodes.parent)
        table = np.zeros((ns + 1, 14), dtype=np.int64)
        table[1:, 0], table[1:, 1] = fronts.columns, fronts.below
        table[1:, 2] = leading(fronts.columns, pad)
        table[1:, 3] = leading(fronts.below, pad)
        table[1:, 4], table[1:, 5], table[1:, 6] = fronts.first, fronts.triangle, fronts.panel
        table[1:, 7], table[1:, 8] = fronts.update, fronts.parity
        table[:, 9], table[:, 10] = block_start, fronts.child_start
        table[1:, 11] = fronts.run_inside
        table[:, 12], table[:, 13] = fronts.run_start, fronts.strip_start
        offset = np.asarray(pattern.offsets)
        width = pattern.sizes[nodes.order]
        begin = np.repeat(offset[nodes.order], width)
        local = np.arange(self.n) - np.repeat(np.cumsum(width) - width, width)
        scalar = np.ascontiguousarray(begin + local, dtype=np.int64)
        storage = aligned(fronts.storage, self.dtype)
        inverse = aligned(self.n, self.dtype)
        self._strip_room = self.n
        work = aligned(self.n + pad + int(table[:, 3].max(initial=0)), self.dtype)
        stacks = [aligned(size, self.dtype) for size in fronts.stacks]
        children = np.append(fronts.children, 0).astype(np.int64)
        self._keep = (table, blocks, children, fronts.runs, fronts.strips, scalar, storage, inverse,
                      work, stacks)
        self._count = ns
        self._fronts = <const Front*>address(table)
        self._blocks = <const long long*>address(blocks)
        self._children = <const long long*>address(children)
        self._runs = <const int*>address(fronts.runs)
        self._strips = <const int*>address(fronts.strips)
        self._scalar = <const long long*>address(scalar)
        self._factor_storage = address(storage)
        self._inverse = address(inverse)
        self._work = address(work)
        self._stack[0], self._stack[1] = address(stacks[0]), address(stacks[1])
        self.plan = {
            "solver": "sparse",
            "n": self.n,
            "ordering": analysis.ordering,
            "nnz_l": analysis.nnz,
            "flops": analysis.flops,
            "supernodes": ns,
        }

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal)
        return self._factor(<const double*>values, <const double*>diagonal)

    cdef void solve(self, void* b) noexcept nogil:
        if self.single:
            self._solve(<float*>b)
        else:
            self._solve(<double*>b)

    def parts(self):
        """The factor as it lies in memory, for what is done with it outside of a solve.

        Returns
        -------
        fronts : (ns + 1, 14) int64, see `Front`; the first row is zero
        storage : triangles and panels, column by column
        runs, strips : moves of each front's rows, see `Fronts`
        scalar : (n,) int64, original scalar at each place of the elimination
        """
        table, _, _, runs, strips, scalar, storage = self._keep[:7]
        return table, storage, runs, strips, scalar

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t s, i, status
        cdef const Front* f
        cdef const Front* c
        cdef real* storage = <real*>self._factor_storage
        cdef real* inverse = <real*>self._inverse
        cdef real* triangle
        cdef real* panel
        cdef real* update
        cdef const real* of_child
        cdef const int* runs
        for s in range(1, self._count + 1):
            f = self._fronts + s
            triangle, panel = storage + f.triangle, storage + f.panel
            update = <real*>self._stack[f.parity] + f.update
            memset(triangle, 0, f.columns * f.tall * sizeof(real))
            memset(panel, 0, f.columns * f.low * sizeof(real))
            put(self._blocks, (f - 1).blocks, f.blocks, values, storage)
            for i in range(f.columns):
                triangle[i * (f.tall + 1)] = diagonal[self._scalar[f.first + i]]
            for i in range((f - 1).children, f.children):
                c = self._fronts + self._children[i] + 1
                runs = self._runs + 3 * (c - 1).runs
                of_child = <const real*>self._stack[c.parity] + c.update
                tiles.extend_columns(runs, c.inside - (c - 1).runs, c.runs - (c - 1).runs,
                                     f.columns, of_child, c.low, triangle, f.tall, panel, f.low)
            status = eliminate(f, triangle, panel, update, inverse + f.first, self._large)
            if status:
                return 1 + self._scalar[f.first + status - 1]
            if f.below == 0:
                continue
            for i in range((f - 1).children, f.children):
                c = self._fronts + self._children[i] + 1
                runs = self._runs + 3 * (c - 1).runs
                of_child = <const real*>self._stack[c.parity] + c.update
                tiles.extend_update(runs, c.inside - (c - 1).runs, c.runs - (c - 1).runs,
                                    f.columns, of_child, c.low, update, f.low)
        return 0

    cdef void _solve(self, real* b) noexcept nogil:
        cdef Py_ssize_t s, i, j, n = self.n
        cdef const Front* f
        cdef const real* storage = <const real*>self._factor_storage
        cdef const real* inverse = <const real*>self._inverse
        cdef real* x = <real*>self._work
        cdef real* y = x + self._strip_room
        cdef real* part
        cdef const int* strip
        cdef const real* from_
        for i in range(n):
            x[i] = b[self._scalar[i]]
        for s in range(1, self._count + 1):
            f = self._fronts + s
            tiles.forward(f.columns, f.columns, storage + f.triangle, f.tall, inverse + f.first,
                          x + f.first)
            if f.below == 0:
                continue
            tiles.multiply(f.below, f.columns, storage + f.panel, f.low, x + f.first, y)
            from_ = y
            strip = self._strips + 2 * (f - 1).strips
            for _ in range(f.strips - (f - 1).strips):
                part = x + strip[0]
                for j in range(strip[1]):
                    part[j] += from_[j]
                from_ += strip[1]
                strip += 2
        for s in range(self._count, 0, -1):
            f = self._fronts + s
            if f.below > 0:
                part = y
                strip = self._strips + 2 * (f - 1).strips
                for _ in range(f.strips - (f - 1).strips):
                    from_ = x + strip[0]
                    for j in range(strip[1]):
                        part[j] = from_[j]
                    part += strip[1]
                    strip += 2
                # The panel's rows are padded with zeros, so whole vectors may be taken.
                for j in range(f.below, f.low):
                    y[j] = 0
                tiles.transposed(f.low, f.columns, storage + f.panel, f.low, y, x + f.first)
            tiles.backward(f.columns, f.columns, storage + f.triangle, f.tall, inverse + f.first,
                           x + f.first)
        for i in range(n):
            b[self._scalar[i]] = x[i]


# Every row of a dense triangle may be addressed from every column.
cdef extern from *:
    Py_ssize_t PY_SSIZE_T_MAX

cdef Py_ssize_t DENSE = PY_SSIZE_T_MAX // 2


cdef Py_ssize_t eliminate(
    const Front* f, real* triangle, real* panel, real* update, real* inverse, Py_ssize_t large
) noexcept nogil:
    """Factor the columns of a front and form its update matrix; 0 or 1 + the failing column."""
    cdef Py_ssize_t k = f.columns, r = f.below, i, status
    if k <= large:
        status = tiles.potrf(k, k, DENSE, triangle, f.tall, inverse)
        if status == 0 and r > 0:
            tiles.trsm(r, k, triangle, f.tall, inverse, panel, f.low)
            tiles.syrk(r, k, panel, f.low, update, f.low)
        return status
    status = blas.potrf(<int>k, triangle, <int>f.tall)
    # Optimised LAPACKs do not look for NaN; it then stands on the diagonal of the factor.
    for i in range(k if status == 0 else status - 1):
        if not isfinite(<double>triangle[i * (f.tall + 1)]):
            return i + 1
        inverse[i] = 1 / triangle[i * (f.tall + 1)]
    if status == 0 and r > 0:
        blas.trsm(<int>r, <int>k, triangle, <int>f.tall, panel, <int>f.low)
        blas.syrk(<int>r, <int>k, panel, <int>f.low, <real>0, update, <int>f.low)
    return status
