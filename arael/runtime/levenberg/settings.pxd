# Settings of a solve as plain C, and the ways in which it may end.

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
    STATUS_COUNT


cdef enum:
    LADDER = 0
    NIELSEN
    GAIN
    CUSTOM


ctypedef struct Settings:
    double abs_precision
    double rel_precision
    double enough  # a promise up to this share of the cost that no step realises counts as none
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
    bint dogleg           # steps inside a trust region, or damped steps
    int damping
    bint by_promise       # how the end is judged: by what is promised, or by small steps
    bint watched          # whether the watcher wants to see each step
    double epsilon        # machine precision of the problem
    bint guarded          # whether a guard of the problem reads parameters


cdef Settings settings_of(
    config, dtype, bint guarded, bint watched, Py_ssize_t size) except *
# How much worse a way to end is than others; all that count as solved are below 10.
cdef int badness(int status) noexcept nogil
