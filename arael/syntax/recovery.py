"""Runs the automaton over the tokens, with error recovery to find further mistakes."""

from __future__ import annotations

from arael.syntax.automaton import Automaton
from arael.syntax.limits import MAX_ERRORS, MAX_STACK
from arael.syntax.log import ErrorLog
from arael.syntax.tables import END
from arael.syntax.tokens import NEWLINE, Token

# After these a statement cannot be complete, so a line end there is ignored.
_CONTINUES = frozenset(
    [
        "PLUS",
        "MINUS",
        "STAR",
        "SLASH",
        "DOTSTAR",
        "DOTSLASH",
        "CARET",
        "EQ",
        "NE",
        "LT",
        "LE",
        "GT",
        "GE",
        "AND",
        "OR",
        "NOT",
        "COMMA",
        "EQUAL",
        "IF",
        "THEN",
        "ELSE",
        "VBAR",
        "WHEN",
        "LOSS",
        "INTO",
    ]
)
# The parts of a header that may be on the next line.
_HEADER_PARTS = ("LBRACE", "THEN", "ELSE")

# Operators with which no statement can begin; signs can, see `building.body`.
_LEADING = frozenset(
    [
        "STAR",
        "SLASH",
        "DOTSTAR",
        "DOTSLASH",
        "CARET",
        "EQ",
        "NE",
        "LT",
        "LE",
        "GT",
        "GE",
        "AND",
        "OR",
    ]
)

_MAX_STUCK = 4


def drive(automaton: Automaton, tokens: list[Token], log: ErrorLog) -> set[int]:
    """Parse all `tokens`, reporting to `log`; the result is valid only if `log` stays empty.

    Returns
    -------
    set of int
        Numbers of the line ends that did not end a statement.

    Raises
    ------
    AraelError
        If `log` is full, or if the text ends too early.
    """
    index = stuck = repaired = 0
    passed: set[int] = set()
    reported = False
    while True:
        token = tokens[index]
        if token.type == NEWLINE and _joins(automaton, tokens[index + 1]):
            passed.add(index)
            index += 1
        elif token.type == NEWLINE and _leads(automaton, tokens[index + 1]):
            if not reported:
                _refuse_leading(tokens[index - 1], tokens[index + 1], log)
            reported = True  # once for a statement that spans many lines
            index += 1
        elif automaton.feed(token):
            reported = reported and token.type != NEWLINE
            if token.type == END:
                return passed
            index += 1
            stuck = stuck if token.damaged else 0
            if len(automaton.states) > MAX_STACK:
                _refuse_depth(token, log)
        elif token.type == NEWLINE and _goes_on(automaton, tokens[index - 1] if index else None):
            passed.add(index)
            index += 1
        else:
            # imported here: start-up time, since most texts have no mistake
            from arael.syntax.mistakes import explain
            from arael.syntax.trouble import Trouble

            stuck += 1
            repaired += 1
            trouble = Trouble(automaton, tokens, index, log)
            if repaired > 3 * MAX_ERRORS:
                log.stop()
            if stuck < _MAX_STUCK:
                explain(trouble)
            else:
                trouble.skip()
                trouble.panic()
            if token.type == END:
                log.stop()
                log.error("E0123", "the text ends too early", token.start, token.end)
            index = trouble.index


def _refuse_depth(token: Token, log: ErrorLog) -> None:
    log.error(
        "E0105",
        "an expression is nested too deeply",
        token.start,
        token.end,
        "the limit is reached here",
        help="name parts of it with `let`",
    )
    log.stop()


def _leads(automaton: Automaton, token: Token) -> bool:
    """Return whether `token` begins a line, but can only continue the statement above."""
    return token.type in _LEADING and automaton.accepts(token.type) and automaton.accepts(NEWLINE)


def _refuse_leading(before: Token, token: Token, log: ErrorLog) -> None:
    log.error(
        "E0133",
        "an operator at the start of a line does not continue the previous line",
        token.start,
        token.end,
        "cannot begin a statement",
        labels=[(before.start, before.end, "the statement ended here")],
        help=f"put the `{token.text}` at the end of the line above, or brackets around it all",
    )


def _joins(automaton: Automaton, token: Token) -> bool:
    return token.type == "DERIVS" and automaton.accepts("DERIVS")


def _goes_on(automaton: Automaton, before: Token | None) -> bool:
    """Return whether a line end that cannot end a statement may be skipped."""
    if before is None or before.type in _CONTINUES:
        return True
    for value, _, _ in reversed(automaton.entries):
        if isinstance(value, Token):
            if value.type in ("LPAR", "LSQB"):
                return True
            if value.type == "LBRACE":
                break
    return any(automaton.accepts(part) for part in _HEADER_PARTS)
