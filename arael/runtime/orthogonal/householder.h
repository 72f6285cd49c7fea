/* Householder reflections of one dense front, column-major and in row echelon form.
 *
 * The loops keep several sums so that additions do not wait for each other; the order of additions
 * is fixed, so results do not depend on the machine's vector width.
 */
#ifndef ARAEL_HOUSEHOLDER_H
#define ARAEL_HOUSEHOLDER_H

#include <math.h>
#include <stddef.h>

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

/* x'y */
static inline double qr_dot(ptrdiff_t n, const double *RESTRICT x, const double *RESTRICT y) {
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    ptrdiff_t i = 0;
    for (; i + 4 <= n; i += 4) {
        s0 += x[i] * y[i];
        s1 += x[i + 1] * y[i + 1];
        s2 += x[i + 2] * y[i + 2];
        s3 += x[i + 3] * y[i + 3];
    }
    for (; i < n; i++) s0 += x[i] * y[i];
    return (s0 + s2) + (s1 + s3);
}

/* y += f x */
static inline void qr_add(ptrdiff_t n, double f, const double *RESTRICT x, double *RESTRICT y) {
    ptrdiff_t i;
    for (i = 0; i < n; i++) y[i] += f * x[i];
}

/* Length of x; entries are of order 1, so squares neither overflow nor matter when they vanish. */
static inline double qr_length(ptrdiff_t n, const double *x) {
    return n == 1 ? fabs(x[0]) : sqrt(qr_dot(n, x, x));
}

/* Apply the reflection with the vector (1, v), v of n - 1 entries, to x of n entries. */
static inline void qr_reflect(ptrdiff_t n, double tau, const double *RESTRICT v,
                              double *RESTRICT x) {
    double s = tau * (x[0] + qr_dot(n - 1, v, x + 1));
    x[0] -= s;
    qr_add(n - 1, -s, v, x + 1);
}

/* Reduce a front to row echelon form in place.
 *
 * a      (rows, columns), leading dimension `rows`; the first `pivots` columns have all their
 *        entries here, the others go on to the parent
 * stair  one past the last row that may have an entry in each column; grows with the column
 * pivot  out: row of each column's pivot, or -1 for a column that adds no rank
 * tau    out: factor of each column's reflection; its vector is below the pivot
 * norms  out, of the pivotal columns: length of what remained of them
 * dead   up to this remaining length a pivotal column is dependent on those before it
 * noise  up to this remaining length any other column is taken as zero
 *
 * Returns the number of rows with a pivot.
 */
static int qr_reduce(int rows, int columns, int pivots, double *RESTRICT a,
                     const int *RESTRICT stair, int *RESTRICT pivot, double *RESTRICT tau,
                     double *RESTRICT norms, double dead, double noise) {
    int k, j, i, top = 0;
    for (k = 0; k < columns; k++) {
        double *x = a + (ptrdiff_t)k * rows + top;
        ptrdiff_t n = stair[k] - top;
        double norm = n > 0 ? qr_length(n, x) : 0.0;
        if (k < pivots) norms[k] = norm;
        pivot[k] = -1;
        tau[k] = 0;
        if (!(norm > (k < pivots ? dead : noise))) {
            for (i = 0; i < n; i++) x[i] = 0;
            continue;
        }
        if (n > 1) {
            double beta = x[0] > 0 ? -norm : norm, f = 1 / (x[0] - beta);
            tau[k] = (beta - x[0]) / beta;
            for (i = 1; i < n; i++) x[i] *= f;
            x[0] = beta;
            for (j = k + 1; j < columns; j++) {
                qr_reflect(n, tau[k], x + 1, a + (ptrdiff_t)j * rows + top);
            }
        }
        pivot[k] = top++;
    }
    return top;
}

#endif
