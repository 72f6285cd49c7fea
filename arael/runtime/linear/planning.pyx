# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Symbolic analysis of block patterns: orders, trees, supernodes, fronts."""

include "front_time.pxi"
include "stacks.pxi"
include "fronts.pxi"
include "heap.pxi"
include "symbolic.pxi"
include "independent.pxi"
include "minimum_degree.pxi"
include "separators.pxi"
include "siblings.pxi"
include "trees.pxi"
include "supernodes.pxi"
