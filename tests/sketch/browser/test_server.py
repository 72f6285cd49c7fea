"""The page and its server: a hostile page, the page in a notebook."""

from __future__ import annotations

import base64
import http.server
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests import optional
from tests.sketch.server.inside import InsideServer


def until(page: Any, condition: str, between: Callable[[], None] = lambda: None) -> None:
    """Wait for a condition in the page (the page's policy forbids playwright's own way)."""
    for _ in range(800):
        between()
        if page.evaluate(f"() => {{ try {{ return !!({condition}) }} catch {{ return false }} }}"):
            return
        page.wait_for_timeout(25)
    raise AssertionError(f"not reached: {condition}")


@pytest.fixture
def elsewhere(tmp_path: Path) -> Iterator[str]:
    """Address of a page of another origin on this machine."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "index.html").write_text("<title>elsewhere</title>")
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as found:
        threading.Thread(target=found.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{found.server_port}/"
        found.shutdown()


ATTACK = """async ([socket, page, agents]) => {
  const closed = await new Promise((done) => {
    const found = new WebSocket(socket);
    found.onopen = () => done("open");
    found.onerror = () => done("refused");
  });
  const answers = [];
  for (const [url, options] of [[page, {}], [agents, { method: "POST", body: "{}" }]]) {
    answers.push(await fetch(url, options).then((r) => r.text(), () => "refused"));
  }
  const frame = document.createElement("iframe");
  frame.src = page;
  document.body.append(frame);
  await new Promise((done) => (frame.onload = done));
  let inside = "unreadable";
  try { inside = frame.contentDocument?.title ?? "unreadable"; } catch { /* another origin */ }
  return [closed, ...answers, inside, frame.contentWindow.length];
}"""


def test_a_hostile_page_gets_nowhere(browser: Any, server: InsideServer, elsewhere: str) -> None:
    """Even with the tokens: its origin is another one."""
    page = browser.new_page()
    page.goto(elsewhere)
    addresses = [f"{server.socket}&window=evil", server.address, server.agents]
    assert page.evaluate(ATTACK, addresses) == [
        "refused",
        "refused",
        "refused",
        "unreadable",
        0,
    ]
    page.close()


KERNEL = """async () => {
  const handlers = [];
  const model = {
    on: (event, handler) => handlers.push(handler),
    off: (event, handler) => handlers.splice(handlers.indexOf(handler), 1),
    send: (content, callbacks, buffers = []) => toKernel(
      content, buffers.map((one) => btoa(String.fromCharCode(...new Uint8Array(one))))),
  };
  window.fromKernel = (content, buffers) => {
    const views = buffers.map((text) =>
      new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer));
    for (const handler of [...handlers]) handler(content, views);
  };
  const { default: widget } = await import("/notebook.js");
  widget.render({ model, el: document.body });
}"""


def test_the_page_runs_in_a_notebook(browser: Any, server: InsideServer) -> None:
    """A kernel's part is played by this process, a notebook's by an empty page."""
    optional.require("anywidget")
    from arael.sketch.sketch import Sketch

    sketch = Sketch()
    widget = sketch.edit()
    context = browser.new_context(bypass_csp=True)
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    waiting: list[tuple[Any, list[str]]] = []

    def send(content: Any, buffers: Any = None) -> None:
        waiting.append((content, [base64.b64encode(one).decode() for one in buffers or []]))

    def received(content: Any, buffers: list[str]) -> None:
        widget._received(widget, content, [base64.b64decode(one) for one in buffers])

    widget.send = send
    page.expose_function("toKernel", received)
    page.goto(f"http://127.0.0.1:{server.port}/package.json")
    page.evaluate(KERNEL)

    def deliver() -> None:
        while waiting:
            page.evaluate("([content, buffers]) => fromKernel(content, buffers)", waiting.pop(0))

    until(page, "frames[0].app.wire.state === 'open'", deliver)
    sketch.run("add_rect 0,0 50,30 hv")
    until(page, "frames[0].app.store.entities.size === 4", deliver)
    page.evaluate("() => { frames[0].app.wire.run('add_circle 20,15 5'); }")
    until(page, "frames[0].app.store.entities.size === 5", deliver)
    assert len(sketch.entities) == 5
    until(page, "frames[0].app.store.verdict.freedoms === 7", deliver)
    inside = "document.querySelector('iframe').offsetWidth <= document.body.clientWidth"
    assert page.evaluate(inside), "its right edge would be cut"
    assert errors == []
    context.close()
