# The numeric side of a block elimination; see elimination.pxi.


# Work of the threads of one pass.
cdef struct Pass:
    void* of                            # Elimination or Sums
    const void* values                  # or the input vector
    const void* diagonal
    const void* b                       # right-hand side, if it is processed together
    void* out


cdef class Elimination:
    cdef readonly object reduction      # Reduction
    cdef readonly Py_ssize_t n          # scalars of the reduced system
    cdef object _keep
    cdef Py_ssize_t _count
    cdef const Entity* _entities
    cdef const Coupling* _couplings
    cdef const long long* _scalar       # (n,) scalar of the whole system
    cdef const long long* _padded       # (n,) place in a padded vector
    cdef Py_ssize_t _padded_size
    cdef void* _factors
    cdef void* _stored                  # Z
    cdef void* _eliminated              # the eliminated scalars of a vector
    cdef void* _work                    # one eliminated entity
    cdef void* _input                   # padded vectors
    cdef void* _output
    cdef readonly bint single           # f32 if true, else f64
    cdef public int threads
    cdef Py_ssize_t _parts, _sweeps     # parts of the entities; of sweeps, with an output each
    cdef bint _together                 # whether a sweep can be combined with the elimination
    cdef const long long* _part_ends    # [parts + 1] entities
    cdef const long long* _sweep_ends
    cdef const long long* _tails        # [sweeps] entities swept after all are eliminated
    cdef long long* _failed             # [parts]
    cdef void* _outputs                 # [sweeps - 1] padded vectors
    cdef Py_ssize_t _work_stride

    # Factor the eliminated diagonal blocks; 0 or 1 + the scalar of the whole system that failed.
    cdef Py_ssize_t eliminate(self, const real* values, const real* diagonal) noexcept nogil

    # Combines this with `descend` for a known right-hand side: data is read again while it is in
    # the caches.
    cdef Py_ssize_t eliminate_with(
        self, const real* values, const real* diagonal, const real* b, real* reduced
    ) noexcept nogil

    # Right-hand side of the reduced system; `b` of the whole one is stored for `ascend`.
    cdef void descend(self, const real* b, real* reduced) noexcept nogil

    # Solution of the whole system from that of the reduced one.
    cdef void ascend(self, const real* reduced, real* x) noexcept nogil

    # y = B x, or B x - W' D^-1 W x if `whole` is false, in which case B is not reduced.
    cdef void multiply(
        self, Py_ssize_t count, const Block* blocks, const real* values, bint whole, const real* x,
        real* y
    ) noexcept nogil

    cdef void _add_outputs(self, real* y) noexcept nogil
    cdef void _eliminate_part(
        self, Py_ssize_t k, const real* values, const real* diagonal) noexcept nogil
    cdef void _eliminate_with_part(
        self, Py_ssize_t k, const real* values, const real* diagonal, const real* b
    ) noexcept nogil
    cdef void _sweep(
        self, Py_ssize_t begin, Py_ssize_t end, const real* b, real* output) noexcept nogil
    cdef Py_ssize_t _first_failure(self, Py_ssize_t count) noexcept nogil
    cdef void _put_kept(self, const real* b) noexcept nogil
    cdef void _take_kept(self, real* reduced) noexcept nogil
    cdef void _descend_part(self, Py_ssize_t k, const real* b) noexcept nogil
    cdef void _ascend_part(self, Py_ssize_t k, real* x) noexcept nogil
    cdef void _apply_part(self, Py_ssize_t k, const real* _) noexcept nogil
    cdef real* _output_of(self, Py_ssize_t k, const real* _) noexcept nogil
    cdef real* _place_of(self, Py_ssize_t k, const real* _) noexcept nogil


cdef class Sums:
    cdef readonly object products       # Products
    cdef Elimination _of
    cdef object _keep
    cdef const long long* _tasks
    cdef const int* _pairs
    cdef const long long* _copies       # (nblocks, 3) place, place in the whole values or -1, size
    cdef const long long* _diagonal     # (n,) places of the diagonal's scalars
    cdef void* _values
    cdef void* _damped                  # (n,) diagonal
    cdef Py_ssize_t _parts
    cdef bint _together                 # whether a sweep can be combined with the elimination
    cdef const long long* _part_ends    # [parts + 1][3] blocks, scalars and tasks

    # Sum the blocks of the reduced system into `_values` and its diagonal into `_damped`.
    cdef void form(self, const real* values, const real* diagonal) noexcept nogil

    cdef void _form_part(
        self, Py_ssize_t k, const real* values, const real* diagonal) noexcept nogil
