"""The tools and resources of the Model Context Protocol."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, TypeVar

from mcp.server import MCPServer
from mcp.server.mcpserver import Context, Image
from mcp.server.mcpserver.exceptions import ToolError
from mcp_types import ToolAnnotations

from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.sketch.agents.consent import Consent
from arael.sketch.agents.http import SESSION_HEADER
from arael.sketch.agents.state import state_of
from arael.sketch.commands import manual, table
from arael.sketch.commands.session import State
from arael.sketch.commands.tokens import Statement, lines
from arael.sketch.document.saved import to_json
from arael.sketch.drawing import layout, to_image, to_svg
from arael.sketch.server.permissions import Agent
from arael.sketch.server.worker import Worker
from arael.version import __version__

_T = TypeVar("_T")

MAX_SCRIPT = 1024 * 1024
"""Characters of a script."""

MAX_NAME = 60
"""Characters of an agent's name that are shown."""

INSTRUCTIONS = """\
A parametric 2D sketch editor. Geometry is drawn and constrained by commands (`get_help` lists \
them, `get_help` with a command's name explains it). Every call that changes the sketch is one \
step of undo (`undo`), and a person may watch, allow or refuse it. Constraints hold exactly; one \
that is redundant or impossible is refused with the names of those that it depends on. Look at \
the result with `render`, and at the names of things with `get_sketch_state`."""

READS = ToolAnnotations(read_only_hint=True, open_world_hint=False)
CHANGES = ToolAnnotations(read_only_hint=False, destructive_hint=False, open_world_hint=False)

_ASKING = frozenset({"help", "history", "list", "print"})


class Agents:
    """What agents may do with a shared sketch.

    Parameters
    ----------
    worker : of the sketch
    address : of the page

    Attributes
    ----------
    server : of the SDK
    state : variables, cursor and selection of agents
    """

    def __init__(self, worker: Worker, address: str) -> None:
        self._worker = worker
        self._shared = worker.shared
        self._consent = Consent(worker, address)
        self.state = State()
        self.server = self._made()

    def _made(self) -> MCPServer:
        server = MCPServer(
            "arael sketch", instructions=INSTRUCTIONS, version=__version__, log_level="WARNING"
        )
        server.tool(annotations=CHANGES)(self.execute_command)
        server.tool(annotations=CHANGES)(self.execute_script)
        server.tool(annotations=READS)(self.get_sketch_state)
        server.tool(annotations=READS)(self.get_help)
        server.tool(annotations=READS)(self.render)
        for address, mime, function in (
            ("sketch://manual", "text/markdown", self.manual),
            ("sketch://document", "application/json", self.document),
            ("sketch://drawing", "image/svg+xml", self.drawing),
        ):
            server.resource(address, mime_type=mime)(function)
        return server

    # --- tools --------------------------------------------------------------------------------

    async def execute_command(self, command: str, context: Context[Any, Any]) -> dict[str, Any]:
        """Run one command line of the sketch editor, such as `add_line 0,0 50,0` or `length L0 80`.

        Several commands may be separated by `;`: they are made together or not at all, as one step
        of undo. `_` and `_0`, `_1` stand for what the last command created. The reply has its text
        and the names of what was created. Commands that only ask (`list`, `info L0`, `free`,
        `why L0`, `what_if ...`) change nothing.
        """
        return await self._run(context, "execute_command", command)

    async def execute_script(self, script: str, context: Context[Any, Any]) -> dict[str, Any]:
        """Run several command lines as one step of undo: all of them, or none if one is refused.

        Lines that begin with `#` are comments; `name = add_line ...` keeps a name for later lines.
        """
        return await self._run(context, "execute_script", script)

    async def get_sketch_state(self) -> dict[str, Any]:
        """Describe the sketch: entities with coordinates, constraints, dimensions, parameters.

        Also how many degrees of freedom are left, in words what can still move, and which
        constraints are redundant.
        """
        self._seen()
        return await self._call(self._state)

    async def get_help(self, topic: str = "") -> str:
        """Show the commands, or one command, group or topic; `full` shows the whole manual."""
        if len(topic.split()) > 1:
            raise ToolError("expected one word as `topic`")
        found = await self._call(lambda: self._shared.query(self, f"help {topic}".strip()))
        return str(found["text"])

    async def render(self, dark: bool = False) -> Any:
        """Draw the sketch with its dimensions and constraints, as a picture to look at."""
        self._seen()
        document = self._shared.session.document
        try:
            data = await self._call(
                lambda: to_image(layout(document), "png", theme="dark" if dark else "light")
            )
        except (AraelError, ModuleNotFoundError):  # without matplotlib
            return await self._call(lambda: to_svg(layout(document)))
        return Image(data=data, format="png")

    # --- resources ----------------------------------------------------------------------------

    def manual(self) -> str:
        """The manual of all commands."""
        return manual.full()

    async def document(self) -> str:
        """The sketch as JSON, as it is saved."""
        return await self._call(lambda: to_json(self._shared.session.document).decode())

    async def drawing(self) -> str:
        """The drawing as SVG."""
        return await self._call(lambda: to_svg(layout(self._shared.session.document)))

    def ended(self, session: str) -> None:
        """A session of an agent is over."""
        self._consent.end(session)

    # --- inside -------------------------------------------------------------------------------

    async def _run(self, context: Context[Any, Any], tool: str, text: str) -> dict[str, Any]:
        self._seen()
        if len(text) > MAX_SCRIPT:
            raise ToolError(f"{len(text):,} characters; at most {MAX_SCRIPT:,} are read")
        try:
            found = list(lines(Source("command", text)))
            if not found:
                raise AraelError(Diagnostic("E1250", "expected a command, found nothing"))
            statements = [one for line in found for one in line]
            if not all(map(_only_asks, statements)):
                await self._consent.require(_agent(context), tool, text)
        except AraelError as error:
            raise ToolError(_written(error)) from None
        outside = any(map(_is_outside, statements)) and len(found) == 1
        step = "" if outside or len(found) == 1 else f"agent: {statements[0].text[:100]} ..."
        reply = await self._call(lambda: self._make(text, step))
        if not reply["ok"]:
            raise ToolError(_refused(reply["error"]))
        return {key: reply[key] for key in ("text", "names", "created", "notes") if reply[key]}

    def _make(self, text: str, step: str) -> dict[str, Any]:
        return self._shared.run(self, "agent", text, step=step)

    def _state(self) -> dict[str, Any]:
        with self._shared.session.editor.solver.question():
            return state_of(self._shared)

    async def _call(self, function: Callable[[], _T]) -> _T:
        """Call a function in the thread of the sketch."""
        try:
            return await asyncio.wrap_future(self._worker.call(function))
        except AraelError as error:
            raise ToolError(_written(error)) from None

    def _seen(self) -> None:
        """An agent is there: pages show it."""
        shared = self._shared
        if not shared.agents:
            shared.agents = 1
            self._worker.call(shared.send_presence)


def _agent(context: Context[Any, Any]) -> Agent:
    """Who calls a tool.

    Requests of the protocol without sessions (2026-07-28) are told apart by the name and version
    that the agent's program gives.
    """
    parameters = context.session.client_params
    name, version = "an agent", ""
    if parameters is not None:
        name, version = parameters.client_info.name, parameters.client_info.version
        name = " ".join(name.split())[:MAX_NAME] or "an agent"
    session = (context.headers or {}).get(SESSION_HEADER)
    return Agent(session or f"{name} {version}"[: 2 * MAX_NAME], name)


def _find(statement: Statement) -> Any:
    return table.find((statement.text.split(None, 1) or [""])[0])


def _is_outside(statement: Statement) -> bool:
    found = _find(statement)
    return found is not None and bool(found.outside)


def _only_asks(statement: Statement) -> bool:
    """Whether a command changes nothing; what is unknown is refused by running it."""
    found = _find(statement)
    return found is not None and (found.group == "ask" or found.name in _ASKING)


def _written(error: AraelError) -> str:
    return str(error)


def _refused(error: dict[str, Any]) -> str:
    """Why a command was refused, in lines."""
    parts = [f"error[{error['code']}]: {error['message']}"]
    parts += [f"note: {note}" for note in error["notes"]]
    parts += [f"help: {one}" for one in error["help"]]
    return "\n".join(parts)
