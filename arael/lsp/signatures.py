"""The arguments of the call that is being typed."""

from __future__ import annotations

from dataclasses import dataclass

from arael.check.builtins import FUNCTIONS
from arael.check.losses import LOSSES
from arael.lsp.document import Document
from arael.lsp.hover import builtin
from arael.lsp.outline import is_word
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS


@dataclass(frozen=True)
class Signature:
    """A call: its text, the texts of its arguments within it, and which one is being typed."""

    label: str
    arguments: tuple[str, ...]
    active: int
    doc: str = ""


def signature(document: Document, offset: int) -> Signature | None:
    """The signature of the innermost call around `offset`."""
    tokens = document.tokens
    at = document.before(offset - 1)
    depth = commas = 0
    while at >= 0:
        kind = tokens[at].type
        if kind in CLOSERS:
            depth += 1
        elif kind in OPENERS:
            if depth == 0:
                called = at > 0 and kind == "LPAR" and is_word(tokens[at - 1])
                return _of(document, at - 1, commas) if called else None
            depth -= 1
        elif kind == "COMMA" and depth == 0:
            commas += 1
        elif kind == NEWLINE and depth == 0 and at and tokens[at - 1].type == "RBRACE":
            return None
        at -= 1
    return None


def _of(document: Document, i: int, active: int) -> Signature | None:
    name = document.tokens[i].text
    own = document.names.arguments.get(name)
    if own is not None:
        arguments = tuple(a.name for a in own)
        doc = document.names.functions[name].doc
    elif name in FUNCTIONS:
        one = FUNCTIONS[name]
        method = i > 0 and document.tokens[i - 1].type == "DOT"
        count = max(one.least, one.most or one.least) - method
        words = ("x",) if count == 1 else tuple("abcdefgh"[:count])
        if name == "atan2":
            words = ("y", "x")
        arguments = (*words, "...") if one.most is None else words
        doc = builtin(name)
    elif name in LOSSES:
        arguments, doc = ("scale",), builtin(name)
    elif name == "normal":
        arguments, doc = ("mean", "sigma"), ""
    else:
        return None
    label = f"{name}({', '.join(arguments)})"
    return Signature(label, arguments, min(active, max(len(arguments) - 1, 0)), doc)
