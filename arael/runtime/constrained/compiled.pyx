# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/linear
"""Rows that hold exactly: their products, the quadratic problem of a step, the loop."""

include "row_table.pxi"
include "quadratic.pxi"
include "loop.pxi"
