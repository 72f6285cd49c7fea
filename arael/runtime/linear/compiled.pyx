# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/linear
# distutils: depends = arael/runtime/linear/blocks.h arael/runtime/linear/instruction_sets.h
"""Linear solvers and their dense kernels."""

include "base.pxi"
include "blas.pxi"
include "blocks.pxi"
include "tiles.pxi"
include "band.pxi"
include "cholesky.pxi"
include "cholmod.pxi"
include "eliminate.pxi"
include "instruction_sets.pxi"
include "reduction.pxi"
include "elimination.pxi"
include "conjugate.pxi"
include "dense.pxi"
include "lapack_band.pxi"
include "remaining.pxi"
include "schur.pxi"
include "sparse.pxi"
