"""Diagnostics as plain data, for editors and other programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from arael.diagnostics.records import Diagnostic, Span


def as_json(diagnostics: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    """One dict per diagnostic, of strings, numbers, lists and dicts only.

    Lines and columns count from 1, columns in characters; the end is the place after the last
    character. Without a source text the places are None and ``file`` is the origin.
    """
    return [_one(d) for d in diagnostics]


def _one(d: Diagnostic) -> dict[str, Any]:
    return {
        "severity": d.severity,
        "code": d.code,
        "message": d.message,
        **(_place(d.span) if d.span else {**_NOWHERE, "file": d.origin or None}),
        "label": d.label,
        "labels": [{**_place(label.span), "text": label.text} for label in d.labels],
        "notes": list(d.notes),
        "help": list(d.help),
    }


_NOWHERE: dict[str, Any] = {
    "file": None,
    "line": None,
    "column": None,
    "end_line": None,
    "end_column": None,
}


def _place(span: Span) -> dict[str, Any]:
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(max(span.start, span.end))
    return {
        "file": span.source.name,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
    }
