"""Imports and solve schedules."""

from __future__ import annotations

from arael.syntax.trouble import Trouble


def unquoted_import(t: Trouble) -> bool:
    """Recognise ``import geometry``."""
    before = t.before
    if before is None or before is not t.top or before.type != "IMPORT":
        return False
    name = t.token.text if t.is_word(t.token) else "file"
    t.log.error(
        "E0112",
        "`import` takes the name of a file in quotes",
        before.start,
        before.end,
        "expected a text after this",
        help=f'write `import "{name}.arael"`',
    )
    t.panic()
    return True


def setting_with_colon(t: Trouble) -> bool:
    """Recognise ``x: 1`` in a pass."""
    block, token = t.block(), t.token
    if block is None or block.type not in ("PASS", "UPDATE") or t.before is None:
        return False
    if token.type != "COLON" or "EQUAL" not in t.expected:
        return False
    t.log.error(
        "E0135",
        "`:` where `=` belongs",
        token.start,
        token.end,
        f"a setting is written `{t.before.text} = value`",
    )
    t.swap("EQUAL")
    return True


def pass_without_word(t: Trouble) -> bool:
    """Recognise ``coarse { ... }`` in a solve schedule."""
    block, token = t.block(), t.token
    if block is None or block.type != "SOLVE" or not t.is_name(token):
        return False
    if not t.automaton.accepts("PASS"):
        return False
    t.log.error(
        "E0128",
        f"`{token.text}` without `pass`",
        token.start,
        token.end,
        "a solve schedule holds passes",
        help=f"write `pass {token.text} {{ ... }}`",
    )
    if t.ahead().type == "LBRACE":
        t.insert("PASS")
    else:
        t.panic()
    return True


RECOGNISERS = (unquoted_import, setting_with_colon, pass_without_word)
