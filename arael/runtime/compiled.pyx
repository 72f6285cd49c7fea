# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""What all packages of the runtime need: arrays on cache lines or read-only, breaking off."""

include "aligned.pxi"
include "interruption.pxi"
include "protected.pxi"
