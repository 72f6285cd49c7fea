"""Blanks between two tokens of a line."""

from __future__ import annotations

from arael.syntax.formatting.facts import Facts
from arael.syntax.tokens import Token

_TIGHT_BEFORE = frozenset(
    ["RPAR", "RSQB", "COMMA", "SEMICOLON", "DOT", "QUOTE", "QUESTION", "CARET"]
)
_TIGHT_AFTER = frozenset(["LPAR", "LSQB", "DOT", "CARET"])
_VALUES = frozenset(["RPAR", "RSQB", "QUOTE", "SELF", "PARENT", "ROOT", "NUMBER", "STRING"])
_STEP_GAP = 3


class Spacing:
    """Decides blanks token by token; requires every token of the file in order."""

    def __init__(self, facts: Facts) -> None:
        self._facts = facts
        self._unit_end = -1
        self._in_dims = False
        self._bars_open = 0

    def gap(self, before: Token | None, token: Token) -> int:
        """Blanks before `token`, which follows `before` on the same line or is the first (None)."""
        facts = self._facts
        if token.start in facts.units:
            self._unit_end = facts.units[token.start]
            return 1
        if token.start < self._unit_end:
            return 0
        if self._in_dims:
            self._in_dims = token.type != "GT"
            return 0
        if before is None:
            self._bar(token)
            return 0
        if token.type == "LT" and before.start in facts.dimensioned:
            self._in_dims = True
            return 0
        if token.start in facts.steps and before.type not in ("SEMICOLON", "LBRACE"):
            self._bar(token)
            return _STEP_GAP
        if token.type == "VBAR":
            return int(self._bar(token))
        if before.type == "VBAR":
            return int(not self._bars_open)
        return int(self._apart(before, token))

    def _bar(self, token: Token) -> bool:
        """Track the bars of a lambda; return whether `token` opens one."""
        if token.type != "VBAR":
            return False
        self._bars_open = 1 if token.start in self._facts.lambdas else 0
        return bool(self._bars_open)

    def _apart(self, before: Token, token: Token) -> bool:
        kind, last = token.type, before.type
        if kind == "DOT" and last == "NUMBER":
            return True  # `1.a` is not a number
        if kind in _TIGHT_BEFORE or last in _TIGHT_AFTER:
            return False
        if before.start in self._facts.slices:
            return False
        if kind == "COLON":
            after_comma = token.start in self._facts.slices and last == "COMMA"
            return before.start in self._facts.roots or after_comma
        if last in ("MINUS", "PLUS") and before.start in self._facts.signs:
            return False
        if kind == "LPAR":
            return not self._is_value(before)
        if kind == "LSQB":
            return token.start in self._facts.lists or not self._is_value(before)
        return True

    def _is_value(self, token: Token) -> bool:
        return token.start in self._facts.names or token.type in _VALUES
