"""The editor in a notebook: the page of the server, over the widget's own messages."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anywidget

from arael.diagnostics.records import AraelError
from arael.sketch.server.protocol import received
from arael.sketch.server.shared import SharedSketch
from arael.sketch.server.windows import Window

if TYPE_CHECKING:
    from arael.sketch.sketch import Sketch

PAGE = Path(__file__).with_name("page")
"""Folder of the page's files."""

_KINDS = (".js", ".css", ".html")
_NOT_SENT = frozenset({"notebook.js", "page.js", "eslint.config.js"})


class WidgetLink:
    """The way to one view of a widget.

    Parameters
    ----------
    widget : that sends
    window : made by the view
    """

    is_behind = False

    def __init__(self, widget: SketchWidget, window: str) -> None:
        self._widget = widget
        self._window = window

    def send(self, data: bytes) -> None:
        """Send a message."""
        self._widget.send({"type": "page", "window": self._window}, [data])


class SketchWidget(anywidget.AnyWidget):  # type: ignore[misc,unused-ignore]
    """Shows the editor of a sketch; each output that shows it is a window of its own.

    The messages are those of the server, one per buffer. Everything runs in the kernel's thread:
    while a cell runs the editor waits, and a solve cannot be broken off from the page.

    Parameters
    ----------
    sketch : that is edited
    """

    _esm = PAGE / "notebook.js"

    def __init__(self, sketch: Sketch, **options: Any) -> None:
        super().__init__(**options)
        self._shared = SharedSketch(sketch.session)
        self._views: dict[str, Window] = {}
        self._waits = False
        sketch.session.after_line = self._cell_changed
        self.on_msg(self._received)

    def _received(self, _: Any, content: Any, buffers: list[Any]) -> None:
        """A message of a view: ``files``, ``open``, ``page`` with a buffer, ``close``."""
        if not isinstance(content, dict):
            return
        kind, name = content.get("type"), str(content.get("window", ""))[:64]
        if kind == "files":
            self.send({"type": "files", "window": name, "files": files()})
        elif kind == "open":
            since = content.get("since")
            revision = since if isinstance(since, int) else -1
            try:
                self._views[name] = self._shared.open(name, WidgetLink(self, name), revision)
            except AraelError as error:
                text = error.diagnostics[0].message
                self.send({"type": "refused", "window": name, "text": text})
        elif kind == "close" and name in self._views:
            self._shared.close(self._views.pop(name))
        elif kind == "page" and name in self._views and buffers:
            self._page(self._views[name], buffers[0])
        self._later()

    def _page(self, window: Window, data: Any) -> None:
        try:
            message = received(bytes(data))
        except AraelError as error:
            text = error.diagnostics[0].message
            window.send({"type": "message", "level": "error", "text": text})
            return
        self._shared.receive(window, message)

    def _cell_changed(self) -> None:
        """A cell ran a command: windows show what it changed."""
        if self._shared.is_running or self._shared.session.document.is_changing:
            return
        self._shared.publish("script", self._title())
        self._later()

    def _title(self) -> str:
        done = self._shared.session.document.history.done
        return done[-1].label if done else ""

    def _later(self) -> None:
        """Verdicts come when the kernel has nothing else to do."""
        if self._waits or self._shared.is_dragging:
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            self._idle()
            return
        self._waits = True
        loop.call_later(0.02, self._idle)

    def _idle(self) -> None:
        self._waits = False
        self._shared.idle()


def files() -> dict[str, str]:
    """The page's files by path, for a view that makes modules of them."""
    return {
        path.relative_to(PAGE).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(PAGE.rglob("*"))
        if path.suffix in _KINDS and path.name not in _NOT_SENT and "node_modules" not in path.parts
    }
