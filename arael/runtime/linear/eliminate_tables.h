/* Tables that the kernels of a block elimination read. */
#ifndef ARAEL_ELIMINATE_TABLES
#define ARAEL_ELIMINATE_TABLES

/* Number of prefetched pairs of places; a list is padded by as many. */
#define PAIRS_AHEAD 8
typedef struct {
    long long scalar;       /* first scalar in the whole system */
    long long source;       /* diagonal block in the values */
    long long factor;       /* L in its storage */
    long long couplings;    /* first of its couplings; they end at the first of the next */
    long long size;
} Entity;
typedef struct {
    long long source;       /* block in the values */
    long long place;        /* Z */
    int padded;             /* the kept entity in a padded vector */
    int width;              /* scalars of the kept entity */
    int turned;             /* whether the block is stored transposed in the values */
    int kept;               /* number of the kept entity */
} Coupling;
typedef struct {
    long long place;        /* block in the values, row-major */
    int row, column;        /* its entities in a padded vector */
    int height, width;
} Block;

#endif
