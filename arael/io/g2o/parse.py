"""A g2o file as arrays: the lines of each part of a graph, each with its line number."""

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
from arael.io.g2o.kinds import EQUIV, IMAGES, RENAMED, SE2, SE3, SWITCHES, TUTORIAL, Form, Kind
from arael.io.plain_numbers import is_plain
from arael.io.report import Report
from arael.runtime.store import rotations
from arael.runtime.store.messages import shorten

Array = NDArray[Any]
ID_LIMIT = 2**63
WORD = re.compile(r"\S+")
SPACED_TAG = re.compile(r"\s*(\w+)\s*:\s*(\w+)(?=\s|$)")
DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?", re.ASCII)

Information = tuple[float, float]
"""Information of positions [1/m^2] and of rotations [1/rad^2], for lines that give none."""


@dataclass
class Records:
    """Lines of one part of the graph.

    Attributes
    ----------
    ids : vertices that each line names
    offsets : the sensor offset that each line names, -1 for none
    values : (n, k) measured numbers, poses in the form of the file
    information : (n, r, r) information matrices
    lines : line numbers, from 0
    """

    ids: list[list[int]] = field(default_factory=list)
    offsets: list[int] = field(default_factory=list)
    values: Array = field(default_factory=lambda: np.empty((0, 0)))
    information: Array = field(default_factory=lambda: np.empty((0, 0, 0)))
    lines: list[int] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.lines)

    def append(
        self,
        ids: list[list[int]],
        offsets: list[int],
        values: Array,
        information: Array,
        lines: list[int],
    ) -> None:
        """Add the lines of another tag."""
        if self.lines:
            values = np.concatenate((self.values, values))
            information = np.concatenate((self.information, information))
        self.values, self.information = values, information
        self.ids += ids
        self.offsets += offsets
        self.lines += lines

    def keep(self, chosen: list[bool]) -> None:
        """Drop the other lines."""
        rows = np.flatnonzero(chosen)
        self.values, self.information = self.values[rows], self.information[rows]
        for name in ("ids", "offsets", "lines"):
            setattr(self, name, [getattr(self, name)[i] for i in rows.tolist()])


@dataclass
class Graph:
    """The content of a file.

    Attributes
    ----------
    parts : records by the name of their collection
    fixed : (id, line) of each vertex that FIX names
    equal : (id, id, line) of each EQUIV
    """

    text: Text
    parts: dict[str, Records] = field(default_factory=dict)
    fixed: list[tuple[int, int]] = field(default_factory=list)
    equal: list[tuple[int, int, int]] = field(default_factory=list)

    def __getitem__(self, part: str) -> Records:
        return self.parts.setdefault(part, Records())


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
        """Report something about a line (counted from 0), or about its `word`-th word.

        A tag counts as one word, also where it is written with blanks.
        """
        helps = (help,) if help else ()
        start = sum(map(len, self.lines[:line])) + line
        text = self.lines[line].rstrip()
        if len(text) <= 1000:
            first, last = 0, len(text)
            if word is not None:
                first, last = self._words(text)[word]
            span = Span(self.source, start + first, start + max(last, 1))
            found = Diagnostic(code, message, span, notes=notes, help=helps)
        else:
            found = Diagnostic(
                code, message, origin=f"{self.source.name}:{line + 1}", notes=notes, help=helps
            )
        self.report.take(found)

    @staticmethod
    def _words(text: str) -> list[tuple[int, int]]:
        tag = SPACED_TAG.match(text)
        if tag is None:
            return [word.span() for word in WORD.finditer(text)]
        return [(tag.start(1), tag.end()), *(w.span() for w in WORD.finditer(text, tag.end()))]


def parse(
    content: bytes, name: str, kind: Kind, report: Report, information: Information | None = None
) -> Graph:
    """Read the lines of a file; `information` is for those that give none.

    Raises AraelError, with file and line: E0716 malformed, E0717 unknown tag, E0705 not finite,
    E0722 tags of the other kind of graph.
    """
    text = Text(name, content, report)
    graph = Graph(text)

    def run() -> None:
        _Parser(text, kind, graph, information).run()

    report.run(run)
    return graph


class _Parser:
    def __init__(
        self, text: Text, kind: Kind, graph: Graph, information: Information | None
    ) -> None:
        self.text = text
        self.kind = kind
        self.graph = graph
        self.information = information
        self.tokens: dict[str, tuple[list[list[str]], list[int]]] = {}

    def run(self) -> None:
        """Sort lines by tag, then convert all lines of a tag at once."""
        tokens = self.tokens
        for number, line in enumerate(self.text.lines):
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            if (" :" in line or ": " in line) and (tag := SPACED_TAG.match(line)):
                words = [f"{tag[1]}:{tag[2]}", *line[tag.end() :].split()]
            known = tokens.get(words[0])
            if known is None:
                known = tokens.setdefault(words[0], ([], []))
            known[0].append(words)
            known[1].append(number)
        if not self._has_decimal_commas():
            for name, (words_of, lines) in tokens.items():
                self._tag(name, words_of, lines)

    def _has_decimal_commas(self) -> bool:
        """Report decimal commas, once for the whole file."""
        if "," not in self.text.source.text:
            return False
        rows = ((row, line) for both in self.tokens.values() for row, line in zip(*both))  # noqa: B905 - of equal length
        found = [
            (line, i)
            for row, line in rows
            if any("," in word for word in row)
            for i, word in enumerate(row)
            if DECIMAL_COMMA.fullmatch(word)
        ]
        if not found:
            return False
        line, word = min(found)
        others = len({line for line, _ in found}) - 1
        self.text.add(
            "E0716",
            "the numbers have decimal commas, g2o has decimal points",
            line,
            word,
            notes=(f"so have {others} more lines",) if others else (),
            help="replace them: tr , . < FILE > NEW.g2o",
        )
        return True

    def _tag(self, tag: str, words: list[list[str]], lines: list[int]) -> None:
        name = tag
        if tag.startswith(TUTORIAL):
            name = tag.removeprefix(TUTORIAL)
            name = RENAMED.get(name, name)
        form = self.kind.forms.get(name)
        if tag == "FIX":
            self._fix(words, lines)
        elif tag == EQUIV:
            self._equal(words, lines)
        elif form is not None:
            self._records(form, words, lines)
        else:
            self._unknown(tag, name, lines)

    def _equal(self, words: list[list[str]], lines: list[int]) -> None:
        for row, line in zip(words, lines, strict=True):
            if len(row) < 3:
                self.text.add("E0716", "EQUIV names two vertices", line)
                continue
            a, b = (self._id(row[i], line, i) for i in (1, 2))
            if a is not None and b is not None:
                self.graph.equal.append((a, b, line))

    def _fix(self, words: list[list[str]], lines: list[int]) -> None:
        for row, line in zip(words, lines, strict=True):
            if len(row) < 2:
                self.text.add("E0716", "FIX names no vertex", line)
            for number, word in enumerate(row[1:], 1):
                if (id := self._id(word, line, number)) is not None:
                    self.graph.fixed.append((id, line))

    def _unknown(self, tag: str, name: str, lines: list[int]) -> None:
        other = SE3 if self.kind is SE2 else SE2
        count = f" ({len(lines)} lines)" if len(lines) > 1 else ""
        if name in other.forms:
            self.text.add(
                "E0722",
                f"`{tag}` is of an {other.name} graph{count}, the model holds {self.kind.name}",
                lines[0],
                help=f"solve it with `{other.model}`",
            )
            return
        if name in SWITCHES:
            self._switches(tag, count, lines)
            return
        if name in IMAGES:
            self.text.add(
                "E0717",
                f"`{tag}`{count} is of images: a pose graph measures landmarks in axes of poses",
                lines[0],
                0,
                help="write each as `EDGE_SE3_TRACKXYZ`, the point in the sensor's axes from its "
                "pixel and depth, with the information of that; or write a model with a camera",
            )
            return
        known = [*self.kind.forms, "FIX", EQUIV]
        near = closest(tag, known)
        help = f"did you mean `{near[0]}`?" if near else f"known tags are {', '.join(known)}"
        self.text.add("E0717", f"unknown tag `{shorten(tag)}`{count}", lines[0], 0, help=help)

    def _switches(self, tag: str, count: str, lines: list[int]) -> None:
        """Robust edges of Vertigo, which a loss of the model replaces."""
        edge = self.kind.tag("edges")
        if "MAXMIX" in tag:
            help = (
                f"write `{edge}` without its mixture's weight, and give a copy of the model "
                "`constraint between loss tukey(3)`: far edges then cost a constant"
            )
        elif tag.startswith("EDGE_SE"):
            help = (
                f"write `{edge}` without the id of the switch, and give a copy of the model "
                "`constraint between loss dcs(1)`, which is its switch solved for in closed form"
            )
        else:
            help = "leave these lines out: the loss `dcs` of an edge needs no switches"
        self.text.add(
            "E0717",
            f"`{tag}` is of Vertigo{count}: a robust edge, which is a loss of the model here",
            lines[0],
            0,
            help=help,
        )

    def _records(self, form: Form, words: list[list[str]], lines: list[int]) -> None:
        width = form.before + form.size + form.information
        bare = form.before + form.size
        widths = set(map(len, words))
        if bare in widths and bare != width and widths <= {bare, width}:
            self._mixed(form, words, lines)
            return
        if widths != {width}:
            for row, line in zip(words, lines, strict=True):
                if len(row) != width:
                    self.text.add(
                        "E0716",
                        f"expected {width - 1} values after `{row[0]}`, found {len(row) - 1}",
                        line,
                        notes=self._form(form, row[0]),
                    )
            return
        self._take(form, words, lines)

    def _mixed(self, form: Form, words: list[list[str]], lines: list[int]) -> None:
        """Lines of which some have no information matrix."""
        without = [len(row) == form.before + form.size for row in words]
        if self.information is None:
            first, count = without.index(True), sum(without)
            some = f"{count} lines have" if count > 1 else "the line has"
            self.text.add(
                "E0716",
                f"{some} no information matrix after `{words[first][0]}`",
                lines[first],
                notes=self._form(form, words[first][0]),
                help="give one for such lines: --information 100, or position and rotation "
                "as 100,400; from Python `read(path, information=(100, 400))`",
            )
            return
        given = self._default(form, self.information)
        filled = [row + given if bare else row for row, bare in zip(words, without, strict=True)]
        self._take(form, filled, lines)

    @staticmethod
    def _default(form: Form, information: Information) -> list[str]:
        """The words of an information matrix that is the same in all directions."""
        position, rotation = information
        matrix = np.diag([position] * form.positions + [rotation] * form.rotations)
        triangle = matrix[np.triu_indices(form.tangent)].tolist()
        order = range(form.information) if form.order is None else form.order
        found = [""] * form.information
        for number, place in zip(triangle, order, strict=True):
            found[place] = repr(number)
        return found

    def _take(self, form: Form, words: list[list[str]], lines: list[int]) -> None:
        first, last = form.before, form.before + form.size
        found_ids = self._convert([row[1:first] for row in words], lines, int, 1)
        table = self._convert([row[first:] for row in words], lines, float, first)
        if found_ids is None or table is None:
            return
        numbers = np.array(table, dtype=np.float64).reshape(len(words), -1)
        finite = np.isfinite(numbers).all(axis=1)
        for i in np.flatnonzero(~finite).tolist():
            word = first + int(np.argmin(np.isfinite(numbers[i])))
            self.text.add("E0705", "a number is NaN or infinite", lines[i], word)
        ids = np.array(found_ids, dtype=np.int64).reshape(len(words), -1)
        values = numbers[:, : form.size]
        if form.euler:
            q = rotations.quaternion_from_euler(values[:, 3:6])
            values = np.column_stack([values[:, :3], q[:, [1, 2, 3, 0]]])
        information = self._matrices(form, numbers[:, last - first :])
        if form.part == "anchors":
            values, information = self._whole(values, information)
        self.graph[form.part].append(
            ids[:, : form.ids].tolist(),
            ids[:, form.ids].tolist() if form.offset else [-1] * len(words),
            values,
            information,
            lines,
        )

    def _matrices(self, form: Form, triangle: Array) -> Array:
        """Information matrices from the numbers of their upper triangles."""
        n = form.tangent
        found = np.zeros((len(triangle), n, n))
        rows, columns = np.triu_indices(n)
        if form.order is not None:
            triangle = triangle[:, list(form.order)]
        found[:, rows, columns] = triangle
        found[:, columns, rows] = triangle
        return found

    def _whole(self, values: Array, information: Array) -> tuple[Array, Array]:
        """Measured positions as measured poses without information about rotation."""
        kind, d = self.kind, information.shape[1]
        if d == kind.tangent:
            return values, information
        poses = np.tile(kind.identity, (len(values), 1))
        poses[:, :d] = values
        found = np.zeros((len(values), kind.tangent, kind.tangent))
        found[:, :d, :d] = information
        return poses, found

    def _form(self, form: Form, tag: str) -> tuple[str, ...]:
        ids = " ".join(["id"] * form.ids + ["offset"] * form.offset)
        what = {"poses": "a vertex", "edges": "an edge"}.get(form.part, "a line")
        head = f"{what} is `{tag} {ids} {form.shown}`"
        if not form.tangent:
            return (head,)
        if form.tangent == 1:
            return (f"{head} and its information",)
        return (
            f"{head} and the upper triangle of its information matrix, {form.information} numbers",
        )

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
