/* Instructions of the expression machine: a loop over lanes for each operation of the table. */

#include <math.h>

#include "instructions.h"

#if defined(__GNUC__) && !defined(__clang__)
#define ARAEL_INDEPENDENT _Pragma("GCC ivdep")
#else
#define ARAEL_INDEPENDENT
#endif

/* The target may be an operand: lanes do not mix. */
#define ARAEL_EACH(NUMBER, EXPRESSION)                                  \
    case NUMBER:                                                        \
        ARAEL_INDEPENDENT                                               \
        for (w = 0; w < n; w++) t[w] = (EXPRESSION);                    \
        break;

#define A a[w]
#define B b[w]
#define C c[w]
#define ZERO ((real)0)
#define HALF ((real)0.5)
#define ONE ((real)1)

#define real double
#define CALL(name) name
static void execute_f64(int operation, int n, real *t, const real *a, const real *b, const real *c) {
    int w;
    switch (operation) { ARAEL_INSTRUCTIONS(ARAEL_EACH) }
}
#undef real
#undef CALL

#define real float
#define CALL(name) name##f
static void execute_f32(int operation, int n, real *t, const real *a, const real *b, const real *c) {
    int w;
    switch (operation) { ARAEL_INSTRUCTIONS(ARAEL_EACH) }
}
#undef real
#undef CALL
#undef A
#undef B
#undef C
#undef ZERO
#undef HALF
#undef ONE
