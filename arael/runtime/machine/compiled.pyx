# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
# distutils: include_dirs = arael/runtime/machine
# distutils: depends = arael/runtime/machine/instructions.h arael/runtime/machine/machine.h
"""The expression machine."""

include "natives.pxi"
include "program.pxi"
include "tape_program.pxi"
