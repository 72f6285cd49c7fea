"""Alignment in columns: types and defaults of fields, values of lets and settings, comments."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from arael.diagnostics.records import Source
from arael.syntax import tree
from arael.syntax.formatting.facts import Aligned, Facts
from arael.syntax.formatting.lines import Line, Word


@dataclass
class _Row:
    """A statement that begins a line, and the words that may be aligned."""

    line: Line
    node: Aligned

    def word(self, matches: Callable[[Word], bool]) -> Word | None:
        return next((w for w in self.line.words if matches(w)), None)

    def width_to(self, word: Word) -> int:
        """Characters from the start of the statement to the end of the word before `word`."""
        total = 0
        for w in self.line.words:
            if w is word:
                break
            total += w.gap + len(w.token.text)
        return total


def align(lines: list[Line], facts: Facts, source: Source) -> None:
    """Set the blanks of `lines` so that consecutive statements of one kind are aligned."""
    for run in _runs(lines, facts):
        kind = type(run[0].node)
        if kind is tree.Field:
            _align_fields(run, source)
        elif kind is tree.PassBlock:
            _line_up(run, lambda w: w.token.type == "LBRACE")
        else:
            _line_up(run, lambda w: w.token.type == "EQUAL")


def _runs(lines: list[Line], facts: Facts) -> Iterator[list[_Row]]:
    """Statements of one kind and depth that follow each other without a blank line."""
    run: list[_Row] = []
    for line in lines:
        if (line.continues and not line.blank_before) or not line.words:
            if not line.blank_before:
                continue
            node = None
        else:
            node = facts.aligned.get(line.words[0].token.start)
        if isinstance(node, tree.PassBlock) and line.words[-1].token.type != "RBRACE":
            node = None
        fits = run and node is not None and type(node) is type(run[0].node)
        if run and not (fits and line.depth == run[0].line.depth and not line.blank_before):
            yield run
            run = []
        if node is not None:
            run.append(_Row(line, node))
    if run:
        yield run


def _line_up(rows: Iterable[_Row], matches: Callable[[Word], bool]) -> None:
    """Align the first matching word of each row, one blank after the longest start."""
    found = [(row, word) for row in rows if (word := row.word(matches)) is not None]
    column = max((row.width_to(word) for row, word in found), default=0) + 1
    for row, word in found:
        word.gap = column - row.width_to(word)


def _align_fields(run: list[_Row], source: Source) -> None:
    for group in _field_groups(run, source):
        _line_up(group, _is_at([row.node.type.span.start for row in group]))
        for (has_default, _), rows in groupby(group, _default_key):
            if has_default:
                _line_up(rows, lambda w: w.token.type == "EQUAL")


def _default_key(row: Any) -> tuple[bool, bool]:
    node = row.node
    return node.default is not None, getattr(node.type, "unit", None) is not None


def _is_at(starts: list[int]) -> Callable[[Word], bool]:
    places = set(starts)
    return lambda w: w.token.start in places


def _field_groups(run: list[Any], source: Source) -> list[list[Any]]:
    """Align parameters and data separately, unless they are joined in the source.

    They are joined if the last parameter and the first data field have their types in one column.
    """
    groups: list[list[Any]] = []
    for _, rows in groupby(run, lambda row: row.node.role == "param"):
        group = list(rows)
        if groups and _type_column(groups[-1][-1], source) == _type_column(group[0], source):
            groups[-1] += group
        else:
            groups.append(group)
    return groups


def _type_column(row: Any, source: Source) -> int:
    return source.position(row.node.type.span.start)[1]
