"""Exclusion of concurrent solves and changes of rows of a model instance."""

from __future__ import annotations

from contextlib import AbstractContextManager
from threading import RLock, Thread, current_thread

from arael.runtime.store.messages import error


class Use:
    """The thread that solves an instance, and a lock for operations that must not overlap.

    Rows may be added or removed, and refs changed, only while no solve runs, because a solve reads
    arrays that were allocated for the rows at its start. Preparing a problem and changing rows hold
    the lock and wait for each other, since both are short. Solves may be long: a conflicting
    operation fails at once. Values of fields may be written at any time.

    Parameters
    ----------
    name : of the instance's root struct, for messages
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.lock = RLock()
        self._solver: Thread | None = None
        self._depth = 0

    def solving(self) -> AbstractContextManager[None]:
        """Mark the instance as being solved by this thread; a solve within a solve is allowed.

        Raises
        ------
        AraelError
            E1040: another thread solves it.
        """
        return _Solving(self)

    def _begin(self) -> None:
        own = current_thread()
        with self.lock:
            if self._solver is not None and self._solver is not own and self._solver.is_alive():
                raise self._in_use(f"thread `{own.name}` cannot solve `{self.name}`")
            if self._solver is not own:  # or its thread does not exist after a fork
                self._solver, self._depth = own, 0
            self._depth += 1

    def _end(self) -> None:
        with self.lock:
            self._depth -= 1
            if self._depth == 0:
                self._solver = None

    def changing(self, what: str) -> AbstractContextManager[None]:
        """Context that holds the lock while rows or refs are changed.

        Parameters
        ----------
        what : description of the change, with an infinitive: ``add rows to `poses` ``

        Raises
        ------
        AraelError
            E1040: the instance is being solved, by another thread or by a caller in this one.
        """
        return _Changing(self, what)

    def _require_unused(self, what: str) -> None:
        solver = self._solver
        if solver is None:
            return
        if solver is current_thread():
            raise error(
                "E1040",
                f"cannot {what} while `{self.name}` is being solved",
                self.name,
                help="an observer or driver may read the model and write values: record the "
                "rows to add or remove, end the solve by returning False, and change the "
                "rows after `solve` has returned",
            )
        if solver.is_alive():
            raise self._in_use(f"thread `{current_thread().name}` cannot {what}")

    def _in_use(self, refused: str) -> Exception:
        assert self._solver is not None
        return error(
            "E1040",
            f"{refused}: thread `{self._solver.name}` is solving `{self.name}`",
            self.name,
            help="use a separate model instance for each thread, or guard solves and changes of "
            "rows by one `threading.Lock`",
        )


class _Solving(AbstractContextManager[None]):
    """What `Use.solving` returns; a generator would take a microsecond more of each solve."""

    __slots__ = ("_use",)

    def __init__(self, use: Use) -> None:
        self._use = use

    def __enter__(self) -> None:
        self._use._begin()

    def __exit__(self, *exception: object) -> None:
        self._use._end()


class _Changing(AbstractContextManager[None]):
    """What `Use.changing` returns; a generator would take a tenth of the time of adding a row."""

    __slots__ = ("_use", "_what")

    def __init__(self, use: Use, what: str) -> None:
        self._use = use
        self._what = what

    def __enter__(self) -> None:
        self._use.lock.acquire()
        try:
            self._use._require_unused(self._what)
        except BaseException:
            self._use.lock.release()
            raise

    def __exit__(self, *exception: object) -> None:
        self._use.lock.release()
