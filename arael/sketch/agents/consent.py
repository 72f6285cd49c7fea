"""Whether an agent may change the sketch: a person is asked in the page."""

from __future__ import annotations

import asyncio

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.server.permissions import Agent
from arael.sketch.server.worker import Worker

ANSWER_WITHIN = 120.0
"""Seconds until a request without an answer counts as refused."""

SILENT_FOR = 1800.0
"""Seconds without a request after which an agent's session is over, as of the SDK's sessions."""


class Consent:
    """Asks the open pages, unless the agent has a permission that stands.

    Parameters
    ----------
    worker : of the sketch
    address : of the page, for the message where none is open
    """

    def __init__(self, worker: Worker, address: str) -> None:
        self._worker = worker
        self._address = address
        self._ends: dict[str, asyncio.TimerHandle] = {}

    async def require(self, agent: Agent, tool: str, what: str) -> None:
        """Return when the change is allowed.

        Parameters
        ----------
        what : the commands

        Raises
        ------
        AraelError
            E1420: refused, or not answered; E1421: no page is open in which to ask
        """
        shared = self._worker.shared
        self._last_seen(agent)
        if shared.permissions.allows(agent):
            return
        if not shared.windows:
            raise AraelError(
                Diagnostic(
                    "E1421",
                    "no page is open in which a person can allow an agent's change",
                    help=(
                        f"ask the person to open {self._address} in a browser, or to start the "
                        "server with `--mcp-allow-all`",
                    ),
                )
            )
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[bool] = loop.create_future()

        def settle(allow: bool) -> None:
            if not answer.done():
                answer.set_result(allow)

        identity = await asyncio.wrap_future(
            self._worker.call(
                lambda: shared.permissions.ask(
                    agent, tool, what, lambda allow: loop.call_soon_threadsafe(settle, allow)
                )
            )
        )
        try:
            await self._wait(answer)
        finally:
            self._worker.call(lambda: shared.permissions.withdraw(identity))
        if not answer.result():
            raise AraelError(
                Diagnostic(
                    "E1420",
                    "the person refused this change",
                    help=("ask what is wanted before the next one",),
                )
            )

    def end(self, session: str) -> None:
        """An agent's session is over: its permission ends."""
        timer = self._ends.pop(session, None)
        if timer is not None:
            timer.cancel()
        self._worker.call(lambda: self._worker.shared.permissions.revoke(session))

    def _last_seen(self, agent: Agent) -> None:
        """End the session of an agent that is silent for long."""
        timer = self._ends.pop(agent.session, None)
        if timer is not None:
            timer.cancel()
        loop = asyncio.get_running_loop()
        self._ends[agent.session] = loop.call_later(SILENT_FOR, self.end, agent.session)

    async def _wait(self, answer: asyncio.Future[bool]) -> None:
        """Wait for an answer, as long as there is a page that can give one."""
        waited = 0.0
        while not answer.done():
            await asyncio.wait({answer}, timeout=0.5)
            waited += 0.5
            if not answer.done() and (waited >= ANSWER_WITHIN or not self._worker.shared.windows):
                reason = "no answer came" if self._worker.shared.windows else "the page was closed"
                raise AraelError(
                    Diagnostic(
                        "E1420",
                        f"{reason}: the change is not made",
                        help=("ask the person, then try again",),
                    )
                )
