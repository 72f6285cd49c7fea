# The expression machine: runs the tape of a group on lanes, as a generated kernel would.

from libc.stdint cimport int32_t

from arael.runtime.kernel cimport Lanes, Native


cdef struct Code:
    Py_ssize_t count            # instructions
    const int32_t* words        # [count][5] operation, target, operands: numbers of registers
    const int32_t* operands     # registers of the operands of calls, one call after the other


cdef class Program:
    cdef readonly bint single           # f32 if true, else f64
    cdef readonly Py_ssize_t uses       # entities read
    cdef readonly Py_ssize_t residuals
    cdef object _keep                   # arrays that the pointers below point into
    cdef Py_ssize_t _states, _data, _uniforms, _constants, _registers, _arguments
    cdef Code _cost, _full
    cdef const int32_t* _state          # [states][3] use, offset, stride
    cdef const double* _constant        # [constants]
    cdef const int32_t* _results        # [residuals] registers of the residuals
    cdef const int32_t* _entries        # [entries][3] register, residual, use | tangent << 16
    cdef Py_ssize_t _entry_count
    cdef const int32_t* _products       # [products][7] registers i, j, pair, three offsets, factor
    cdef Py_ssize_t _product_count

    # Without memory for the registers, all set `exhausted`, and what they return means nothing.
    # The sum of squared residuals; with `costs`, those of each instance instead, see `Kernel.cost`.
    cdef double cost(self, const Lanes* lanes, double* costs, bint* exhausted) noexcept nogil
    # `shared`: all instances contribute to the same places, which get one sum a block of lanes.
    cdef double linearise(
        self, const Lanes* lanes, bint shared, void* gradient, void* values, bint* exhausted
    ) noexcept nogil
    cdef void rows(
        self, const Lanes* lanes, void* residuals, void* entries, bint* exhausted) noexcept nogil
