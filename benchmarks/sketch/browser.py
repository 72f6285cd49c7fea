"""Chromium with one page, driven by its own protocol and by nothing else.

A driver such as Playwright's has the browser report every message of a WebSocket to a process of
its own. During a drag that took an eighth of a processor, and both processors of a small machine
for 3 to 8 ms whenever the driver collected its garbage, which no user's browser does.
"""

from __future__ import annotations

import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

_STARTED_WITHIN = 60.0
_ANSWERED_WITHIN = 120.0
_SIZE = {"width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": False}
_OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-port=0",
    "--no-first-run",
    "--disable-extensions",
    "--disable-component-update",
    "--disable-background-networking",
)


class Browser:
    """A browser on an empty page of 1280 by 800 pixels, until the block ends.

    The executable is `ARAEL_CHROMIUM`, or ``chromium`` on the path.
    """

    def __enter__(self) -> Browser:
        from websockets.sync.client import connect

        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        chromium = os.environ.get("ARAEL_CHROMIUM") or shutil.which("chromium")
        if chromium is None:
            raise SystemExit("no Chromium: install it, or name it by ARAEL_CHROMIUM")
        self._process = subprocess.Popen(
            [chromium, *_OPTIONS, f"--user-data-dir={self._folder.name}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            self._link = connect(self._page(), compression=None, max_size=None)
            self._numbers = itertools.count(1)
            self._call("Emulation.setDeviceMetricsOverride", **_SIZE)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._link.close()
        self._end()

    def open(self, address: str, ready: str) -> None:
        """Load a page, and wait until an expression is true in it."""
        self._call("Page.navigate", url=address)
        self.await_(ready)

    def await_(self, expression: str) -> None:
        """Wait until an expression is true in the page."""
        end = time.monotonic() + _STARTED_WITHIN
        while not self.evaluate(f"!!({expression})"):
            if time.monotonic() > end:
                raise SystemExit(f"the page is not ready: {expression} stays false")
            time.sleep(0.05)

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page, as JSON has it; promises are waited for."""
        found = self._call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in found:
            details = found["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description", details["text"]))
        return found["result"].get("value")

    def mouse(self, type: str, at: Sequence[float], pressed: bool = False) -> None:
        """``mouseMoved``, ``mousePressed`` or ``mouseReleased`` at a place in pixels."""
        self._call("Input.dispatchMouseEvent", **_event(type, at, pressed))

    def move(
        self, places: Sequence[Sequence[float]], period: float, pressed: bool, paced: bool
    ) -> None:
        """Move the mouse.

        Parameters
        ----------
        places : in pixels of the page
        period : milliseconds from one move to the next
        pressed : whether the left button is down
        paced : one move every `period` whatever the browser does, as of a mouse. Otherwise at
            least `period`, and not before the page has handled the move before, which is after a
            refresh of the screen: every place then comes at the same moment between two refreshes
        """
        due = time.perf_counter()
        for at in places:
            if paced:
                self._send("Input.dispatchMouseEvent", **_event("mouseMoved", at, pressed))
                due += period / 1e3
                self._read_until(due)
            else:
                due = time.perf_counter() + period / 1e3
                self.mouse("mouseMoved", at, pressed)
                time.sleep(max(due - time.perf_counter(), 0.0))

    def _read_until(self, due: float) -> None:
        while (left := due - time.perf_counter()) > 0:
            try:
                self._link.recv(timeout=left)
            except TimeoutError:
                return

    def _send(self, method: str, **given: Any) -> int:
        number = next(self._numbers)
        self._link.send(json.dumps({"id": number, "method": method, "params": given}))
        return number

    def _call(self, method: str, **given: Any) -> dict[str, Any]:
        number = self._send(method, **given)
        while True:
            answer = json.loads(self._link.recv(timeout=_ANSWERED_WITHIN))
            if answer.get("id") == number:
                break
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        found: dict[str, Any] = answer["result"]
        return found

    def _page(self) -> str:
        """Address of the protocol of the only page."""
        file = Path(self._folder.name) / "DevToolsActivePort"
        end = time.monotonic() + _STARTED_WITHIN
        while time.monotonic() < end and self._process.poll() is None:
            try:
                port = int(file.read_text(encoding="ascii").split()[0])
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
                    pages = [one for one in json.load(answer) if one["type"] == "page"]
                return str(pages[0]["webSocketDebuggerUrl"])
            except (OSError, ValueError, IndexError):
                time.sleep(0.1)
        raise SystemExit("Chromium did not start")

    def _end(self) -> None:
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()


def _event(type: str, at: Sequence[float], pressed: bool) -> dict[str, Any]:
    x, y = at
    button = "left" if pressed else "none"
    found = {"type": type, "x": x, "y": y, "pointerType": "mouse", "button": button}
    return found | {"buttons": int(pressed), "clickCount": int(type != "mouseMoved")}
