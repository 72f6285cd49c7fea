/* One fault for each sanitizer to find: if it does not, a clean run of its tests says nothing. */

#include <limits.h>
#include <stdlib.h>

#include "pool.h"

static long sum;

static void add(void *job, ptrdiff_t item) {
    (void)job;
    sum += item; /* by several threads, unguarded */
}

void race(void) { pool_share(2, 1000000, add, NULL); }

int overrun(int length) {
    volatile char *bytes = malloc(length);
    const char behind = bytes[length];
    free((void *)bytes);
    return behind;
}

int overflow(int x) { return x + INT_MAX; }

int cast(int x) { return (int)(x * 1e30); }
