"""`arael sketch --serve`: a server on this machine, for one file."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.agents.http import TOOLS, HttpAgents
from arael.sketch.commands.session import Session
from arael.sketch.server.addresses import listening_for
from arael.sketch.server.app import Server
from arael.sketch.server.keeping import Keeper
from arael.sketch.server.protocol import MAX_MESSAGE
from arael.sketch.server.shared import SharedSketch
from arael.sketch.server.worker import Worker

if TYPE_CHECKING:
    from arael.sketch.agents.tools import Agents


def serve(
    file: str | None = None,
    *,
    port: int = 0,
    open_browser: bool = True,
    allow_agents: bool = False,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the editor until it is interrupted.

    Parameters
    ----------
    file : ``.json``, need not be there; ``.cmd``: it is run, and kept as ``.json`` beside it;
        None: a new one in the working folder
    port : 0 for the one that the file's server had last, or a free one
    open_browser : whether a browser is opened, where there is a display
    allow_agents : whether agents may change the sketch without asking
    say : prints a line

    Raises
    ------
    AraelError
        E1410: another server has the file; E1411: not a file of a sketch; E1413: the port is
        taken; as `Keeper`
    """
    found = opened(file, port, allow_agents, say)
    say("end with Ctrl-C")
    if open_browser and has_display():
        threading.Thread(target=webbrowser.open, args=(found.address,), daemon=True).start()
    with contextlib.suppress(KeyboardInterrupt):  # raised again after everything is closed
        uvicorn.Server(config(found.server.app)).run(sockets=[found.listener])


@dataclass(frozen=True)
class Opened:
    """A server that is about to run.

    Attributes
    ----------
    server : the application
    agents : returns the tools of agents, the same ones each time
    listener : the socket that it listens on
    address : of the page, with the token
    """

    server: Server
    agents: Callable[[], Agents]
    listener: socket.socket
    address: str


def opened(
    file: str | None,
    port: int,
    allow_agents: bool,
    say: Callable[[str], None] = print,
    by_agent: bool = False,
) -> Opened:
    """Open a file for a server, and print its addresses; parameters as of `serve`.

    `by_agent`: an agent started it, so that no person sees what is printed.
    """
    shared = shared_sketch(file, say)
    keeper = shared.keeper
    assert keeper is not None
    try:
        listener, address = listening_for(keeper.path, port)
    except BaseException:
        keeper.close(keeper.document)
        raise
    if allow_agents:
        shared.permissions.allow_every()
    worker = Worker(shared)
    shown = address.page if by_agent else "the address that the server printed"
    agents = cache(lambda: import_module(TOOLS).Agents(worker, shown))
    tokens = {"/": address.token, "/socket": address.token, "/mcp": address.agent_token}
    server = Server(worker, tokens, HttpAgents(agents))
    say(f"editing {keeper.path}")
    if keeper.read_only:
        say(f"{keeper.read_only}: changes are not kept; `save other.json` writes a copy")
    say(f"open {address.page}")
    say(f"agents connect to {address.agents}")
    return Opened(server, agents, listener, address.page)


def config(app: Any) -> uvicorn.Config:
    """Settings of uvicorn: no compression, messages of bounded size, few lines in the log."""
    return uvicorn.Config(
        app,
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=MAX_MESSAGE,
        ws_per_message_deflate=False,
        server_header=False,
        timeout_graceful_shutdown=2,
    )


def shared_sketch(file: str | None, say: Callable[[str], None] = print) -> SharedSketch:
    """The sketch of a file, with its lock and journal."""
    path = Path(file).absolute() if file else _free_name(Path.cwd())
    script = ""
    if path.suffix.lower() not in (".json", ".cmd"):
        raise _not_served(path, "expected a file ending in .json or .cmd")
    if path.suffix.lower() == ".cmd":
        script, path = _script(path), path.with_suffix(".json")
        if path.exists():
            raise _not_served(
                path, "the sketch of this script is there already", "open it, or move it away"
            )
    if not path.parent.is_dir():
        raise _not_served(path, "there is no such folder")
    try:
        keeper = Keeper(path)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise _not_served(path, f"cannot be read: {reason}") from None
    session = Session(folder=path.parent)
    session.editor = session.make_editor(keeper.document)
    if keeper.recovered:
        changes = "1 change" if keeper.recovered == 1 else f"{keeper.recovered} changes"
        say(f"took up {changes} that had not been saved")
    shared = SharedSketch(session, keeper)
    if script:
        session.run(script, str(file))
        shared.publish("script", f"run {Path(str(file)).name}")
    return shared


def _script(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise _not_served(path, f"cannot be read: {(error.strerror or '').lower()}") from None
    except UnicodeDecodeError:
        raise _not_served(path, "a script is a text file in UTF-8") from None


def _free_name(folder: Path) -> Path:
    """A name in a folder that no sketch has: ``sketch.json``, ``sketch2.json``."""
    number = 1
    while True:
        path = folder / f"sketch{number if number > 1 else ''}.json"
        if not path.exists() and not path.with_name(f"{path.name}.journal").exists():
            return path
        number += 1


def _not_served(path: Path, reason: str, *help_: str) -> AraelError:
    return AraelError(Diagnostic("E1411", reason, origin=str(path), help=help_))


def has_display() -> bool:
    """Whether a browser has somewhere to open."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
