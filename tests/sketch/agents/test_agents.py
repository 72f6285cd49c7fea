"""Agents by the SDK's own client, over both transports: tools, resources, consent, files."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import subprocess
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from arael.sketch.document.saved import load
from tests import optional

optional.require("starlette")
optional.require("websockets")
optional.require("mcp")

from mcp import Client, StdioServerParameters  # noqa: E402
from mcp_types import Implementation  # noqa: E402

from tests.event_loop import completed  # noqa: E402
from tests.sketch.server.client import Page  # noqa: E402
from tests.sketch.server.process import ServerProcess  # noqa: E402
from tests.sketch.server.shared import Local, shared_sketch  # noqa: E402

Use = Callable[[Client], Awaitable[Any]]
RECTANGLE = "add_rect 0,0 50,30 hv"


def http(server: ServerProcess) -> str:
    return server.agents


def stdio(folder: Path, *options: str) -> StdioServerParameters:
    arguments = ["-m", "arael", "sketch", "mcp", "a.json", *options]
    env = {**os.environ, "ARAEL_STATE_DIR": str(folder / ".state")}
    return StdioServerParameters(command=sys.executable, args=arguments, cwd=str(folder), env=env)


def use(target: Any, function: Use, **options: Any) -> Any:
    """Connect an agent and let a function use it."""

    async def run() -> Any:
        async with Client(target, read_timeout_seconds=60, **options) as client:
            return await function(client)

    return completed(run())


async def text_of(client: Client, tool: str, **arguments: Any) -> tuple[bool, str]:
    """Whether a tool succeeded, and its text."""
    found = await client.call_tool(tool, arguments)
    return not found.is_error, "\n".join(getattr(one, "text", "") for one in found.content)


@pytest.fixture(scope="module")
def allowed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server on which agents need not ask."""
    folder = tmp_path_factory.mktemp("sketch") / "in"
    folder.mkdir()
    with ServerProcess(folder / "a.json", "--mcp-allow-all", folder=folder) as server:
        yield server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server on which a person is asked."""
    folder = tmp_path_factory.mktemp("asked")
    with ServerProcess(folder / "a.json", folder=folder) as running:
        yield running


async def everything(client: Client) -> None:
    """What an agent can do, over any transport."""
    assert "parametric" in (client.instructions or "")
    tools = {tool.name: tool for tool in (await client.list_tools()).tools}
    assert set(tools) == {
        "execute_command",
        "execute_script",
        "get_sketch_state",
        "get_help",
        "render",
    }
    assert all(tool.description for tool in tools.values())
    assert tools["render"].annotations is not None
    assert tools["render"].annotations.read_only_hint

    found = await client.call_tool("execute_command", {"command": f"clear; {RECTANGLE}"})
    assert not found.is_error and found.structured_content is not None
    assert found.structured_content["names"] == ["L0", "L1", "L2", "L3"]
    fine, text = await text_of(client, "execute_script", script="length L0 60\nlength L1 20")
    assert fine and "d0" in text
    fine, text = await text_of(client, "execute_command", command="length L2 40")
    assert not fine and "E1231" in text and "`d0`" in text and "help:" in text

    state = (await client.call_tool("get_sketch_state", {})).structured_content
    assert state is not None and state["degrees_of_freedom"] == 2
    assert "d0: length L0 = 60" in state["dimensions"]
    assert len(state["free"]) == 2
    fine, text = await text_of(client, "get_help", topic="length")
    assert fine and "Length of a line" in text
    assert (await text_of(client, "get_help"))[0]
    fine, text = await text_of(client, "get_help", topic="lenth")
    assert not fine and "did you mean" in text

    (picture,) = (await client.call_tool("render", {})).content
    if optional.is_installed("matplotlib"):
        assert picture.type == "image" and picture.mime_type == "image/png"
        assert base64.b64decode(picture.data).startswith(b"\x89PNG")
    else:
        assert picture.type == "text" and picture.text.startswith("<svg")

    addresses = {str(one.uri) for one in (await client.list_resources()).resources}
    assert addresses == {"sketch://manual", "sketch://document", "sketch://drawing"}
    contents = {}
    for address in addresses:
        (one,) = (await client.read_resource(address)).contents
        contents[address] = one.text  # type: ignore[union-attr]
    assert "add_line" in contents["sketch://manual"]
    assert json.loads(contents["sketch://document"])["format"] == "arael-sketch"
    assert "<svg" in contents["sketch://drawing"]

    assert (await text_of(client, "execute_command", command="undo"))[0]
    state = (await client.call_tool("get_sketch_state", {})).structured_content
    assert state is not None and state["dimensions"] == []


def test_over_http(allowed: ServerProcess) -> None:
    use(http(allowed), everything)


def test_over_pipes(tmp_path: Path) -> None:
    use(stdio(tmp_path, "--mcp-allow-all"), everything)
    assert len(load(tmp_path / "a.json").entities) == 4


def test_what_an_agent_does_appears_in_the_page_as_one_step(allowed: ServerProcess) -> None:
    page = Page(allowed.socket).start()
    page.run("clear")
    steps = page.history["position"]

    async def draw(client: Client) -> None:
        await client.call_tool("execute_script", {"script": f"{RECTANGLE}\nlength L0 60"})

    use(http(allowed), draw)
    change = page.until(lambda m: m["type"] == "change" and m["by"] == "agent")
    assert {one["name"] for one in change["put"]["dimensions"]} == {"d0"}
    assert page.until("history")["position"] == steps + 1
    assert page.run("undo")["ok"] and not page.tables["entities"]
    assert any(m["agents"] == 1 for m in page.messages if m["type"] == "presence")
    page.close()


@pytest.mark.parametrize(
    ("command", "code"),
    [
        ("save ../b.json", "E1264"),
        ("export /tmp/b.svg", "E1264"),
        ("load ../in/../../b.json", "E1264"),
        ("import ~/b.svg", "E1264"),
        ("load link/b.json", "E1264"),
        ("dance", "E1250"),
        ("", "E1250"),
        ("  # nothing", "E1250"),
        ("undo; undo\nadd_point 1,1", "E1404"),
        ("add_line 0,0", "E12"),
        ("add_line 0,0 (", "E1258"),
    ],
)
def test_what_an_agent_may_not_do_is_a_message(
    allowed: ServerProcess, command: str, code: str
) -> None:
    folder = Path(allowed.file).parent
    if not (folder / "link").exists():
        (folder / "link").symlink_to(folder.parent)

    async def attempt(client: Client) -> tuple[bool, str]:
        return await text_of(client, "execute_command", command=command)

    fine, text = use(http(allowed), attempt)
    assert not fine and f"error[{code}" in text
    assert not (folder.parent / "b.json").exists()


def test_a_script_that_is_too_long_is_refused(allowed: ServerProcess) -> None:
    async def attempt(client: Client) -> tuple[bool, str]:
        return await text_of(client, "execute_script", script="# x\n" * 300_000)

    fine, text = use(http(allowed), attempt)
    assert not fine and "at most" in text


# --- consent ------------------------------------------------------------------------------------


async def attempts(client: Client) -> list[tuple[bool, str]]:
    return [await text_of(client, "execute_command", command=f"add_point {k},0") for k in range(2)]


def test_without_a_page_an_agent_is_refused(server: ServerProcess) -> None:
    found = use(http(server), attempts)
    for fine, text in found:
        assert not fine and "E1421" in text and "--mcp-allow-all" in text
        assert server.token not in text


def test_over_pipes_the_refusal_has_the_address(tmp_path: Path) -> None:
    found = use(stdio(tmp_path), attempts)
    assert all("E1421" in text and "http://127.0.0.1:" in text for _, text in found)
    assert not (tmp_path / "a.json").exists()


def test_questions_need_no_consent(server: ServerProcess) -> None:
    async def ask(client: Client) -> list[tuple[bool, str]]:
        found = [await text_of(client, "get_sketch_state"), await text_of(client, "get_help")]
        for line in ("list", "dof", "free", "explain add_point 1,1", "history", "help length"):
            found.append(await text_of(client, "execute_command", command=line))
        return found

    assert all(fine for fine, _ in use(http(server), ask))


@pytest.mark.parametrize(
    "line", ["list; add_point 1,1", "select all", "explain save b.json", "what_if export b.svg"]
)
def test_a_question_with_a_change_behind_it_needs_consent(server: ServerProcess, line: str) -> None:
    async def attempt(client: Client) -> tuple[bool, str]:
        return await text_of(client, "execute_command", command=line)

    fine, text = use(http(server), attempt)
    assert not fine and ("E1421" in text or "E1252" in text)
    assert not list(Path(server.file).parent.glob("b.*"))


class Person(threading.Thread):
    """Answers questions in a page."""

    def __init__(self, server: ServerProcess, answers: list[dict[str, Any]]) -> None:
        super().__init__(daemon=True)
        self.page = Page(server.socket).start()
        self.page.until("presence")
        self.answers = answers
        self.asked: list[dict[str, Any]] = []
        self.start()

    def run(self) -> None:
        for answer in self.answers:
            question = self.page.until(lambda m: m["type"] == "agent" and m["what"] != "")
            self.asked.append(question)
            if answer.get("close"):
                self.page.close()
                return
            again = answer.pop("again", None)
            self.page.send({"type": "answer", "id": question["id"], **answer})
            if again is not None:
                self.page.send({"type": "answer", "id": question["id"], **again})


def test_a_person_refuses_and_allows(server: ServerProcess) -> None:
    person = Person(server, [{"allow": False}, {"allow": True}])
    (first, refusal), (second, _) = use(http(server), attempts)
    assert not first and "E1420" in refusal and "refused" in refusal
    assert second
    person.join(30)
    assert [one["what"] for one in person.asked] == ["add_point 0,0", "add_point 1,0"]
    assert {one["tool"] for one in person.asked} == {"execute_command"}
    person.page.run("list")
    assert list(person.page.tables["entities"]) == ["P0"]
    person.page.run("clear")
    person.page.close()


def test_a_person_allows_for_good(tmp_path: Path) -> None:
    with ServerProcess(tmp_path / "a.json", folder=tmp_path) as own:
        person = Person(own, [{"allow": True, "always": True}])
        found = use(http(own), attempts)
        person.join(30)
    assert all(fine for fine, _ in found) and len(person.asked) == 1


@pytest.mark.parametrize("mode", ["legacy", "auto"])
def test_a_permission_is_one_agents_and_is_revoked(server: ServerProcess, mode: str) -> None:
    person = Person(server, [{"allow": True, "always": True}, *[{"allow": False}] * 4])
    page = person.page

    async def all_of() -> tuple[list[tuple[bool, str]], ...]:
        painter, other = (
            Client(http(server), mode=mode, client_info=Implementation(name=name, version="1"))
            for name in ("Painter", "Other")
        )
        async with painter as permitted, other as stranger:
            first = await attempts(permitted)
            second = await attempts(stranger)
            (standing,) = permissions(page)
            assert standing["name"] == "Painter"
            page.send({"type": "revoke", "session": "another"})
            page.send({"type": "revoke", "session": standing["session"]})
            while permissions(page):  # the thread of the person reads
                await asyncio.sleep(0.01)
            return first, second, await attempts(permitted)

    permitted, refused, revoked = completed(all_of())
    person.join(30)
    assert [fine for fine, _ in (*permitted, *refused, *revoked)] == [True] * 2 + [False] * 4
    assert [one["agent"] for one in person.asked] == ["Painter", "Other", "Other", *["Painter"] * 2]
    assert permissions(page) == []
    page.run("clear")
    page.close()


def test_a_permission_ends_with_the_session(server: ServerProcess) -> None:
    person = Person(server, [{"allow": True, "always": True}])
    assert all(fine for fine, _ in use(http(server), attempts, mode="legacy"))
    person.join(30)
    if permissions(person.page):
        person.page.until(lambda m: m["type"] == "permissions" and not m["agents"])
    person.page.run("clear")
    person.page.close()


def permissions(page: Page) -> list[dict[str, Any]]:
    """The permissions that stand, as the page was told last."""
    found: list[dict[str, Any]] = next(
        m["agents"] for m in reversed(page.messages) if m["type"] == "permissions"
    )
    return found


def test_a_silent_agent_has_no_permission_any_more(monkeypatch: pytest.MonkeyPatch) -> None:
    from arael.sketch.agents import consent
    from arael.sketch.server.permissions import Agent
    from arael.sketch.server.worker import Worker

    monkeypatch.setattr(consent, "SILENT_FOR", 0.0)
    shared = shared_sketch()
    shared.permissions._standing["s"] = agent = Agent("s", "Painter")

    async def silent() -> None:
        await consent.Consent(worker, "").require(agent, "tool", "list")
        await asyncio.sleep(0.1)

    worker = Worker(shared)
    worker.start()
    completed(silent())
    worker.stop()
    assert not shared.permissions.allows(agent)


def test_that_every_agent_is_allowed_is_shown_and_revoked() -> None:
    from arael.sketch.server.permissions import Agent

    shared = shared_sketch()
    shared.permissions.allow_every()
    page = Local(shared)
    assert page.last("permissions")["agents"] == [{"session": "", "name": "every agent"}]
    assert shared.permissions.allows(Agent("s", "any"))
    shared.receive(page.window, {"type": "revoke", "session": ""})
    assert page.last("permissions")["agents"] == []
    assert not shared.permissions.allows(Agent("s", "any"))


def test_a_page_that_opens_later_has_the_request_too() -> None:
    from arael.sketch.server.permissions import Agent

    shared = shared_sketch()
    answers: list[bool] = []
    identity = shared.permissions.ask(Agent("s", "Painter"), "tool", "undo", answers.append)
    page = Local(shared)
    assert page.last("agent")["id"] == identity
    for allow in (True, False):
        shared.receive(page.window, {"type": "answer", "id": identity, "allow": allow})
    assert answers == [True]


@pytest.mark.parametrize("always", [True, False])
def test_a_request_is_answered_once(server: ServerProcess, always: bool) -> None:
    """A second answer neither changes the first nor gives a permission for good."""
    first = {"allow": False, "again": {"allow": True, "always": always}}
    person = Person(server, [first, {"allow": False}])
    found = use(http(server), attempts)
    person.join(30)
    assert [fine for fine, _ in found] == [False, False] and len(person.asked) == 2
    identities = [one["id"] for one in person.asked]
    assert len(set(identities)) == 2
    person.page.run("list")
    over = [m["id"] for m in person.page.messages if m["type"] == "agent_answered"]
    assert over == identities  # once each; nothing else that a page could take for a request
    assert [m["id"] for m in person.page.messages if m["type"] == "agent"] == identities
    person.page.close()


def test_a_page_that_closes_counts_as_refusal(server: ServerProcess) -> None:
    person = Person(server, [{"close": True}])
    (first, text), _ = use(http(server), attempts)
    person.join(30)
    assert not first and "E1420" in text and "closed" in text


def test_an_answer_to_nothing_is_ignored(server: ServerProcess) -> None:
    page = Page(server.socket).start()
    for number in (1, 99, "x", None):
        page.send({"type": "answer", "id": number, "allow": True})
    assert page.run("list")["ok"]
    page.close()


def test_a_server_starts_without_the_sdk_but_not_where_it_is_missing() -> None:
    """To import it takes half of the start; it is there when the first agent comes."""
    there = "import sys, arael.sketch.server.serving; assert 'mcp' not in sys.modules"
    subprocess.run([sys.executable, "-c", there], check=True)
    missing = "import sys; sys.modules['mcp'] = None; from arael.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", missing, "sketch", "--serve", "--no-open", "nowhere.json"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    assert "E1412" in done.stderr and "the module `mcp`" in done.stderr
    assert "pip install 'arael[sketch]'" in done.stderr
