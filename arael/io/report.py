"""Errors in one data file: several per run, up to a limit."""

from __future__ import annotations

from collections.abc import Callable

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Column
from arael.runtime.store.messages import problem

MOST = 20


class TooMany(Exception):
    """The limit of errors was reached, or what follows needs what was wrong."""


class Report:
    """Collects the errors of a file; `stop` raises them.

    Places are key paths; each is shown after the file's name.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.found: list[Diagnostic] = []

    def at(self, place: str) -> str:
        """``scene.json: poses[3].pos``."""
        return f"{self.name}: {place}" if place else self.name

    def add(
        self, code: str, message: str, place: str, column: Column | None = None, help: str = ""
    ) -> None:
        """Add one error."""
        self.take(problem(code, message, self.at(place), column, help))

    def take(self, diagnostic: Diagnostic) -> None:
        """Add an existing diagnostic."""
        self.found.append(diagnostic)
        if len(self.found) >= MOST:
            raise TooMany

    def halt(self) -> None:
        """End the reader if anything was found; within `run`, which raises the errors."""
        if self.found:
            raise TooMany

    def stop(self) -> None:
        """Raise AraelError if anything was found."""
        if len(self.found) >= MOST:
            last = self.found[-1]
            more = (*last.notes, f"only the first {MOST} errors are shown")
            self.found[-1] = Diagnostic(
                last.code,
                last.message,
                last.span,
                last.label,
                last.labels,
                more,
                last.help,
                last.origin,
            )
        if self.found:
            raise AraelError(self.found)

    def run(self, read: Callable[[], None]) -> None:
        """Run a reader that reports here, then raise the errors."""
        try:
            read()
        except TooMany:
            pass
        except AraelError as failure:
            self.found += failure.diagnostics[: MOST - len(self.found)]
        self.stop()
