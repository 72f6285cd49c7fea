# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/linear
"""The loop of a solve."""

include "settings.pxi"
include "damping.pxi"
include "box.pxi"
include "vectors.pxi"
include "secant.pxi"
include "dogleg.pxi"
include "ends.pxi"
include "inner.pxi"
include "record.pxi"
include "supervised.pxi"
include "partitioned.pxi"
include "attempt.pxi"
include "last_factor.pxi"
include "loop.pxi"
include "remote.pxi"
