"""The Starlette application: static files of the page, the WebSocket, agents at ``/mcp``."""

from __future__ import annotations

import asyncio
import secrets
import threading
import time
from collections import deque
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.routing import BaseRoute, Mount, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from arael.diagnostics.records import AraelError
from arael.sketch.server.guard import Guard
from arael.sketch.server.page_files import PageFiles
from arael.sketch.server.protocol import json_message, received
from arael.sketch.server.windows import Window
from arael.sketch.server.worker import Worker

PAGE = Path(__file__).resolve().parents[1] / "page"
"""Folder of the page's files."""

BUSY_AFTER = 0.1
"""Seconds after which pages are sent that something runs."""

MAX_BEHIND = 64 * 1024 * 1024
"""Bytes that wait for a page that reads too slowly; then it is disconnected."""


class SocketLink:
    """The way to a page over a WebSocket: a queue that one task sends.

    Parameters
    ----------
    loop : of the task
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._queue: deque[bytes] = deque()
        self._bytes = 0
        self._lock = threading.Lock()
        self._wake = asyncio.Event()
        self.ended = False

    @property
    def is_behind(self) -> bool:
        """Whether messages wait to be sent."""
        return bool(self._queue)

    def send(self, data: bytes) -> None:
        """Send a message, or put it in the queue; by any thread."""
        if self.ended:
            return
        with self._lock:
            self._queue.append(data)
            self._bytes += len(data)
            if self._bytes > MAX_BEHIND:
                self.ended = True
        try:
            self._loop.call_soon_threadsafe(self._wake.set)
        except RuntimeError:  # the loop has ended
            self.ended = True

    async def pump(self, socket: WebSocket) -> None:
        """Send what is put into the queue, until the page is too far behind."""
        try:
            while not self.ended:
                await self._wake.wait()
                self._wake.clear()
                while self._queue and not self.ended:
                    with self._lock:
                        data = self._queue.popleft()
                        self._bytes -= len(data)
                    await socket.send_bytes(data)
            await socket.close(4408, "too slow")
        except (WebSocketDisconnect, RuntimeError):  # the page is gone
            self.ended = True


class Server:
    """The application and what it shares.

    Parameters
    ----------
    worker : of the sketch
    tokens : by path, as `Guard`
    agents : of `arael.sketch.agents`, None without them
    page : folder of static files
    """

    def __init__(
        self, worker: Worker, tokens: Mapping[str, str], agents: Any = None, page: Path = PAGE
    ) -> None:
        self.worker = worker
        self.shared = worker.shared
        self._agents = agents
        routes: list[BaseRoute] = [WebSocketRoute("/socket", self._socket)]
        if agents is not None:
            routes += agents.routes
        routes.append(Mount("/", PageFiles(directory=page, html=True, check_dir=False)))
        self.app = Guard(Starlette(routes=routes, lifespan=self._lifespan), tokens)

    @asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        async with AsyncExitStack() as stack:
            if self._agents is not None:
                await stack.enter_async_context(self._agents.running())
            self.worker.start()
            try:
                yield
            finally:
                await asyncio.to_thread(self.worker.stop)

    async def _socket(self, socket: WebSocket) -> None:
        await socket.accept()
        loop = asyncio.get_running_loop()
        link = SocketLink(loop)
        name = socket.query_params.get("window", "")[:64] or f"window-{secrets.token_hex(8)}"
        since = socket.query_params.get("since", "")
        revision = int(since) if since.isdigit() and len(since) < 12 else -1
        try:
            opening = self.worker.call(lambda: self.shared.open(name, link, revision))
            window = await asyncio.wrap_future(opening)
        except AraelError as error:
            await socket.close(4409, error.diagnostics[0].message[:100])
            return
        pump = asyncio.create_task(link.pump(socket))
        try:
            await self._read(socket, window)
        finally:
            link.ended = True
            pump.cancel()
            self.worker.call(lambda: self.shared.close(window))

    async def _read(self, socket: WebSocket, window: Window) -> None:
        loop = asyncio.get_running_loop()
        try:
            while True:
                message = await socket.receive()
                if message["type"] == "websocket.disconnect":
                    return
                data = message.get("bytes")
                try:
                    found = received(data if data is not None else b"")
                except AraelError as error:
                    text = error.diagnostics[0].message
                    window.send({"type": "message", "level": "error", "text": text})
                    continue
                self.worker.receive(window, found)
                if isinstance(found, dict):
                    loop.call_later(BUSY_AFTER, self._report_busy)
        except WebSocketDisconnect:
            return

    def _report_busy(self) -> None:
        """Send that something runs for long, and when it has ended."""
        began = self.worker.began
        if not began or self.worker.reported:
            return
        since = time.monotonic() - began
        loop = asyncio.get_running_loop()
        if since < BUSY_AFTER:
            loop.call_later(BUSY_AFTER - since, self._report_busy)
            return
        self.worker.reported = True
        self._send_all({"type": "busy", "since_ms": round(1e3 * since), "what": "solving"})
        loop.call_later(0.05, self._report_idle, began)

    def _report_idle(self, began: float) -> None:
        if self.worker.began == began:
            asyncio.get_running_loop().call_later(0.05, self._report_idle, began)
            return
        if self.worker.began:  # what waited behind it runs now
            asyncio.get_running_loop().call_later(BUSY_AFTER, self._report_busy)
        self.worker.reported = False
        self._send_all({"type": "idle"})

    def _send_all(self, content: dict[str, Any]) -> None:
        data = json_message(content, self.shared.revision)
        for window in list(self.shared.windows.values()):
            window.link.send(data)
