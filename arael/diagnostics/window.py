"""An excerpt of a source with marks under it."""

from __future__ import annotations

from dataclasses import dataclass

from arael.diagnostics.cells import char_width, printable, safe_message
from arael.diagnostics.cells import width as cells
from arael.diagnostics.records import Source
from arael.diagnostics.style import Style, paint

_MAX_LINES = 24
_CONTEXT = 20


@dataclass(frozen=True)
class Mark:
    """Characters ``start:end`` of a source, and their text."""

    start: int
    end: int
    text: str
    primary: bool


@dataclass
class _Piece:
    """The part of a mark on one line, in columns of the line as shown."""

    left: int
    right: int
    text: str
    primary: bool


def draw_window(
    source: Source, marks: list[Mark], gutter: int, style: Style, color: bool, width: int
) -> list[str]:
    """Lines of the window: every line that a mark touches, with its marks; gaps as ``...``."""
    shown = _lines_of(source, marks)
    bar = paint("|", "frame", color)
    out = [f"{' ' * gutter} {bar}"]
    previous = 0
    for number in sorted(shown)[:_MAX_LINES]:
        if previous and number == previous + 2 and len(source.line(previous + 1)) <= width:
            out.append(_code_line(source, previous + 1, gutter, bar, color, width))
        elif previous and number > previous + 1:
            out.append(paint("...", "frame", color))
        previous = number
        text, pieces = _cut(source.line(number), shown[number], width - gutter - 3)
        out.append(f"{paint(f'{number:>{gutter}}', 'frame', color)} {bar} {text}")
        out += (f"{' ' * gutter} {bar} {line}" for line in _under(pieces, style, color, width))
    return out


def _code_line(source: Source, number: int, gutter: int, bar: str, color: bool, width: int) -> str:
    text, _ = _cut(source.line(number), [], width - gutter - 3)
    return f"{paint(f'{number:>{gutter}}', 'frame', color)} {bar} {text}"


def _lines_of(source: Source, marks: list[Mark]) -> dict[int, list[tuple[int, int, Mark]]]:
    """For each line that a mark touches: ``(start, end, mark)`` in characters of the line.

    Of a mark over many lines only the first and the last are shown; its text is on the last.
    """
    lines: dict[int, list[tuple[int, int, Mark]]] = {}
    for mark in marks:
        first, start = source.position(mark.start)
        last, end = source.position(max(mark.start, mark.end - 1))
        start -= 1
        if first == last:
            end = start + max(mark.end - mark.start, 1)
            lines.setdefault(first, []).append((start, end, mark))
            continue
        head = Mark(mark.start, mark.end, "", mark.primary)
        lines.setdefault(first, []).append((start, max(len(source.line(first)), start + 1), head))
        text = source.line(last)
        indent = min(len(text) - len(text.lstrip()), end - 1)
        lines.setdefault(last, []).append((indent, end, mark))
    return lines


def _cut(line: str, marks: list[tuple[int, int, Mark]], width: int) -> tuple[str, list[_Piece]]:
    """Return the line as shown and its marks in columns; long lines are cut around the marks."""
    low, high = 0, len(line)
    before = after = ""
    if high > width:
        left = min((s for s, _, _ in marks), default=0)
        low = max(0, min(left - _CONTEXT, high - 1))
        if left < width - _CONTEXT:
            low = 0
        before = "..." if low else ""
        columns = cells(before)
        high = low
        while high < len(line) and columns + char_width(line[high]) <= width - 3:
            columns += char_width(line[high])
            high += 1
        after = "..." if high < len(line) else ""
    visible = line[low:high]
    pieces = []
    for start, end, mark in marks:
        start, end = max(start, low), min(end, max(high, start + 1))
        if start >= max(high, low + 1) and after:
            start, end = high - 1, high
        left = cells(before) + cells(line[low:start])
        pieces.append(_Piece(left, left + max(cells(line[start:end]), 1), mark.text, mark.primary))
    return before + printable(visible) + after, pieces


def _under(pieces: list[_Piece], style: Style, color: bool, width: int) -> list[str]:
    """Rows under a line: underlines with the last text beside them, then the other texts.

    ::

        (a + b]
        -     ^ expected `)`
        |
        opened here
    """
    if not pieces:
        return []
    pieces = sorted(pieces, key=lambda p: (p.left, not p.primary))
    rows = [_underlines(pieces, style, color)]
    labelled = [p for p in pieces if p.text]
    if not labelled:
        return rows
    last = max(labelled, key=lambda p: (p.left, p.primary))
    free = all(p is last or p.right <= last.left for p in pieces)
    if free:
        rows[0] += " " + _text(last, style, color)
        labelled.remove(last)
    for n in range(len(labelled) - 1, -1, -1):
        hanging = labelled[: n + 1]
        rows.append(_bars(hanging, style, color))
        lead = _bars([p for p in hanging[:-1] if p.left < hanging[-1].left], style, color)
        start = max((p.left + 1 for p in hanging[:-1] if p.left < hanging[-1].left), default=0)
        rows.append(lead + " " * (hanging[-1].left - start) + _text(hanging[-1], style, color))
    return rows


def _text(piece: _Piece, style: Style, color: bool) -> str:
    return paint(safe_message(piece.text), style if piece.primary else "secondary", color)


def _underlines(pieces: list[_Piece], style: Style, color: bool) -> str:
    size = max(p.right for p in pieces)
    signs: list[tuple[str, Style]] = [(" ", "plain")] * size
    for primary in (False, True):
        for p in (p for p in pieces if p.primary is primary):
            mark: tuple[str, Style] = ("^", style) if primary else ("-", "secondary")
            signs[p.left : p.right] = [mark] * (p.right - p.left)
    out = ""
    at = 0
    while at < size:
        end = at
        while end < size and signs[end] == signs[at]:
            end += 1
        out += paint(signs[at][0] * (end - at), signs[at][1], color and signs[at][0] != " ")
        at = end
    return out


def _bars(pieces: list[_Piece], style: Style, color: bool) -> str:
    out, at = "", 0
    for p in pieces:
        if p.left < at:
            continue
        out += " " * (p.left - at) + paint("|", style if p.primary else "secondary", color)
        at = p.left + 1
    return out
