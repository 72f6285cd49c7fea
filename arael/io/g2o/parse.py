"""A g2o file as arrays: vertices, edges, fixed vertices, each with its line."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic, Source, Span
from arael.diagnostics.suggest import closest
from arael.io.g2o.kinds import SE2, SE3, Kind
from arael.io.plain_numbers import is_plain
from arael.io.report import Report
from arael.runtime.store.messages import shorten

Array = NDArray[Any]
ID_LIMIT = 2**63
WORD = re.compile(r"\S+")


@dataclass
class Records:
    """Lines of one kind: ids, numbers, and their line numbers."""

    ids: list[list[int]] = field(default_factory=list)
    numbers: Array = field(default_factory=lambda: np.empty((0, 0)))
    lines: list[int] = field(default_factory=list)


@dataclass
class Graph:
    """The content of a file."""

    text: Text
    vertices: Records
    edges: Records
    priors: Records
    fixed: list[tuple[int, int]]  # (id, line)


class Text:
    """The file's text, for messages with a line."""

    def __init__(self, name: str, content: bytes, report: Report) -> None:
        self.source = Source(name, content.decode("utf-8", "replace"))
        self.lines = self.source.text.split("\n")
        self.report = report

    def add(
        self,
        code: str,
        message: str,
        line: int,
        word: int | None = None,
        notes: tuple[str, ...] = (),
        help: str = "",
    ) -> None:
        """Report something about a line (counted from 0), or about its `word`-th word."""
        helps = (help,) if help else ()
        start = sum(map(len, self.lines[:line])) + line
        text = self.lines[line].rstrip()
        if len(text) <= 1000:
            first, last = 0, len(text)
            if word is not None:
                first, last = list(WORD.finditer(text))[word].span()
            span = Span(self.source, start + first, start + max(last, 1))
            found = Diagnostic(code, message, span, notes=notes, help=helps)
        else:
            found = Diagnostic(
                code, message, origin=f"{self.source.name}:{line + 1}", notes=notes, help=helps
            )
        self.report.take(found)


def parse(content: bytes, name: str, kind: Kind, report: Report) -> Graph:
    """Read the lines of a file.

    Raises AraelError, with file and line: E0716 malformed, E0717 unknown tag, E0705 not finite,
    E0722 tags of the other kind of graph.
    """
    text = Text(name, content, report)
    graph = Graph(text, Records(), Records(), Records(), [])

    def run() -> None:
        _Parser(text, kind, graph).run()

    report.run(run)
    return graph


class _Parser:
    def __init__(self, text: Text, kind: Kind, graph: Graph) -> None:
        self.text = text
        self.kind = kind
        self.graph = graph
        self.tokens: dict[str, tuple[list[list[str]], list[int]]] = {}

    def run(self) -> None:
        """Sort lines by tag, then convert all lines of a tag at once."""
        tokens = self.tokens
        for number, line in enumerate(self.text.lines):
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            known = tokens.get(words[0])
            if known is None:
                known = tokens.setdefault(words[0], ([], []))
            known[0].append(words)
            known[1].append(number)
        for tag, (words_of, lines) in tokens.items():
            self._tag(tag, words_of, lines)

    def _tag(self, tag: str, words: list[list[str]], lines: list[int]) -> None:
        kind = self.kind
        if tag == "FIX":
            self._fix(words, lines)
        elif tag in kind.vertices:
            self._records(self.graph.vertices, words, lines, 1, kind.size, None)
        elif tag in kind.edges:
            count = kind.size + kind.information
            self._records(self.graph.edges, words, lines, 2, count, kind.edges[tag])
        elif tag == kind.prior:
            self._priors(words, lines)
        elif tag == kind.offset:
            self._offsets(words, lines)
        else:
            self._unknown(tag, lines)

    def _priors(self, words: list[list[str]], lines: list[int]) -> None:
        """Priors have unit weight, like the model's anchors; others cannot be represented."""
        kind, priors = self.kind, self.graph.priors
        numbers = kind.size + kind.information
        self._records(priors, words, lines, 2 if kind.offset else 1, numbers, None)
        unit = np.array(kind.unit_information)
        for row, line in zip(priors.numbers, priors.lines, strict=True):
            if not np.array_equal(row[kind.size :], unit):
                self.text.add(
                    "E0722",
                    "the model's anchors have unit weight, this prior has another",
                    line,
                    help="the information of a prior must be the unit matrix",
                )

    def _offsets(self, words: list[list[str]], lines: list[int]) -> None:
        offsets = Records()
        self._records(offsets, words, lines, 1, self.kind.size, None)
        for row, line in zip(offsets.numbers, offsets.lines, strict=True):
            if row.tolist() != self.kind.identity:
                self.text.add(
                    "E0722", "the model has no sensor offsets, this one is not zero", line
                )

    def _fix(self, words: list[list[str]], lines: list[int]) -> None:
        for row, line in zip(words, lines, strict=True):
            if len(row) < 2:
                self.text.add("E0716", "FIX names no vertex", line)
            for number, word in enumerate(row[1:], 1):
                if (id := self._id(word, line, number)) is not None:
                    self.graph.fixed.append((id, line))

    def _unknown(self, tag: str, lines: list[int]) -> None:
        other = SE3 if self.kind is SE2 else SE2
        count = f" ({len(lines)} lines)" if len(lines) > 1 else ""
        if tag in other.vertices or tag in other.edges:
            self.text.add(
                "E0722",
                f"`{tag}` is of an {other.name} graph{count}, the model holds {self.kind.name}",
                lines[0],
                help=f"solve it with `{other.model}`",
            )
            return
        known = [*sorted(self.kind.vertices), *self.kind.edges, "FIX"]
        near = closest(tag, known)
        help = f"did you mean `{near[0]}`?" if near else f"known tags are {', '.join(known)}"
        self.text.add("E0717", f"unknown tag `{shorten(tag)}`{count}", lines[0], 0, help=help)

    def _records(
        self,
        records: Records,
        words: list[list[str]],
        lines: list[int],
        ids: int,
        numbers: int,
        order: list[int] | None,
    ) -> None:
        width = 1 + ids + numbers
        if set(map(len, words)) != {width}:
            for row, line in zip(words, lines, strict=True):
                if len(row) != width:
                    self.text.add(
                        "E0716",
                        f"expected {width - 1} values after `{row[0]}`, found {len(row) - 1}",
                        line,
                        notes=self._form(row[0]),
                    )
            return
        found_ids = self._convert([row[1 : 1 + ids] for row in words], lines, int, 1)
        values = self._convert([row[1 + ids :] for row in words], lines, float, 1 + ids)
        if found_ids is None or values is None:
            return
        table = np.array(values, dtype=np.float64).reshape(len(words), numbers)
        finite = np.isfinite(table).all(axis=1)
        for i in np.flatnonzero(~finite).tolist():
            word = 1 + ids + int(np.argmin(np.isfinite(table[i])))
            self.text.add("E0705", "a number is NaN or infinite", lines[i], word)
        if order is not None:
            table[:, self.kind.size :] = table[:, [self.kind.size + k for k in order]]
        if records.lines:
            table = np.concatenate((records.numbers, table))
        records.numbers = table
        records.ids += [found_ids[i : i + ids] for i in range(0, len(found_ids), ids)]
        records.lines += lines

    def _form(self, tag: str) -> tuple[str, ...]:
        pose = "x y theta" if self.kind is SE2 else "x y z qx qy qz qw"
        if tag in self.kind.vertices:
            return (f"a vertex is `{tag} id {pose}`",)
        if tag in self.kind.edges:
            return (
                f"an edge is `{tag} id id {pose}` and the upper triangle of its information "
                f"matrix, {self.kind.information} numbers",
            )
        return ()

    def _convert(
        self, rows: list[list[str]], lines: list[int], to: Callable[[str], Any], first: int
    ) -> list[Any] | None:
        """All tokens as numbers; None after reporting invalid ones.

        The first token of a line is its `first`-th word.
        """
        flat = list(chain.from_iterable(rows))
        joined = "".join(flat)
        if is_plain(joined):
            try:
                values = list(map(to, flat))
            except ValueError:
                pass
            else:
                if to is float or all(-ID_LIMIT <= v < ID_LIMIT for v in values):
                    return values
        for row, line in zip(rows, lines, strict=True):
            for i, word in enumerate(row):
                if not _is_number(word, to):
                    what = "an id (an integer)" if to is int else "a number"
                    message = f"expected {what}, found `{shorten(word)}`"
                    self.text.add("E0716", message, line, first + i)
                    break
        return None

    def _id(self, word: str, line: int, number: int) -> int | None:
        if _is_number(word, int):
            return int(word)
        self.text.add(
            "E0716", f"expected an id (an integer), found `{shorten(word)}`", line, number
        )
        return None


def _is_number(word: str, to: Callable[[str], Any]) -> bool:
    if not is_plain(word):
        return False
    try:
        value = to(word)
    except ValueError:
        return False
    return to is float or -ID_LIMIT <= value < ID_LIMIT
