"""The editor's server in a thread of the test's process, which begins in a moment."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import TracebackType

STARTED_WITHIN = 60.0


class InsideServer:
    """What `arael sketch --serve FILE` runs, until the block ends; for tests that kill none.

    Attributes
    ----------
    address : of the page, with its token
    port, token : the parts of it
    agents : address for agents
    file : that is served
    """

    def __init__(self, file: Path | str, *, allow_agents: bool = False) -> None:
        self.file = str(file)
        self._allow_agents = allow_agents

    def start(self) -> InsideServer:
        """Start it and wait until it listens."""
        import uvicorn

        from arael.sketch.server.serving import config, opened

        lines: list[str] = []
        found = opened(self.file, 0, self._allow_agents, lines.append)
        self.address = found.address
        self.port = found.listener.getsockname()[1]
        self.token = found.address.split("token=")[1]
        self.agents = lines[-1].split()[-1]
        self._server = uvicorn.Server(config(found.server.app))
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [found.listener]}, daemon=True
        )
        self._thread.start()
        end = time.monotonic() + STARTED_WITHIN
        while not self._server.started:
            assert time.monotonic() < end, "the server did not start"
            time.sleep(0.005)
        return self

    @property
    def socket(self) -> str:
        """Address of the WebSocket, to which `&window=` may be added."""
        return f"ws://127.0.0.1:{self.port}/socket?token={self.token}"

    def stop(self) -> None:
        """End it as Ctrl-C does."""
        self._server.should_exit = True
        self._thread.join(20)

    def __enter__(self) -> InsideServer:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
