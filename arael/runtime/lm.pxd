# The Levenberg-Marquardt loop: plain C state, so that an iteration touches no Python object.

from libc.stdint cimport int32_t, int64_t

from arael.runtime.box cimport Box
from arael.runtime.dogleg cimport Dogleg
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
    STALLED


cdef enum:
    LADDER = 0
    NIELSEN
    GAIN
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
    double predicted      # reduction that the linear model predicts for the step
    double promise        # reduction that it predicts for the step without bounds and region
    double radius         # of the trust region; NaN where there is none
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
    bint dogleg           # or damped steps
    int damping
    bint by_promise       # how the end is judged: by what is promised, or by small steps
    bint watched          # whether the watcher wants to see each step


cdef class Minimiser:
    cdef readonly Evaluation evaluation
    cdef readonly LinearSolver solver
    cdef readonly double start_cost
    cdef readonly double current_cost
    cdef readonly Py_ssize_t attempts
    cdef readonly Py_ssize_t accepted
    cdef readonly Py_ssize_t factorisations  # failed ones counted
    cdef readonly double damping          # lambda of the next attempt
    cdef readonly Vectors vectors
    cdef readonly Dogleg dogleg
    cdef readonly double predicted_decrease  # by the last linearisation, least damped
    cdef readonly double gradient_norm       # sqrt of the sum of g_i^2 / H_ii
    cdef readonly double noise_floor         # of the cost, by rounding

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
    cdef double _energy                   # see `StatePair.energy`
    cdef double _added                    # of the promise, by what was added to the diagonal
    cdef double[3] _jitter                # of the costs of the last rejected states
    cdef bint _proven                     # whether an undamped step was asked for

    cdef Box _box

    cdef void _run(self) noexcept nogil
    cdef void _linearise(self) noexcept nogil
    cdef void _attempt(self) noexcept nogil
    cdef bint _factor(self) noexcept nogil
    cdef bint _is_exact(self) noexcept nogil
    cdef void _floor_of_noise(self) noexcept nogil
    cdef void _try_dogleg(self) noexcept nogil
    cdef void _try_damped(self) noexcept nogil
    cdef void _look_ahead(self) noexcept nogil
    cdef void _judge(self) noexcept nogil
    cdef void _next_damping(self) noexcept nogil
    cdef void _nielsen(self, double gain, double least) noexcept nogil
    cdef void _keep_promise(self) noexcept nogil
    cdef int _verdict(self) noexcept nogil
    cdef int _by_promise(self) noexcept nogil
    cdef bint _promise_is_noise(self) noexcept nogil
    cdef int _after_acceptance(self) noexcept nogil
    cdef bint _at_noise_floor(self) noexcept nogil
    cdef bint _interrupted(self) noexcept nogil
    cdef void _keep_record(self) noexcept nogil
    cdef void _take_failure(self) noexcept nogil
    cdef _show(self)
    cdef void _lap(self, int phase) noexcept nogil
