"""Log messages: the logger ``arael`` of Python's `logging`, silent by default.

| logger | level | message |
|---|---|---|
| ``arael.solve`` | debug | every attempted step, the lines of the verbose trace |
| ``arael.solve`` | info | every pass: status, cost, iterations, time, linear solver |
| ``arael.solve`` | info | residuals by own code without Jacobians: central differences |
| ``arael.solve`` | warning | a pass that ended without converging; notes on a result |
| ``arael.compile`` | info | a model was compiled, with the time it took |
| ``arael.compile`` | debug | a compiled model was found, with its place |

Nothing is printed without a handler. A program that configures `logging` receives these messages
like those of any other library; `log_to` is for programs that do not.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TextIO

from arael.diagnostics.records import AraelError, Diagnostic

if TYPE_CHECKING:
    import logging

Sink = Callable[[str], object]

LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40}
"""Levels by name, with the numbers of `logging`."""


_loggers: dict[str, logging.Logger] = {}


def logger(name: str, level: int) -> logging.Logger | None:
    """The logger ``arael.<name>`` if it has a handler for `level`, else None.

    If `logging` is not imported there is no handler, and it is not imported here, which would take
    as long as a small solve.
    """
    loaded = sys.modules.get("logging")
    if loaded is None:
        return None
    found = _loggers.get(name)
    if found is None:
        # Kept: to look one up takes a lock, and a small solve takes microseconds.
        found = _loggers[name] = loaded.getLogger(f"arael.{name}")
    # A library does not use the handler of last resort, which prints warnings on stderr.
    return found if found.isEnabledFor(level) and found.hasHandlers() else None


def log(name: str, level: str, message: str) -> None:
    """Log `message` to the logger ``arael.<name>``, if it has a handler."""
    number = LEVELS[level]
    found = logger(name, number)
    if found is not None:
        found.log(number, "%s", message)


class LogSink:
    """A handler installed by `log_to`; `close`, or the end of a ``with``, removes it."""

    def __init__(self, handler: logging.Handler) -> None:
        self._handler = handler
        _sinks.append(self)
        _adjust()

    def close(self) -> None:
        """Listen no more."""
        if self in _sinks:
            _sinks.remove(self)
            _adjust()

    def __enter__(self) -> LogSink:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_sinks: list[LogSink] = []
_level_before: list[int] = []


def _adjust() -> None:
    """Let the logger hear what its sinks want, and have its own level back when there are none."""
    # imported here: start-up time
    import logging

    root = logging.getLogger("arael")
    for handler in [h for h in root.handlers if getattr(h, "of_arael", False)]:
        root.removeHandler(handler)
    if not _sinks:
        root.setLevel(_level_before.pop() if _level_before else logging.NOTSET)
        return
    if not _level_before:
        _level_before.append(root.level)
    root.setLevel(min(sink._handler.level for sink in _sinks))
    for sink in _sinks:
        root.addHandler(sink._handler)


def log_to(sink: Sink | TextIO | None = None, level: str = "info") -> LogSink:
    """Send the messages of arael to `sink`.

    Parameters
    ----------
    sink : called with each message; or an open text file; None: stderr
    level : least level that is heard: ``"debug"`` (every step of a solve), ``"info"`` (every pass,
        every compilation), ``"warning"`` or ``"error"``

    Returns
    -------
    LogSink
        Its ``close()`` ends it, or use it in a ``with``.

    Raises
    ------
    AraelError
        E1010 for an unknown level or a sink that takes no messages.
    """
    if level not in LEVELS:
        raise _refused(f"there is no log level {level!r}", f"levels are {', '.join(LEVELS)}")
    write = _writer(sys.stderr if sink is None else sink)
    # imported here: start-up time
    import logging

    class Handler(logging.Handler):
        of_arael = True

        def emit(self, record: logging.LogRecord) -> None:
            # What a sink raises is its owner's business and must not be swallowed.
            write(record.getMessage())

    return LogSink(Handler(LEVELS[level]))


def _writer(sink: Any) -> Sink:
    if callable(sink):
        write: Sink = sink
        return write
    if not hasattr(sink, "write"):
        raise _refused(f"{sink!r} takes no messages", "give a function of one string, or a file")

    def to_file(message: str) -> None:
        sink.write(message + "\n")
        sink.flush()

    return to_file


def _refused(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E1010", message, origin="log_to", help=(advice,)))
