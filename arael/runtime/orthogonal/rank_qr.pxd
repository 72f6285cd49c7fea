# Rank, dependencies and null space of a sparse matrix from one QR factorisation.

from arael.runtime.compiled cimport Interruption


cdef class RankQR(ScaledFactor):
    cdef object given_tolerance
    cdef readonly Interruption interruption
    cdef object priority                # array
    cdef object settled                 # `Settled` of an earlier or the present factor, or None
    cdef long settled_of                # number of factorisations at `settled`
