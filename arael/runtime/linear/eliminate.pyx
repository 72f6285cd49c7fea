# cython: language_level=3
# distutils: include_dirs = arael/runtime/linear
# distutils: depends = arael/runtime/linear/eliminate.h arael/runtime/linear/instances.h
"""Selection of the kernels in eliminate.h for the current processor.

The header is compiled for several instruction sets; the best one that the processor supports is
selected at import. `use` selects another one, for tests and comparisons.
"""

import numpy as np

from arael.runtime.address cimport address

from arael.runtime.records import check_record, probe_of

cdef extern from *:
    """
    #define KERNELS "eliminate.h"
    #include "instances.h"

    #define ELIMINATE_TABLE(p, set) {(void *)eliminate_##p##_##set, (void *)gram_##p##_##set, \\
        (void *)descend_##p##_##set, (void *)ascend_##p##_##set, (void *)apply_##p##_##set, \\
        (void *)symmetric_##p##_##set}
    static void *eliminate_tables[2][3][6] = {
    #if KERNEL_X86
        {ELIMINATE_TABLE(f32, base), ELIMINATE_TABLE(f32, avx2), ELIMINATE_TABLE(f32, avx512)},
        {ELIMINATE_TABLE(f64, base), ELIMINATE_TABLE(f64, avx2), ELIMINATE_TABLE(f64, avx512)},
    #else
        {ELIMINATE_TABLE(f32, base)}, {ELIMINATE_TABLE(f64, base)},
    #endif
    };
    """
    void* eliminate_tables[2][3][6]
    int kernel_sets() nogil

_NAMES = ("base", "avx2", "avx512")

#: Records of the tables for the kernels.
ENTITY = np.dtype(
    [(name, np.int64) for name in ("scalar", "source", "factor", "couplings", "size")]
)
COUPLING = np.dtype(
    [(name, np.int64) for name in ("source", "place")]
    + [(name, np.int32) for name in ("padded", "width", "turned", "kept")]
)
BLOCK = np.dtype(
    [("place", np.int64)] + [(name, np.int32) for name in ("row", "column", "height", "width")]
)
one = probe_of(ENTITY)
check_record("Entity", ENTITY, (<const Entity*>address(one, ENTITY))[0], sizeof(Entity))
one = probe_of(COUPLING)
check_record("Coupling", COUPLING, (<const Coupling*>address(one, COUPLING))[0], sizeof(Coupling))
one = probe_of(BLOCK)
check_record("Block", BLOCK, (<const Block*>address(one, BLOCK))[0], sizeof(Block))

#: Padding of a list of pairs, in int32.
SLACK = PAIRS_AHEAD + 2


cdef void _take(int which):
    global f32, f64
    cdef void** t = eliminate_tables[0][which]
    f32.eliminate, f32.gram = <eliminate32_t>t[0], <gram32_t>t[1]
    f32.descend, f32.ascend = <sweep32_t>t[2], <sweep32_t>t[3]
    f32.apply, f32.symmetric = <apply32_t>t[4], <symmetric32_t>t[5]
    t = eliminate_tables[1][which]
    f64.eliminate, f64.gram = <eliminate64_t>t[0], <gram64_t>t[1]
    f64.descend, f64.ascend = <sweep64_t>t[2], <sweep64_t>t[3]
    f64.apply, f64.symmetric = <apply64_t>t[4], <symmetric64_t>t[5]


def available():
    """Names of the supported instruction sets, the best one last."""
    return _NAMES[: kernel_sets()]


def use(name):
    """Select the kernels of instruction set `name` for the whole process."""
    if name not in available():
        raise ValueError(f"instruction set {name!r} is not among {available()}")
    _take(_NAMES.index(name))


use(available()[-1])
