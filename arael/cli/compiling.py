"""Progress of a compilation on stderr."""

from __future__ import annotations

import sys

import click

from arael.display.progress import OnTerminal

SHOWN_AFTER = 1.0
"""Seconds before a terminal shows that something is compiled."""

REPORTED_AFTER = 30.0
"""Seconds before a pipe gets one line about it."""


class CompilingLine:
    """A `arael.compiler.progress.Listener`: one line that changes on a terminal, one in a pipe."""

    def __init__(self) -> None:
        self._show = OnTerminal()
        self._shown = self._reported = False

    def __call__(self, what: str, seconds: float | None, limit: float) -> None:
        """Show the current stage and its duration; None at the end."""
        if sys.stderr is None or sys.stderr.closed:
            return
        if seconds is None:
            if self._shown:
                self._show("")
            self._shown = self._reported = False
        elif sys.stderr.isatty():
            if seconds >= SHOWN_AFTER:
                self._shown = True
                self._show(f"{what} ... {seconds:.0f} s (at most {limit:g} s)")
        elif seconds >= REPORTED_AFTER and not self._reported:
            self._reported = True
            click.echo(f"{what} ... {seconds:.0f} s so far (at most {limit:g} s)", err=True)
