# Scales of the rows and columns of a sparse matrix, powers of two.

from libc.stdint cimport uint8_t

cdef int not_finite(
    int m, const int* start, const double* entries, const uint8_t* active
) noexcept nogil
cdef void equation_scales(
    int m, const int* start, const int* at, const double* entries, const uint8_t* active,
    const double* of_unknowns, double* of_equations, double shortest,
) noexcept nogil
cdef void both_scales(
    int m, int n, const int* start, const int* at, const double* entries, const uint8_t* active,
    double* of_unknowns, double* of_equations, double* least, double* greatest, double shortest,
) noexcept nogil
cdef double negligible(int count, const double* entries) noexcept nogil
