"""The record of an attempt, and those of all attempts of a solve."""

import numpy as np

from libc.string cimport memcpy

from arael.runtime.address cimport address, writable

from arael.runtime.records import check_record, probe_of

RECORD = np.dtype(
    [
        ("iteration", np.int32),
        ("retry", np.int32),
        ("accepted", np.int32),
        ("factored", np.int32),
        ("pivot", np.int64),
        ("cost", np.float64),
        ("trial_cost", np.float64),
        ("predicted", np.float64),
        ("promise", np.float64),
        ("radius", np.float64),
        ("damping", np.float64),
        ("next_damping", np.float64),
        ("step_norm", np.float64),
        ("gradient", np.float64),
        ("seconds", np.float64),
    ]
)

probe = probe_of(RECORD)
check_record("Record", RECORD, (<const Record*>address(probe, RECORD))[0], sizeof(Record))


cdef class History:
    """Records of attempts, as many as there is place for.

    Parameters
    ----------
    capacity : int
        Places at first.
    """

    def __init__(self, Py_ssize_t capacity):
        self.grow(capacity)

    def grow(self, Py_ssize_t capacity):
        """Have so many places; the records stay."""
        # Not zeroed: most of it is never touched.
        array = np.empty(capacity, dtype=RECORD)
        if self._array is not None:
            array[: len(self._array)] = self._array
        # Whatever may raise comes before the first change: the old records must stay reachable.
        cdef void* records = writable(array, RECORD, capacity)
        self._array, self._capacity, self._records = array, capacity, <Record*>records

    def double(self):
        """Have twice as many places."""
        self.grow(2 * self._capacity)

    def array(self):
        """Return the records as a structured array of `RECORD`."""
        # Copying records field by field takes longer than a small solve.
        found = np.empty(self.count, dtype=RECORD)
        memcpy(writable(found, RECORD), self._records, self.count * sizeof(Record))
        return found

    cdef bint keep(self, const Record* record) noexcept nogil:
        if self.count >= self._capacity:
            return False
        self._records[self.count] = record[0]
        self.count += 1
        return True
