"""Errors of `arael.fit`."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic


def mistake(code: str, message: str, origin: str, help: str = "") -> AraelError:
    """An error with its place and, if known, the remedy."""
    return AraelError(Diagnostic(code, message, origin=origin, help=(help,) if help else ()))
