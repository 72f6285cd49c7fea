# Rows of a system from the kernels of a compiled model, edited in place.

from libc.stdint cimport int32_t


cdef class KernelRows(TableRows):
    cdef dict _free                     # first rows of removed instances, by their rows
    cdef dict _readers                  # quantity: number of expressions that read it

    # Value of a field of the instance that begins at `row`, both valid.
    cdef void set_field(self, Py_ssize_t row, Py_ssize_t field, double value) noexcept nogil

    cdef Py_ssize_t _claim(self, Py_ssize_t count)
    cdef _check(self, LaneTable table, const int32_t* offset, Py_ssize_t count)
