"""Lines to text: indentation and comment columns."""

from __future__ import annotations

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
    """Tracks brackets over lines: continuation lines are aligned with the text after one."""

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
    """Add the comments; on neighbouring lines they are aligned at their rightmost column."""
    out = [code + line.comment for code, line in zip(codes, lines, strict=True)]
    for group in _comment_groups(lines):
        column = max(max(lines[n].comment_column, len(codes[n]) + 2) for n in group)
        for n in group:
            out[n] = codes[n].ljust(column) + lines[n].comment
    return out


def _comment_groups(lines: list[Line]) -> list[list[int]]:
    """Numbers of lines with a comment after code that follow each other at one depth."""
    groups: list[list[int]] = []
    for n, line in enumerate(lines):
        if not (line.comment and line.words):
            continue
        last = groups[-1][-1] if groups else -2
        if last == n - 1 and not line.blank_before and lines[last].depth == line.depth:
            groups[-1].append(n)
        else:
            groups.append([n])
    return groups
