"""Command lines to statements, and statements to words with their places."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NoReturn

from arael.diagnostics.records import AraelError, Diagnostic, Source, Span
from arael.sketch.expressions.units import SPELLED

MAX_LINE = 100_000
"""Characters of a command line."""

MAX_STATEMENTS = 1000
"""Commands in one line."""

MAX_WORDS = 20_000
"""Words of one command."""

_CLOSED_BY = {"(": ")", "[": "]"}
_SPACE = " \t\r"
_NUMBER_END = re.compile(r"(?:^|[^\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z", re.ASCII)
_UNIT = re.compile(r"(" + "|".join(sorted(SPELLED, key=len, reverse=True)) + r")(?![\w.(])")
_OPERATOR_AHEAD = re.compile(r"[+\-][ \t]+[^ \t;]|[*/^,]")


@dataclass(frozen=True, slots=True)
class Token:
    """A word of a command.

    Attributes
    ----------
    text : without quotes; a doubled quote within them is one
    span : its place in the command line
    quoted : whether it was in quotes
    """

    text: str
    span: Span
    quoted: bool = False


@dataclass(frozen=True, slots=True)
class Statement:
    """One command of a line: characters ``start:end`` of its source."""

    source: Source
    start: int
    end: int

    @property
    def text(self) -> str:
        """As it was written."""
        return self.source.text[self.start : self.end]

    @property
    def span(self) -> Span:
        """Its place."""
        return Span(self.source, self.start, self.end)


def fail(
    code: str, message: str, span: Span, label: str = "", *help_: str, notes: tuple[str, ...] = ()
) -> NoReturn:
    """Raise `AraelError` at a place."""
    raise AraelError(Diagnostic(code, message, span, label, notes=notes, help=help_))


def quoted(text: str) -> str:
    """A text as a word of a command."""
    doubled = text.replace('"', '""')
    return f'"{doubled}"'


def lines(source: Source) -> Iterator[list[Statement]]:
    """The statements of every line that has some.

    Raises
    ------
    AraelError
        E1258: a bracket or quote that is not closed; E1260: a line that is too long.
    """
    start = 0
    text = source.text
    while start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        found = statements(source, start, end)
        if found:
            yield found
        start = end + 1


def statements(source: Source, start: int, end: int) -> list[Statement]:
    """The statements of one line, which ``;`` separates; comments are left out."""
    text = source.text
    if end - start > MAX_LINE:
        help_ = f"at most {MAX_LINE:,} are read; write several lines"
        span = Span(source, start + MAX_LINE, start + MAX_LINE + 1)
        fail("E1260", f"a line of {end - start:,} characters", span, "", help_)
    found: list[Statement] = []
    at = first = start
    brackets: list[int] = []
    whole = _is_whole(text, start, end)
    while at <= end:
        char = text[at] if at < end else ""
        if char == '"' and not whole:
            at = _close_quote(source, at, end)
        elif char in ("(", "[") and char and not whole:
            brackets.append(at)
        elif char in (")", "]") and char and not whole:
            _close(source, brackets, at)
        comment = char == "#" and not whole and (at == first or text[at - 1] in _SPACE + ";")
        if char == "" or comment or (char == ";" and not brackets):
            _add(found, source, first, at)
            if char != ";":
                break
            first = at + 1
            whole = _is_whole(text, first, end)
        at += 1
    if brackets:
        at = brackets[-1]
        what = f"`{text[at]}` is not closed"
        fail("E1258", what, Span(source, at, at + 1), f"expected `{_CLOSED_BY[text[at]]}`")
    return found


def _add(found: list[Statement], source: Source, start: int, end: int) -> None:
    text = source.text
    while start < end and text[start] in _SPACE:
        start += 1
    while end > start and text[end - 1] in _SPACE:
        end -= 1
    if end > start:
        if len(found) >= MAX_STATEMENTS:
            span = Span(source, start, end)
            fail("E1260", f"more than {MAX_STATEMENTS} commands in one line", span)
        found.append(Statement(source, start, end))


def _is_whole(text: str, start: int, end: int) -> bool:
    """Whether the command that begins here takes its text as it is."""
    return re.compile(r"[ \t]*msg(?![\w.])").match(text, start, end) is not None


def _close_quote(source: Source, at: int, end: int) -> int:
    """Where the quote at a place is closed; two of them in a row are one that is part of it."""
    closed = source.text.find('"', at + 1, end)
    while closed >= 0 and source.text.startswith('""', closed, end):
        closed = source.text.find('"', closed + 2, end)
    if closed < 0:
        fail("E1258", "this quote is not closed", Span(source, at, at + 1), 'expected another `"`')
    return closed


def _close(source: Source, brackets: list[int], at: int) -> None:
    text = source.text
    if not brackets or _CLOSED_BY[text[brackets[-1]]] != text[at]:
        fail("E1258", f"`{text[at]}` closes nothing", Span(source, at, at + 1))
    brackets.pop()


def split(
    statement: Statement, start: int, is_name: Callable[[str], bool] = lambda name: False
) -> list[Token]:
    """The words of a statement from `start` on.

    A word goes on over spaces within brackets, beside operators (``p + n * 2``), after a comma,
    and before a unit (``12 mm``), unless `is_name` knows the unit's name as something else.
    """
    source, end = statement.source, statement.end
    text = source.text
    found: list[Token] = []
    at = start
    while at < end:
        while at < end and text[at] in _SPACE:
            at += 1
        if at >= end:
            break
        if len(found) >= MAX_WORDS:
            span = Span(source, at, end)
            fail("E1260", f"more than {MAX_WORDS:,} words in one command", span)
        if text[at] == '"':
            closed = _close_quote(source, at, end)
            inner = text[at + 1 : closed].replace('""', '"')
            found.append(Token(inner, Span(source, at + 1, closed), True))
            at = closed + 1
            continue
        if text.startswith((">=", "<="), at):
            found.append(Token(text[at : at + 2], Span(source, at, at + 2)))
            at += 2
            continue
        stop = _word_end(text, at, end, is_name)
        found.append(Token(text[at:stop], Span(source, at, stop)))
        at = stop
    return found


def _word_end(text: str, start: int, end: int, is_name: Callable[[str], bool]) -> int:
    depth = 0
    at = start
    while at < end:
        char = text[at]
        if char in "([":
            depth += 1
        elif char in ")]":
            depth -= 1
        elif depth == 0 and char in _SPACE:
            after = at
            while after < end and text[after] in _SPACE:
                after += 1
            if after >= end or not _goes_on(text, start, at, after, end, is_name):
                return at
            at = after
            continue
        at += 1
    return end


def _goes_on(
    text: str, start: int, at: int, after: int, end: int, is_name: Callable[[str], bool]
) -> bool:
    """Whether the word ``start:at`` goes on at `after`, behind spaces."""
    last = text[at - 1]
    alone = at - start == 1 and last in "+-"
    if last in "+-*/^,=" and not alone:
        return text[after] not in "<>"
    if alone:
        return False
    if _OPERATOR_AHEAD.match(text, after, end):
        return True
    unit = _UNIT.match(text, after, end)
    return (
        unit is not None
        and _NUMBER_END.search(text[max(start, at - 40) : at]) is not None
        and not is_name(unit[1])
    )
