# Factor of a scaled sparse matrix, and solves with it.


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
    cdef double* of_equations           # (m) scales
    cdef double* of_unknowns            # (n) scales
    cdef double* least                  # (m) entries up to which are zero
    cdef double* side                   # (n) workspace
    cdef double* other                  # (n) workspace
    cdef bint automatic                 # whether the unknowns are scaled here
    cdef double shortest                # see `RankQR.factor`
    cdef double dead                    # remaining length up to which an equation is dependent

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL

    # None allocates.
    # 0, or 1 + the first equation with an entry that is not finite, or -1 if it was broken off:
    # there is no factor then; `scale` may be null: unknowns are scaled here.
    cdef int factor_entries(self, const double* entries, const double* scale) noexcept nogil
    # d of least norm with J d = right on the basic equations; both (n) and (m); right is kept.
    cdef void least_norm_into(self, const double* right, double* d) noexcept nogil
    # c = J'x + remainder: unknowns and values of c; equations and factors found, at most m of them.
    # Returns their number.
    cdef int dependency_into(
        self, int count, const int* unknowns, const double* values, int* equations,
        double* factors, double* remainder,
    ) noexcept nogil

    cdef void load(self) noexcept nogil
