"""Scales of equations and unknowns, powers of two so that scaling rounds nothing."""

from libc.math cimport fabs, frexp, isfinite, ldexp, sqrt

# An entry below this part of the largest of its equation is a rounding error: scaling its unknown
# up would make it an equation of its own.
cdef double ROUNDING = 4 * 2.220446049250313e-16

cdef enum:
    PASSES = 4


cdef inline double power(double x) noexcept nogil:
    """The power of two next below x, a positive number."""
    cdef int e
    frexp(x, &e)
    return ldexp(1.0, min(max(e - 1, -1000), 1000))


cdef double negligible(int count, const double* entries) noexcept nogil:
    """Up to which absolute value entries of one equation are taken as zero."""
    cdef double largest = 0
    cdef int p
    for p in range(count):
        largest = max(largest, fabs(entries[p]))
    return ROUNDING * largest


cdef int not_finite(int m, const int* start, const double* entries) noexcept nogil:
    """1 + the first equation with an entry that is not finite, or 0."""
    cdef int i, p
    for i in range(m):
        for p in range(start[i], start[i + 1]):
            if not isfinite(entries[p]):
                return i + 1
    return 0


cdef void equation_scales(
    int m, const int* start, const int* at, const double* entries,
    const double* of_unknowns, double* of_equations, double shortest,
) noexcept nogil:
    """Scale equations to lengths in [1, 2), with given scales of the unknowns.

    An equation below `shortest` is short because its entries cancelled out: their errors are those
    of the length that it could have, and it is scaled as one of that length.
    """
    cdef int i, p
    cdef double largest, total, x
    for i in range(m):
        of_equations[i] = 0
        largest = total = 0
        for p in range(start[i], start[i + 1]):
            largest = max(largest, fabs(entries[p] * of_unknowns[at[p]]))
        if largest == 0:
            continue
        for p in range(start[i], start[i + 1]):
            x = entries[p] * of_unknowns[at[p]] / largest
            total += x * x
        if shortest > 0 and largest * sqrt(total) < shortest:
            of_equations[i] = 1 / power(shortest)
            continue
        of_equations[i] = 1 / power(largest) / power(largest / power(largest) * sqrt(total))


cdef void both_scales(
    int m, int n, const int* start, const int* at, const double* entries,
    double* of_unknowns, double* of_equations, double* least, double* greatest, double shortest,
) noexcept nogil:
    """Scale equations and unknowns by turns, by the geometric mean of least and greatest entry.

    `least` and `greatest` are workspace of n doubles. After R. Fourer, "Solving staircase linear
    programs by the simplex method", Math. Programming 23 (1982), section on scaling.
    """
    cdef int i, p, u, _
    cdef double low, high, x, none
    for u in range(n):
        of_unknowns[u] = 1
    for _ in range(PASSES):
        for u in range(n):
            least[u], greatest[u] = 1e300, 0
        for i in range(m):
            none = negligible(start[i + 1] - start[i], entries + start[i])
            low, high = 1e300, 0
            for p in range(start[i], start[i + 1]):
                if fabs(entries[p]) > none:
                    x = fabs(entries[p]) * of_unknowns[at[p]]
                    low, high = min(low, x), max(high, x)
            if high == 0:
                continue
            low = 1 / sqrt(low) / sqrt(high)
            for p in range(start[i], start[i + 1]):
                if fabs(entries[p]) > none:
                    x = fabs(entries[p]) * low
                    least[at[p]], greatest[at[p]] = min(least[at[p]], x), max(greatest[at[p]], x)
        for u in range(n):
            of_unknowns[u] = power(1 / sqrt(least[u]) / sqrt(greatest[u])) if greatest[u] else 1.0
    equation_scales(m, start, at, entries, of_unknowns, of_equations, shortest)
