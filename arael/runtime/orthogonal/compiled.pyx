# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Sparse QR that reveals the rank."""

include "analysis.pxi"
include "factor.pxi"
include "scaling.pxi"
include "scaled_factor.pxi"
include "rank_qr.pxi"
