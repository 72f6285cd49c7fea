"""What the way from the mouse to the canvas takes in Chromium without an editor.

``python -m benchmarks.sketch.floor PORT`` serves a page with one canvas, which sends every move of
the mouse over a WebSocket and draws two hundred lines when it comes back; the server returns each
message as it is. An editor with a server cannot be quicker in the same browser.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.sketch.browser import Browser

_PAGE = Path(__file__).with_name("floor.html")


def floor(
    moves: int, period: float, paced: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Milliseconds to the end of the rasterisation.

    Parameters
    ----------
    moves : of the mouse, one per `period` milliseconds at most
    paced : exactly, whatever the browser does

    Returns
    -------
    from the stamp of the mouse's event, and from the message that the page sends: (n,) each, the
    first ones left out
    """
    port = _free_port()
    server = subprocess.Popen([sys.executable, "-m", "benchmarks.sketch.floor", str(port)])
    try:
        with Browser() as browser:
            _await(port)
            browser.open(f"http://127.0.0.1:{port}/", "window.ready")
            time.sleep(2.0)
            places = [(100.0 + i % 1000, 200.0 + i % 50) for i in range(moves)]
            browser.move(places, period, pressed=False, paced=paced)
            time.sleep(0.3)
            found = np.array(browser.evaluate("taken"), dtype=np.float64)
    finally:
        server.terminate()
        server.wait()
    found = found[len(found) // 10 :]
    return found[:, 0], found[:, 1]


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def _await(port: int) -> None:
    """Wait until a server answers."""
    for _ in range(300):
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return
        except OSError:
            time.sleep(0.1)
    raise SystemExit(f"no server answers at port {port}")


def _serve(port: int) -> None:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import HTMLResponse
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect

    async def page(_: Request) -> HTMLResponse:
        return HTMLResponse(_PAGE.read_text(encoding="utf-8"))

    async def echo(page: WebSocket) -> None:
        await page.accept()
        try:
            while True:
                await page.send_bytes(await page.receive_bytes())
        except WebSocketDisconnect:
            pass

    routes = [Route("/", page), WebSocketRoute("/echo", echo)]
    # the same implementation of WebSockets as the editor's server
    uvicorn.run(
        Starlette(routes=routes),
        host="127.0.0.1",
        port=port,
        log_level="error",
        ws="websockets-sansio",
        ws_per_message_deflate=False,
    )


if __name__ == "__main__":
    _serve(int(sys.argv[1]))
