/* The dense kernels of tiles.h for one instruction set, in both precisions. */

#include "instruction_set.h"

#define NC 6

#define T float
#define INTEGER int
#define BYTES 4
#define SQRT sqrtf
#define LARGEST FLT_MAX
#define F(x) x##_f32
#include "tiles.h"
#undef T
#undef INTEGER
#undef BYTES
#undef SQRT
#undef LARGEST
#undef F

#define T double
#define INTEGER long long
#define BYTES 8
#define SQRT sqrt
#define LARGEST DBL_MAX
#define F(x) x##_f64
#include "tiles.h"

#define TABLE(p)                                                                              \
    {(void *)potrf_##p, (void *)trsm_##p, (void *)syrk_##p, (void *)multiply_##p,             \
     (void *)transposed_##p, (void *)forward_##p, (void *)backward_##p,                       \
     (void *)extend_columns_##p, (void *)extend_update_##p, (void *)lessen_##p, (void *)ascend_##p}
void *const JOIN(arael_tiles, SET_NAME)[2][11] = {TABLE(f32), TABLE(f64)};
