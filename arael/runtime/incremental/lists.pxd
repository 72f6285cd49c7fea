# Lists of integers that grow.

cdef struct IntList:
    int* at
    int count, room

cdef int push(IntList* list, int value) except -1
cdef void empty(IntList* list) noexcept
