"""Whether an agent may change the sketch: a person is asked in the page."""

from __future__ import annotations

import asyncio
import itertools
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.server.worker import Worker

ANSWER_WITHIN = 120.0
"""Seconds until a question without an answer counts as refused."""


class Consent:
    """Asks the open pages, unless agents are allowed for good.

    Parameters
    ----------
    worker : of the sketch
    address : of the page, for the message where none is open
    """

    def __init__(self, worker: Worker, address: str) -> None:
        self._worker = worker
        self._address = address
        self._numbers = itertools.count(1)
        self._open: dict[Any, asyncio.Future[bool]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        worker.shared.on_answer = self._answered

    def _answered(self, number: Any, allow: bool) -> None:
        """An answer of a page, in the thread of the sketch."""
        loop = self._loop
        if loop is not None and isinstance(number, int):
            loop.call_soon_threadsafe(self._settle, number, allow)

    def _settle(self, number: int, allow: bool) -> None:
        found = self._open.get(number)
        if found is not None and not found.done():
            found.set_result(allow)

    async def require(self, tool: str, what: str) -> None:
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
        if shared.agent_allowed:
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
        self._loop = asyncio.get_running_loop()
        number = next(self._numbers)
        answer = self._open[number] = self._loop.create_future()
        question = {"type": "agent", "id": number, "tool": tool, "what": what}
        self._worker.call(lambda: shared.send(question))
        try:
            await self._wait(answer)
        finally:
            del self._open[number]
            self._worker.call(
                lambda: shared.send({"type": "agent", "id": number, "tool": tool, "what": ""})
            )
        if not answer.result():
            raise AraelError(
                Diagnostic(
                    "E1420",
                    "the person refused this change",
                    help=("ask what is wanted before the next one",),
                )
            )

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
