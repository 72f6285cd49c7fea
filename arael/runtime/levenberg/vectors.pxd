# The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

from libc.stdint cimport int64_t, uint8_t

from arael.runtime.parallel.compiled cimport Task

ctypedef fused real:
    float
    double


# Sums over the scalars of one component. `D` is the scale, `H` the undamped matrix, `A` what was
# added to its diagonal; `c` the steepest descent in scaled variables, -g / D; `n` the Gauss-Newton
# step.
cdef struct Sums:
    double slope                # g' step
    double length               # step' step
    double scaled               # step' D step
    double added                # step' A step
    double descent_length       # c' D c = g' c without its sign
    double descent_added        # c' A n
    double largest              # magnitude in the gradient; NaN counts for nothing
    double gradient             # sum of g_i^2 / H_ii: what single coordinates promise, undamped
    double faded                # see `take_faded`
    double secant_moved         # s'g of a pair: s the last step, y the change of the gradient
    double secant_change        # s'y
    double secant_newton        # y'n
    double secant_solved        # y'u, with u = n' - n, n' the Gauss-Newton step before: H^-1 y


cdef class Vectors:
    cdef readonly bint single   # f32 if true, else f64
    cdef readonly Py_ssize_t n
    cdef readonly int threads   # that share the passes
    # J'r and the values of J'J, each with what lies behind it; the diagonal, not under its floor;
    # that and its damping; the step; the largest diagonal so far; the Gauss-Newton step; steepest
    # descent.
    cdef readonly object gradient_array, value_array, diagonal_array, damped_array, step_array
    cdef readonly object scale_array, newton_array, descent_array
    cdef void* gradient
    cdef void* values
    cdef void* step
    cdef void* damped
    cdef void* scale
    cdef void* newton
    cdef void* descent
    cdef void* _gradient_before
    cdef void* _newton_before
    cdef void* _moved
    cdef void* _diagonal
    cdef void* _own             # the diagonal as it is in the values
    cdef object _keep
    cdef const int64_t* _at     # [n] offsets of the diagonal in the values
    cdef Py_ssize_t _parts
    cdef double _floor
    cdef bint _by_scale
    # Scalars of one component that are passed over in one go, cut at the parts of threads.
    cdef int64_t* _run          # [runs][3] begin, end, component
    cdef int64_t* _ends         # [parts + 1] runs of each part
    cdef Sums* _sums            # [runs]
    cdef bint _direct           # each component is one run, whose sums are those of the component

    cdef readonly Py_ssize_t components
    cdef Sums* sums             # [components] as the functions below leave them
    cdef int64_t* active        # [active_count] components that are still solved
    cdef Py_ssize_t active_count
    cdef Py_ssize_t active_scalars  # of those
    cdef uint8_t* wanted        # [components] which `keep_newton` keeps
    cdef double* damping        # [components]
    cdef double* along          # [components] of the descent, in a dogleg
    cdef double* across         # [components] of the Gauss-Newton step
    cdef double* back           # [components] of the Gauss-Newton step before, in a secant step
    cdef double* onward         # [components] of the last step
    cdef uint8_t* paired        # [components] which `keep_pair` keeps, and `secant_sums` looks at

    # Take the diagonal from the values, not under `floor`, and the largest magnitude in the
    # gradient; NaN stays in the one and counts for nothing in the other.
    cdef void take_diagonal(self, double floor) noexcept nogil
    # Damp the diagonal by a multiple of itself, or of its largest value so far; the step becomes
    # the negative gradient.
    cdef void prepare(self, bint by_scale) noexcept nogil
    # The step becomes the negative gradient.
    cdef void turn_back(self) noexcept nogil
    # The sum `faded`, of |g_i step_i| d_i / H_ii over scalars whose diagonal H_ii is less than half
    # of the damped one d_i of the last `prepare`.
    cdef void take_faded(self) noexcept nogil
    # Sums in f64 over the step.
    cdef void products(self) noexcept nogil
    # Keep the step as the Gauss-Newton step.
    cdef void keep_newton(self) noexcept nogil
    # Steepest descent in scaled variables, and its sums.
    cdef void take_descent(self) noexcept nogil
    # The step becomes `along` times the descent plus `across` times the Gauss-Newton step.
    cdef void combine(self) noexcept nogil
    # Keep gradient, Gauss-Newton step and step, of components that are `paired`.
    cdef void keep_pair(self) noexcept nogil
    # The sums `secant_...` of components that are `paired`.
    cdef void secant_sums(self) noexcept nogil
    # Add `back` times the Gauss-Newton step before and `onward` times the last step, where paired.
    cdef void add_pair(self) noexcept nogil
    # The sum `gradient`.
    cdef void scaled_gradient(self) noexcept nogil

    # Leave out components that are not `kept`: from now on no function above works on them. Their
    # step is zero, and their part of the damped diagonal one.
    cdef void leave_out(self, const uint8_t* kept) noexcept nogil
    # Zero the values of components that are not `kept`; `value_runs` are [count][3] begin, end and
    # component.
    cdef void empty_values(
        self, const int64_t* value_runs, Py_ssize_t count, const uint8_t* kept) noexcept nogil

    cdef void _leave_out(self, real* step, const uint8_t* kept) noexcept nogil
    cdef void _share(self, Task task) noexcept nogil
    cdef Sums* _of_run(self, Py_ssize_t k) noexcept nogil
    cdef void _take_part(self, Py_ssize_t part, const real* values) noexcept nogil
    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil
    cdef void _descent_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _combine_part(self, Py_ssize_t part, real* step) noexcept nogil
    cdef void _turn_back_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _faded_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _secant_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _add_pair_part(self, Py_ssize_t part, real* step) noexcept nogil
    cdef void _scaled(self, const real* gradient) noexcept nogil
