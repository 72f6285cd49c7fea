"""Brackets that are not closed, not opened, or of the wrong kind."""

from __future__ import annotations

from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, OPENERS, Token
from arael.syntax.trouble import ITEM_WORDS, MEMBER_WORDS, STARTERS, Trouble


def unopened(t: Trouble) -> bool:
    """``}`` where nothing is open."""
    if t.token.type not in CLOSERS or t.opener() is not None:
        return False
    token = t.token
    t.log.error(
        "E0121",
        f"unmatched `{token.text}`",
        token.start,
        token.end,
        "closes nothing",
        help="delete it, or open its partner before",
    )
    t.skip()
    return True


def wrong_kind(t: Trouble) -> bool:
    """Recognise ``(a, b]``: closed by another bracket than the one that is open."""
    opener = t.opener()
    if t.token.type not in CLOSERS or opener is None or OPENERS[opener.type] == t.token.type:
        return False
    token, wanted = t.token, OPENERS[opener.type]
    if opener.type == "LBRACE":
        t.log.error(
            "E0121",
            f"unmatched `{token.text}`",
            token.start,
            token.end,
            "closes nothing",
            help="delete it, or open its partner before",
        )
        t.skip()
        return True
    if not t.automaton.accepts(wanted):
        return False
    if token.type == "RBRACE":
        return _unclosed(t, opener)
    t.log.error(
        "E0121",
        f"`{opener.text}` is closed by `{token.text}`",
        token.start,
        token.end,
        f"expected `{_closer(opener)}`",
        labels=[_opened(opener)],
    )
    t.swap(wanted)
    return True


def unclosed_round(t: Trouble) -> bool:
    """Recognise a statement begins while ``(`` or ``[`` is open."""
    opener = t.opener()
    if opener is None or opener.type == "LBRACE" or not t.begins_line:
        return False
    field = t.is_name(t.token) and t.ahead().type == "COLON"
    if t.token.type not in STARTERS and not field:
        return False
    if t.automaton.accepts(OPENERS[opener.type]):
        return _unclosed(t, opener)
    _say_unclosed(t, opener)
    t.panic()
    return True


def unclosed_body(t: Trouble) -> bool:
    """Recognise a member begins in the braces of a constraint, or an item inside any braces."""
    if not t.begins_line or t.opener() is None or t.opener().type != "LBRACE":  # type: ignore[union-attr]
        return False
    kind, after = t.token.type, t.ahead().type
    item = kind in ITEM_WORDS or (kind == "ROOT" and t.is_name(t.ahead()))
    member = kind in MEMBER_WORDS or (t.is_name(t.token) and after == "COLON")
    inner = t.block() is not None and not t.in_members
    if not (item or (member and inner)):
        return False
    if not t.automaton.accepts("RBRACE"):
        return False
    opener = t.opener()
    assert opener is not None
    suspect = _suspect(t) or opener
    _say_unclosed(t, suspect)
    braces = sum(1 for _, token in t.held() if token.type == "LBRACE") if item else 1
    for _, token in t.held():
        if token.type == "LBRACE":
            token.damaged = True
    t.insert(*["RBRACE"] * braces, "_NEWLINE")
    return True


def unclosed_at_end(t: Trouble) -> bool:
    """Recognise the text ends while a bracket is open."""
    opener = t.opener()
    if t.token.type != END or opener is None:
        return False
    _say_unclosed(t, _suspect(t) or opener)
    return True


def _unclosed(t: Trouble, opener: Token) -> bool:
    _say_unclosed(t, opener)
    if t.token.type == "RBRACE":
        t.insert(OPENERS[opener.type])
    else:
        t.insert(OPENERS[opener.type], "_NEWLINE")
    return True


def _say_unclosed(t: Trouble, opener: Token) -> None:
    before = t.before or opener
    here = t.token
    label = "the file ends here" if here.type == END else "expected before this"
    start, end = (before.end, before.end) if here.type == END else (here.start, here.end)
    t.log.error(
        "E0120",
        f"unclosed `{opener.text}`",
        opener.start,
        opener.end,
        "never closed",
        labels=[(start, end, f"`{_closer(opener)}` {label}" if here.type != END else label)],
    )


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


def _opened(opener: Token) -> tuple[int, int, str]:
    return opener.start, opener.end, "opened here"


def _closer(opener: Token) -> str:
    return {"(": ")", "[": "]", "{": "}"}[opener.text]


RECOGNISERS = (unopened, wrong_kind, unclosed_round, unclosed_body, unclosed_at_end)
