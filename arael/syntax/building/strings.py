"""Text in quotes."""

from __future__ import annotations

from arael.syntax import tree
from arael.syntax.log import ErrorLog
from arael.syntax.tokens import Token

_ESCAPES = {'"': '"', "\\": "\\", "n": "\n", "t": "\t"}


def make_string(token: Token, log: ErrorLog) -> tree.String:
    """Node of a string token, with escapes resolved; reports unknown escapes."""
    value = []
    characters = iter(enumerate(token.text[1:-1], token.start + 1))
    for at, char in characters:
        if char != "\\":
            value.append(char)
            continue
        _, escaped = next(characters)
        if escaped not in _ESCAPES:
            log.error(
                "E0112",
                f"unknown escape `\\{escaped}`",
                at,
                at + 2,
                'the escapes are `\\"` `\\\\` `\\n` `\\t`',
                help="folders in a path are separated with `/`",
            )
        value.append(_ESCAPES.get(escaped, escaped))
    return tree.String(span=log.span(token.start, token.end), value="".join(value))
