"""The separator of the cells of a text table."""

from __future__ import annotations

import csv
import re

_LINES = 50
"""Lines that are compared."""
_NAME = re.compile(r"[^\s\[(]\S*?(?:\s*[\[(][^\])]*[\])])?(?=\s|$)")
"""A name between spaces, together with a unit in brackets after it."""


def separated(content: bytes) -> tuple[bytes, str | None]:
    """Find the separator of a table: the first that divides all lines into equally many cells.

    Tried in this order: comma, tab, semicolon, bar, spaces. Names between spaces may have a unit
    after them, ``x [m]``.

    Parameters
    ----------
    content : the text without comments

    Returns
    -------
    content : the text; one separated by spaces with tabs in their place
    delimiter : the separator; None if no separator divides all lines equally, as in a table of one
        column or with a cell too many
    """
    text = content.decode("utf-8-sig", "replace")
    lines = [line for line in text.splitlines() if line.strip()]
    for delimiter in ",\t;|":
        try:
            counts = {len(row) for row in csv.reader(lines[:_LINES], delimiter=delimiter)}
        except csv.Error:
            continue
        # Of a header alone, any separator divides all lines equally.
        if len(counts) == 1 and counts.pop() > 1:
            return content, delimiter
    if any(d in lines[0] for d in ",\t;|"):
        return content, None
    names, rows = _NAME.findall(lines[0]), [line.split() for line in lines[1:]]
    if len(names) == 1 or not rows or any(len(row) != len(names) for row in rows[:_LINES]):
        return content, None
    found = ["\t".join(line.split()) for line in text.splitlines()]  # lines keep their numbers
    found[next(k for k, line in enumerate(found) if line)] = "\t".join(names)
    return "\n".join(found).encode(), "\t"
