# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/parallel
# distutils: depends = arael/runtime/parallel/pool.h
"""The pool of threads."""

include "kept.pxi"
include "pool.pxi"
