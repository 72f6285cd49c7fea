"""Diagnostics as readable text, in the style of rustc.

::

    error[E0126]: `=` where `:` belongs
     --> slam.arael:4:9
      |
    4 |     pos = vec3
      |         ^ the type of `pos` follows a `:`
      |
      = help: write `pos: vec3`
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from arael.diagnostics.cells import printable, safe_message
from arael.diagnostics.records import Diagnostic, Source
from arael.diagnostics.style import Style, paint
from arael.diagnostics.window import Mark, draw_window


def render(
    diagnostics: Iterable[Diagnostic],
    *,
    color: bool = False,
    width: int = 100,
    place_first: bool = False,
) -> str:
    """All `diagnostics`, separated by blank lines, with a final count if there are several.

    Parameters
    ----------
    color
        Write ANSI colours; see `use_color`.
    width
        Columns of the terminal. Source lines are cut to it around the marks, notes are wrapped.
    place_first
        Begin with ``slam.arael:4:9: error[E0126]: ...`` on one line, for logs and tracebacks, in
        place of the line with the arrow.
    """
    found = list(diagnostics)
    blocks = [_render_one(d, color, max(width, 40), place_first) for d in found]
    errors = sum(d.severity == "error" for d in found)
    if len(found) > 1 and errors > 1:
        blocks.append(paint(f"{errors} errors", "strong", color) + "\n")
    return "\n".join(blocks)


def _render_one(d: Diagnostic, color: bool, width: int, place_first: bool) -> str:
    style: Style = d.severity
    code = f"[{d.code}]" if d.code else ""
    head = paint(f"{d.severity}{code}", style, color)
    place = printable(str(d.span) if d.span else d.origin)
    head = f"{place}: {head}" if place_first and place else head
    lines = [head + paint(f": {safe_message(d.message)}", "strong", color)]
    windows = _windows(d)
    gutter = max((len(str(_last_line(s, marks))) for s, marks in windows), default=1)
    arrow = paint("-->", "frame", color)
    if d.span is None and d.origin and not place_first:
        lines.append(f"{' ' * gutter}{arrow} {printable(d.origin)}")
    for n, (source, marks) in enumerate(windows):
        first = next((m for m in marks if m.primary), marks[0])
        line, column = source.position(first.start)
        sign = arrow if n == 0 else paint(":::", "frame", color)
        if n > 0 or not place_first or d.span is None:
            lines.append(f"{' ' * gutter}{sign} {printable(source.name)}:{line}:{column}")
        lines += draw_window(source, marks, gutter, style, color, width)
    if windows and (d.notes or d.help):
        lines.append(" " * gutter + paint(" |", "frame", color))
    remarks: tuple[tuple[Style, tuple[str, ...]], ...] = (("note", d.notes), ("help", d.help))
    for word, texts in remarks:
        for text in texts:
            lines += _remark(word, text, gutter, bool(windows), color, width)
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _windows(d: Diagnostic) -> list[tuple[Source, list[Mark]]]:
    """Return marks by source, that of the primary span first."""
    grouped: dict[Source, list[Mark]] = {}
    if d.span is not None:
        mark = Mark(d.span.start, d.span.end, d.label, True)
        grouped[d.span.source] = [mark]
    for label in d.labels:
        marks = grouped.setdefault(label.span.source, [])
        marks.append(Mark(label.span.start, label.span.end, label.text, False))
    return list(grouped.items())


def _last_line(source: Source, marks: list[Mark]) -> int:
    return max(source.position(max(m.start, m.end - 1))[0] for m in marks)


def _remark(
    word: Style, text: str, gutter: int, framed: bool, color: bool, width: int
) -> list[str]:
    sign = paint("=", "frame", color) + " " if framed else ""
    lead = " " * (gutter + 1) + ("= " if framed else "") + f"{word}: "
    wrapped: list[str] = []
    for line in safe_message(text).split("\n"):
        wrapped += textwrap.wrap(
            line, max(width - len(lead), 20), break_long_words=False, break_on_hyphens=False
        ) or [""]
    first = " " * (gutter + 1) + sign + paint(f"{word}:", word, color) + " " + wrapped[0]
    return [first, *(" " * len(lead) + line for line in wrapped[1:])]
