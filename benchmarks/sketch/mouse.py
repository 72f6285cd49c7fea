"""A mouse that moves at its own pace, by the protocol of Chromium.

A move by Playwright waits until the page has handled the one before, which is after a refresh of
the screen: every place then comes at the same moment between two refreshes. The places of a mouse
come at any moment, also while the browser puts the screen together. Besides, Playwright's driver
takes an eighth of a processor, and both for some 20 ms when it collects its garbage.
"""

from __future__ import annotations

import json
import socket
import time
import urllib.request
from collections.abc import Sequence
from typing import Any


def free_port() -> int:
    """A port of this machine that is free."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def move_by_turns(page: Any, places: Sequence[tuple[float, float]], period: float) -> None:
    """Move the mouse of a page of Playwright, the next time when it has handled the one before.

    Parameters
    ----------
    period : milliseconds from one move to the next, at least
    """
    for at in places:
        began = time.perf_counter()
        page.mouse.move(*at)
        time.sleep(max(period / 1e3 - (time.perf_counter() - began), 0.0))


def move(port: int, places: Sequence[tuple[float, float]], period: float, pressed: bool) -> None:
    """Move the mouse over the only page of a browser, one place every `period` milliseconds.

    Parameters
    ----------
    port : of the protocol, ``--remote-debugging-port`` of the browser
    places : in pixels of the page
    pressed : whether the left button is down
    """
    from websockets.sync.client import connect

    with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
        pages = [one for one in json.load(answer) if one["type"] == "page"]
    with connect(pages[0]["webSocketDebuggerUrl"], compression=None) as link:
        due = time.perf_counter()
        for number, (x, y) in enumerate(places):
            given = {"type": "mouseMoved", "x": x, "y": y, "pointerType": "mouse"}
            given |= {"button": "left" if pressed else "none", "buttons": int(pressed)}
            message = {"id": number, "method": "Input.dispatchMouseEvent", "params": given}
            link.send(json.dumps(message))
            due += period / 1e3
            while (left := due - time.perf_counter()) > 0:
                try:
                    link.recv(timeout=left)
                except TimeoutError:
                    break
