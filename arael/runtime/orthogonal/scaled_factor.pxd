# Factor of a scaled sparse matrix, and solves with it, for loops without the GIL.

from libc.stdint cimport int64_t, uint8_t


# Multipliers of scaled equations below this part of the largest one are rounding errors.
cdef double NEGLIGIBLE


cdef class ScaledFactor:
    cdef readonly int m                 # equations
    cdef readonly int n                 # unknowns
    cdef readonly double tolerance      # of remaining lengths, as a part of the largest length
    cdef readonly bint factored
    cdef readonly Analysis analysis
    cdef Factor part
    cdef list kept
    cdef object indptr, indices, numbers    # arrays; `numbers` are the entries
    cdef long factors                   # number of factorisations

    # An unknown of very many equations has copies, which further equations keep equal. They are
    # numbered behind the others, here and in the factor.
    cdef int copies
    cdef int* origin                    # (n + copies) unknown
    cdef double* share                  # (n + copies) square root of the number of its copies
    cdef double* wide                   # (n + copies) workspace

    cdef int* start                     # (m + copies + 1)
    cdef int* at                        # (entries) unknown
    cdef int* copy_at                   # (entries + 2 copies) the same, and copies instead
    cdef double* entries                # (entries) as given
    cdef uint8_t* active                # (m)
    cdef double* of_equations           # (m) scales
    cdef double* of_unknowns            # (n) scales
    cdef double* least                  # (m) entries up to which are zero
    cdef double* side                   # (n) workspace
    cdef double* other                  # (n) workspace
    cdef bint automatic                 # whether the unknowns are scaled here
    cdef double shortest                # see `RankQR.factor`
    cdef double dead                    # remaining length up to which an equation is dependent

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL

    # For loops without the GIL. None allocates.
    # 0, or 1 + the first equation with an entry that is not finite, or -1 if it was broken off:
    # there is no factor then; `scale` and `active` may be
    # null: unknowns are scaled here, and all equations are active.
    cdef int factor_entries(
        self, const double* entries, const double* scale, const uint8_t* active
    ) noexcept nogil
    cdef int rank_now(self) noexcept nogil
    cdef bint is_basic(self, int equation) noexcept nogil
    # d of least norm with J d = right on the basic equations; both (n) and (m); right is kept.
    cdef void least_norm_into(self, const double* right, double* d) noexcept nogil
    # v minus its part in the row space, in place.
    cdef void project_into(self, double* v) noexcept nogil
    # c = J'x + remainder: unknowns and values of c; equations and factors found, at most m of them.
    # Returns their number.
    cdef int dependency_into(
        self, int count, const int* unknowns, const double* values, int* equations,
        double* factors, double* remainder,
    ) noexcept nogil

    cdef void load(self) noexcept nogil
    cdef int refactor(self, int equation) noexcept nogil
