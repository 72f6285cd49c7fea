# The few BLAS and LAPACK routines that the solvers need, as pointers into SciPy's own copy.
#
# All matrices are column-major. The pointers are null until `load()` has been called; a solver
# that needs them calls it in its constructor.

ctypedef fused real:
    float
    double

ctypedef void (*dgemm_t)(char*, char*, int*, int*, int*, double*, double*, int*, double*, int*,
                         double*, double*, int*) noexcept nogil
ctypedef void (*sgemm_t)(char*, char*, int*, int*, int*, float*, float*, int*, float*, int*,
                         float*, float*, int*) noexcept nogil
ctypedef void (*dsyrk_t)(char*, char*, int*, int*, double*, double*, int*, double*, double*,
                         int*) noexcept nogil
ctypedef void (*ssyrk_t)(char*, char*, int*, int*, float*, float*, int*, float*, float*,
                         int*) noexcept nogil
ctypedef void (*dtrsm_t)(char*, char*, char*, char*, int*, int*, double*, double*, int*, double*,
                         int*) noexcept nogil
ctypedef void (*strsm_t)(char*, char*, char*, char*, int*, int*, float*, float*, int*, float*,
                         int*) noexcept nogil
ctypedef void (*dtrsv_t)(char*, char*, char*, int*, double*, int*, double*, int*) noexcept nogil
ctypedef void (*strsv_t)(char*, char*, char*, int*, float*, int*, float*, int*) noexcept nogil
ctypedef void (*dgemv_t)(char*, int*, int*, double*, double*, int*, double*, int*, double*, double*,
                         int*) noexcept nogil
ctypedef void (*sgemv_t)(char*, int*, int*, float*, float*, int*, float*, int*, float*, float*,
                         int*) noexcept nogil
ctypedef void (*dpotrf_t)(char*, int*, double*, int*, int*) noexcept nogil
ctypedef void (*spotrf_t)(char*, int*, float*, int*, int*) noexcept nogil
ctypedef void (*dpotrs_t)(char*, int*, int*, double*, int*, double*, int*, int*) noexcept nogil
ctypedef void (*spotrs_t)(char*, int*, int*, float*, int*, float*, int*, int*) noexcept nogil
ctypedef void (*dpbtrf_t)(char*, int*, int*, double*, int*, int*) noexcept nogil
ctypedef void (*spbtrf_t)(char*, int*, int*, float*, int*, int*) noexcept nogil
ctypedef void (*dpbtrs_t)(char*, int*, int*, int*, double*, int*, double*, int*,
                          int*) noexcept nogil
ctypedef void (*spbtrs_t)(char*, int*, int*, int*, float*, int*, float*, int*, int*) noexcept nogil

cdef dgemm_t dgemm
cdef sgemm_t sgemm
cdef dsyrk_t dsyrk
cdef ssyrk_t ssyrk
cdef dtrsm_t dtrsm
cdef strsm_t strsm
cdef dtrsv_t dtrsv
cdef strsv_t strsv
cdef dgemv_t dgemv
cdef sgemv_t sgemv
cdef dpotrf_t dpotrf
cdef spotrf_t spotrf
cdef dpotrs_t dpotrs
cdef spotrs_t spotrs
cdef dpbtrf_t dpbtrf
cdef spbtrf_t spbtrf
cdef dpbtrs_t dpbtrs
cdef spbtrs_t spbtrs


cdef inline int blas_potrf(int n, real* a, int lda) noexcept nogil:
    """Lower Cholesky factor in place; 0, or the 1-based pivot that is not positive."""
    cdef char uplo = b"L"
    cdef int info = 0
    if real is double:
        dpotrf(&uplo, &n, a, &lda, &info)
    else:
        spotrf(&uplo, &n, a, &lda, &info)
    return info


cdef inline void blas_potrs(int n, real* a, int lda, real* b) noexcept nogil:
    """Solve with the factor of `potrf`, one right-hand side, in place."""
    cdef char uplo = b"L"
    cdef int one = 1, info = 0
    if real is double:
        dpotrs(&uplo, &n, &one, a, &lda, b, &n, &info)
    else:
        spotrs(&uplo, &n, &one, a, &lda, b, &n, &info)


cdef inline int blas_pbtrf(int n, int kd, real* ab, int ldab) noexcept nogil:
    """Banded lower Cholesky factor in place; 0, or the 1-based pivot that is not positive."""
    cdef char uplo = b"L"
    cdef int info = 0
    if real is double:
        dpbtrf(&uplo, &n, &kd, ab, &ldab, &info)
    else:
        spbtrf(&uplo, &n, &kd, ab, &ldab, &info)
    return info


cdef inline void blas_pbtrs(int n, int kd, real* ab, int ldab, real* b) noexcept nogil:
    """Solve with the factor of `pbtrf`, one right-hand side, in place."""
    cdef char uplo = b"L"
    cdef int one = 1, info = 0
    if real is double:
        dpbtrs(&uplo, &n, &kd, &one, ab, &ldab, b, &n, &info)
    else:
        spbtrs(&uplo, &n, &kd, &one, ab, &ldab, b, &n, &info)


cdef inline void blas_syrk(
    int n, int k, real* a, int lda, real beta, real* c, int ldc
) noexcept nogil:
    """Lower triangle of C = beta C - A A', A of shape (n, k)."""
    cdef char uplo = b"L", trans = b"N"
    cdef real minus = -1
    if real is double:
        dsyrk(&uplo, &trans, &n, &k, &minus, a, &lda, &beta, c, &ldc)
    else:
        ssyrk(&uplo, &trans, &n, &k, &minus, a, &lda, &beta, c, &ldc)


cdef inline void blas_trsm(int m, int n, real* a, int lda, real* b, int ldb) noexcept nogil:
    """B = B L^-T with L the lower triangle of A, B of shape (m, n)."""
    cdef char side = b"R", uplo = b"L", trans = b"T", diag = b"N"
    cdef real one = 1
    if real is double:
        dtrsm(&side, &uplo, &trans, &diag, &m, &n, &one, a, &lda, b, &ldb)
    else:
        strsm(&side, &uplo, &trans, &diag, &m, &n, &one, a, &lda, b, &ldb)


cdef inline void blas_gemm_nt(
    int m, int n, int k, real* a, int lda, real* b, int ldb, real* c, int ldc
) noexcept nogil:
    """C = C - A B', A of shape (m, k), B of shape (n, k)."""
    cdef char no = b"N", yes = b"T"
    cdef real minus = -1, one = 1
    if real is double:
        dgemm(&no, &yes, &m, &n, &k, &minus, a, &lda, b, &ldb, &one, c, &ldc)
    else:
        sgemm(&no, &yes, &m, &n, &k, &minus, a, &lda, b, &ldb, &one, c, &ldc)


cdef inline void blas_trsv(char trans, int n, real* a, int lda, real* x) noexcept nogil:
    """x = L^-1 x (`trans` b"N") or L^-T x (b"T"), L the lower triangle of A."""
    cdef char uplo = b"L", diag = b"N"
    cdef int one = 1
    if real is double:
        dtrsv(&uplo, &trans, &diag, &n, a, &lda, x, &one)
    else:
        strsv(&uplo, &trans, &diag, &n, a, &lda, x, &one)


cdef inline void blas_gemv(
    char trans, int m, int n, real* a, int lda, real* x, real beta, real* y
) noexcept nogil:
    """y = beta y - A x or (`trans` b"T") beta y - A' x, A of shape (m, n)."""
    cdef int one = 1
    cdef real minus = -1
    if real is double:
        dgemv(&trans, &m, &n, &minus, a, &lda, x, &one, &beta, y, &one)
    else:
        sgemv(&trans, &m, &n, &minus, a, &lda, x, &one, &beta, y, &one)
