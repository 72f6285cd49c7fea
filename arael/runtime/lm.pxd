# The Levenberg-Marquardt loop: plain C state, so that an iteration touches no Python object.

from libc.stdint cimport int32_t, int64_t

from arael.runtime.box cimport Box
from arael.runtime.evaluation cimport Evaluation
from arael.runtime.linear.base cimport LinearSolver
from arael.runtime.vectors cimport Vectors


cdef enum:
    RUNNING = 0
    CONVERGED
    COST_THRESHOLD
    MAX_ITERATIONS
    GRADIENT_TOLERANCE
    PARAMETER_TOLERANCE
    PREDICTED_REDUCTION
    TIME_LIMIT
    DRIVER_TERMINATED
    OBSERVER_TERMINATED
    LAMBDA_CEILING
    RETRY_BUDGET
    ABORTED


cdef enum:
    LADDER = 0
    NIELSEN
    CUSTOM


cdef enum:
    FIRST_FACTOR = 0
    LINEARISE
    FACTOR
    SOLVE
    REFRESH
    COST
    PHASES


# One attempt at a step. The layout of `RECORD` in lm.pyx.
ctypedef struct Record:
    int32_t iteration     # from 1; retries keep the number
    int32_t retry         # rejections before this attempt, with the same linearisation
    int32_t accepted
    int32_t factored      # whether the damped matrix was positive definite
    int64_t pivot         # scalar at which factorisation failed, or -1
    double cost           # before
    double trial_cost     # after; NaN without a step
    double predicted      # reduction that the linearisation promised
    double damping        # lambda in effect
    double next_damping   # lambda of the attempt to come
    double step_norm
    double gradient       # largest magnitude of the gradient 2 J'r
    double seconds        # spent on this attempt


ctypedef struct Settings:
    double abs_precision
    double rel_precision
    Py_ssize_t max_iters
    Py_ssize_t min_iters
    Py_ssize_t patience
    double initial_lambda
    double lambda_floor
    double lambda_ceiling
    Py_ssize_t retry_budget
    double cost_threshold
    double gradient_tolerance
    double parameter_tolerance
    double predicted_reduction_tolerance
    double min_diagonal
    double time_limit
    int damping
    bint watched          # whether the watcher wants to see each step


cdef class Minimiser:
    cdef readonly Evaluation evaluation
    cdef readonly LinearSolver solver
    cdef readonly double start_cost
    cdef readonly double current_cost
    cdef readonly Py_ssize_t attempts
    cdef readonly Py_ssize_t accepted
    cdef readonly double damping          # lambda of the next attempt
    cdef readonly Vectors vectors

    cdef Settings _settings
    cdef int _status
    cdef object _watcher
    cdef object _driver
    cdef object _failure
    cdef object _history
    cdef Record* _records
    cdef Py_ssize_t _capacity
    cdef Record _now
    cdef double[6] _phases
    cdef double _began, _mark, _last_check
    cdef double _epsilon
    cdef double _growth                   # Nielsen's nu
    cdef Py_ssize_t _small_steps

    cdef Box _box

    cdef void _run(self) noexcept nogil
    cdef void _linearise(self) noexcept nogil
    cdef void _attempt(self) noexcept nogil
    cdef bint _factor(self) noexcept nogil
    cdef void _propose(self) noexcept nogil
    cdef void _judge(self) noexcept nogil
    cdef void _next_damping(self) noexcept nogil
    cdef void _nielsen(self) noexcept nogil
    cdef int _verdict(self) noexcept nogil
    cdef int _after_acceptance(self) noexcept nogil
    cdef bint _at_noise_floor(self) noexcept nogil
    cdef bint _interrupted(self) noexcept nogil
    cdef void _keep_record(self) noexcept nogil
    cdef void _take_failure(self) noexcept nogil
    cdef _show(self)
    cdef void _lap(self, int phase) noexcept nogil
