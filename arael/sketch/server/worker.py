"""The thread that changes the document: messages in turn, places of the pointer merged."""

from __future__ import annotations

import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

from arael.sketch.server.protocol import DragTo
from arael.sketch.server.shared import SharedSketch
from arael.sketch.server.windows import Window

_T = TypeVar("_T")

SHORT = 0.01
"""Seconds of a frame of a drag up to which it is made by the thread that received its place."""


class Worker:
    """Runs everything that touches a sketch, one after the other, in one thread.

    Of several places of a window's pointer that wait behind each other the newest is used. While
    nothing runs or waits, a thread that received a place makes its frame itself, as long as frames
    are short: to hand it over to another thread and back takes a third of the time of the solver
    at 500 constraints.

    Parameters
    ----------
    shared : the sketch; after `start` only this class calls it

    Attributes
    ----------
    began : when what runs now began, by `time.monotonic`; 0 while nothing runs
    reported : whether pages know that it runs for long
    """

    def __init__(self, shared: SharedSketch) -> None:
        self.shared = shared
        self.began = 0.0
        self.reported = False
        self._inbox: deque[Callable[[], None]] = deque()
        self._places: dict[Window, DragTo] = {}
        self._wake = threading.Condition()
        self._ended = False
        self._taken = True  # something touches the sketch; the thread, before it starts
        self._frame_took = 0.0
        self._thread = threading.Thread(target=self._work, name="sketch", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """Do what waits, close the sketch, end."""
        with self._wake:
            self._ended = True
            self._wake.notify()
        self._thread.join()

    def receive(
        self,
        window: Window,
        message: DragTo | dict[str, Any],
        soon: Callable[[Callable[[], None]], object] | None = None,
    ) -> None:
        """Put a message of a page in line; by any thread.

        Parameters
        ----------
        soon : calls a function in a thread of the caller, at once or after the messages that it has
            received already; None: only the worker's thread makes frames
        """
        if isinstance(message, DragTo):
            with self._wake:
                waits = window in self._places
                self._places[window] = message
                if waits:
                    return
                job = partial(self._drag, window)
                here = not (self._taken or self._inbox) and self._frame_took < SHORT
                self._inbox.append(job)
                if not here or soon is None:
                    self._wake.notify()
                    return
            soon(partial(self._drag_here, job))
            return
        if message["type"] == "break":
            self.shared.interrupt()
            self._put(self.shared.resume)  # what waits until then is broken off as well
            return
        self._put(lambda: self.shared.receive(window, message))

    def _drag(self, window: Window) -> None:
        with self._wake:
            place = self._places.pop(window)
        began = time.monotonic()
        try:
            self.shared.receive(window, place)
        finally:
            self._frame_took = time.monotonic() - began

    def _drag_here(self, job: Callable[[], None]) -> None:
        """Make a frame in this thread, if it is still the first in line."""
        with self._wake:
            if self._taken or not self._inbox or self._inbox[0] is not job:
                self._wake.notify()
                return
            self._inbox.popleft()
            self._taken = True
        self._safely(job)
        with self._wake:
            self._taken = False
            if self._inbox or self._ended or self.shared.is_unfinished:
                self._wake.notify()

    def call(self, function: Callable[[], _T]) -> Future[_T]:
        """Call a function in the thread; by any thread."""
        future: Future[_T] = Future()

        def run() -> None:
            if not future.set_running_or_notify_cancel():
                return
            try:
                future.set_result(function())
            except BaseException as error:  # given to the caller
                future.set_exception(error)

        self._put(run)
        return future

    def _put(self, job: Callable[[], None]) -> None:
        with self._wake:
            self._inbox.append(job)
            self._wake.notify()

    def _work(self) -> None:
        wait: float | None = 0.0
        while True:
            with self._wake:
                self._taken = False
                if not self._inbox and not self._ended:
                    self._wake.wait(wait)
                while self._taken:  # another thread makes a frame
                    self._wake.wait(SHORT)
                job = self._inbox.popleft() if self._inbox else None
                if job is None and self._ended:
                    break
                self._taken = True
            self.began = time.monotonic()
            if job is None:
                wait = self._safely(self.shared.idle)
            else:
                self._safely(job)
                wait = 0.0
            self.began = 0.0
        self._safely(self.shared.finish)

    def _safely(self, job: Callable[[], _T]) -> _T | None:
        """Run a job; a mistake of arael is printed and does not end the thread."""
        try:
            return job()
        except Exception:
            traceback.print_exc(file=sys.stderr)
            return None
