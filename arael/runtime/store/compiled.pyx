# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Compiled passes over rows of the store, fingerprints of columns."""

include "fingerprint.pxi"
include "rearranged.pxi"
