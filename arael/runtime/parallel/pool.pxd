# Threads that share the items of a job; see pool.h.

ctypedef void (*Task)(void* job, Py_ssize_t item) noexcept nogil

# Run task(job, i) for i in range(items) on up to `threads` threads; returns when all are done. A
# task must not acquire the GIL. Results must depend on the items, not on the threads.
cdef void distribute(int threads, Py_ssize_t items, Task task, void* job) noexcept nogil

# Acquire and release one of `count` workspaces, exclusive among the threads of a job; `busy` is
# initially 0. There must be a workspace for every thread.
cdef int claim(int* busy, int count) noexcept nogil
cdef void release(int* busy, int place) noexcept nogil
