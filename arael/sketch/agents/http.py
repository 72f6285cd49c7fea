"""Agents over streamable HTTP, at ``/mcp`` of the editor's server."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from typing import Any

from arael.sketch.agents.tools import Agents

MAX_BODY = 4 * 1024 * 1024
"""Bytes of a request."""


class HttpAgents:
    """Routes of agents, and what has to run for them.

    The guard of the application has checked host, origin and token before.

    Parameters
    ----------
    agents : the tools

    Attributes
    ----------
    routes : of Starlette
    """

    def __init__(self, agents: Agents) -> None:
        self._server = agents.server
        app = self._server.streamable_http_app(
            streamable_http_path="/mcp", json_response=True, max_request_body_size=MAX_BODY
        )
        self.routes: list[Any] = list(app.routes)

    def running(self) -> AbstractAsyncContextManager[None]:
        """Sessions of agents, while the context lasts; once."""
        return self._server.session_manager.run()
