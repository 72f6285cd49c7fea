"""Where the kernels of each group read, whole and share by share."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free

from arael.runtime.address cimport address
from arael.runtime.kernel cimport Lanes
from arael.runtime.machine.compiled cimport NativeTable

from arael.runtime.assembly import shares

assert shares.MOST_SHARES <= MOST_SHARES


cdef class GroupLanes:
    """The lanes of all groups.

    Parameters
    ----------
    groups : sequence of Group
    instances : list of Instances, one per group
    plan : Shares
        Places in lane order, and where the shares begin.
    widths : list of int
        Lanes of each group's data.
    states : StatePair
    natives : NativeTable

    Attributes
    ----------
    data : list of (data in lane order, uniforms), one per group
    """

    def __init__(self, groups, instances, plan, widths, StatePair states, NativeTable natives):
        cdef Py_ssize_t use = 0, which
        cdef Lanes* lanes
        self.bounds, self._widths, self._shares = plan.bounds, widths, plan.count
        self._orders = plan.orders
        most = max([placed.first.size for placed in plan.placed], default=0)
        self._adds = np.zeros(most + 1, dtype=np.uint8)
        self._none_first = <const uint8_t*>address(self._adds, np.uint8)
        self._uses = [len(group.uses) for group in groups]
        self.data = [None] * len(groups)
        self._dtype = np.float32 if states.single else np.float64
        self._keep = (plan.placed, states, natives)
        for which in range(2):
            self._whole[which] = <Lanes*>calloc(len(groups) + 1, sizeof(Lanes))
            self._parts[which] = <Lanes*>calloc(len(groups) * self._shares + 1, sizeof(Lanes))
        self._pointers = <const void**>calloc(2 * sum(self._uses) + 1, sizeof(void*))
        self._stride = <Stride*>calloc(len(groups) + 1, sizeof(Stride))
        if not (self._whole[0] and self._whole[1] and self._parts[0] and self._parts[1]
                and self._pointers and self._stride):
            raise MemoryError
        for g, (group, placed, one) in enumerate(zip(groups, plan.placed, instances, strict=True)):
            self._place(g, one)
            for which in range(2):
                lanes = self.whole(which, g)
                lanes.natives = natives.items
                lanes.row = <const int32_t*>address(placed.row, np.int32)
                lanes.gradient_at = <const int32_t*>address(placed.gradient_at, np.int32)
                lanes.block_at = <const int64_t*>address(placed.block_at, np.int64)
                lanes.turn = <const uint8_t*>address(placed.turn, np.uint8)
                lanes.run = <const uint8_t*>address(placed.run, np.uint8)
                lanes.first = <const uint8_t*>address(placed.first, np.uint8)
                lanes.state = &self._pointers[use]
                for one_use in group.uses:
                    self._pointers[use] = states.entities[<Py_ssize_t>one_use.entity].state[which]
                    use += 1
            self._cut(g)

    def __dealloc__(self):
        free(self._whole[0])
        free(self._whole[1])
        free(self._parts[0])
        free(self._parts[1])
        free(self._pointers)
        free(self._stride)

    cdef Lanes* whole(self, int which, Py_ssize_t g) noexcept nogil:
        return &self._whole[which][g]

    cdef Lanes adding(self, int which, Py_ssize_t g) noexcept nogil:
        cdef Lanes lanes = self._whole[which][g]
        lanes.first = self._none_first
        return lanes

    cdef Lanes* part(self, int which, Py_ssize_t g, Py_ssize_t share) noexcept nogil:
        return &self._parts[which][g * self._shares + share]

    def rows_of(self, Py_ssize_t g):
        """Rows of the entities that a group uses, in lane order."""
        return self._keep[0][g].row

    def replace(self, Py_ssize_t g, one):
        """Let the instances of a group have other data; there are as many as before."""
        if len(one.rows) != self.whole(0, g).n:
            raise ValueError(f"expected {self.whole(0, g).n} instances, found {len(one.rows)}")
        self._place(g, one)
        self._cut(g)

    cdef _place(self, Py_ssize_t g, one):
        """Point the lanes of a group at its data."""
        cdef Py_ssize_t which
        cdef Lanes* lanes
        width = self._widths[g]
        self.data[g] = one.in_lanes(width, self._orders[g]), np.ascontiguousarray(one.uniform)
        for which in range(2):
            lanes = self.whole(which, g)
            lanes.n = len(one.rows)
            lanes.data = address(self.data[g][0], self._dtype)
            lanes.uniform = address(self.data[g][1], self._dtype)

    cdef _cut(self, Py_ssize_t g):
        """The lanes of a group's shares: the same arrays from each share's first block on."""
        cdef Py_ssize_t which, share
        cdef Stride* stride = &self._stride[g]
        stride.data, stride.width = self.data[g][0].strides[0], self._widths[g]
        stride.uses = self._uses[g]
        bounds = self.bounds[g]
        for which in range(2):
            for share in range(self._shares):
                self.part(which, g, share)[0] = self.between(
                    which, g, bounds[share], bounds[share + 1])

    cdef Lanes between(
        self, int which, Py_ssize_t g, Py_ssize_t begin, Py_ssize_t end
    ) noexcept nogil:
        cdef const Stride* stride = &self._stride[g]
        cdef Py_ssize_t uses = stride.uses, width = stride.width, pairs = uses * (uses + 1) // 2
        cdef Lanes lanes = self._whole[which][g]
        lanes.n = min(lanes.n, end * width) - min(lanes.n, begin * width)
        lanes.data = <const char*>lanes.data + begin * stride.data
        lanes.row += begin * uses * width
        lanes.gradient_at += begin * uses * width
        lanes.block_at += begin * pairs * width
        lanes.turn += begin * pairs * width
        lanes.run += begin
        lanes.first += begin * pairs
        return lanes
