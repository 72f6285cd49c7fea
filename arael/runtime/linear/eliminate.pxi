"""Selection of the kernels in eliminate.h for the current processor.

The header is compiled for several instruction sets; the best one that the processor supports is
selected at import (instruction_sets.pxi).
"""

import numpy as np

from arael.runtime.address cimport address

from arael.runtime.records import check_record, probe_of

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


cdef void take_blocks(int which):
    global blocks32, blocks64
    cdef void** t = kernel_sets[which].eliminate[0]
    blocks32.eliminate, blocks32.gram = <eliminate32_t>t[0], <gram32_t>t[1]
    blocks32.descend, blocks32.ascend = <descend32_t>t[2], <descend32_t>t[3]
    blocks32.apply, blocks32.symmetric = <apply32_t>t[4], <symmetric32_t>t[5]
    t = kernel_sets[which].eliminate[1]
    blocks64.eliminate, blocks64.gram = <eliminate64_t>t[0], <gram64_t>t[1]
    blocks64.descend, blocks64.ascend = <descend64_t>t[2], <descend64_t>t[3]
    blocks64.apply, blocks64.symmetric = <apply64_t>t[4], <symmetric64_t>t[5]
