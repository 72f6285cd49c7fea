"""The editor's server as a process, as a person starts it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

_AGENTS = re.compile(r"agents connect to (http://\S+)")
_ADDRESS = re.compile(r"open (http://127\.0\.0\.1:(\d+)/\?token=(\S+))")
STARTED_WITHIN = 60.0


class ServerProcess:
    """`arael sketch --serve FILE` until the block ends, or `kill`.

    Attributes
    ----------
    address : of the page, with its token
    port, token : the parts of it
    agents : address for agents
    file : that is served
    """

    def __init__(self, file: Path | str | None, *options: str, folder: Path | None = None) -> None:
        self.command = [
            sys.executable,
            "-m",
            "arael",
            "sketch",
            "--serve",
            *([str(file)] if file else []),
            "--no-open",
            *options,
        ]
        self._folder = folder
        self.file = str(file or "")
        self._state = str(Path(self._folder or ".") / ".state")
        self.port, self.token, self.address, self.agents = 0, "", "", ""
        self.output = ""

    def start(self) -> ServerProcess:
        """Start it and wait for its address."""
        self.process = subprocess.Popen(
            self.command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=self._folder,
            env={**os.environ, "PYTHONUNBUFFERED": "1", "ARAEL_STATE_DIR": self._state},
        )
        assert self.process.stdout is not None
        end = time.monotonic() + STARTED_WITHIN
        for line in self.process.stdout:
            self.output += line
            found = _ADDRESS.search(line)
            if found:
                self.address, self.port, self.token = found[1], int(found[2]), found[3]
            found = _AGENTS.search(line)
            if found:
                self.agents = found[1]
                return self
            if time.monotonic() > end:
                break
        raise AssertionError(f"the server did not start:\n{self.output}")

    @property
    def socket(self) -> str:
        """Address of the WebSocket, to which `&window=` may be added."""
        return f"ws://127.0.0.1:{self.port}/socket?token={self.token}"

    def kill(self) -> None:
        """End it as a crash would: SIGKILL."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> int:
        """End it as Ctrl-C does; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(2)
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.kill()
        return self.process.returncode

    def __enter__(self) -> ServerProcess:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
        if self.process.stdout is not None:
            self.output += self.process.stdout.read()
            self.process.stdout.close()
