"""Lists of integers that grow."""

from libc.stdlib cimport free, realloc


cdef int push(IntList* list, int value) except -1:
    cdef int room
    cdef int* grown
    if list.count == list.room:
        room = max(8, 2 * list.room)
        grown = <int*>realloc(list.at, room * sizeof(int))
        if grown == NULL:
            raise MemoryError
        list.at, list.room = grown, room
    list.at[list.count] = value
    list.count += 1
    return 0


cdef void empty(IntList* list) noexcept:
    """Give the memory back."""
    free(list.at)
    list.at = NULL
    list.count = list.room = 0


cdef void* grown(void* memory, Py_ssize_t before, Py_ssize_t after, size_t item) except NULL:
    """Memory for `after` items, of which those beyond `before` are zero."""
    cdef char* found = <char*>realloc(memory, after * item)
    if found == NULL:
        raise MemoryError
    memset(found + before * item, 0, (after - before) * item)
    return found
