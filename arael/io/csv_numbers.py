"""A CSV file of points, as columns of numbers by name, without a model."""

from __future__ import annotations

import math
import os
import re
from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.csv_reader import csv_rows
from arael.io.csv_separators import separated
from arael.io.files import StrPath, check_name, read_bytes, shown, without_mark
from arael.io.plain_numbers import real
from arael.runtime.store.messages import problem, shorten

MOST_MISTAKES = 20

MISSING = frozenset({"", "-", "?", "na", "n/a", "nan", "null", "none", "missing"})
"""Texts of cells without a value, in lower case."""

_COMMENT = re.compile(rb"^[ \t]*[#%][^\r\n]*", re.MULTILINE)
_UNIT = re.compile(r"\s*[(\[][^()\[\]]*[)\]]\s*$")


class Points:
    """Rows of a CSV file below a line of names; cells are converted to numbers on demand.

    Cells are separated by commas, tabs, semicolons, bars or spaces, whichever divides all lines
    into equally many; a decimal comma is read where commas do not separate. Lines that begin with
    ``#`` or ``%`` are comments. The names may be in a comment, as `numpy.savetxt` writes them.

    Parameters
    ----------
    path : the file

    Attributes
    ----------
    name : the file, for messages
    titles : maps the name of a column in formulas to its title in the file. ``Time (s)``
        is read as ``Time``, ``wheel speed`` as ``wheel_speed``.
    size : number of rows

    Raises
    ------
    AraelError
        With file and line, several at once: E0712 unreadable, E0711 not CSV, without names or
        without rows, E0718 a column twice, E0704 wrong number of cells.
    """

    def __init__(self, path: StrPath) -> None:
        path = check_name(path)
        self.name = shown(os.path.basename(path))
        content = without_mark(read_bytes(path), self.name)
        text = _COMMENT.sub(b"", content)
        if not content.strip():
            raise AraelError(problem("E0712", "the file is empty", self.name))
        if not text.strip():
            raise AraelError(problem("E0711", "there are no rows, only comments", self.name))
        text, delimiter = separated(text)
        header, rows, lines = csv_rows(text, self.name, delimiter)
        # With another separator than the comma, a comma between digits is a decimal point.
        self._comma = delimiter not in (None, ",")
        if all(self._number(cell) is not None for cell in header):
            first = 1 + text[: len(text) - len(text.lstrip())].count(b"\n")
            rows, lines = [header, *rows], [first, *lines]
            header = self._from_comment(content, header)
        rows = [_without_ends(row, len(header)) for row in rows]
        self._header, self._rows, self._lines = header, rows, lines
        self.size = len(rows)
        found: list[Diagnostic] = [
            problem("E0718", f"the column `{shorten(title)}` is given twice", self.name)
            for title, count in sorted(Counter(header).items())
            if count > 1
        ]
        if not rows:
            what = "there is no row below the names of the columns"
            found.append(problem("E0711", what, self.name))
        for line, row in zip(lines, rows, strict=True):
            if len(row) != len(header) and len(found) < MOST_MISTAKES:
                what = f"expected {len(header)} cells, found {len(row)}"
                found.append(problem("E0704", what, f"{self.name}:{line}"))
        self._wrong = found
        self.titles = readable_names(header)

    def columns(self, names: Iterable[str]) -> dict[str, NDArray[np.float64]]:
        """Columns by name, each (rows,); NaN where a cell is empty or says that it has no value.

        Raises
        ------
        AraelError
            With file, line and column, several at once: E0703 not a number, E0705 not finite, and
            errors of the file as a whole.
        """
        wanted = {self.titles[name]: name for name in names}
        found = list(self._wrong)
        values: dict[str, Any] = {name: np.full(self.size, math.nan) for name in wanted.values()}
        for number, (line, row) in enumerate(zip(self._lines, self._rows, strict=True)):
            if len(row) != len(self._header):
                continue
            for title, cell in zip(self._header, row, strict=True):
                if (
                    title not in wanted
                    or cell.strip().lower() in MISSING
                    or len(found) >= MOST_MISTAKES
                ):
                    continue
                value = self._number(cell)
                if value is None or not math.isfinite(value):
                    code = "E0703" if value is None else "E0705"
                    expected = "a number" if value is None else "a finite number"
                    what = f'expected {expected}, found "{shorten(cell)}"'
                    found.append(problem(code, what, f"{self.name}:{line}: {title}"))
                else:
                    values[wanted[title]][number] = value
        if found:
            raise AraelError(found)
        return values

    def texts(self, name: str) -> list[str]:
        """Cells of one column as they are written, for the names of groups.

        Raises
        ------
        AraelError
            Errors of the file as a whole.
        """
        if self._wrong:
            raise AraelError(self._wrong)
        at = self._header.index(self.titles[name])
        return [row[at].strip() for row in self._rows]

    def _number(self, cell: str) -> float | None:
        text = cell.strip()
        if self._comma and "." not in text and text.count(",") == 1:
            text = text.replace(",", ".")
        return _number(text)

    def _from_comment(self, content: bytes, first: list[str]) -> list[str]:
        """The names in the last comment above the first row, if their number fits."""
        comments = []
        for line in content.decode().splitlines():
            if line.strip() and not line.lstrip().startswith("#"):
                break
            comments.append(line.lstrip(" \t#%").rstrip())
        for comment in reversed(comments):
            delimiter = next((d for d in ",\t;|" if d in comment), None)
            names = [name.strip() for name in comment.split(delimiter)]
            if len(names) == len(first) and all(names) and not _all_numbers(names):
                return names
        raise AraelError(
            problem(
                "E0711",
                "expected the names of the columns in the first line, found numbers",
                self.name,
                help=f"put a line such as `{','.join('xyzuvw'[: len(first)])}` above them",
            )
        )


def readable_names(titles: Iterable[str]) -> dict[str, str]:
    """Titles of columns by their names in formulas.

    A unit in brackets at the end is removed if the name remains unique.
    """
    kept = list(dict.fromkeys(titles))
    short = {title: _identifier(_UNIT.sub("", title)) for title in kept}
    counts = Counter(short.values())
    found: dict[str, str] = {}
    for title in kept:
        name = title if _is_name(title) else short[title]
        if name != title and (counts[name] > 1 or not name or name in kept):
            name = _identifier(title)
        if name and name not in found:
            found[name] = title
    return found


def _is_name(text: str) -> bool:
    return re.fullmatch(r"[A-Za-z_]\w*", text, re.ASCII) is not None


def _identifier(title: str) -> str:
    """A title as a name: other characters become ``_``; "" if nothing is left."""
    name = re.sub(r"\W+", "_", title, flags=re.ASCII).strip("_")
    return f"_{name}" if name[:1].isdigit() else name


def _without_ends(row: list[str], count: int) -> list[str]:
    """A row without the empty cells that separators at the end of its line make."""
    kept = row
    while len(kept) > count and not kept[-1].strip():
        kept = kept[:-1]
    return kept


def _all_numbers(cells: list[str]) -> bool:
    return all(_number(cell) is not None for cell in cells)


def _number(cell: str) -> float | None:
    try:
        return real(cell.strip())
    except ValueError:
        return None
