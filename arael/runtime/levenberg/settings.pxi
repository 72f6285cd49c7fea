"""Settings of a solve as plain C, and the ways in which it may end."""

from libc.math cimport INFINITY

STATUSES = (
    "running",
    "converged",
    "cost_threshold",
    "max_iterations",
    "gradient_tolerance",
    "parameter_tolerance",
    "predicted_reduction",
    "time_limit",
    "driver_terminated",
    "observer_terminated",
    "lambda_ceiling",
    "retry_budget",
    "aborted",
    "stalled",
)

# From the best end to the worst: solved, nothing more to gain, out of attempts, out of means.
cdef int[STATUS_COUNT] BADNESS
BADNESS[:] = [0, 1, 2, 11, 3, 4, 5, 15, 14, 16, 13, 12, 17, 10]


cdef int badness(int status) noexcept nogil:
    return BADNESS[status]


cdef Settings settings_of(
    config, dtype, bint guarded, bint watched, Py_ssize_t size
) except *:
    cdef Settings s
    cdef bint single = dtype.char == "f"
    strategy = config.chosen_strategy()
    s.abs_precision = config.abs_precision
    s.rel_precision = config.relative(size, single)
    s.enough = config.enough
    s.max_iters, s.min_iters, s.patience = config.max_iters, config.min_iters, config.patience
    s.initial_lambda = config.initial_lambda
    s.lambda_floor = config.floor(single)
    s.lambda_ceiling, s.retry_budget = config.lambda_ceiling, config.retry_budget
    s.cost_threshold = config.cost_threshold
    s.gradient_tolerance = config.gradient_tolerance
    s.parameter_tolerance = config.parameter_tolerance
    s.predicted_reduction_tolerance = config.predicted_reduction_tolerance
    s.min_diagonal = config.min_diagonal
    s.time_limit = INFINITY if config.time_limit is None else config.time_limit
    s.dogleg = strategy != "damped"
    s.damping = CUSTOM if callable(config.damping) else {
        "ladder": LADDER, "nielsen": NIELSEN, "gain": GAIN
    }[config.damping]
    s.by_promise = config.ending == "promise"
    s.watched = watched
    s.epsilon = 2.0**-23 if single else 2.0**-52
    s.guarded = guarded
    return s
