"""Kernels compiled by another process while this one uses the expression machine.

The other process stores them in the cache, where this one finds them. It continues if this one
ends, so that the next session finds the kernels.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from typing import Any

from arael.compiler.cache.keys import code_digest
from arael.compiler.kernels import find_kernels, kernels_of
from arael.diagnostics.records import AraelError

# The path of modules is set before anything is imported: `-c` would look into the working folder.
_CHILD = """
import sys
sys.path[:] = sys.argv[3:]
from arael.compiler.meanwhile import main
main(sys.argv[1], sys.argv[2])
"""


class Meanwhile:
    """A compilation in the background.

    Parameters
    ----------
    source : Cython source
    name : of the model
    origin : the model's file

    Attributes
    ----------
    failure : why there will be no kernels; "" as long as there may be
    """

    def __init__(self, source: str, name: str, origin: str) -> None:
        self.failure = ""
        self._code = code_digest(source)
        self._table: Any = None
        self._task = threading.Thread(
            target=self._run, args=(source, name, origin), daemon=True, name="arael compilation"
        )
        self._task.start()

    @property
    def kernels(self) -> Any:
        """The table of kernels, or None as long as there is none."""
        return None if self._task.is_alive() else self._table

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the compilation has ended, or for `timeout` seconds; return whether it has."""
        self._task.join(timeout)
        return not self._task.is_alive()

    def _run(self, source: str, name: str, origin: str) -> None:
        try:
            self.failure = _compile(source, name, origin)
            if not self.failure:
                kernels = find_kernels(self._code)
                self._table = None if kernels is None else kernels.table
                if self._table is None:
                    self.failure = "the kernels that were compiled cannot be loaded"
        except AraelError as error:
            self.failure = error.diagnostics[0].message
        except Exception as error:  # a thread has no caller to raise to
            self.failure = f"{type(error).__name__}: {error}"


def _compile(source: str, name: str, origin: str) -> str:
    """Compile in a separate process; return why that failed, or ""."""
    if "python" not in os.path.basename(sys.executable or ""):
        kernels_of(source, name, origin)  # an embedded Python: in this thread
        return ""
    done = subprocess.run(
        [sys.executable, "-c", _CHILD, name, origin, *sys.path],
        input=source.encode(),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for this process
        check=False,
    )
    if done.returncode == 0:
        return ""
    text = done.stdout.decode("utf-8", "replace").strip()
    return text or f"the process that compiled ended with status {done.returncode}"


def main(name: str, origin: str) -> None:
    """Compile the source on stdin into the cache; the reason of a failure goes to stdout."""
    sys.stdin.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    try:
        kernels_of(sys.stdin.read(), name, origin)
    except AraelError as error:
        print(error.diagnostics[0].message)
        sys.exit(1)
