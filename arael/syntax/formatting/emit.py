"""Lines to text: indentation and comment columns."""

from __future__ import annotations

from itertools import groupby

from arael.syntax.formatting.lines import CONTINUED, Line

INDENT = 4


def emit(lines: list[Line]) -> str:
    """Text of `lines`, ending with one line end."""
    codes = _Indenter().run(lines)
    out: list[str] = []
    for code, line in zip(_with_comments(codes, lines), lines, strict=True):
        if line.blank_before:
            out.append("")
        out.append(code.rstrip())
    return "\n".join(out) + "\n" if out else ""


class _Indenter:
    """Follows brackets over lines: what goes on inside one stands under what follows it."""

    def __init__(self) -> None:
        self._open: list[tuple[int, int]] = []
        self._statement = 0

    def run(self, lines: list[Line]) -> list[str]:
        return [self._code(line) for line in lines]

    def _code(self, line: Line) -> str:
        indent = self._indent(line)
        if not line.continues:
            self._statement = indent
        code = " " * indent
        for n, word in enumerate(line.words):
            code += " " * word.gap + word.token.text
            kind = word.token.type
            if kind in ("LPAR", "LSQB"):
                ends_line = n == len(line.words) - 1
                inside = indent + CONTINUED if ends_line else len(code)
                self._open.append((inside, indent))
            elif kind in ("RPAR", "RSQB") and self._open:
                self._open.pop()
        return code

    def _indent(self, line: Line) -> int:
        if not line.continues:
            return line.depth * INDENT
        if not self._open:
            return self._statement + CONTINUED
        first = line.words[0].token.type if line.words else ""
        inside, outer = self._open[-1]
        closes = first in ("RPAR", "RSQB")
        return outer if closes and inside == outer + CONTINUED else inside


def _with_comments(codes: list[str], lines: list[Line]) -> list[str]:
    """Add the comments; those of neighbouring lines go in the rightmost column among them."""
    out: list[str] = []
    numbered = list(zip(codes, lines, strict=True))
    for _, group in groupby(numbered, lambda p: (bool(p[1].comment and p[1].words), p[1].depth)):
        members = list(group)
        if not members[0][1].comment or not members[0][1].words:
            out += [code + line.comment for code, line in members]
            continue
        column = max(max(line.comment_column, len(code) + 2) for code, line in members)
        out += [code.ljust(column) + line.comment for code, line in members]
    return out
