"""A calculator in the style of bc: statements in, lines of text out.

It does not use a terminal; `arael calc` is its command. Variables without a value stay symbols, so
``diff(x^2, x)`` gives ``2 * x``. Nothing of a statement is ever run as code.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from arael.calculator.forms import FORMS, TEXTS, resolved
from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES
from arael.check.typed import BOOL
from arael.diagnostics.arguments import fail
from arael.diagnostics.records import AraelError, Diagnostic, Label, Source, Span
from arael.sym.evaluation import eval
from arael.sym.functions import number
from arael.sym.notation import shaped, text
from arael.sym.reading import Reader
from arael.sym.user_functions import FunctionBag
from arael.sym.values import Value, entries, free_vars, type_of, with_entries
from arael.syntax import tree
from arael.syntax.lexer import tokenise
from arael.syntax.log import ErrorLog
from arael.syntax.parser import parse, parse_expression
from arael.syntax.tokens import Token

LAST = "ans"
"""The variable that holds the last result."""

MAX_DEFINITIONS = 1000
"""Variables and functions that a calculator holds."""

DIGITS = 15
"""Significant digits of numbers, unless others are asked for."""

_DEFINITION = re.compile(r"\s*([A-Za-z_]\w*)\s*(\(([^()]*)\))?\s*=(?!=)")


@dataclass(frozen=True)
class Answer:
    """What a statement gave.

    Attributes
    ----------
    text : to be shown; empty where a definition was taken in silently
    value : the value, None for definitions of functions and for text
    """

    text: str
    value: Value | None = None


class Calculator:
    """Holds variables and functions, and works out statements.

    Attributes
    ----------
    variables : values by name, as they were when they were given
    functions : functions of the user
    digits : significant digits of the numbers shown
    """

    def __init__(self, digits: int = DIGITS) -> None:
        self.variables: dict[str, Value] = {}
        self.functions = FunctionBag()
        self.digits = digits

    def run(self, line: str, name: str = "input", number: int = 1) -> Iterator[Answer]:
        """Work out the statements of a line, which ``;`` separates.

        Parameters
        ----------
        name, number : of what the line is from, and which line of it that is

        Raises
        ------
        AraelError
            At the first statement that is wrong, with its place; those before it have been done.
        """
        source = Source(name, line, number)
        for start, end in _statements(source):
            yield self._statement(source, start, end)

    def names(self) -> list[str]:
        """Every name that means something, for completion."""
        own = [*self.variables, *self.functions]
        return sorted({*own, *FORMS, *TEXTS, *FUNCTIONS, *CONSTANTS, *IDENTITIES})

    # --- statements -------------------------------------------------------------------------------

    def _statement(self, source: Source, start: int, end: int) -> Answer:
        definition = _DEFINITION.match(source.text, start, end)
        if definition is None:
            return self._shown(*self._expression(source, start, end))
        if definition[2] is not None:
            return self._define(source, start, end)
        at = Span(source, *definition.span(1))
        value, _ = self._expression(source, definition.end(), end)
        if value is None:
            fail("E0655", "this gives text, which no variable can hold", at)
        return self._assign(definition[1], value, at)

    def _assign(self, name: str, value: Value, at: Span) -> Answer:
        if name in FUNCTIONS or name in IDENTITIES or name in FORMS:
            fail("E0655", f"`{name}` is a function", at, help=("choose another name",))
        if len(self.variables) >= MAX_DEFINITIONS and name not in self.variables:
            fail("E0655", f"more than {MAX_DEFINITIONS} variables", at)
        if self._reads(value, name):
            fail(
                "E0655",
                f"`{name}` would be defined by itself",
                at,
                help=(f"give `{name}` a number first",),
            )
        self.variables[name] = value
        return Answer("", value)

    def _reads(self, value: Value, name: str) -> bool:
        """Whether a value depends on the variable `name`, through other variables too."""
        waiting = list(free_vars(value))
        seen: set[str] = set()
        while waiting:
            here = waiting.pop()
            if here == name:
                return True
            if here not in seen:
                seen.add(here)
                waiting += free_vars(self.variables.get(here, number(0.0)))
        return False

    def _define(self, source: Source, start: int, end: int) -> Answer:
        """Take in ``f(x) = expr``, by the grammar of a model's functions."""
        head = "fn "
        moved = Source(source.name, head + source.text[start:end], source.first)
        shift = start - len(head)
        try:
            items = parse(moved).items
            if len(items) != 1 or not isinstance(items[0], tree.Function):
                fail("E0651", "expected the definition of one function", Span(source, start, end))
            if len(self.functions) >= MAX_DEFINITIONS:
                fail("E0651", f"more than {MAX_DEFINITIONS} functions", items[0].name.span)
            self.functions.add(items[0])
        except AraelError as error:
            raise _moved(error, moved, source, shift) from None
        return Answer("")

    def _expression(self, source: Source, start: int, end: int) -> tuple[Value | None, str]:
        """Value of the formula at ``start:end``, or the text that it asks for."""
        blank = re.sub(r"[^\n]", " ", source.text[:start])
        moved = Source(source.name, blank + source.text[start:end], source.first)
        try:
            node = parse_expression(moved)
            reader = Reader(self.functions, self.variables, {}, FORMS)
            if _asks_for_text(node, self.functions):
                assert isinstance(node, tree.Call) and isinstance(node.func, tree.Name)
                if len(node.args) != 1:
                    fail("E0303", f"`{node.func.id}` takes 1 argument", node.span)
                return None, TEXTS[node.func.id](_worked_out(reader.read(node.args[0])))
            return _worked_out(resolved(reader.read(node), self.variables)), ""
        except AraelError as error:
            raise _moved(error, moved, source, 0) from None

    def _shown(self, value: Value | None, asked: str) -> Answer:
        if value is None:
            return Answer(asked)
        answer = Answer(self.text(value), value)
        self.variables[LAST] = value
        return answer

    # --- text -------------------------------------------------------------------------------------

    def text(self, value: Value) -> str:
        """Write a value: numbers where there is no variable left, else a formula."""
        if free_vars(value) or type_of(value) == BOOL:
            return text(value)
        numbers = np.ravel(eval(value))
        return shaped(type_of(value), [self._number(float(x)) for x in numbers])

    def _number(self, x: float) -> str:
        return f"{x + 0.0:.{self.digits}g}"


def _asks_for_text(node: tree.Expr, functions: FunctionBag) -> bool:
    if not isinstance(node, tree.Call) or not isinstance(node.func, tree.Name):
        return False
    return node.func.id in TEXTS and node.func.id not in functions


def _worked_out(value: Value) -> Value:
    """Return the numbers that a value without variables is."""
    if free_vars(value):
        return value
    if type_of(value) == BOOL:
        return sp.true if eval(value) else sp.false
    return with_entries(value, [number(eval(e)) for e in entries(value)])


# --- places ---------------------------------------------------------------------------------------


def _statements(source: Source) -> Iterator[tuple[int, int]]:
    """Stretches of the text between ``;`` and line ends outside of brackets, comments left out."""
    log = ErrorLog(source)
    lexed = tokenise(source, log)
    log.stop()
    depth = 0
    inside: list[Token] = []
    for token in lexed.tokens:
        depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
        if token.text == ";" or (token.text in ("\n", "") and depth <= 0):
            if inside:
                yield inside[0].start, inside[-1].end
            inside = []
        else:
            inside.append(token)
    if inside:
        yield inside[0].start, inside[-1].end


def _moved(error: AraelError, old: Source, new: Source, shift: int) -> AraelError:
    """Return the same error with places in the text that the user wrote."""

    def span(s: Span) -> Span:
        if s.source is not old:
            return s
        return Span(new, max(0, s.start + shift), max(0, s.end + shift))

    def moved(d: Diagnostic) -> Diagnostic:
        labels = tuple(Label(span(label.span), label.text) for label in d.labels)
        return replace(d, span=span(d.span) if d.span else None, labels=labels)

    return AraelError([moved(d) for d in error.diagnostics])
