"""Progress of a compilation on stderr."""

from __future__ import annotations

import sys

import click

SHOWN_AFTER = 1.0
"""Seconds before a terminal shows that something is compiled."""

REPORTED_AFTER = 30.0
"""Seconds before a pipe gets one line about it."""


class CompilingLine:
    """A `arael.compiler.progress.Listener`: one line that changes on a terminal, one in a pipe."""

    def __init__(self) -> None:
        self._shown = False
        self._reported = False

    def __call__(self, what: str, seconds: float | None, limit: float) -> None:
        """Show the current stage and its duration; None at the end."""
        if sys.stderr is None or sys.stderr.closed:
            return
        if seconds is None:
            if self._shown:
                sys.stderr.write("\r\x1b[K")
                sys.stderr.flush()
            self._shown = self._reported = False
        elif sys.stderr.isatty():
            if seconds >= SHOWN_AFTER:
                self._shown = True
                sys.stderr.write(f"\r\x1b[K{what} ... {seconds:.0f} s (at most {limit:g} s)")
                sys.stderr.flush()
        elif seconds >= REPORTED_AFTER and not self._reported:
            self._reported = True
            click.echo(f"{what} ... {seconds:.0f} s so far (at most {limit:g} s)", err=True)
