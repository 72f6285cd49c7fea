"""Costs of instances, component by component, and which blocks of lanes are still evaluated."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free

from arael.runtime.address cimport address, writable

# Blocks that are evaluated although nothing in them is active, so that a kernel is not called anew.
cdef Py_ssize_t BLOCK_GAP = 2


cdef class ComponentLanes:
    """The instances of a problem by component.

    Parameters
    ----------
    groups : Groups
    partition : Partition
    """

    def __init__(self, Groups groups, partition):
        cdef Py_ssize_t g
        cdef GroupCosts* one
        self.components, self._count = partition.count, groups.count
        self.shares = groups.shares
        self.groups = <GroupCosts*>calloc(self._count + 1, sizeof(GroupCosts))
        if self.groups == NULL:
            raise MemoryError
        self.costs, self._keep = [], [groups]
        for g in range(self._count):
            one = &self.groups[g]
            component = partition.of_instance[g]
            order = groups.orders[g]
            component = np.ascontiguousarray(component if order is None else component[order])
            one.n, one.width = len(component), groups.compiled.widths[g]
            one.blocks = (one.n + one.width - 1) // one.width
            bounds = np.ascontiguousarray(groups.lanes.bounds[g], dtype=np.int64)
            # At most every third block begins a run, and each share.
            runs = np.zeros((2, one.blocks // 2 + 1 + self.shares, 2), dtype=np.int64)
            ends = np.arange(self.shares + 1)
            runs[0, : self.shares, 0], runs[0, : self.shares, 1] = (
                bounds[: self.shares], bounds[1:])
            costs = np.zeros(one.n)
            self.costs.append(costs)
            self._keep += [component, bounds, runs, ends]
            one.component = <const int32_t*>address(component, np.int32)
            one.costs = <double*>writable(costs, np.float64)
            one.bounds = <const int64_t*>address(bounds, np.int64, self.shares + 1)
            one.runs = <int64_t*>writable(runs, np.int64)
            one.before = one.runs + 2 * (one.blocks // 2 + 1 + self.shares)
            one.ends = <int64_t*>writable(ends, np.int64)

    def __dealloc__(self):
        free(self.groups)

    def keep(self, active):
        """Of what is evaluated, keep what has components that are active.

        Parameters
        ----------
        active : (components + 1,) bool; the last for instances that read nothing that is solved for
        """
        cdef const uint8_t[::1] marks = np.ascontiguousarray(active, np.bool_).view(np.uint8)
        if len(marks) != self.components + 1:
            raise ValueError(f"expected {self.components + 1} marks, found {len(marks)}")
        self.choose(&marks[0])

    def evaluated(self):
        """Instances of each group in the blocks that are evaluated."""
        cdef GroupCosts* one
        cdef Py_ssize_t g, k
        found = []
        for g in range(self._count):
            one = &self.groups[g]
            found.append(sum(
                min(one.n, one.runs[2 * k + 1] * one.width) - one.runs[2 * k] * one.width
                for k in range(one.ends[self.shares])
            ))
        return found

    cdef void choose(self, const uint8_t* active) noexcept nogil:
        cdef Py_ssize_t g, share, block, i, k, found, begin, first, end
        cdef bint acts
        cdef GroupCosts* one
        for g in range(self._count):
            one = &self.groups[g]
            one.runs, one.before = one.before, one.runs
            found = first = 0
            for share in range(self.shares):
                begin, end = found, one.ends[share + 1]
                for k in range(first, end):
                    for block in range(one.before[2 * k], one.before[2 * k + 1]):
                        acts = False
                        for i in range(block * one.width, min(one.n, (block + 1) * one.width)):
                            acts |= active[one.component[i]]
                        if not acts:
                            continue
                        if found > begin and block - one.runs[2 * found - 1] <= BLOCK_GAP:
                            one.runs[2 * found - 1] = block + 1
                        else:
                            one.runs[2 * found], one.runs[2 * found + 1] = block, block + 1
                            found += 1
                first, one.ends[share + 1] = end, found

    cdef void add(self, double* total) noexcept nogil:
        cdef Py_ssize_t g, k, i
        cdef GroupCosts* one
        for g in range(self._count):
            one = &self.groups[g]
            for k in range(one.ends[self.shares]):
                for i in range(one.runs[2 * k] * one.width,
                               min(one.n, one.runs[2 * k + 1] * one.width)):
                    total[one.component[i]] += one.costs[i]
