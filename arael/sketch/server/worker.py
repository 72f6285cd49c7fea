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


class Worker:
    """Runs everything that touches a sketch, one after the other, in one thread.

    Of several places of a window's pointer that wait behind each other the newest is used.

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

    def receive(self, window: Window, message: DragTo | dict[str, Any]) -> None:
        """Put a message of a page in line; by any thread."""
        if isinstance(message, DragTo):
            with self._wake:
                waits = window in self._places
                self._places[window] = message
            if not waits:
                self._put(partial(self._drag, window))
            return
        if message["type"] == "break":
            self.shared.interrupt()
            self._put(self.shared.resume)  # what waits until then is broken off as well
            return
        self._put(lambda: self.shared.receive(window, message))

    def _drag(self, window: Window) -> None:
        with self._wake:
            place = self._places.pop(window)
        self.shared.receive(window, place)

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
                if not self._inbox and not self._ended:
                    self._wake.wait(wait)
                job = self._inbox.popleft() if self._inbox else None
                if job is None and self._ended:
                    break
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
