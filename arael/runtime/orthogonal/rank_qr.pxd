# Rank, dependencies and null space of a sparse matrix from one QR factorisation.

from arael.runtime.compiled cimport Interruption


cdef class RankQR(ScaledFactor):
    cdef readonly Interruption interruption
    cdef object priority                # array
    cdef object settled                 # `Settled` of the factor, or None
