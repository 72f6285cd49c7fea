"""What a solve has to do with Python and the clock: watcher, Ctrl-C, exceptions, records, times."""

import numpy as np

from cpython.exc cimport PyErr_CheckSignals

from arael.runtime.address cimport writable
from arael.runtime.levenberg.clock cimport seconds


# Seconds between looks at pending signals (Ctrl-C): each takes the GIL.
cdef double SIGNAL_INTERVAL = 0.02


cdef class Supervised:
    """Base of the loop, which runs without the GIL and asks for it here."""

    def watch(self, watcher, Py_ssize_t places):
        """Let `watcher` look on, and have places for so many records."""
        self._watcher, self._history = watcher, History(places)

    @property
    def history(self):
        """Attempts so far, as a structured array of `RECORD`."""
        return self._history.array()

    @property
    def timing(self):
        """Seconds per phase."""
        return {
            "first_factor": self._phases[FIRST_FACTOR],
            "linearise": self._phases[LINEARISE],
            "factor": self._phases[FACTOR],
            "solve": self._phases[SOLVE],
            "refresh": self._phases[REFRESH],
            "cost": self._phases[COST],
        }

    cdef bint _interrupted(self) noexcept nogil:
        cdef double now = seconds()
        if now - self._last_check < SIGNAL_INTERVAL:
            return False
        self._last_check = now
        with gil:
            return self._signalled()

    def _signalled(self):
        try:
            PyErr_CheckSignals()
        except KeyboardInterrupt:
            return True
        except BaseException as error:
            self._failure = error
            return True
        return False

    def _start(self):
        try:
            self._watcher.started(self)
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef void _take_failure(self) noexcept nogil:
        if self.evaluation.raised.any or self.solver.raised.any:
            with gil:
                self._raise_later()

    def _raise_later(self):
        try:
            self.solver.raised.again()
            self.evaluation.raise_failure()
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef _show(self):
        try:
            if not self._watcher.stepped(self, self._record()):
                self._status = OBSERVER_TERMINATED
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    def _record(self):
        """The present attempt as one structured scalar."""
        record = np.empty(1, dtype=RECORD)
        (<Record*>writable(record, RECORD))[0] = self._now
        return record[0]

    cdef void _keep_record(self) noexcept nogil:
        if not self._history.keep(&self._now):
            with gil:
                self._make_place()
            if not self._history.keep(&self._now):
                return
        self.attempts += 1

    def _make_place(self):
        # Python may find a signal here before the loop does.
        try:
            self._history.double()
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef void _lap(self, int phase) noexcept nogil:
        cdef double now = seconds()
        self._phases[phase] += now - self._mark
        self._mark = now
