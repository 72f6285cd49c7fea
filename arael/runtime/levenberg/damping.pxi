"""How lambda follows success and failure of the damped steps of one component.

Levenberg-Marquardt: ``(J'J + lambda D) step = -J'r`` (Marquardt, SIAM J. Appl. Math. 11, 1963),
where a step that lowers the cost is accepted and lambda shrinks, and any other is retried with the
same linearisation and a larger lambda. D is the diagonal of J'J with the fixed ladder of factors
and with Nielsen's gain ratio (IMM-REP-1999-05, "Damping parameter in Marquardt's method"), or the
largest diagonal so far (Moré, 1978) with `gain`.
"""

from libc.math cimport isfinite

from arael.runtime.levenberg.component cimport Component

# A driver that rejected so often in a row that its growth overflows has given up.
cdef double GROWTH_LIMIT = 1e9


cdef int next_damping(Component* c, const Settings* s, double gain) noexcept nogil:
    cdef int found = RUNNING
    if s.damping == NIELSEN:
        found = nielsen(c, gain, 1.0 / 3.0)
    elif s.damping == GAIN:
        found = nielsen(c, gain, 0.1)
    elif c.accepted:
        c.damping *= 0.2
    else:
        c.damping *= 10
    if c.damping < s.lambda_floor:
        c.damping = s.lambda_floor
    return found


cdef int nielsen(Component* c, double gain, double least) noexcept nogil:
    cdef double shape
    if not c.accepted:
        c.damping *= c.growth
        c.growth *= 2
        return DRIVER_TERMINATED if c.growth > GROWTH_LIMIT else RUNNING
    shape = 2 * gain - 1
    c.damping *= max(least, 1 - shape * shape * shape) if isfinite(gain) else least
    c.growth = 2
    return RUNNING
