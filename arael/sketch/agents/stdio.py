"""`arael sketch mcp`: an agent's program starts the server and talks to it over its pipes.

The page is served as well, so that a person can watch, allow and refuse.
"""

from __future__ import annotations

import asyncio
import contextlib
import sys

import uvicorn

from arael.sketch.server.serving import Opened, config, opened


def serve_stdio(file: str | None = None, *, port: int = 0, allow_agents: bool = False) -> None:
    """Serve an agent over standard input and output until its input ends.

    Parameters are those of `arael.sketch.server.serving.serve`; addresses are printed to stderr.
    """
    found = opened(file, port, allow_agents, say=_say, by_agent=True)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_serve(found))


async def _serve(found: Opened) -> None:
    agents = found.agents()
    page = uvicorn.Server(config(found.server.app))
    serving = asyncio.create_task(page.serve(sockets=[found.listener]))
    try:
        while not page.started and not serving.done():
            await asyncio.sleep(0.01)
        await agents.server.run_stdio_async()
    finally:
        page.should_exit = True
        await serving


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
