"""Which thread uses a model instance, so that no solve meets rows that another thread moves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock, Thread, current_thread

from arael.runtime.store.messages import error


class Use:
    """Who solves an instance at present, and a lock for what must not overlap.

    Rows may only be added, removed or referred to otherwise while nothing solves: the arrays that
    a solve reads were laid out for the rows that were there when it began. Preparing a problem and
    changing rows hold the lock and wait for each other, as both are short. Solves may be long: what
    conflicts with one is refused at once. Values of fields may be written at any time.

    Parameters
    ----------
    name : of the instance's root struct, for messages
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.lock = RLock()
        self._solver: Thread | None = None
        self._depth = 0

    @contextmanager
    def solving(self) -> Iterator[None]:
        """Mark the instance as being solved by this thread; a solve within a solve is allowed.

        Raises
        ------
        AraelError
            E1040: another thread solves it.
        """
        own = current_thread()
        with self.lock:
            if self._solver is not None and self._solver is not own and self._solver.is_alive():
                raise self._in_use(f"thread `{own.name}` cannot solve `{self.name}`")
            if self._solver is not own:  # or its thread did not survive a fork
                self._solver, self._depth = own, 0
            self._depth += 1
        try:
            yield
        finally:
            with self.lock:
                self._depth -= 1
                if self._depth == 0:
                    self._solver = None

    @contextmanager
    def changing(self, what: str) -> Iterator[None]:
        """Hold the lock while rows or refs are changed.

        Parameters
        ----------
        what : the change in words, with an infinitive: ``add rows to `poses` ``

        Raises
        ------
        AraelError
            E1040: the instance is being solved, by another thread or further up in this one.
        """
        with self.lock:
            solver = self._solver
            if solver is current_thread():
                raise error(
                    "E1040",
                    f"cannot {what} while `{self.name}` is being solved",
                    self.name,
                    help="an observer or driver may read the model and write values: keep what is "
                    "to be added or removed, end the solve by returning False, and change the "
                    "rows when `solve` has returned",
                )
            if solver is not None and solver.is_alive():
                raise self._in_use(f"thread `{current_thread().name}` cannot {what}")
            yield

    def _in_use(self, refused: str) -> Exception:
        assert self._solver is not None
        return error(
            "E1040",
            f"{refused}: thread `{self._solver.name}` is solving `{self.name}`",
            self.name,
            help="give each thread a model instance of its own, or guard solves and changes of "
            "rows by one `threading.Lock`",
        )
