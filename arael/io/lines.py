"""Lines of numbers in text files, with the place of each wrong one."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic, Source, Span
from arael.io.plain_numbers import is_plain, real
from arael.io.report import Report
from arael.runtime.store.messages import shorten

Array = NDArray[np.float64]

MOST_SHOWN = 1000
"""Longer lines are named by their number and not printed."""


class Lines:
    """The lines of a text that are neither empty nor comments, as words with line numbers.

    Comments begin with ``#``. With `keep_empty` empty lines are lines without words.

    Attributes
    ----------
    words : words of each line
    numbers : number of each line, from 1
    """

    def __init__(
        self,
        name: str,
        content: bytes,
        report: Report,
        separator: str | None = None,
        keep_empty: bool = False,
    ) -> None:
        self.source = Source(name, content.decode("utf-8", "replace"))
        self.report, self.separator = report, separator
        self._lines = self.source.text.split("\n")
        self.words: list[list[str]] = []
        self.numbers: list[int] = []
        for number, line in enumerate(self._lines, 1):
            text = line.strip()
            if (text or keep_empty) and not text.startswith("#"):
                words = text.split(separator)
                self.words.append(words if separator is None else [w.strip() for w in words])
                self.numbers.append(number)

    def __len__(self) -> int:
        return len(self.words)

    def add(
        self, code: str, message: str, row: int, word: int | None = None, help: str = ""
    ) -> None:
        """Report an error in the `row`-th line of `words`, or in its `word`-th word.

        `word` is counted as in the text, before any words were taken from the line.
        """
        number = self.numbers[row] if row < len(self.numbers) else len(self._lines)
        text = self._lines[number - 1].rstrip()
        helps = (help,) if help else ()
        if len(text) > MOST_SHOWN:
            self.report.take(
                Diagnostic(code, message, origin=f"{self.source.name}:{number}", help=helps)
            )
            return
        start = sum(map(len, self._lines[: number - 1])) + number - 1
        first, last = 0, len(text)
        if word is not None:
            pattern = r"\S+" if self.separator is None else f"[^{re.escape(self.separator)}]*"
            spans = [m.span() for m in re.finditer(pattern, text) if m.group() or self.separator]
            first, last = spans[min(word, len(spans) - 1)]
            first += len(text[first:last]) - len(text[first:last].lstrip())
        span = Span(self.source, start + first, start + max(last, first + 1))
        self.report.take(Diagnostic(code, message, span, help=helps))

    def table(self, widths: Iterable[int], what: str) -> Array:
        """All lines as rows of finite numbers, of the one width among `widths` that the first has.

        Wrong lines are reported: E0716 the number of words or a word, E0705 NaN or infinite.

        Returns
        -------
        array (lines, width); without rows if an error was reported
        """
        allowed = sorted(widths)
        width = len(self.words[0]) if self.words else allowed[0]
        if width not in allowed:
            width = allowed[0]
        good = True
        for row, words in enumerate(self.words):
            if len(words) != width:
                expected = " or ".join(map(str, allowed)) if row == 0 else str(width)
                message = f"expected {expected} numbers ({what}), found {len(words)}"
                self.add("E0716", message, row)
                good = False
        return self.reals(self.words, range(len(self)), 0, width) if good else np.empty((0, width))

    def reals(self, words: list[list[str]], rows: Iterable[int], first: int, width: int) -> Array:
        """Words (lines, width) as finite numbers; `first` is the place of a line's first word.

        Wrong words are reported; the array then has no rows.
        """
        flat = list(chain.from_iterable(words))
        try:
            if not is_plain("".join(flat)):
                raise ValueError
            found = np.array(list(map(float, flat)), np.float64).reshape(-1, width)
        except ValueError:
            found = None
        if found is not None and np.isfinite(found).all():
            return found
        for row, line in zip(rows, words, strict=True):
            for k, word in enumerate(line):
                try:
                    value = real(word)
                except ValueError:
                    text = f"expected a number, found `{shorten(word)}`"
                    self.add("E0716", text, row, first + k)
                    break
                if not np.isfinite(value):
                    text = f"expected a finite number, found `{shorten(word)}`"
                    self.add("E0705", text, row, first + k)
                    break
        return np.empty((0, width))

    def whole(self, row: int, word: int, what: str, place: int | None = None) -> int:
        """One word as a whole number from 0; -1 after reporting that it is not."""
        text = self.words[row][word]
        if text.isascii() and text.isdigit() and len(text) < 20 and int(text) < 2**63:
            return int(text)
        at = word if place is None else place
        self.add("E0716", f"expected {what}, found `{shorten(text)}`", row, at)
        return -1
