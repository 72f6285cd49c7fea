"""Requests that are refused: foreign origins and hosts, no token, paths outside of the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import optional

optional.require("starlette")

from starlette.testclient import TestClient  # noqa: E402
from starlette.websockets import WebSocketDisconnect  # noqa: E402

from arael.sketch.server.app import Server  # noqa: E402
from arael.sketch.server.worker import Worker  # noqa: E402
from tests.sketch.server.client import Mirror, encoded  # noqa: E402
from tests.sketch.server.shared import shared_sketch  # noqa: E402

HERE = "http://127.0.0.1:8123"
TOKENS = {"/": "secret", "/socket": "secret", "/mcp": "other"}
PAGE = "/?token=secret"
SOCKET = "/socket?token=secret&window=w1"


@pytest.fixture
def client(tmp_path: Path) -> Iterator[TestClient]:
    page = tmp_path / "page"
    (page / "draw").mkdir(parents=True)
    (page / "index.html").write_text("<title>page</title>")
    (page / "draw" / "a.js").write_text("export const a = 1;")
    (tmp_path / "secret.txt").write_text("secret")
    (page / "link.txt").symlink_to(tmp_path / "secret.txt")
    server = Server(Worker(shared_sketch()), TOKENS, page=page)
    with TestClient(server.app, base_url=HERE) as found:
        yield found


def connected(client: TestClient, url: str = SOCKET, **headers: str) -> list[str]:
    """Types of the first messages of a socket; the refusal's code if there is one."""
    mirror = Mirror()
    headers = {"host": "127.0.0.1:8123", **headers}
    try:
        with client.websocket_connect(url, headers=headers) as socket:
            return [mirror.take(socket.receive_bytes())["type"] for _ in range(2)]
    except WebSocketDisconnect as refusal:
        return [f"refused {refusal.code}"]


def test_the_page_connects(client: TestClient) -> None:
    assert connected(client) == ["hello", "snapshot"]
    assert connected(client, origin=HERE) == ["hello", "snapshot"]
    assert connected(client, "/socket?window=w1", authorization="Bearer secret")[0] == "hello"


@pytest.mark.parametrize(
    "url",
    [
        "/socket",
        "/socket?token=",
        "/socket?token=wrong",
        "/socket?token=secret2",
        "/socket?token=other",
        "/socket?token=wrong&token=secret",
        "//socket",
        "/socket/",
    ],
)
def test_without_the_token_no_page_connects(client: TestClient, url: str) -> None:
    assert connected(client, url) == ["refused 4403"]


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "https://127.0.0.1:8123",
        "http://127.0.0.1:8124",
        "http://127.0.0.1:8123.evil.example",
        "http://localhost:8123",
        "null",
        "file://",
        "",
    ],
)
def test_pages_of_other_origins_are_refused(client: TestClient, origin: str) -> None:
    assert connected(client, origin=origin) == ["refused 4403"]
    assert client.get("/", headers={"origin": origin}).status_code == 403


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8123", "127.0.0.1.evil.example", "", "127.0.0.1:x"]
)
def test_names_that_lead_here_are_refused(client: TestClient, host: str) -> None:
    assert client.get("/", headers={"host": host}).status_code == 421
    assert connected(client, host=host) == ["refused 4403"]


def test_localhost_is_a_host(client: TestClient) -> None:
    assert client.get(PAGE, headers={"host": "localhost:8123"}).status_code == 200


@pytest.mark.parametrize("url", ["/", "/?token=", "/?token=wrong", "/?token=other"])
def test_an_address_without_its_token_says_what_to_do(client: TestClient, url: str) -> None:
    answer = client.get(url)
    assert answer.status_code == 401 and "text/html" in answer.headers["content-type"]
    assert "Copy the whole address from the terminal" in answer.text
    assert "script" not in answer.text and "secret" not in answer.text.replace("a secret that", "")


def test_agents_need_a_token_of_their_own(client: TestClient) -> None:
    for url in ("/mcp", "/mcp?token=wrong", "/mcp?token=secret"):
        assert client.post(url, json={}).status_code == 401


def test_static_files_come_with_a_policy(client: TestClient) -> None:
    for path, kind in ((PAGE, "text/html"), ("/draw/a.js", "javascript")):
        answer = client.get(path)
        assert answer.status_code == 200 and kind in answer.headers["content-type"]
        assert "default-src 'self'" in answer.headers["content-security-policy"]
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    "path",
    [
        "/../secret.txt",
        "/%2e%2e/secret.txt",
        "/draw/../../secret.txt",
        "/draw/%2e%2e/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "//etc/passwd",
        "/%2fetc/passwd",
        "/link.txt",
        "/draw/%00",
        "/nothing.js",
    ],
)
def test_only_files_of_the_page_are_served(client: TestClient, path: str) -> None:
    answer = client.get(path)
    assert answer.status_code in (400, 404, 405) and "secret" not in answer.text


def test_a_page_cannot_write(client: TestClient) -> None:
    assert client.post("/index.html", content=b"x").status_code == 405


def test_malformed_messages_are_answered_and_the_page_goes_on(client: TestClient) -> None:
    mirror = Mirror()
    with client.websocket_connect(SOCKET, headers={"host": "127.0.0.1:8123"}) as socket:

        def until(kind: str) -> dict[str, Any]:
            while (message := mirror.take(socket.receive_bytes()))["type"] != kind:
                pass
            return message

        until("presence")
        for data in (b"", b"\0" * 16, encoded({"type": "run"})[:-1], b"\xff" * 400):
            socket.send_bytes(data)
            assert "cannot be read" in until("message")["text"]
        socket.send_text("hello")
        assert "cannot be read" in until("message")["text"]
        socket.send_bytes(encoded({"type": "run", "id": 1, "text": "add_point 1,2"}))
        assert until("reply")["ok"] and list(mirror.tables["entities"]) == ["P0"]


def test_reloading_takes_the_window_over(client: TestClient) -> None:
    """The new connection of a window may come before the old one is closed."""
    first, second = Mirror(), Mirror()
    with client.websocket_connect(SOCKET, headers={"host": "127.0.0.1:8123"}) as old:
        for _ in range(4):
            first.take(old.receive_bytes())
        with client.websocket_connect(SOCKET, headers={"host": "127.0.0.1:8123"}) as new:
            while second.take(new.receive_bytes())["type"] != "presence":
                pass
            old.close()
            new.send_bytes(encoded({"type": "run", "id": 1, "text": "add_point 1,2"}))
            while second.take(new.receive_bytes())["type"] != "reply":
                pass
    assert second.is_last_presence(1) and list(second.tables["entities"]) == ["P0"]
