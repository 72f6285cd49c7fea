"""Errors of this package: one diagnostic, with a place if there is one."""

from __future__ import annotations

from typing import Any, NoReturn

from arael.diagnostics.records import AraelError, Diagnostic, Span


def fail(
    code: str, message: str, span: Span | None = None, label: str = "", **more: Any
) -> NoReturn:
    """Raise `AraelError` with one diagnostic; `more` are further fields of it."""
    raise AraelError(Diagnostic(code, message, span, label, **more))
