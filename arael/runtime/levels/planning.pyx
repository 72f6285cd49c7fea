# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Symbolic analysis of a system of rows."""

include "arrangement.pxi"
include "elimination_tree.pxi"
