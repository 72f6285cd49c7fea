"""Tokens, from the lexer to the parser."""

from __future__ import annotations

from dataclasses import dataclass

NEWLINE = "_NEWLINE"
OPENERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
CLOSERS = {closer: opener for opener, closer in OPENERS.items()}


@dataclass(slots=True, eq=False)
class Token:
    """A terminal `type` of the grammar at characters ``start:end``.

    `damaged` marks tokens that the parser inserted, and brackets in which it skipped something, so
    that missing parts inside are not reported.
    """

    type: str
    text: str
    start: int
    end: int
    damaged: bool = False
