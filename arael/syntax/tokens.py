"""Tokens: what the lexer makes and the parser takes."""

from __future__ import annotations

from dataclasses import dataclass

NEWLINE = "_NEWLINE"
OPENERS = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
CLOSERS = {closer: opener for opener, closer in OPENERS.items()}


@dataclass(slots=True, eq=False)
class Token:
    """A terminal `type` of the grammar at characters ``start:end``.

    `damaged` marks a bracket in which the parser skipped something, so that what is missing inside
    is not reported as missing, and tokens that the parser made up.
    """

    type: str
    text: str
    start: int
    end: int
    damaged: bool = False
