"""Selection of the dense kernels in tiles.h for the current processor.

The header is compiled for several instruction sets; the best one that the processor supports is
selected at import (instruction_sets.pxi).
"""

cdef extern from "instruction_sets.h":
    ctypedef struct KernelSet:
        const char* name
        bint (*runs_here)() noexcept nogil
        void** tiles[2]
        void** eliminate[2]
    const KernelSet kernel_sets[1]
    enum: KERNEL_SETS


# Without wide vectors the BLAS of the wheel, which has kernels for every processor, is faster.
cdef Py_ssize_t NARROW = 1536


cdef void take_tiles(int which):
    global tiles32, tiles64, large
    large = PY_SSIZE_T_MAX if which else NARROW
    cdef void** t = kernel_sets[which].tiles[0]
    tiles32.potrf, tiles32.trsm, tiles32.syrk = <potrf32_t>t[0], <trsm32_t>t[1], <syrk32_t>t[2]
    tiles32.multiply, tiles32.transposed = <multiply32_t>t[3], <multiply32_t>t[4]
    tiles32.forward, tiles32.backward = <sweep32_t>t[5], <sweep32_t>t[6]
    tiles32.extend_columns = <columns32_t>t[7]
    tiles32.extend_update = <update32_t>t[8]
    tiles32.lessen, tiles32.ascend = <lessen32_t>t[9], <ascend32_t>t[10]
    t = kernel_sets[which].tiles[1]
    tiles64.potrf, tiles64.trsm, tiles64.syrk = <potrf64_t>t[0], <trsm64_t>t[1], <syrk64_t>t[2]
    tiles64.multiply, tiles64.transposed = <multiply64_t>t[3], <multiply64_t>t[4]
    tiles64.forward, tiles64.backward = <sweep64_t>t[5], <sweep64_t>t[6]
    tiles64.extend_columns = <columns64_t>t[7]
    tiles64.extend_update = <update64_t>t[8]
    tiles64.lessen, tiles64.ascend = <lessen64_t>t[9], <ascend64_t>t[10]
