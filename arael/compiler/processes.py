"""Run a compiler as a process: bounded in time, with its temporary files in a folder of ours."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arael.compiler import progress


@dataclass(frozen=True)
class Finished:
    """How a process ended: its status (negative: the signal that ended it), and what it wrote."""

    status: int
    lines: tuple[str, ...]


class TimedOut(Exception):
    """A process took longer than its limit and was ended, with all that it had started."""


def run_bounded(
    command: Sequence[str], folder: Path, limit: float, what: str, spent: float = 0.0
) -> Finished:
    """Run `command` in `folder`, for at most `limit` seconds.

    Parameters
    ----------
    what : what is done, for reports of progress: ``compiling fit``
    spent : seconds that it has taken before this process, for the same

    Raises
    ------
    OSError
        It cannot be started.
    TimedOut
        It did not end in time.
    """
    group: dict[str, Any] = {} if sys.platform == "win32" else {"process_group": 0}
    # Temporary files are in a folder that no other user can write, and are removed with it.
    settings = {name: str(folder) for name in ("TMPDIR", "TMP", "TEMP")}
    settings["LC_ALL"] = "C"  # messages are searched for their cause
    process = subprocess.Popen(
        command,
        cwd=folder,
        env={**os.environ, **settings},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **group,
    )
    began = time.monotonic()
    try:
        with progress.step(what, limit) as note:
            while True:
                waited = time.monotonic() - began
                if waited >= limit:
                    raise TimedOut
                try:
                    out, err = process.communicate(timeout=min(1.0, limit - waited))
                    break
                except subprocess.TimeoutExpired:
                    note(spent + time.monotonic() - began)
    except BaseException:
        _end(process)
        raise
    text = (err.strip() or out.strip()).decode("utf-8", "replace")
    return Finished(process.returncode, tuple(text.splitlines()))


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and those that it started."""
    with contextlib.suppress(OSError):
        if sys.platform == "win32":
            process.kill()
        else:
            os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.communicate(timeout=5)
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
