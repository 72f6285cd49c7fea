# Ascending order in place; the C library's qsort may allocate.

cdef inline void sort(int* x, Py_ssize_t count) noexcept nogil:
    """Shell sort, with the gaps of M. Ciura (2001): lists are short, or nearly in order."""
    cdef int* gaps = [1750, 701, 301, 132, 57, 23, 10, 4, 1]
    cdef Py_ssize_t i, j, k, gap
    cdef int value
    for k in range(9):
        gap = gaps[k]
        for i in range(gap, count):
            value = x[i]
            j = i
            while j >= gap and x[j - gap] > value:
                x[j] = x[j - gap]
                j -= gap
            x[j] = value
