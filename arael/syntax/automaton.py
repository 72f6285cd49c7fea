"""The LALR(1) automaton: a stack of states and values driven by the grammar's tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arael.syntax import tables
from arael.syntax.tables import END
from arael.syntax.tokens import Token

Entry = tuple[Any, int, int]
"""A value and its characters ``start:end``."""

Build = Callable[[str, list[Any], int, int], Any]
"""Builds the value of a production from its name, the kept parts, and its place."""


class Automaton:
    """A parse under way from one of the grammar's start rules.

    The recovery code may change the stacks: `entries` runs parallel to `states`, whose first
    element is the start state.
    """

    def __init__(self, start: str, build: Build) -> None:
        grammar = tables.load()
        self._rows = grammar.rows
        self._gotos = grammar.gotos
        self._productions = grammar.productions
        self._end_state = grammar.end_states[start]
        self._build = build
        self.states: list[int] = [grammar.start_states[start]]
        self.entries: list[Entry] = []

    def accepts(self, terminal: str) -> bool:
        """Return whether `terminal` is acceptable here."""
        states = self.states.copy()
        while True:
            action = self._rows[states[-1]].get(terminal)
            if action is None:
                return False
            if action > 0:
                return True
            production = self._productions[-action - 1]
            if production.size:
                del states[-production.size :]
            states.append(self._gotos[states[-1]][production.name])
            if terminal == END and states[-1] == self._end_state:
                return True

    def expected(self) -> set[str]:
        """Acceptable terminals."""
        return {t for t in self._rows[self.states[-1]] if self.accepts(t)}

    def feed(self, token: Token) -> bool:
        """Shift `token`; False, with unchanged stacks, if it is not acceptable."""
        kind = token.type
        action = self._rows[self.states[-1]].get(kind)
        if action is not None and action > 0:
            self.states.append(action - 1)
            self.entries.append((token, token.start, token.end))
            return True
        before = self.states.copy(), self.entries.copy()
        while action is not None:
            if action > 0:
                self.states.append(action - 1)
                self.entries.append((token, token.start, token.end))
                return True
            self._reduce(-action - 1)
            if kind == END and self.states[-1] == self._end_state:
                return True
            action = self._rows[self.states[-1]].get(kind)
        self.states, self.entries = before
        return False

    def _reduce(self, number: int) -> None:
        production = self._productions[number]
        size = production.size
        states, entries = self.states, self.entries
        if production.passes_through:
            states.pop()
            states.append(self._gotos[states[-1]][production.name])
            return
        if size:
            parts = entries[-size:]
            del entries[-size:]
            del states[-size:]
            start, end = parts[0][1], parts[-1][2]
        else:
            parts = []
            start = end = entries[-1][2] if entries else 0
        kept: list[Any] = []
        for i, splice in production.template:
            if i < 0:
                kept.append(None)
            elif splice:
                kept += parts[i][0]
            else:
                kept.append(parts[i][0])
        handler = production.handler
        value = self._build(handler, kept, start, end) if handler else kept
        entries.append((value, start, end))
        states.append(self._gotos[states[-1]][production.name])

    def pop(self, count: int) -> None:
        """Pop `count` symbols."""
        if count:
            del self.states[-count:]
            del self.entries[-count:]

    @property
    def result(self) -> Any:
        """Value of the start rule, once the end of the text was accepted."""
        return self.entries[-1][0]
