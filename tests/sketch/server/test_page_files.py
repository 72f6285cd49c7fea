"""What a browser receives of the page: its meaning, its size, when it is sent again."""

from __future__ import annotations

import re
import urllib.parse
from pathlib import Path

import pytest

from tests import optional

optional.require("starlette")
optional.require("websockets")

from starlette.applications import Starlette  # noqa: E402
from starlette.routing import Mount  # noqa: E402
from starlette.testclient import TestClient  # noqa: E402

from arael.sketch.server.app import PAGE  # noqa: E402
from arael.sketch.server.page_files import PageFiles  # noqa: E402

MOST_BYTES = 250_000
"""Of all files that a browser loads, compressed."""

IMPORT = re.compile(r"(?:from|import|href=|src=)\s*\(?\s*[\"']([^\"':]+\.(?:js|css))[\"']")


@pytest.fixture
def browser() -> TestClient:
    return TestClient(Starlette(routes=[Mount("/", PageFiles(directory=PAGE, html=True))]))


def loaded(browser: TestClient) -> dict[str, int]:
    """Bytes over the wire, by address, of all that a page loads."""
    found: dict[str, int] = {}
    waiting = ["/"]
    while waiting:
        address = waiting.pop()
        if address in found:
            continue
        answer = browser.get(address)
        assert answer.status_code == 200 and answer.headers["content-encoding"] == "gzip"
        found[address] = int(answer.headers["content-length"])
        waiting += [urllib.parse.urljoin(address, one) for one in IMPORT.findall(answer.text)]
    return found


def test_what_a_browser_loads_is_small(browser: TestClient) -> None:
    sizes = loaded(browser)
    assert len(sizes) > 80 and "/draw/batches.js" in sizes and "/styles/phone.css" in sizes
    assert sum(sizes.values()) < MOST_BYTES


def test_a_file_that_the_browser_has_is_not_sent_again(browser: TestClient) -> None:
    first = browser.get("/pick.js")
    again = browser.get("/pick.js", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_a_file_that_was_changed_is_sent_anew(tmp_path: Path) -> None:
    app = Starlette(routes=[Mount("/", PageFiles(directory=tmp_path))])
    (tmp_path / "a.js").write_text("let a = 1; // one")
    browser = TestClient(app)
    first = browser.get("/a.js")
    (tmp_path / "a.js").write_text("let a = 12; // twelve")
    again = browser.get("/a.js", headers={"if-none-match": first.headers["etag"]})
    assert first.text == "let a = 1; // one" and again.text == "let a = 12; // twelve"


def test_a_client_without_decompression_gets_plain_text(browser: TestClient) -> None:
    answer = browser.get("/pick.js", headers={"accept-encoding": "identity"})
    assert "content-encoding" not in answer.headers and "class Picker" in answer.text
