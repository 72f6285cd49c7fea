# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/parallel
# distutils: depends = arael/runtime/parallel/stack.h
"""An online solve: a factor that is edited, and linearisation points of its own for each row."""

include "lists.pxi"
include "tree.pxi"
include "linearisations.pxi"
