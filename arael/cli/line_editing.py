"""Editing lines at a prompt, with a persistent history; does nothing if Python has no readline."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

MAX_HISTORY = 2000
"""Number of lines in the history."""


def history_file(name: str = "calc_history") -> Path:
    """Path of a history: ``ARAEL_HISTORY``, else of this name in the user's data directory."""
    chosen = os.environ.get("ARAEL_HISTORY")
    if chosen:
        return Path(chosen)
    # imported here: start-up time
    from platformdirs import user_data_path

    return user_data_path("arael", appauthor=False) / name


@contextlib.contextmanager
def line_editing(names: Callable[[], list[str]], history: str = "calc_history") -> Iterator[None]:
    """Context in which `input` edits lines, recalls earlier ones, and completes `names` on Tab.

    A history that cannot be read or written is ignored. `history` is its file's name.
    """
    try:
        # imported here: start-up time
        import readline
    except ImportError:
        yield
        return
    path = history_file(history)
    before = readline.get_completer()

    def complete(word: str, state: int) -> str | None:
        found = [name for name in names() if name.startswith(word)]
        return found[state] if state < len(found) else None

    readline.set_completer(complete)
    readline.set_completer_delims(" \t\n+-*/^=<>()[],;|'")
    libedit = "libedit" in (getattr(readline, "__doc__", "") or "")
    readline.parse_and_bind("bind ^I rl_complete" if libedit else "tab: complete")
    readline.clear_history()
    with contextlib.suppress(OSError, UnicodeError):
        readline.read_history_file(path)
    try:
        yield
    finally:
        readline.set_completer(before)
        readline.set_history_length(MAX_HISTORY)
        with contextlib.suppress(OSError):
            _write(path, readline.write_history_file)


def _write(path: Path, write: Callable[[Path], None]) -> None:
    """Write the history so that only its owner can read it."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600))
    write(path)
