# cython: language_level=3
"""What the C library keeps of memory that was freed."""

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
    """Give the system what was freed and lies between what is in use.

    An analysis leaves many holes that the few large arrays of a factorisation do not fit into.
    """
    with nogil:
        heap_trim()
