"""What a person allows agents: requests that are open, and permissions that stand.

Called in the thread of the sketch (`Worker`).
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

EVERY_AGENT = "every agent"
"""Name under which the permission of `--mcp-allow-all` is shown."""


@dataclass(frozen=True)
class Agent:
    """An agent that is connected.

    Attributes
    ----------
    session : unique while it is connected
    name : as it calls itself
    """

    session: str
    name: str


@dataclass(frozen=True)
class Request:
    """A change that waits for a person.

    Attributes
    ----------
    agent : that wants to make it
    message : as windows are sent it
    settle : called once, with the answer
    """

    agent: Agent
    message: dict[str, Any]
    settle: Callable[[bool], object]


class Permissions:
    """Open requests and standing permissions.

    Parameters
    ----------
    send : sends a message to every window
    """

    def __init__(self, send: Callable[[dict[str, Any]], None]) -> None:
        self._send = send
        self._requests: dict[str, Request] = {}
        self._standing: dict[str, Agent] = {}
        self._every = False

    # --- requests -----------------------------------------------------------------------------

    def ask(self, agent: Agent, tool: str, what: str, settle: Callable[[bool], object]) -> str:
        """Ask in every window; the identity of the request, which no other one ever has."""
        identity = secrets.token_hex(8)
        message = {"type": "agent", "id": identity, "agent": agent.name, "tool": tool, "what": what}
        self._requests[identity] = Request(agent, message, settle)
        self._send(message)
        return identity

    def answer(self, identity: Any, allow: bool, always: bool) -> None:
        """Take the first answer to an open request; ignore any other.

        Parameters
        ----------
        always : whether the agent of the request need not ask again
        """
        request = self._requests.get(identity) if isinstance(identity, str) else None
        if request is None:
            return
        self.withdraw(identity)
        if allow and always:
            self._standing[request.agent.session] = request.agent
            self._send(self.message())
        request.settle(allow)

    def withdraw(self, identity: str) -> None:
        """End a request without an answer."""
        if self._requests.pop(identity, None) is not None:
            self._send({"type": "agent_answered", "id": identity})

    # --- permissions --------------------------------------------------------------------------

    def allow_every(self) -> None:
        """No agent need ask."""
        self._every = True

    def allows(self, agent: Agent) -> bool:
        """Whether an agent need not ask."""
        return self._every or agent.session in self._standing

    def revoke(self, session: Any) -> None:
        """Take a permission back: of an agent's session, or of every agent (empty)."""
        if session == "" and self._every:
            self._every = False
        elif not isinstance(session, str) or self._standing.pop(session, None) is None:
            return
        self._send(self.message())

    def messages(self) -> list[dict[str, Any]]:
        """What a window that opens has to know."""
        return [self.message(), *(one.message for one in self._requests.values())]

    def message(self) -> dict[str, Any]:
        """The permissions that stand."""
        every = [{"session": "", "name": EVERY_AGENT}] if self._every else []
        agents = [{"session": one.session, "name": one.name} for one in self._standing.values()]
        return {"type": "permissions", "agents": every + agents}
