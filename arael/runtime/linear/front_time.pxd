# Predicted nanoseconds to assemble and factor a front; see front_time.pyx.


cdef inline double front_time(double k, double r) noexcept nogil:
    """The model for one front of k columns and r rows below them."""
    return (
        150.0 + 16.0 * k + 0.02 * k * k * k + (k * k * r + k * r * r) / 90.0
        + 0.16 * k * k + 0.24 * k * r + 2.5 * r + 0.2 * r * r
    )
