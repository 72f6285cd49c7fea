# The expression machine: runs the tape of a group on lanes, as a generated kernel would.

from cython cimport floating
from libc.stdint cimport int32_t

from arael.runtime.kernel cimport Lanes, Native


cdef struct Code:
    Py_ssize_t count            # instructions
    const int32_t* words        # [count][5] operation, target, operands: numbers of registers
    const int32_t* operands     # registers of the operands of calls, one call after the other


# Execute instructions on `n` lanes of every register; `arguments`: workspace for those of calls.
cdef void run(
    const Code* code, floating** registers, int n, const Native* natives, double* arguments
) noexcept nogil

# Bytes of registers above which there is "no memory"; tests lower it.
cdef size_t most_workspace


cdef class Program:
    cdef readonly bint single           # f32 if true, else f64
    cdef readonly Py_ssize_t uses       # entities read
    cdef readonly Py_ssize_t residuals
    cdef readonly bint guarded          # whether it has a guard over parameters
    cdef readonly bint looks_up         # whether it has look-ups
    cdef Program _guard                 # whose residual is the guard
    cdef Program _arguments_of          # whose residuals are the arguments of look-ups
    cdef object _lanes_written
    cdef const int32_t* _written        # columns of data that the residuals are written into
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
    # Write whether each instance is active, or the arguments of its look-ups, into its data.
    cdef void guard(self, const Lanes* lanes, bint* exhausted) noexcept nogil
    cdef void arguments(self, const Lanes* lanes, bint* exhausted) noexcept nogil
    cdef void rows(
        self, const Lanes* lanes, void* residuals, void* entries, bint* exhausted) noexcept nogil
