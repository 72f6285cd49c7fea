"""Thread pool of a solve: availability, number of threads, distribution of work."""

import os

import numpy as np

cdef extern from "pool.h":
    enum:
        POOL_THREADS
        POOL_MOST
    void pool_share(int threads, Py_ssize_t items, Task task, void* job) noexcept nogil
    int pool_claim(int* busy, int count) noexcept nogil
    void pool_release(int* busy, int place) noexcept nogil
    int pool_helpers() noexcept nogil


cdef void distribute(int threads, Py_ssize_t items, Task task, void* job) noexcept nogil:
    pool_share(threads, items, task, job)


cdef int claim(int* busy, int count) noexcept nogil:
    return pool_claim(busy, count)


cdef void release(int* busy, int place) noexcept nogil:
    pool_release(busy, place)


def supported():
    """Whether this build supports threads; otherwise every solve runs on one."""
    return bool(POOL_THREADS)


def cores():
    """Number of cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def threads_for(num_threads):
    """Number of threads for `LmConfig.num_threads`: itself, or all cores for 0; at least 1."""
    if not POOL_THREADS:
        return 1
    return max(1, min(num_threads or cores(), POOL_MOST))


def helpers():
    """Current number of threads of the pool, without the callers."""
    return pool_helpers()


cdef struct Tally:
    long long* times
    long long* inner
    int threads
    Py_ssize_t items


cdef void count_one(void* job, Py_ssize_t item) noexcept nogil:
    (<long long*>job)[item] += 1


cdef void count_row(void* job, Py_ssize_t item) noexcept nogil:
    cdef Tally* tally = <Tally*>job
    tally.times[item] += 1
    pool_share(tally.threads, tally.items, count_one, tally.inner + item * tally.items)


def tally(int threads, Py_ssize_t items, Py_ssize_t inner=0):
    """Number of executions of each item of a job, and of each item of its nested jobs.

    Returns
    -------
    times : (items,) int64
    inner : (items, inner) int64
    """
    times = np.zeros(max(items, 1), dtype=np.int64)
    within = np.zeros((max(items, 1), max(inner, 1)), dtype=np.int64)
    cdef size_t first = times.ctypes.data, second = within.ctypes.data
    cdef Tally job
    job.times, job.inner = <long long*>first, <long long*>second
    job.threads, job.items = threads, inner
    with nogil:
        pool_share(threads, items, count_row, &job)
    return times[:items], within[:items, :inner]
