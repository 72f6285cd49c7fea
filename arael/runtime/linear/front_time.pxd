# Predicted nanoseconds to assemble and factor a front; see front_time.pxi.


cdef inline double front_time(double k, double r) noexcept nogil:
    """The model for one front of k columns and r rows below them."""
    return (
        150.0 + 10.0 * k + 0.006 * k * k * k + (k * k * r + k * r * r) / 107.0
        + 0.08 * k * k + 0.45 * k * r + 3.0 * r + 0.16 * r * r
    )
