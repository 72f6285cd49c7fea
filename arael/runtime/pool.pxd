# Threads that share the items of a job; see pool.h.

ctypedef void (*Task)(void* job, Py_ssize_t item) noexcept nogil

# Do task(job, i) for i in range(items) on up to `threads` threads; returns when all are done. The
# GIL must not be asked for by a task. What comes out may depend on the items, not on who did them.
cdef void distribute(int threads, Py_ssize_t items, Task task, void* job) noexcept nogil
