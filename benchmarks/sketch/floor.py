"""What the way from the mouse to the canvas takes in Chromium without an editor.

``python -m benchmarks.sketch.floor PORT`` serves a page with one canvas, which sends every move of
the mouse over a WebSocket and draws two hundred lines when it comes back; the server returns each
message as it is. An editor with a server cannot be quicker in the same browser.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_PAGE = Path(__file__).with_name("floor.html")
_SIZE = {"width": 1280, "height": 800}


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
    from playwright.sync_api import sync_playwright

    from benchmarks.sketch.mouse import free_port, move, move_by_turns

    port, protocol = free_port(), free_port()
    server = subprocess.Popen([sys.executable, "-m", "benchmarks.sketch.floor", str(port)])
    try:
        with sync_playwright() as playwright:
            chromium = os.environ.get("ARAEL_CHROMIUM") or shutil.which("chromium")
            options = ["--no-sandbox", f"--remote-debugging-port={protocol}"]
            browser = playwright.chromium.launch(executable_path=chromium, args=options)
            page = browser.new_page(viewport=_SIZE)
            _open(page, f"http://127.0.0.1:{port}/")
            places = [(100.0 + i % 1000, 200.0 + i % 50) for i in range(moves)]
            if paced:
                move(protocol, places, period, pressed=False)
            else:
                move_by_turns(page, places, period)
            page.wait_for_timeout(300)
            found = np.array(page.evaluate("taken"), dtype=np.float64)
            browser.close()
    finally:
        server.terminate()
        server.wait()
    found = found[len(found) // 10 :]
    return found[:, 0], found[:, 1]


def _open(page: Any, address: str) -> None:
    """Load the page, as soon as the server answers."""
    from playwright.sync_api import Error

    for _ in range(100):
        try:
            page.goto(address)
            break
        except Error:
            time.sleep(0.1)
    page.wait_for_function("window.ready")
    page.wait_for_timeout(500)


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
