"""Warnings of a model as they are stored: places by file number and character, not by name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from arael.diagnostics.records import Diagnostic, Label, Source, Span


class StoredSpan(msgspec.Struct, frozen=True):
    """Characters ``start:end`` of file number `file`."""

    file: int
    start: int
    end: int


class StoredWarning(msgspec.Struct, frozen=True):
    """A `Diagnostic`, without the texts it points into."""

    code: str
    message: str
    span: StoredSpan | None
    label: str
    labels: tuple[tuple[StoredSpan, str], ...]
    notes: tuple[str, ...]
    help: tuple[str, ...]


def stored(warnings: Iterable[Diagnostic], sources: Sequence[Source]) -> tuple[StoredWarning, ...]:
    """Warnings whose places lie in `sources`, ready to be stored."""
    numbers = {source.name: k for k, source in enumerate(sources)}

    def place(span: Span) -> StoredSpan:
        return StoredSpan(numbers[span.source.name], span.start, span.end)

    return tuple(
        StoredWarning(
            d.code,
            d.message,
            place(d.span) if d.span else None,
            d.label,
            tuple((place(label.span), label.text) for label in d.labels),
            d.notes,
            d.help,
        )
        for d in warnings
    )


def rendered(warnings: Iterable[StoredWarning], sources: Sequence[Source]) -> tuple[str, ...]:
    """Stored warnings as text, with the names of `sources`."""
    found = list(warnings)
    if not found:
        return ()
    # imported here: start-up time
    from arael.diagnostics.render import render

    def place(span: StoredSpan) -> Span:
        return Span(sources[span.file], span.start, span.end)

    return tuple(
        render(
            [
                Diagnostic(
                    w.code,
                    w.message,
                    place(w.span) if w.span else None,
                    w.label,
                    tuple(Label(place(span), text) for span, text in w.labels),
                    w.notes,
                    w.help,
                    severity="warning",
                )
            ],
            color=False,
            width=100,
        )
        for w in found
    )
