"""Corrections that a message proposes, as edits.

A help line quotes what to write. Each reading of it as an edit is tried: the changed text is
checked, and the edit is offered only if the error is gone and there is no new one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from arael.diagnostics.records import Diagnostic, Source, Span
from arael.lsp.document import Document, analyse
from arael.lsp.workspace import Workspace

_QUOTED = re.compile(r"`([^`]+)`")
MAX_TRIED = 12
"""Texts that are checked for one error."""


@dataclass(frozen=True)
class Action:
    """An edit of one place that removes `finding`."""

    title: str
    finding: Diagnostic
    span: Span
    text: str


def actions(document: Document, start: int, end: int, workspace: Workspace) -> list[Action]:
    """Corrections of the errors between two offsets."""
    found: list[Action] = []
    for finding in document.findings:
        span = finding.span
        if span is None or span.source.name != document.source.name:
            continue
        if span.end < start or span.start > end:
            continue
        tried: set[tuple[int, int, str]] = set()
        for action in _readings(document, finding):
            key = (action.span.start, action.span.end, action.text)
            if key in tried or len(tried) >= MAX_TRIED:
                continue
            tried.add(key)
            if _mends(document, action, workspace):
                found.append(action)
    return found


def _readings(document: Document, finding: Diagnostic) -> Iterator[Action]:
    """Edits that the help lines of `finding` may mean."""
    span = finding.span
    assert span is not None
    for line in finding.help:
        title = line[:1].upper() + line[1:]
        for quoted in _QUOTED.findall(line):
            if quoted.startswith("when "):
                yield from _guarded(document, finding, title, quoted)
            elif line.startswith("omit"):
                yield from _without(document, finding, title, quoted)
            else:
                for place in _places(document, span):
                    yield Action(f"Replace by `{quoted}`", finding, place, quoted)
                yield Action(f"Write `{quoted}`", finding, _line(span), quoted)


def _places(document: Document, span: Span) -> Iterator[Span]:
    """The text of an error, then its last and its first word."""
    yield span
    words = [t for t in document.tokens if span.start <= t.start and t.end <= span.end]
    for token in (words[-1:] + words[:1]) if len(words) > 1 else []:
        yield Span(document.source, token.start, token.end)


def _line(span: Span) -> Span:
    """The statement on the line of `span`, without its indentation."""
    text = span.source.text
    start = text.rfind("\n", 0, span.start) + 1
    end = text.find("\n", span.start)
    line = text[start : end if end >= 0 else len(text)]
    begin = start + len(line) - len(line.lstrip())
    return Span(span.source, begin, start + len(line.rstrip()))


def _guarded(document: Document, finding: Diagnostic, title: str, clause: str) -> Iterator[Action]:
    """``add `when x` to the constraint``: behind its name, or joined with its guard by `and`."""
    assert finding.span is not None
    at = document.before(finding.span.start)
    while at >= 0 and document.tokens[at].type not in ("CONSTRAINT", "REQUIRE", "FIT"):
        at -= 1
    opening = at
    while opening < len(document.tokens) and document.tokens[opening].type != "LBRACE":
        opening += 1
    if at < 0 or opening >= len(document.tokens):
        return
    header = document.tokens[at:opening]
    guard = clause.removeprefix("when ")
    for token in header:
        if token.type == "WHEN":
            place = Span(document.source, token.end, token.end)
            yield Action(title, finding, place, f" {guard} and")
            return
    after = header[-1].end if header[0].type == "FIT" else header[1].end
    yield Action(title, finding, Span(document.source, after, after), f" {clause}")


def _without(document: Document, finding: Diagnostic, title: str, word: str) -> Iterator[Action]:
    """``omit `word```: the word and the blank behind it."""
    assert finding.span is not None
    line = _line(finding.span)
    found = re.search(rf"(?<!\w){re.escape(word)}(?!\w)[ \t]*", line.text)
    if found:
        place = Span(document.source, line.start + found.start(), line.start + found.end())
        yield Action(title, finding, place, "")


def _mends(document: Document, action: Action, workspace: Workspace) -> bool:
    """Whether the text with the edit has fewer errors, and none that it did not have."""
    text, span = document.source.text, action.span
    changed = text[: span.start] + action.text + text[span.end :]
    if changed == text:
        return False
    after = analyse(Source(document.source.name, changed), workspace)
    before = [(d.code, d.message) for d in document.findings]
    now = [(d.code, d.message) for d in after.findings]
    errors = len(after.errors), len(document.errors)
    if action.finding.severity == "error" and errors[0] >= errors[1]:
        return False
    return len(now) < len(before) and all(one in before for one in now)
