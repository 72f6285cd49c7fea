# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/parallel
# distutils: depends = arael/runtime/parallel/stack.h
"""Evaluation of a problem: groups, their lanes and kernels, states."""

include "compiled_groups.pxi"
include "raised.pxi"
include "state_pair.pxi"
include "group_lanes.pxi"
include "groups.pxi"
include "component_lanes.pxi"
include "evaluation.pxi"
