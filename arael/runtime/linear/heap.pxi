"""Return of freed memory from the C library to the system."""

cdef extern from *:
    """
    #include <stdlib.h>
    #if defined(__GLIBC__)
    #include <malloc.h>
    static void heap_trim(void) { malloc_trim(0); }
    #else
    static void heap_trim(void) {}
    #endif
    """
    void heap_trim() nogil


def give_back():
    """Return freed memory between used blocks to the system.

    An analysis fragments the heap, and the few large arrays of a factorisation do not fit into the
    gaps.
    """
    with nogil:
        heap_trim()
