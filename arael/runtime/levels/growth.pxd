# Memory that grows.

from libc.stdlib cimport realloc


# Memory of `count` items, at least one, with what was there; MemoryError where there is none.
cdef inline void* grown(void* memory, Py_ssize_t count, size_t size) except NULL:
    memory = realloc(memory, max(count, 1) * size)
    if memory == NULL:
        raise MemoryError
    return memory
