"""Parser: text to tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arael.diagnostics.records import Source
from arael.syntax import tree
from arael.syntax.automaton import Automaton
from arael.syntax.building import TreeBuilder
from arael.syntax.docs import DocComments
from arael.syntax.lexer import Lexed, tokenise
from arael.syntax.limits import MAX_BYTES
from arael.syntax.log import ErrorLog
from arael.syntax.recovery import drive
from arael.syntax.tokens import Token


def parse(source: Source) -> tree.File:
    """Read a model file.

    Raises
    ------
    AraelError
        With every syntax error found, in the order of the text, at most `MAX_ERRORS` of them.
    """
    return parse_with_layout(source).file


@dataclass(frozen=True)
class Layout:
    """A file with its tokens.

    `passed` has the numbers of the line ends among `tokens` that did not end a statement.
    """

    file: tree.File
    tokens: list[Token]
    passed: set[int]


def parse_with_layout(source: Source) -> Layout:
    """Read a model file with its layout, for the formatter.

    Raises
    ------
    AraelError
        As for `parse`.
    """
    items, lexed, passed = _run(source, "start")
    return Layout(tree.File(source, items, tuple(lexed.comments)), lexed.tokens, passed)


def parse_expression(source: Source) -> tree.Expr:
    """Read one formula, as the command line and Python callers pass it.

    Raises
    ------
    AraelError
        As for `parse`.
    """
    expr, _, _ = _run(source, "expression")
    return expr  # type: ignore[no-any-return]


def parse_rule(source: Source) -> tree.Expr:
    """Read a formula, or a comparison as a `require` has it, which may be a chain.

    Raises
    ------
    AraelError
        As for `parse`.
    """
    expr, _, _ = _run(source, "rule_alone")
    return expr  # type: ignore[no-any-return]


def parse_loss(source: Source) -> tree.Expr:
    """Read a loss as written after `loss` in a model: ``cauchy(2)`` or ``|s| log(1 + s)``.

    Raises
    ------
    AraelError
        As for `parse`.
    """
    expr, _, _ = _run(source, "loss_alone")
    return expr  # type: ignore[no-any-return]


def _run(source: Source, start: str) -> tuple[Any, Lexed, set[int]]:
    log = ErrorLog(source)
    _check_size(source, log)
    lexed = tokenise(source, log)
    builder = TreeBuilder(source, DocComments(source, lexed.comments), log)
    automaton = Automaton(start, builder)
    passed = drive(automaton, lexed.tokens, log)
    log.stop()
    return automaton.result, lexed, passed


def _check_size(source: Source, log: ErrorLog) -> None:
    if len(source.text) > MAX_BYTES:
        log.error(
            "E0104",
            f"the text has {len(source.text)} characters",
            0,
            0,
            help=f"at most {MAX_BYTES} are read",
        )
        log.stop()
