"""Brackets that are not closed, not opened, or of the wrong kind."""

from __future__ import annotations

from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, OPENERS, Token
from arael.syntax.trouble import ITEM_WORDS, MEMBER_WORDS, STARTERS, Trouble

_CLOSER = {"(": ")", "[": "]", "{": "}"}


def unmatched(t: Trouble) -> bool:
    """``a + b) * 2``: a bracket that closes nothing."""
    opener = t.opener()
    if t.token.type not in CLOSERS or (
        opener is not None and (t.token.type == "RBRACE" or opener.type != "LBRACE")
    ):
        return False
    t.report(
        "E0121",
        f"unmatched `{t.token.text}`",
        "closes nothing",
        help="delete it, or open its partner before",
    )
    t.skip()
    return True


def wrong_closer(t: Trouble) -> bool:
    """``(a + b]``: another bracket than the one that is open."""
    opener = t.opener()
    if opener is None or t.token.type not in ("RPAR", "RSQB") or not _can_close(t):
        return False
    t.report(
        "E0121",
        f"`{opener.text}` is closed by `{t.token.text}`",
        f"expected `{_CLOSER[opener.text]}`",
        related=(opener, "opened here"),
    )
    t.swap(OPENERS[opener.type])
    return True


def unclosed(t: Trouble) -> bool:
    """A bracket is open where a statement, a member, an item or the end of the text follows."""
    opener = t.opener()
    if opener is None:
        return False
    if t.token.type == END:
        _report(t, _misplaced_brace(t) or opener)
    elif opener.type != "LBRACE":
        if not ((t.token.type == "RBRACE" and _can_close(t)) or _statement_begins(t)):
            return False
        _report(t, opener)
        if _can_close(t):
            t.insert(OPENERS[opener.type], *([] if t.token.type == "RBRACE" else ["_NEWLINE"]))
        else:
            t.panic()
    elif t.begins_line and _member_begins(t):
        _report(t, _misplaced_brace(t) or opener)
        braces = [token for _, token in t.held() if token.type == "LBRACE"]
        for brace in braces:
            brace.damaged = True
        t.insert(*["RBRACE"] * (len(braces) if _is_item(t) else 1), "_NEWLINE")
    else:
        return False
    return True


def _report(t: Trouble, opener: Token) -> None:
    closer = _CLOSER[opener.text]
    place = (t.token, f"`{closer}` expected before this")
    if t.token.type == END:
        end = (t.before or opener).end
        place = (Token(END, "", end, end), "the file ends here")
    t.report("E0120", f"unclosed `{opener.text}`", "never closed", at=opener, related=place)


def _can_close(t: Trouble) -> bool:
    opener = t.opener()
    return opener is not None and t.automaton.accepts(OPENERS[opener.type])


def _statement_begins(t: Trouble) -> bool:
    return t.begins_line and (t.token.type in STARTERS or t.begins_field)


def _member_begins(t: Trouble) -> bool:
    """A member in the braces of a constraint, or an item inside any braces."""
    member = t.token.type in MEMBER_WORDS or t.begins_field
    inner = t.block() is not None and not t.in_members
    return (_is_item(t) or (member and inner)) and t.automaton.accepts("RBRACE")


def _is_item(t: Trouble) -> bool:
    return t.token.type in ITEM_WORDS or (t.token.type == "ROOT" and t.is_name(t.ahead()))


def _misplaced_brace(t: Trouble) -> Token | None:
    """Find the unclosed brace from the indentation.

    Closing braces pair with the nearest open one, so the unpaired brace is often not the mistake. A
    brace whose partner is indented less than its own line is.
    """
    source = t.log.source
    stack: list[Token] = []

    def indent(token: Token) -> int:
        line = source.line(source.position(token.start)[0])
        return len(line) - len(line.lstrip())

    for token in t.tokens[: t.index]:
        if token.damaged and token.start == token.end:
            continue
        if token.type == "LBRACE":
            stack.append(token)
        elif token.type == "RBRACE" and stack:
            opener = stack.pop()
            line_start = source.text.rfind("\n", 0, token.start) + 1
            alone = not source.text[line_start : token.start].strip()
            if alone and stack and indent(opener) > token.start - line_start:
                return opener
    return None
