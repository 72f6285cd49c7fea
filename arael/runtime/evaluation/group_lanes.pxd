# Where the kernels of each group read, whole and share by share.

from libc.stdint cimport uint8_t

from arael.runtime.kernel cimport Lanes

cdef enum:
    MOST_SHARES = 64


# How far the arrays of a group reach from one block of lanes to the next.
cdef struct Stride:
    Py_ssize_t data             # bytes
    Py_ssize_t width            # lanes
    Py_ssize_t uses


cdef class GroupLanes:
    cdef readonly list data      # per group, its data in lane order, and its uniforms
    cdef object _keep            # arrays of places
    cdef object _adds            # zeros: no block of lanes is the first to write
    cdef object _orders          # per group, that of its instances, or None
    cdef object _dtype           # of scalars
    cdef readonly object bounds  # of the shares, per group, in blocks of lanes
    cdef list _widths            # per group, its lanes
    cdef list _uses              # per group, how many entities it uses
    cdef const uint8_t* _none_first
    cdef Stride* _stride         # [groups]
    cdef Py_ssize_t _shares
    cdef Lanes* _whole[2]        # [groups], by which of the states they read
    cdef Lanes* _parts[2]        # [groups][shares], the same by shares
    cdef const void** _pointers  # to the states that the lanes read

    # Of all instances of a group, reading one of the two states.
    cdef Lanes* whole(self, int which, Py_ssize_t g) noexcept nogil
    # The same with none of them the first to write a block: all contributions are added.
    cdef Lanes adding(self, int which, Py_ssize_t g) noexcept nogil
    # Of the instances in one share.
    cdef Lanes* part(self, int which, Py_ssize_t g, Py_ssize_t share) noexcept nogil
    # Of the instances in some blocks of lanes, from `begin` to `end`.
    cdef Lanes between(
        self, int which, Py_ssize_t g, Py_ssize_t begin, Py_ssize_t end) noexcept nogil

    cdef _place(self, Py_ssize_t g, one)
    cdef _cut(self, Py_ssize_t g)
