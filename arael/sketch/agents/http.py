"""Agents over streamable HTTP, at ``/mcp`` of the editor's server."""

from __future__ import annotations

import asyncio
import importlib
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

from starlette.datastructures import Headers
from starlette.routing import BaseRoute, Route, Router
from starlette.types import ASGIApp, Receive, Scope, Send

if TYPE_CHECKING:
    from arael.sketch.agents.tools import Agents

if find_spec("mcp") is None:
    raise ModuleNotFoundError("No module named 'mcp'", name="mcp")

TOOLS = "arael.sketch.agents.tools"
"""The module of `Agents`. With the SDK it takes half of a server's start, so that it is imported
when the first agent comes."""
SESSION_HEADER = "mcp-session-id"
"""Names the session of an agent; `DELETE` ends it."""
MAX_BODY = 4 * 1024 * 1024
"""Bytes of a request."""


class HttpAgents:
    """Routes of agents, and what has to run for them.

    The guard of the application has checked host, origin and token before.

    Parameters
    ----------
    make : returns the tools, the same ones each time; called with the first request

    Attributes
    ----------
    routes : of Starlette
    """

    def __init__(self, make: Callable[[], Agents]) -> None:
        self._make = make
        self.routes: list[BaseRoute] = [Route("/mcp", endpoint=self)]
        self._wanted: asyncio.Event
        self._app: asyncio.Future[ASGIApp]

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Sessions of agents, while the context lasts; once."""
        self._wanted, ended = asyncio.Event(), asyncio.Event()
        self._app = asyncio.get_running_loop().create_future()
        sessions = asyncio.create_task(self._sessions(ended))
        try:
            yield
        finally:
            ended.set()
            self._wanted.set()
            await sessions

    async def _sessions(self, ended: asyncio.Event) -> None:
        """Begin sessions with the first request and end them: the SDK wants one task to do both."""
        await self._wanted.wait()
        if ended.is_set():
            return
        try:
            await asyncio.to_thread(importlib.import_module, TOOLS)
            server = self._make().server
            app = server.streamable_http_app(
                streamable_http_path="/mcp", json_response=True, max_request_body_size=MAX_BODY
            )
            async with server.session_manager.run():
                self._app.set_result(Router(list(app.routes)))
                await ended.wait()
        except Exception as error:
            if self._app.done():
                raise
            self._app.set_exception(error)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request; the first one waits for the SDK."""
        self._wanted.set()
        app = await asyncio.shield(self._app)
        await app(scope, receive, send)
        if scope["method"] == "DELETE":
            session = Headers(scope=scope).get(SESSION_HEADER)
            if session is not None:
                self._make().ended(session)
