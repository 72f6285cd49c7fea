"""Brackets that are not closed, not opened, or of the wrong kind."""

from __future__ import annotations

from arael.syntax.mistakes.table import Mistake, Names, span
from arael.syntax.tokens import OPENERS, Token
from arael.syntax.trouble import ITEM_WORDS, MEMBER_WORDS, STARTERS, Trouble

_CLOSER = {"(": ")", "[": "]", "{": "}"}


def _can_close(t: Trouble) -> bool:
    opener = t.opener()
    return opener is not None and t.automaton.accepts(OPENERS[opener.type])


def _other_closer(t: Trouble) -> Names | bool:
    """``(a, b]``: another bracket than the one that is open."""
    opener = t.opener()
    if opener is None or OPENERS[opener.type] == t.token.type or not _can_close(t):
        return False
    return {"closer": _CLOSER[opener.text]}


def _close(t: Trouble) -> None:
    opener = t.opener()
    assert opener is not None
    t.swap(OPENERS[opener.type])


def _unclosed(t: Trouble, opener: Token | None) -> Names | bool:
    """Names for an open bracket, which should be closed before this token."""
    return opener is not None and {
        "open": opener.text,
        "closer": _CLOSER[opener.text],
        **span(opener.start, opener.end),
    }


def _closed_too_late(t: Trouble) -> Names | bool:
    """A ``}`` while a round bracket is open that can be closed."""
    return _can_close(t) and _unclosed(t, t.opener())


def _statement_begins(t: Trouble) -> Names | bool:
    """A statement on a new line, while a round bracket is open."""
    field = t.is_name(t.token) and t.ahead().type == "COLON"
    return (t.token.type in STARTERS or field) and _unclosed(t, t.opener())


def _member_begins(t: Trouble) -> Names | bool:
    """A member in the braces of a constraint, or an item inside any braces."""
    member = t.token.type in MEMBER_WORDS or (t.is_name(t.token) and t.ahead().type == "COLON")
    inner = t.block() is not None and not t.in_members
    if not (_is_item(t) or (member and inner)):
        return False
    return t.automaton.accepts("RBRACE") and _unclosed(t, _suspect(t) or t.opener())


def _is_item(t: Trouble) -> bool:
    return t.token.type in ITEM_WORDS or (t.token.type == "ROOT" and t.is_name(t.ahead()))


def _text_ends(t: Trouble) -> Names | bool:
    return t.opener() is not None and _unclosed(t, _suspect(t) or t.opener())


def _insert_closer(t: Trouble) -> None:
    opener = t.opener()
    assert opener is not None
    t.insert(OPENERS[opener.type], *([] if t.token.type == "RBRACE" else ["_NEWLINE"]))


def _insert_or_give_up(t: Trouble) -> None:
    if _can_close(t):
        _insert_closer(t)
    else:
        t.panic()


def _insert_braces(t: Trouble) -> None:
    open_ = [token for _, token in t.held() if token.type == "LBRACE"]
    for token in open_:
        token.damaged = True
    t.insert(*["RBRACE"] * (len(open_) if _is_item(t) else 1), "_NEWLINE")


def _nothing(t: Trouble) -> None:
    """Leave the tokens: at the end of the text there is nothing to read."""


def _suspect(t: Trouble) -> Token | None:
    """Find the unclosed brace from the indentation.

    Closing braces pair with the nearest open one, so the unpaired brace is often not the mistake. A
    brace whose partner is indented less than its own line is.
    """
    text = t.log.source.text
    position = t.log.source.position
    stack: list[Token] = []

    def indent(token: Token) -> int:
        line, _ = position(token.start)
        whole = t.log.source.line(line)
        return len(whole) - len(whole.lstrip())

    for token in t.tokens[: t.index]:
        if token.damaged and token.start == token.end:
            continue
        if token.type == "LBRACE":
            stack.append(token)
        elif token.type == "RBRACE" and stack:
            opener = stack.pop()
            line_start = text.rfind("\n", 0, token.start) + 1
            alone = not text[line_start : token.start].strip()
            if alone and stack and indent(opener) > token.start - line_start:
                return opener
    return None


_UNCLOSED = ("E0120", "unclosed `{open}`", "never closed")
_BEFORE_THIS = ("token", "`{closer}` expected before this")
_UNMATCHED = ("E0121", "unmatched `{token}`", "closes nothing")
_NO_PARTNER = "delete it, or open its partner before"

ROWS = (
    Mistake(*_UNMATCHED, help=_NO_PARTNER, token="closer", opener="none", repair="skip"),
    Mistake(*_UNMATCHED, help=_NO_PARTNER, token="RPAR RSQB", opener="LBRACE", repair="skip"),
    Mistake(
        *_UNCLOSED, place="span", related=_BEFORE_THIS,
        token="RBRACE", opener="LPAR LSQB", when=_closed_too_late, repair=_insert_closer,
    ),
    Mistake(
        "E0121", "`{opener}` is closed by `{token}`", "expected `{closer}`",
        related=("opener", "opened here"),
        token="RPAR RSQB", opener="LPAR LSQB", when=_other_closer, repair=_close,
    ),
    Mistake(
        *_UNCLOSED, place="span", related=_BEFORE_THIS,
        opener="LPAR LSQB", begins=True, when=_statement_begins, repair=_insert_or_give_up,
    ),
    Mistake(
        *_UNCLOSED, place="span", related=_BEFORE_THIS,
        opener="LBRACE", begins=True, when=_member_begins, repair=_insert_braces,
    ),
    Mistake(
        *_UNCLOSED, place="span", related=("after", "the file ends here"),
        token="eof", when=_text_ends, repair=_nothing,
    ),
)  # fmt: skip
