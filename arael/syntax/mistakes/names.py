"""Names that are missing, or are reserved words."""

from __future__ import annotations

from arael.syntax.trouble import NAMES, Trouble

# Kind of a name, by the word before it.
_NAMED = {
    "struct": "struct", "root": "root", "component": "component", "constraint": "constraint",
    "param": "parameter", "let": "value", "const": "constant", "fn": "function", "pass": "pass",
    "symbolic": "value", "compute": "value", "as": "element", "key": "field",
}  # fmt: skip
_MEANINGS = {
    "root": "the root of the model in expressions",
    "self": "the entity itself in expressions",
    "parent": "the entity that contains this one in expressions",
}


def reserved(t: Trouble) -> bool:
    """Recognise a reserved word in place of a name, ``param in: real``."""
    word = t.token
    if "NAME" not in t.expected or not word.text.isidentifier() or word.type in NAMES:
        return False
    if t.before is not None and t.before.type in ("COLON", "OF"):
        return False
    if t.wants_operand and (t.begins_line or word.type in ("THEN", "ELSE", "OF", "AS")):
        return False
    if t.automaton.accepts("_NEWLINE") and t.ahead().type != "COLON":
        return False
    meaning = _MEANINGS.get(word.text)
    t.log.error(
        "E0125",
        f"`{word.text}` is a reserved word",
        word.start,
        word.end,
        "cannot be a name",
        notes=[f"`{word.text}` is {meaning}"] if meaning else (),
        help=f"choose another name, for example `{word.text}_`",
    )
    t.swap("NAME")
    return True


def missing(t: Trouble) -> bool:
    """``constraint { ... }``: the word before needs a name."""
    before = t.before
    if before is None or "NAME" not in t.expected or t.wants_operand or before.text not in _NAMED:
        return False
    if t.top is not before:
        return False
    what = _NAMED[before.text]
    token = t.token
    if token.type == "NUMBER" or token.type == "STRING":
        t.log.error(
            "E0124",
            f"the {what} needs a name",
            token.start,
            token.end,
            "this is not a name",
            help="a name starts with a letter",
        )
        t.swap("NAME")
        return True
    examples = {"constraint": "constraint drift { ... }", "struct": "struct Pose { ... }"}
    t.log.error(
        "E0124",
        f"`{before.text}` without a name",
        before.start,
        before.end,
        f"the {what} needs a name after this",
        help=f"write for example `{examples[before.text]}`" if before.text in examples else (),
    )
    t.insert("NAME")
    return True


RECOGNISERS = (reserved, missing)
