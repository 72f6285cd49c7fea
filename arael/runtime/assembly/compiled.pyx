# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Loops of the assembly: offsets, first writers, lane order, totals, connected components."""

include "couplings.pxi"
include "first_writers.pxi"
include "lane_order.pxi"
include "totals.pxi"
include "union_find.pxi"
