# Costs of instances, component by component, and which blocks of lanes are still evaluated.

from libc.stdint cimport int32_t, int64_t, uint8_t


# The instances of one group.
cdef struct GroupCosts:
    Py_ssize_t n                # instances
    Py_ssize_t width            # lanes of a block
    Py_ssize_t blocks
    const int32_t* component    # [n] in the order of the lanes
    double* costs               # [n] in the order of the lanes
    const int64_t* bounds       # [shares + 1] blocks at which the shares begin
    int64_t* runs               # [][2] first block and end of what is evaluated, share by share
    int64_t* ends               # [shares + 1] runs of each share
    int64_t* before             # place for the runs of before
    bint whole                  # whether it is always evaluated as a whole


cdef class ComponentLanes:
    cdef readonly Py_ssize_t components
    cdef readonly list costs        # per group, (n,) as last evaluated
    cdef Py_ssize_t shares
    cdef GroupCosts* groups
    cdef Py_ssize_t _count          # of groups
    cdef object _keep

    # Of what is evaluated, keep blocks with instances of components that are active;
    # [components + 1], the last for instances that read nothing that is solved for.
    cdef void choose(self, const uint8_t* active) noexcept nogil
    # Add the costs of all that is evaluated, by component; [components + 1].
    cdef void add(self, double* total) noexcept nogil
