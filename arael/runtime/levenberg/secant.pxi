"""Secant steps: Gauss-Newton steps corrected by the curvature that the last step found.

Where residuals stay large at the optimum, J'J is not the Hessian of the cost, and Gauss-Newton
converges linearly. The last step s changed the gradient by y, and ``y = H s`` holds for the true
Hessian. The BFGS update of the inverse of J'J with this pair (Nocedal, "Updating quasi-Newton
matrices with limited storage", 1980, with J'J as the first matrix, as in Dennis, Gay and Welsch,
"An adaptive nonlinear least-squares algorithm", 1981) gives the step

    n + a (n' - n) + (b - a) s,   a = s'g / s'y,   b = -(y'n + a y'u) / s'y,   u = n' - n

with n the Gauss-Newton step and n' that of the linearisation before: ``u`` stands for
``(J'J)^-1 y``, so that no further system is solved.
"""

from libc.math cimport fabs, sqrt

from arael.runtime.levenberg.component cimport Component

# Gain ratios of steps that leave a pair: not below LOW, where the cost is not quadratic, and off
# one by more than OFF, where the linear model is right.
cdef double LOW = 0.5
cdef double OFF = 0.02
# Part of the promise before below which convergence needs no help, and above which there is none.
cdef double FAST = 0.01
cdef double SECANT_SLOW = 0.9
# Part of the cost that may be promised: farther away, pairs are out of date after each step.
cdef double SECANT_NEAR = 0.001
# Part of the promise that the step must promise too.
cdef double LEAST = 0.25
# Decreases up to so many times the noise tell nothing about curvature.
cdef double CLEAR = 4


cdef bint leaves_pair(const Component* c, double gain) noexcept nogil:
    # Bounds and guards change the gradient in other ways.
    if not c.accepted or not c.whole or c.guarded or c.bounded or not gain > LOW:
        return False
    if c.before - c.trial_cost <= CLEAR * c.noise_floor:
        return False
    return c.secant or fabs(1 - gain) > OFF


cdef bint choose_secant(Component* c, Vectors vectors, Py_ssize_t k) noexcept nogil:
    cdef const Sums* sums = &vectors.sums[k]
    cdef double alpha, beta
    c.secant = (
        c.paired and c.retry == 0 and sums.secant_change > 0 and c.promise < SECANT_NEAR * c.cost
        and FAST * c.promise_before < c.promise < SECANT_SLOW * c.promise_before)
    if not c.secant:
        vectors.paired[k] = False
        return False
    alpha = sums.secant_moved / sums.secant_change
    beta = -(sums.secant_newton + alpha * sums.secant_solved) / sums.secant_change
    vectors.along[k], vectors.across[k] = 0, 1 - alpha
    vectors.back[k], vectors.onward[k] = alpha, beta - alpha
    c.whole = True
    return True


cdef bint is_sound(Component* c, Vectors vectors, Py_ssize_t k) noexcept nogil:
    # Of the solution of a system, -g'step is the decrease that it promises.
    c.predicted = -vectors.sums[k].slope
    c.region.length = sqrt(vectors.sums[k].scaled)
    c.secant = c.region.length <= c.region.radius and c.predicted >= LEAST * c.promise
    if not c.secant:
        vectors.paired[k] = False
    return c.secant
