# Threads that share the items of a job; see pool.h.

ctypedef void (*Task)(void* job, Py_ssize_t item) noexcept nogil

# Do task(job, i) for i in range(items) on up to `threads` threads; returns when all are done. The
# GIL must not be asked for by a task. What comes out may depend on the items, not on who did them.
cdef void distribute(int threads, Py_ssize_t items, Task task, void* job) noexcept nogil

# A place among `count`, all of them free at first (0), that no other thread of a job has, and back
# again. For room that a task needs while it runs: there must be a place for every thread.
cdef int claim(int* busy, int count) noexcept nogil
cdef void release(int* busy, int place) noexcept nogil
