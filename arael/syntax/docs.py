"""Documentation comments: the comment block right above a node."""

from __future__ import annotations

from arael.diagnostics.records import Source, Span
from arael.syntax.tree import Comment


class DocComments:
    """Finds the comment block above a place of `source`."""

    def __init__(self, source: Source, comments: list[Comment]) -> None:
        self._source = source
        self._own_line: dict[int, str] = {}
        for comment in comments:
            line, column = source.position(comment.span.start)
            if not source.line(line)[: column - 1].strip(" \t\r\f;"):
                self._own_line[line] = comment.text

    def of(self, span: Span) -> str:
        """Text above the line on which `span` starts, if nothing else precedes it on that line."""
        line, column = self._source.position(span.start)
        if line - 1 not in self._own_line or self._source.line(line)[: column - 1].strip(
            " \t\r\f;"
        ):
            return ""
        first = line - 1
        while first - 1 in self._own_line:
            first -= 1
        return "\n".join(_words(self._own_line[n]) for n in range(first, line))


def _words(comment: str) -> str:
    text = comment.removeprefix("#")
    return text.removeprefix(" ").rstrip()
