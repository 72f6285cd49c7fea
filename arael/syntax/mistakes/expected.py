"""The general syntax error: the expected tokens, in words."""

from __future__ import annotations

from arael.syntax import tables
from arael.syntax.tables import END
from arael.syntax.tokens import NEWLINE
from arael.syntax.trouble import SOFT_WORDS, Trouble

_PLACES = {
    "struct": "struct", "root": "root", "component": "component", "constraint": "constraint",
    "require": "require", "fit": "fit", "solve": "solve schedule", "pass": "pass",
    "update": "update",
}  # fmt: skip
_TERMINALS = {"NUMBER": "a number", "STRING": "a text in quotes", "NAME": "a name"}
_MEMBERS = {"CONSTRAINT", "PARAM", "FIT", "SOLVE"}


def report_expected(t: Trouble) -> None:
    """Report the acceptable tokens, and skip the statement."""
    before = t.before
    wanted = _wanted(t)
    found = _found(t)
    place = _place(t)
    where = f" {place}" if place else ""
    t.report(
        "E0123",
        f"expected {wanted}{where}, found {found}",
        f"expected {wanted}",
        related=(before, "after this") if before is not None else None,
    )
    if t.token.type == NEWLINE:
        t.panic()
        return
    t.skip(0 if t.token.type in ("LBRACE", "RBRACE", "SEMICOLON") else 1)
    t.panic()


def _found(t: Trouble) -> str:
    if t.token.type == END:
        return "the end of the text"
    if t.token.type == NEWLINE:
        return "the end of the line"
    shown = t.token.text if len(t.token.text) <= 40 else t.token.text[:40] + "..."
    return f"`{shown}`"


def _wanted(t: Trouble) -> str:
    expected = set(t.expected)
    names = "NAME" in expected
    words: list[str] = []
    if t.wants_operand:
        words.append("an expression")
        expected &= {NEWLINE, "RBRACE"}
    elif expected >= _MEMBERS:
        words.append("a field, a constraint or `}`")
        expected = set()
    elif "STRUCT" in expected and "FN" in expected:
        words.append("`struct`, `root`, `fn`, `const` or `import`")
        expected = set()
    elif names and "REF" in expected:
        words.append("a type")
        expected = set()
    elif names:
        words.append("a name")
        expected -= SOFT_WORDS | {"NAME", "SELF", "PARENT", "ROOT"}
    grammar = tables.load()
    if NEWLINE in expected:
        words.append("the end of the statement")
        operators = {"PLUS", "MINUS", "STAR", "SLASH"} <= expected
        expected -= {NEWLINE, "SEMICOLON"}
        if operators:
            words.insert(0, "an operator")
            expected &= {"RBRACE"}
    elif {"PLUS", "STAR"} <= expected:
        words.append("an operator")
        expected &= {"RPAR", "RSQB", "COMMA", "THEN", "ELSE", "LBRACE"}
    expected.discard(END)
    words += sorted(_TERMINALS.get(x) or f"`{grammar.spelling(x)}`" for x in expected)[:4]
    if len(words) <= 1:
        return words[0] if words else "something else"
    return ", ".join(words[:-1]) + " or " + words[-1]


def _place(t: Trouble) -> str:
    construct = t.construct()
    if construct is not None:
        return f"in this `{construct.text}`"
    block = t.block()
    if block is not None:
        return f"in this {_PLACES[block.text]}"
    return ""
