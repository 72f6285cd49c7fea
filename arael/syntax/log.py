"""Collects the syntax errors of one text, up to a bound."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from arael.diagnostics.records import AraelError, Diagnostic, Label, Source, Span
from arael.syntax.limits import MAX_ERRORS

_MAX_MESSAGE = 240


STRAY = "E0110"


class ErrorLog:
    """Errors of `source`; stops with `AraelError` when there are too many."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self._found: dict[tuple[int, str], Diagnostic] = {}

    def span(self, start: int, end: int) -> Span:
        """Characters ``start:end`` of the text."""
        return Span(self.source, start, end)

    def error(
        self,
        code: str,
        message: str,
        start: int,
        end: int,
        label: str = "",
        *,
        labels: Iterable[tuple[int, int, str]] = (),
        notes: Iterable[str] = (),
        help: Iterable[str] | str = (),
    ) -> None:
        """Record an error at ``start:end``; a second one with the same code there is dropped."""
        hints = (help,) if isinstance(help, str) else tuple(help)
        self.add(
            Diagnostic(
                code,
                _clip(message),
                self.span(start, end),
                _clip(label),
                labels=tuple(Label(self.span(a, b), _clip(text)) for a, b, text in labels),
                notes=tuple(map(_clip, notes)),
                help=tuple(map(_clip, hints)),
            )
        )

    def add(self, diagnostic: Diagnostic) -> None:
        """Record `diagnostic`, which must have a span."""
        assert diagnostic.span is not None
        if (diagnostic.span.start, STRAY) in self._found:
            return  # the replacement of a stray character is a guess and must not be quoted
        self._found.setdefault((diagnostic.span.start, diagnostic.code), diagnostic)
        if len(self._found) >= MAX_ERRORS:
            *others, last = self.in_order()
            note = f"reading stopped after {MAX_ERRORS} errors; there may be more"
            raise AraelError([*others, replace(last, notes=(*last.notes, note))])

    def has_error_in(self, start: int, end: int) -> bool:
        """Return whether an error was found that begins in ``start:end``."""
        return any(start <= at < end for at, _ in self._found)

    def said(self, message: str) -> bool:
        """Return whether `message` was recorded before, anywhere."""
        return any(d.message == message for d in self._found.values())

    def in_order(self) -> list[Diagnostic]:
        """Everything found, in the order of the text."""
        return [self._found[key] for key in sorted(self._found)]

    def stop(self) -> None:
        """Raise `AraelError` if anything was found."""
        if self._found:
            raise AraelError(self.in_order())


def _clip(text: str) -> str:
    """Shorten a message that quotes too much of the text."""
    return text if len(text) <= _MAX_MESSAGE else text[: _MAX_MESSAGE - 3] + "..."
