/* The kernels of eliminate.h for one instruction set, in both precisions. */

#include "eliminate_tables.h"
#include "instruction_set.h"

#define T float
#define SQRT sqrtf
#define LARGEST FLT_MAX
#define F(x) x##_f32
#include "eliminate.h"
#undef T
#undef SQRT
#undef LARGEST
#undef F

#define T double
#define SQRT sqrt
#define LARGEST DBL_MAX
#define F(x) x##_f64
#include "eliminate.h"

#define TABLE(p)                                                                            \
    {(void *)eliminate_##p, (void *)gram_##p, (void *)descend_##p, (void *)ascend_##p,      \
     (void *)apply_##p, (void *)symmetric_##p}
void *const JOIN(arael_eliminate, SET_NAME)[2][6] = {TABLE(f32), TABLE(f64)};
