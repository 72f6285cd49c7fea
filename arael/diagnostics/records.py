"""Diagnostic records: messages about user input as data.

A `Diagnostic` names its place either by a `Span` (a range of a source text) or, without a source
text (a binary data file, an option, the environment), by `origin`, a short phrase such as
``"scene.npz: poses.pos row 3"``.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True, eq=False)
class Source:
    """A text and its name for the user.

    Attributes
    ----------
    first : number of its first line: a part of a text that is read line by line has a higher one
    """

    name: str
    text: str
    first: int = 1

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        """Offset of the first character of each line."""
        return (0, *(i + 1 for i, c in enumerate(self.text) if c == "\n"))

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of `offset`, lines counted from `first`, columns from 1."""
        line = bisect_right(self.line_starts, offset)
        return line + self.first - 1, offset - self.line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """Text of line `number` (counted from `first`), without its end."""
        number -= self.first - 1
        start = self.line_starts[number - 1]
        end = self.line_starts[number] if number < len(self.line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")


@dataclass(frozen=True)
class Span:
    """Characters ``start:end`` of a source."""

    source: Source
    start: int
    end: int

    def to(self, other: Span) -> Span:
        """Return the range from the start of this span to the end of `other`."""
        return Span(self.source, min(self.start, other.start), max(self.end, other.end))

    @property
    def text(self) -> str:
        """The characters themselves."""
        return self.source.text[self.start : self.end]

    def __str__(self) -> str:
        line, column = self.source.position(self.start)
        return f"{self.source.name}:{line}:{column}"


@dataclass(frozen=True)
class Label:
    """A secondary place and its text."""

    span: Span
    text: str


@dataclass(frozen=True)
class Diagnostic:
    """One message for the user. Messages are lower case and end without a full stop."""

    code: str
    message: str
    span: Span | None = None
    label: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: tuple[str, ...] = ()
    origin: str = ""
    severity: Severity = "error"

    def __str__(self) -> str:
        place = str(self.span) if self.span else self.origin
        head = f"{self.severity}[{self.code}]: {self.message}"
        return f"{place}: {head}" if place else head


_MAX_SHOWN = 10


class AraelError(Exception):
    """Raised for all user errors, with their diagnostics.

    As text, and so in a traceback or a notebook, it is the diagnostics as the command line prints
    them: with the line of the source, notes and help, without colour, the first ten of them, each
    with its place first. The text is rendered on demand.
    """

    def __init__(self, diagnostics: Diagnostic | Iterable[Diagnostic]) -> None:
        found = (diagnostics,) if isinstance(diagnostics, Diagnostic) else tuple(diagnostics)
        super().__init__(found)
        self.diagnostics: tuple[Diagnostic, ...] = found

    def __str__(self) -> str:
        # imported here: start-up time, and the circle of records and their text
        from arael.diagnostics.render import render

        text = render(self.diagnostics[:_MAX_SHOWN], place_first=True).rstrip("\n")
        more = len(self.diagnostics) - _MAX_SHOWN
        return f"{text}\n\nand {more} more" if more > 0 else text

    def __repr__(self) -> str:
        # Not the repr of the records, which contain whole files.
        first = str(self.diagnostics[0]) if self.diagnostics else ""
        more = len(self.diagnostics) - 1
        return f"<{type(self).__name__} {first}{f' and {more} more' if more > 0 else ''}>"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Show the whole text where IPython displays the exception as a value."""
        printer.text(str(self))


@dataclass
class Findings:
    """Collects diagnostics so that one run can report several mistakes."""

    items: list[Diagnostic] = field(default_factory=list)

    def add(self, diagnostic: Diagnostic) -> None:
        """Add `diagnostic`, unless an identical one for the same place exists."""
        if diagnostic not in self.items:
            self.items.append(diagnostic)

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self.items)

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """Findings that stop the run."""
        return tuple(d for d in self.items if d.severity == "error")

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Findings that do not stop the run."""
        return tuple(d for d in self.items if d.severity == "warning")

    def stop_on_errors(self) -> None:
        """Raise `AraelError` with everything found so far if any of it is an error."""
        if self.errors:
            raise AraelError(self.items)
