"""The server as a person starts it: crashes, windows, refusals. Also E1411, E1412, E1413."""

from __future__ import annotations

import contextlib
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from arael.sketch.document.saved import load
from tests import optional

optional.require("starlette")
optional.require("websockets")

from websockets.exceptions import ConnectionClosed, InvalidStatus  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from arael.sketch.server.addresses import listening, listening_for  # noqa: E402
from tests.sketch.server.client import Page, encoded, place  # noqa: E402
from tests.sketch.server.process import ServerProcess  # noqa: E402
from tests.sketch.server.shared import chain  # noqa: E402


def commands(seed: int, count: int) -> list[str]:
    """Commands that work in any order."""
    numbers = random.Random(seed)
    found = ["add_rect 0,0 50,30 hv"]
    for _ in range(count):
        x, y = numbers.uniform(-99, 99), numbers.uniform(-99, 99)
        found.append(
            numbers.choice(
                [
                    f"add_line {x},{y} {y},{x - 3}",
                    f"add_circle {x},{y} {1 + abs(x)}",
                    f"length L0 {20 + abs(x)}",
                    f"param w {x}",
                    f"drag L1.p2 {x},{y}",
                    "undo",
                    "redo",
                    "add_point 1,1; delete _",
                ]
            )
        )
    return found


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(k, marks=pytest.mark.slow) for k in range(2, 9))]
)
def test_a_killed_server_has_lost_nothing_that_it_acknowledged(tmp_path: Path, seed: int) -> None:
    """What is there after a kill is what the page was sent, or that and the command under way."""
    numbers = random.Random(seed)
    lines = commands(seed, 400)
    known: Page | None = None
    under_way = ""
    for _ in range(4):
        with ServerProcess(tmp_path / "a.json", folder=tmp_path) as server:
            page = Page(server.socket).start()
            if known is not None and page.shown() != known.shown():
                page.until("history")
                assert page.history["done"][-1] == under_way
            killer = threading.Timer(numbers.uniform(0.0, 0.03), server.kill)
            count = numbers.randrange(5, 30)
            with contextlib.suppress(ConnectionClosed, ConnectionError):
                for k in range(len(lines)):
                    if k == count:
                        killer.start()
                    under_way = lines.pop(0)
                    page.run(under_way)
            killer.join()
            assert len(page.tables["entities"]) > 3
            known = page


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server for tests that leave nothing behind."""
    folder = tmp_path_factory.mktemp("running")
    with ServerProcess(folder / "a.json", folder=folder) as server:
        yield server
    assert "Traceback" not in server.output


@pytest.fixture
def page(running: ServerProcess) -> Iterator[Page]:
    with Page(running.socket).start() as found:
        found.run("clear")
        yield found


def test_windows_stay_in_step_over_the_network(tmp_path: Path) -> None:
    with ServerProcess(tmp_path / "a.json", folder=tmp_path) as server:
        first, second = Page(server.socket).start(), Page(server.socket, "w2").start()
        for k in range(5):
            first.run(f"add_line 0,{k} 9,{k + 2}")
            second.run(f"add_circle {k},50 2")
        assert second.ask("drag", handles=["A0.center"], at=[0, 50])["ok"]
        for k in range(1, 20):
            second.drag_to(k, k, 50 + k)
        second.ask("drop")
        first.until(lambda m: m["type"] == "change" and m["revision"] == second.revision)
        assert first.shown() == second.shown()
        assert first.numbers("A0") == pytest.approx([19, 69, 2])
        revision = first.revision
        first.close()
        second.run("length L0 33")
        with Page(server.socket, since=revision) as again:
            again.revision, again.tables, again.values = revision, first.tables, first.values
            assert again.next()["type"] == "hello"
            assert again.next()["type"] == "change"
            assert again.shown() == second.shown()
    assert len(load(tmp_path / "a.json").entities) == 10
    assert server.process.returncode == 0 and "Traceback" not in server.output


def test_places_that_wait_are_merged(page: Page) -> None:
    page.run("add_line 0,0 50,0")
    page.ask("drag", handles=["L0.p2"], at=[50, 0])
    for k in range(1, 1001):
        page.socket.send(place(k, 50.0 + k, 1.0))
    page.until(lambda m: m["type"] == "frame" and m["sequence"] == 1000)
    assert len(page.frames) < 1000 and page.frames == sorted(page.frames)
    assert page.numbers("L0")[2:] == pytest.approx([1050, 1])


def test_a_script_is_run_and_kept_beside(tmp_path: Path) -> None:
    (tmp_path / "plate.cmd").write_text("add_rect 0,0 50,30 hv\nlength L0 60\n")
    with ServerProcess("plate.cmd", folder=tmp_path) as server:
        x1, _, x2, _ = Page(server.socket).start().numbers("L0")
        assert x2 - x1 == pytest.approx(60)
    assert len(load(tmp_path / "plate.json").entities) == 4
    done = refused("plate.cmd", folder=tmp_path)
    assert "error[E1411]" in done and "plate.json" in done


def test_without_a_file_a_new_one_is_taken(tmp_path: Path) -> None:
    (tmp_path / "sketch.json").write_text("mine")
    with ServerProcess(None, folder=tmp_path) as server:
        page = Page(server.socket).start()
        assert page.hello["file"] == "sketch2.json"
        page.run("add_point 1,1")
    assert (tmp_path / "sketch.json").read_text() == "mine"
    assert len(load(tmp_path / "sketch2.json").entities) == 1


def test_a_server_that_comes_back_has_its_address(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    with ServerProcess(path, folder=tmp_path) as server:
        first = (server.address, server.agents)
        assert server.token not in server.agents
        page = Page(server.socket).start()
        page.run("add_point 1,2")
        server.kill()
    with ServerProcess(path, folder=tmp_path) as server:
        assert (server.address, server.agents) == first
        with Page(server.socket, since=page.revision) as again:
            assert again.start().shown() == page.shown()
        with ServerProcess(tmp_path / "b.json", folder=tmp_path) as other:
            assert other.address != server.address
    (place, _) = sorted(tmp_path.glob(".state/sketch_servers/*.json"))
    assert place.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize(
    "text", ['{"port": 0}', "x", '{"port": 80, "token": "a", "agent_token": "b"}', "readable"]
)
def test_a_damaged_address_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.setenv("ARAEL_STATE_DIR", str(tmp_path))
    listener, first = listening_for(tmp_path / "a.json")
    listener.close()
    listener, again = listening_for(tmp_path / "a.json")
    assert again == first
    busy, other = listening_for(tmp_path / "a.json")
    assert other.port != first.port and other.token == first.token
    listener.close()
    busy.close()
    (place,) = (tmp_path / "sketch_servers").iterdir()
    if text == "readable":
        place.chmod(0o644)  # others may have read the tokens
    else:
        place.write_text(text)
    listener, new = listening_for(tmp_path / "a.json")
    listener.close()
    assert new.token != first.token and len(new.token) > 20 and new.token != new.agent_token


def refused(*arguments: str, folder: Path) -> str:
    """What a server that does not start prints."""
    done = subprocess.run(
        [sys.executable, "-m", "arael", "sketch", "--serve", "--no-open", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=folder,
    )
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    return done.stderr


def test_a_second_server_is_refused_with_a_message(tmp_path: Path) -> None:
    with ServerProcess(tmp_path / "a.json", folder=tmp_path) as server:
        assert "error[E1410]" in refused("a.json", folder=tmp_path)
        done = refused("b.json", "--port", str(server.port), folder=tmp_path)
        assert "error[E1413]" in done and "`--port`" in done


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("a.txt", "", "E1411"),
        ("none/a.json", None, "E1411"),
        ("none.cmd", None, "E1411"),
        ("a.json", "{}", "E1210"),
        ("a.cmd", "dance\n", "E1250"),
    ],
)
def test_a_file_that_cannot_be_served_is_a_message(
    tmp_path: Path, name: str, content: str | None, code: str
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    assert f"error[{code}]" in refused(name, folder=tmp_path)


def test_missing_packages_are_named(tmp_path: Path) -> None:
    script = (
        "import sys; sys.modules['uvicorn'] = None\n"
        "from arael.cli.main import main\n"
        "sys.argv = ['arael', 'sketch', '--serve']\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path, timeout=60
    )
    assert done.returncode == 2 and "error[E1412]" in done.stderr
    assert "`uvicorn`" in done.stderr and "pip install 'arael[sketch]'" in done.stderr


def test_it_listens_on_this_machine_only() -> None:
    with listening(0) as listener:
        assert listener.getsockname()[0] == "127.0.0.1"


def test_a_long_command_is_reported_and_broken_off(page: Page) -> None:
    text = "\n".join(f"add_line {k},0 {k},9; length _ 12" for k in range(3000))
    page.send({"type": "run", "id": 1, "text": text, "step": "lines"})
    busy = page.until("busy")
    assert busy["since_ms"] >= 100
    page.send({"type": "break"})
    reply = page.until("reply")
    # between two commands, or within the solve of one
    assert reply["error"]["code"] in ("E1405", "E1235")
    page.until("idle")
    assert not page.tables["entities"]


def test_one_long_solve_is_reported_and_broken_off_at_once(tmp_path: Path) -> None:
    """Two thousand lines that are too short together: the search for the reason takes seconds."""
    lines = 2000
    file = chain(tmp_path / "chain.json", lines)
    with ServerProcess(file, folder=tmp_path) as running, Page(running.socket).start() as page:
        assert page.run("length L0 10")["ok"]
        page.until("verdict")
        before = page.numbers("L7")
        text = f"hdistance L0.p1 L{lines - 1}.p2 {20 * lines}"
        page.send({"type": "run", "id": 1000, "text": text})
        page.send({"type": "run", "id": 1001, "text": "add_point 1,1"})
        assert page.until("busy")["since_ms"] >= 100
        page.send({"type": "break"})
        page.send({"type": "run", "id": 1002, "text": "add_point 2,2"})
        codes = {}
        while 1002 not in codes:
            reply = page.until("reply")
            codes[reply["id"]] = reply["ok"] or reply["error"]["code"]
        # what waited when it was broken off is not done, what came after is
        assert codes == {1000: "E1235", 1001: "E1405", 1002: True}
        page.until("idle")
        assert page.numbers("L7") == before and list(page.tables["dimensions"]) == ["d0"]


def test_a_socket_without_a_token_is_refused(running: ServerProcess) -> None:
    address = f"ws://127.0.0.1:{running.port}/socket"
    options: dict[str, Any]
    for url, options in (
        (f"{address}?token=wrong", {}),
        (running.socket, {"origin": "http://evil.example"}),
    ):
        with pytest.raises(InvalidStatus) as caught, connect(url, **options):
            pass
        assert caught.value.response.status_code == 403


def test_an_oversized_message_closes_its_window_only(running: ServerProcess, page: Page) -> None:
    other = Page(running.socket, "w2").start()
    too_large = encoded({"type": "run", "text": "x" * (64 * 1024 * 1024)})
    with pytest.raises(ConnectionClosed):
        page.socket.send(too_large)
        while True:
            page.next()
    time.sleep(0.05)
    assert other.run("add_point 1,1")["ok"]
