"""Whether a component has ended, and why; `docs/internals/steps.md` has the reasons."""

from libc.math cimport INFINITY, fabs, isfinite, sqrt

from arael.runtime.levenberg.component cimport Component

# Undamped steps prove an end: regularisation up to here.
cdef double PROOF = 1e-6
# Part of the curvature along a step that must be left since the last linearisation, and part of the
# last promise that may be left, where its factor shows the end.
cdef double ALIKE_PROMISE = 0.5
cdef double FASTER = 0.25
# Gain ratios this far off one, and promises so many times the tolerance, are not asked about.
cdef double BENT = 0.5
cdef double LIKELY = 10
# Square of the rounding of doubles: a cost this small a fraction of the first has no digit left.
cdef double EXACT = 4.9e-32


cdef double noise_of(double cost, double energy, double epsilon) noexcept nogil:
    """Rounding noise of a cost.

    A residual is about as uncertain as the machine precision times its terms ``J_i x_i``; a change
    dr changes the cost by ``2 r dr + dr^2``.
    """
    cdef double terms = epsilon * epsilon * energy
    return 4 * epsilon * cost + 2 * sqrt(cost * terms) + terms


cdef int at_linearisation(Component* c, const Settings* s, double gradient) noexcept nogil:
    if s.gradient_tolerance > 0 and gradient <= s.gradient_tolerance:
        return GRADIENT_TOLERANCE
    if not s.by_promise:
        return RUNNING
    if is_exact(c, s):
        c.predicted_decrease = c.cost
        return CONVERGED
    # A derivative that is not finite makes the energy so. No step can be computed then, now or
    # after a rejection, and others must not get these numbers.
    return RUNNING if isfinite(c.energy) else STALLED


cdef bint is_exact(const Component* c, const Settings* s) noexcept nogil:
    """Whether every residual is at the level of rounding, and steps do not help any more."""
    if c.cost <= EXACT * c.start_cost:
        return True
    if not c.cost <= 4 * s.epsilon * s.epsilon * c.energy:  # NaN where a derivative is infinite
        return False
    return c.steps == 0 or c.cost > 0.25 * c.before


cdef int after_attempt(Component* c, const Settings* s) noexcept nogil:
    cdef int found = RUNNING
    keep_promise(c)
    if s.by_promise:
        found = by_promise(c, s)
    elif c.accepted:
        found = after_acceptance(c, s)
    elif c.factored and at_noise_floor(c, s):
        found = CONVERGED
    if found == RUNNING and c.factored:
        found = by_tolerance(c, s)
    if found == RUNNING and not c.accepted:
        found = out_of_means(c, s)
    return found


cdef void keep_promise(Component* c) noexcept nogil:
    """Of the attempts with one linearisation, what the least damped promised."""
    if c.factored and (c.retry == 0 or not c.predicted_decrease >= c.promise):
        c.predicted_decrease = c.promise


cdef int by_promise(Component* c, const Settings* s) noexcept nogil:
    """Whether the linearisation promises no decrease that could be noticed.

    The promise ``g' H^-1 g`` of an undamped step bounds what any step can bring, and every scaled
    entry of the gradient. Where the step was damped, an undamped one is tried first.
    """
    cdef double most
    if not c.factored:
        return RUNNING
    if not c.accepted:
        c.jitter[c.retry % 3] = fabs(c.trial_cost - c.before)
    # What a secant predicts counts, and what the step has brought: in a curved valley both are more
    # than the linear model promises.
    most = max(c.promise, c.predicted if c.secant else 0)
    if c.accepted:
        most = max(most, c.before - c.trial_cost)
    if not most <= tolerance_of(c, s, c.before):
        c.small_steps = 0
        return RUNNING
    if not is_undamped(c, s):
        if not s.dogleg and s.lambda_floor < PROOF and not c.proven:
            c.proven = True  # once a linearisation: it may fail
            c.damping = s.lambda_floor
        return RUNNING
    c.small_steps += c.accepted
    if c.accepted and (c.steps < s.min_iters or c.small_steps <= s.patience):
        return RUNNING
    return CONVERGED


cdef bint is_undamped(const Component* c, const Settings* s) noexcept nogil:
    """Whether the promise is that of a step that neither damping nor added diagonals shorten."""
    return c.damped <= PROOF and not (s.min_diagonal > 0 and c.added > 0.5 * c.promise)


cdef double tolerance_of(const Component* c, const Settings* s, double cost) noexcept nogil:
    """Decreases up to here are not noticeable."""
    return max(max(s.rel_precision * cost, s.abs_precision), c.noise_floor)


cdef bint may_have_ended(const Component* c, const Settings* s) noexcept nogil:
    cdef double bend
    if not (s.by_promise and s.patience == 0 and s.min_diagonal <= 0 and c.steps >= s.min_iters):
        return False
    # Guards and bounds change the system from one linearisation to the next.
    if not (c.accepted and c.whole and c.damped <= PROOF) or c.guarded or c.bounded:
        return False
    # If the cost were quadratic along the step alone, the next promise would be so much.
    bend = 1 - (c.before - c.cost) / c.predicted
    return fabs(bend) < BENT and bend * bend * c.promise <= LIKELY * tolerance_of(c, s, c.cost)


cdef int by_last_factor(
    Component* c, const Settings* s, double promise, double curvature, double faded
) noexcept nogil:
    """Whether the factor of the last linearisation shows that this one promises nothing.

    ``g' H^-1 g`` with the matrix before is what the present one promises, as far as both are alike.
    They are where the step before brought what was predicted, where promises fall fast, and where
    the curvature along ``H^-1 g`` has not fallen. Scalars whose own curvature has fallen count by
    what is left of it.
    """
    cdef double most
    # Negative by rounding alone, where the factor has no digit left.
    if not (0 <= promise <= FASTER * c.promise and curvature >= ALIKE_PROMISE * promise):
        return RUNNING
    # What the present matrix promises along the step, if it is more.
    most = promise * max(1.0, promise / curvature) if promise > 0 else 0
    if not most + faded <= tolerance_of(c, s, c.cost):
        return RUNNING
    c.predicted_decrease = most
    return CONVERGED


cdef bint promise_is_noise(const Component* c) noexcept nogil:
    """Whether costs at states that hardly differ scatter by more than is promised.

    Where the cost jumps, by a guard over parameters or a condition within a formula, it rises by
    nearly the same at each of them, which is no scatter.
    """
    cdef double least = INFINITY, most = 0
    cdef int k
    if c.guarded:
        return False
    for k in range(3):
        if not isfinite(c.jitter[k]):
            return False
        least, most = min(least, c.jitter[k]), max(most, c.jitter[k])
    return most - least > 0.1 * most and c.promise <= 4 * most


cdef int after_acceptance(Component* c, const Settings* s) noexcept nogil:
    cdef double drop = c.before - c.trial_cost
    if s.cost_threshold > 0 and c.cost <= s.cost_threshold:
        return COST_THRESHOLD
    if drop < 16 * s.epsilon * c.before:
        return CONVERGED
    if drop < s.abs_precision or drop < s.rel_precision * c.before:
        c.small_steps += 1
    else:
        c.small_steps = 0
    return CONVERGED if c.steps >= s.min_iters and c.small_steps > s.patience else RUNNING


cdef bint at_noise_floor(const Component* c, const Settings* s) noexcept nogil:
    """Whether a rejected step failed by rounding only: nothing was promised and nothing lost.

    The gradient must be small in a measure that damping does not touch, or a solve that is stuck
    with a huge lambda would pass for converged.
    """
    cdef double noise = 1024 * s.epsilon * c.before
    return (
        c.trial_cost - c.before <= noise
        and c.predicted <= noise
        and c.gradient <= sqrt(s.epsilon) * c.before
    )


cdef int by_tolerance(const Component* c, const Settings* s) noexcept nogil:
    if s.parameter_tolerance > 0 and sqrt(c.step_length) <= s.parameter_tolerance * (
        c.norm + s.parameter_tolerance
    ):
        return PARAMETER_TOLERANCE
    if (s.predicted_reduction_tolerance > 0
            and c.predicted <= s.predicted_reduction_tolerance * c.before):
        return PREDICTED_REDUCTION
    return RUNNING


cdef int out_of_means(const Component* c, const Settings* s) noexcept nogil:
    """Whether a rejected attempt leaves nothing to try."""
    if c.damping > s.lambda_ceiling:
        return LAMBDA_CEILING
    if s.dogleg and c.known and c.retry >= 2 and (
        c.region.radius <= s.epsilon * sqrt(c.energy) or c.region.radius < 1e-300
    ):
        if not c.guarded and c.promise <= s.enough * c.before and is_undamped(c, s):
            return CONVERGED
        return CONVERGED if promise_is_noise(c) else STALLED
    if s.retry_budget > 0 and c.retry >= s.retry_budget:
        return RETRY_BUDGET
    return RUNNING
