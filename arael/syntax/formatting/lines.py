"""Splits tokens and comments into lines with their depth and blanks."""

from __future__ import annotations

from dataclasses import dataclass, field

from arael.syntax.formatting.facts import Facts
from arael.syntax.formatting.spacing import Spacing
from arael.syntax.parser import Layout
from arael.syntax.tables import END
from arael.syntax.tokens import NEWLINE, Token
from arael.syntax.tree import Comment

CONTINUED = 4


@dataclass
class Word:
    """A token with the blanks before it."""

    token: Token
    gap: int


@dataclass
class Line:
    """One line of the result.

    `depth` counts the braces around it. `continues` marks the second and later lines of a
    statement, `comment_column` is the original column of its comment, from 0.
    """

    depth: int
    words: list[Word] = field(default_factory=list)
    comment: str = ""
    comment_column: int = 0
    blank_before: bool = False
    continues: bool = False


def split(layout: Layout, facts: Facts) -> list[Line]:
    """Lines of the formatted file, not yet aligned."""
    return _Splitter(layout, facts).run()


class _Splitter:
    def __init__(self, layout: Layout, facts: Facts) -> None:
        self._position = layout.file.source.position
        self._layout = layout
        self._spacing = Spacing(facts)
        self._comments = list(layout.file.comments)
        self._lines: list[Line] = []
        self._depth = 0
        self._multi: list[bool] = [True]
        self._last_end: int | None = None
        self._last_word: Token | None = None
        self._after_comment = False

    def run(self) -> list[Line]:
        tokens = self._layout.tokens
        closing = _pairs(tokens)
        next_comment = 0
        gap_ends = True
        brackets = 0  # a semicolon in `[ref T in path; 4]` separates no statements
        semicolon: Token | None = None
        for n, token in enumerate(tokens):
            if token.type == NEWLINE:
                gap_ends = gap_ends or n not in self._layout.passed
                continue
            brackets += (token.type == "LSQB") - (token.type == "RSQB")
            if token.type == "SEMICOLON" and not brackets:
                semicolon = token
                gap_ends = True
                continue
            last = self._last_word
            ends = gap_ends or last is None or last.type == "LBRACE" or token.type == "RBRACE"
            while (
                next_comment < len(self._comments)
                and self._comments[next_comment].span.start < token.start
            ):
                self._comment(self._comments[next_comment], ends)
                next_comment += 1
            if token.type == END:
                break
            multi = token.type == "LBRACE" and not self._same_line(token, tokens[closing[n]])
            self._word(token, ends, semicolon)
            if token.type == "LBRACE":
                self._depth += 1
                self._multi.append(multi)
            gap_ends, semicolon = False, None
        return self._lines

    def _line_of(self, offset: int) -> int:
        return self._position(offset)[0]

    def _same_line(self, a: Token, b: Token) -> bool:
        return self._line_of(a.start) == self._line_of(b.start)

    def _breaks(self, start: int) -> int:
        """Line ends between the last thing written and `start`."""
        return 0 if self._last_end is None else self._line_of(start) - self._line_of(self._last_end)

    def _new_line(self, start: int, ends: bool, closes: bool) -> Line:
        opened = not self._after_comment and self._is_opened()
        blank = ends and self._breaks(start) > 1 and not opened and not closes
        line = Line(self._depth, blank_before=blank and bool(self._lines), continues=not ends)
        self._lines.append(line)
        return line

    def _is_opened(self) -> bool:
        return self._last_word is not None and self._last_word.type == "LBRACE"

    def _comment(self, comment: Comment, ends: bool) -> None:
        start = comment.span.start
        own_line = self._last_end is None or self._breaks(start) > 0
        line = self._new_line(start, ends, False) if own_line else self._lines[-1]
        line.comment = _tidy(comment.text)
        line.comment_column = self._position(start)[1] - 1
        self._last_end = comment.span.end
        self._after_comment = True

    def _word(self, token: Token, ends: bool, semicolon: Token | None) -> None:
        closes = token.type == "RBRACE"
        multi = self._multi[-1]
        if closes:
            self._depth -= 1
            self._multi.pop()
        last = self._last_word
        breaks = self._last_end is None or self._after_comment or self._breaks(token.start) > 0
        if token.type == "LBRACE" and not self._after_comment:
            breaks = False
        if multi and (closes or self._is_opened() or semicolon is not None):
            breaks = True
        separates = semicolon is not None and not breaks and not closes
        if separates and semicolon is not None and last is not None and last.type != "LBRACE":
            self._lines[-1].words.append(Word(semicolon, 0))
            last = semicolon
        if breaks:
            line = self._new_line(token.start, ends, closes)
            self._spacing.gap(None, token)
            line.words.append(Word(token, 0))
        else:
            self._lines[-1].words.append(Word(token, self._spacing.gap(last, token)))
        self._last_word, self._last_end, self._after_comment = token, token.end, False


def _tidy(comment: str) -> str:
    text = comment.removeprefix("#").rstrip()
    return f"# {text}" if text[:1].isalnum() else f"#{text}"


def _pairs(tokens: list[Token]) -> dict[int, int]:
    """For each opening brace the number of the closing one."""
    pairs: dict[int, int] = {}
    stack: list[int] = []
    for n, token in enumerate(tokens):
        if token.type == "LBRACE":
            stack.append(n)
        elif token.type == "RBRACE":
            pairs[stack.pop()] = n
    return pairs
