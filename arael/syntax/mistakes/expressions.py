"""Formulas: missing operands and operators, comparisons in a chain, conditions."""

from __future__ import annotations

from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS
from arael.syntax.trouble import STARTERS, Trouble

_COMPARISONS = frozenset(["EQ", "NE", "LT", "LE", "GT", "GE"])
_OPERATORS = (
    frozenset(
        [
            "PLUS",
            "MINUS",
            "STAR",
            "SLASH",
            "DOTSTAR",
            "DOTSLASH",
            "CARET",
            "AND",
            "OR",
            "NOT",
            "EQUAL",
            "COMMA",
        ]
    )
    | _COMPARISONS
)
_OPERANDS = frozenset(
    ["NAME", "NUMBER", "STRING", "TRUE", "FALSE", "SELF", "PARENT", "ROOT", "LPAR", "IF", "NOT"]
)


def chained_comparison(t: Trouble) -> bool:
    """Recognise ``a < b < c``."""
    if t.token.type not in _COMPARISONS or t.wants_operand:
        return False
    t.log.error(
        "E0134",
        "comparisons do not chain",
        t.token.start,
        t.token.end,
        "second comparison",
        help="write `a < b and b < c`",
    )
    t.swap("AND")
    return True


def ternary(t: Trouble) -> bool:
    """``cond ? a : b``."""
    if t.token.type != "QUESTION" or not t.automaton.accepts("PLUS"):
        return False
    t.log.error(
        "E0137",
        "arael has no `? :`",
        t.token.start,
        t.token.end,
        help="write `if COND then A else B`",
    )
    t.panic()
    return True


def condition(t: Trouble) -> bool:
    """``if`` without ``then`` or ``else``, or with braces."""
    if t.wants_operand:
        return False
    head = t.within("IF")
    if head is None:
        return False
    missing = next((w for w in ("THEN", "ELSE") if t.automaton.accepts(w)), None)
    if missing is None:
        return False
    word = missing.lower()
    t.log.error(
        "E0137",
        f"`if` without `{word}`",
        t.token.start,
        t.token.end,
        f"expected `{word}` here",
        labels=[(head.start, head.end, "the `if`")],
        help="write `if COND then A else B`",
    )
    if t.token.type in ("LBRACE", "COLON"):
        t.panic()
    elif t.begins_line or t.token.type in {NEWLINE, END, *CLOSERS, "SEMICOLON", "COMMA", "ELSE"}:
        t.insert(*(["THEN", "NUMBER"] if missing == "THEN" else ["ELSE", "NUMBER"]))
    else:
        t.insert(missing)
    return True


def quoted(t: Trouble) -> bool:
    """``'text'``: a transpose sign in place of an operand."""
    if t.token.type != "QUOTE" or not (t.wants_operand or "STRING" in t.expected):
        return False
    line = t.line_tokens()
    closing = next((n for n, x in enumerate(line[1:], 1) if x.type == "QUOTE"), None)
    if closing is None:
        t.log.error(
            "E0138",
            "`'` has nothing before it to transpose",
            t.token.start,
            t.token.end,
            "a transpose follows its matrix: `M'`",
        )
        t.skip()
        t.panic()
        return True
    text = t.log.source.text[line[1].start : line[closing - 1].end] if closing > 1 else ""
    t.log.error(
        "E0112",
        'text is quoted with `"`',
        t.token.start,
        line[closing].end,
        "`'` is the transpose",
        help=f'write `"{text}"`',
    )
    t.skip(closing)
    t.swap("STRING")
    token = t.token
    token.text = '""'
    return True


def missing_operand(t: Trouble) -> bool:
    """Recognise an operator, a comma or an ``=`` with nothing after it."""
    if not t.wants_operand or t.before is None:
        return False
    before, token = t.before, t.token
    if token.type == "LET" and not t.begins_line:
        return False
    ends = token.type in {NEWLINE, END, *CLOSERS, "SEMICOLON", "LBRACE", "COMMA", "THEN", "ELSE"}
    if token.type in _OPERATORS and before.type in _OPERATORS:
        t.log.error(
            "E0138",
            f"`{before.text}` is followed by `{token.text}`",
            token.start,
            token.end,
            "expected a value before this",
            labels=[(before.start, before.end, "after this")],
        )
        t.skip()
        return True
    if token.type in _OPERATORS and before.type in OPENERS:
        t.log.error(
            "E0138",
            f"`{token.text}` has nothing before it",
            token.start,
            token.end,
            "expected a value before this",
        )
        t.skip()
        return True
    if not (ends or t.begins_line or token.type in STARTERS):
        return False
    if before.type in OPENERS and token.type in ("RPAR", "RSQB"):
        t.log.error(
            "E0138",
            f"nothing between `{before.text}` and `{token.text}`",
            before.start,
            token.end,
            "expected a value",
        )
    else:
        t.log.error(
            "E0138",
            f"nothing follows `{before.text}`",
            before.start,
            before.end,
            "expected a value after this",
        )
    opener = t.opener()
    if t.begins_line and (opener is None or opener.type == "LBRACE"):
        t.insert("NUMBER", NEWLINE)
    else:
        t.insert("NUMBER")
    return True


def missing_operator(t: Trouble) -> bool:
    """``2 x``, ``a b``: two values side by side."""
    before, token = t.before, t.token
    if before is None or t.wants_operand or token.type not in _OPERANDS:
        return False
    if not (t.automaton.accepts("PLUS") and t.automaton.accepts("STAR")) or t.begins_line:
        return False
    t.log.error(
        "E0136",
        f"no operator between `{before.text}` and `{token.text}`",
        token.start,
        token.end,
        "unexpected second value",
        labels=[(before.start, before.end, "after this value")],
        help="write `*` for a product, or begin a new line for a new statement",
    )
    t.insert("STAR")
    return True


def tilde(t: Trouble) -> bool:
    """``~a`` for ``not a``."""
    if t.token.type != "TILDE" or not t.wants_operand:
        return False
    t.log.error("E0110", "stray character `~`", t.token.start, t.token.end, "write `not`")
    t.swap("NOT")
    return True


RECOGNISERS = (
    tilde,
    quoted,
    chained_comparison,
    ternary,
    condition,
    missing_operand,
    missing_operator,
)
