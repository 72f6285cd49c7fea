# The interface between the runtime and generated kernels: plain C structs, no Python objects.
#
# Scalars are `void*`: f64 or f32 as the module was generated. W lanes are evaluated at a time;
# arrays "in lane order" are laid out [block][column][W], the last block padded by repeating its
# last instance. Kernels accumulate J'r and J'J without the factor 2 of gradient and Hessian, but
# store the whole block of a pair whose `first` is set, whatever was there before.

from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_IsValid
from libc.stdint cimport int32_t, int64_t, uint8_t

cdef enum:
    KERNEL_ABI = 6

# A native function as it was bound, called with its arguments in f64. Numbered as in
# Layout.natives; addresses come with a problem and are never part of generated code.
cdef struct Native:
    double (*call)(const Native* native, const double* arguments) noexcept nogil
    void* function              # what `call` passes the arguments on to
    void* user_data
    Py_ssize_t arity
    void* owner                 # the binding, a Python object

ctypedef struct Lanes:
    Py_ssize_t n                # instances
    const void* data            # [blocks][data_count][W] what does not change within a solve
    const void* uniform         # [uniform_count] the same for all instances
    const int32_t* row          # [blocks][uses][W] row of each used entity
    const void* const* state    # [uses] state arrays, rows x stride of the entity
    const int32_t* gradient_at  # [blocks][uses][W] first scalar of the entity in the gradient
    const int64_t* block_at     # [blocks][pairs][W] offset of the pair's block in the values
    const uint8_t* turn         # [blocks][pairs][W] 0 as is, 1 transposed, 2 both on a diagonal
    const uint8_t* run          # [blocks] whether all W lanes share the rows of the lead
    const uint8_t* first        # [blocks][pairs] whether all W lanes are first writers
    const Native* natives       # the native functions of the model

# Pairs of uses are numbered a (a + 1) / 2 + b for a >= b: block (a, b) has the tangent of use a as
# rows and that of use b as columns; of a diagonal pair what is above the diagonal is undefined.
# Entities that are not solved for have offsets into a trash area behind gradient and values.

# costs [n] of the instances, in the order of the lanes; if NULL, their sum is returned instead
ctypedef double (*cost_function)(const Lanes* lanes, double* costs) noexcept nogil
ctypedef double (*linearise_function)(
    const Lanes* lanes, void* gradient, void* values) noexcept nogil
# residuals [n][residuals], entries [n][jacobian entries], both in the order of the lanes
ctypedef void (*rows_function)(const Lanes* lanes, void* residuals, void* entries) noexcept nogil

# state of `rows` entity rows: the stored scalars of `state` moved by the step at delta_at (no step
# where negative), and all caches, into `moved`; `state` and `moved` may be the same.
ctypedef void (*refresh_function)(
    Py_ssize_t rows, const void* state, const void* delta, const int32_t* delta_at, void* moved
) noexcept nogil

# what is written into columns of `data` before an evaluation
ctypedef void (*write_function)(const Lanes* lanes) noexcept nogil

ctypedef struct Kernel:
    const char* label
    cost_function cost
    linearise_function linearise
    rows_function rows
    write_function guard    # whether each instance acts; NULL if no guard reads parameters
    write_function arguments  # of look-ups; NULL if there are none

ctypedef struct KernelTable:
    int abi
    int single              # f32
    int lanes               # W
    int group_count
    int entity_count
    const Kernel* groups    # in the order of Layout.groups
    const refresh_function* refresh  # in the order of Layout.entities


cdef inline const KernelTable* table_of(capsule) except NULL:
    """The kernels in a capsule of a generated module."""
    if not PyCapsule_IsValid(capsule, "arael.kernels"):
        raise TypeError(f"expected a capsule `arael.kernels`, found {type(capsule).__name__}")
    return <const KernelTable*>PyCapsule_GetPointer(capsule, "arael.kernels")
