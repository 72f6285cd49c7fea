"""The formatter: the standard layout of a model.

Line breaks within statements and one-line blocks are preserved; indentation, blanks and columns are
set by the formatter. All comments are preserved.
"""

from __future__ import annotations

from arael.diagnostics.records import Source
from arael.syntax.formatting.columns import align
from arael.syntax.formatting.emit import emit
from arael.syntax.formatting.facts import gather
from arael.syntax.formatting.lines import split
from arael.syntax.parser import parse_with_layout


def format_source(source: Source) -> str:
    """Text of `source` in the standard layout; formatting that again changes nothing.

    Raises
    ------
    AraelError
        If `source` has syntax errors, as for `parse`.
    """
    layout = parse_with_layout(source)
    facts = gather(layout.file)
    lines = split(layout, facts)
    align(lines, facts, source)
    return emit(lines)
