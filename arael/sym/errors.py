"""Errors of this package: one diagnostic, with a place if there is one."""

from __future__ import annotations

from typing import NoReturn

from arael.diagnostics.records import AraelError, Diagnostic, Label, Span


def fail(
    code: str,
    message: str,
    span: Span | None = None,
    label: str = "",
    *,
    labels: tuple[Label, ...] = (),
    notes: tuple[str, ...] = (),
    help: tuple[str, ...] = (),
    origin: str = "",
) -> NoReturn:
    """Raise `AraelError` with one diagnostic."""
    raise AraelError(Diagnostic(code, message, span, label, labels, notes, help, origin))
