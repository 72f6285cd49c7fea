"""Statuses of a solve, in groups; `arael.result.Result` has the meaning of each."""

CONVERGED = frozenset(
    {
        "converged",
        "cost_threshold",
        "gradient_tolerance",
        "parameter_tolerance",
        "predicted_reduction",
    }
)

# Statuses that end the whole schedule, not only the pass they end.
ENDING = frozenset({"aborted", "time_limit", "observer_terminated", "driver_terminated"})
