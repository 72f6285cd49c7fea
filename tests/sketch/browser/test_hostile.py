"""A page of another origin gets nowhere, and names in a drawing are never markup."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import pytest

from tests.sketch.browser.panels import RECTANGLE, connected, run


class Hostile(BaseHTTPRequestHandler):
    """A page of another site."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("content-type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>hostile</title>")

    def log_message(self, *given: Any) -> None:
        """Nothing."""


@pytest.fixture
def hostile(editor: Any) -> Iterator[Any]:
    listener = HTTPServer(("127.0.0.1", 0), Hostile)
    thread = threading.Thread(target=listener.serve_forever, daemon=True)
    thread.start()
    page = editor.context.new_page()
    page.goto(f"http://127.0.0.1:{listener.server_port}/")
    yield page
    listener.shutdown()
    thread.join()
    listener.server_close()


SOCKET = """address => new Promise((resolve) => {
    const socket = new WebSocket(address);
    socket.onopen = () => resolve("open");
    socket.onerror = () => resolve("refused");
})"""


@pytest.mark.parametrize("knows", [False, True])
def test_a_foreign_page_cannot_open_the_socket(editor: Any, hostile: Any, knows: bool) -> None:
    run(connected(editor.page), RECTANGLE)
    token = editor.server.token if knows else "guessed"
    address = f"ws://127.0.0.1:{editor.server.port}/socket?token={token}&window=w"
    assert hostile.evaluate(SOCKET, address) == "refused"
    assert editor.page.evaluate("app.store.entities.size") == 4


def test_a_foreign_page_can_neither_read_nor_frame_the_editor(editor: Any, hostile: Any) -> None:
    connected(editor.page)
    address = editor.server.address
    read = "address => fetch(address).then((found) => found.text(), () => 'refused')"
    assert hostile.evaluate(read, address) == "refused"
    hostile.evaluate(
        """address => new Promise((resolve) => {
            const frame = document.createElement("iframe");
            frame.src = address;
            frame.onload = resolve;
            document.body.append(frame);
        })""",
        address,
    )
    frame = hostile.frames[1]
    assert frame.evaluate("typeof app") == "undefined"
    editor.errors.clear()  # of the pages that were refused


def test_agents_cannot_be_reached_from_a_foreign_page(editor: Any, hostile: Any) -> None:
    connected(editor.page)
    order = """address => fetch(address, {method: "POST", mode: "no-cors",
        headers: {"content-type": "text/plain"}, body: "{}"})
        .then((one) => one.type, () => "refused")"""
    hostile.evaluate(order, editor.server.agents)
    assert editor.page.evaluate("app.store.entities.size") == 0


def test_texts_of_a_document_are_never_markup(editor: Any) -> None:
    page = connected(editor.page)
    page.evaluate("text => app.wire.run(text)", 'msg "<img src=x onerror=window.bad=1>"')
    page.evaluate("app.run('<b>bold</b>')")
    page.locator(".note.error").wait_for()
    assert page.locator(".note img, .note b").count() == 0
    assert page.evaluate("window.bad") is None
