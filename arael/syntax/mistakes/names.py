"""Names that are missing, or are reserved words."""

from __future__ import annotations

from arael.syntax.mistakes.table import Mistake, Names
from arael.syntax.trouble import NAMES, Trouble

# Kind of a name, by the word before it.
_NAMED = {
    "struct": "struct", "root": "root", "component": "component", "constraint": "constraint",
    "param": "parameter", "let": "value", "const": "constant", "fn": "function", "pass": "pass",
    "symbolic": "value", "compute": "value", "as": "element", "key": "field",
}  # fmt: skip
_EXAMPLES = {"constraint": "constraint drift { ... }", "struct": "struct Pose { ... }"}
_MEANINGS = {
    "root": "the root of the model in expressions",
    "self": "the entity itself in expressions",
    "parent": "the entity that contains this one in expressions",
}


def _reserved(t: Trouble) -> Names | bool:
    """A reserved word in place of a name, ``param in: real``."""
    word = t.token
    if not word.text.isidentifier() or word.type in NAMES:
        return False
    if t.before is not None and t.before.type in ("COLON", "OF"):
        return False
    if t.wants_operand and (t.begins_line or word.type in ("THEN", "ELSE", "OF", "AS")):
        return False
    if t.automaton.accepts("_NEWLINE") and t.ahead().type != "COLON":
        return False
    meaning = _MEANINGS.get(word.text)
    return {"meaning": f"`{word.text}` is {meaning}" if meaning else ""}


def _named(t: Trouble) -> Names | bool:
    """``constraint { ... }``: the word before needs a name."""
    word = t.before.text if t.before is not None else ""
    example = f"write for example `{_EXAMPLES[word]}`" if word in _EXAMPLES else ""
    return word in _NAMED and {"what": _NAMED[word], "example": example}


ROWS = (
    Mistake(
        "E0125", "`{token}` is a reserved word", "cannot be a name",
        help="choose another name, for example `{token}_`", note="{meaning}",
        expected="NAME", when=_reserved, repair="swap NAME",
    ),
    Mistake(
        "E0124", "the {what} needs a name", "this is not a name",
        help="a name starts with a letter",
        token="NUMBER STRING", last=True, expected="NAME", operand=False, when=_named,
        repair="swap NAME",
    ),
    Mistake(
        "E0124", "`{before}` without a name", "the {what} needs a name after this",
        help="{example}", place="before",
        last=True, expected="NAME", operand=False, when=_named, repair="insert NAME",
    ),
)  # fmt: skip
