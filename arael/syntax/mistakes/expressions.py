"""Formulas: missing operands and operators, comparisons in a chain, conditions."""

from __future__ import annotations

from functools import partial

from arael.syntax.mistakes.table import Mistake, Names, is_kind, span
from arael.syntax.tokens import NEWLINE
from arael.syntax.trouble import Trouble

_WRITE_IF = "write `if COND then A else B`"
_operator = partial(Mistake, label="expected a value before this", token="operator", operand=True)
_NOTHING_ENDS = "newline eof closer SEMICOLON LBRACE COMMA THEN ELSE"


def _quoted(t: Trouble) -> Names | bool:
    """``'text'``: two transpose signs on one line."""
    line = t.line_tokens()
    closing = _closing(t)
    if closing == 0 or not _text_fits(t):
        return False
    text = t.log.source.text[line[1].start : line[closing - 1].end] if closing > 1 else ""
    return {"quoted": text, **span(t.token.start, line[closing].end)}


def _text_fits(t: Trouble) -> bool:
    return t.wants_operand or "STRING" in t.expected


def _closing(t: Trouble) -> int:
    """Number of the second ``'`` on this line; 0 if there is none."""
    line = t.line_tokens()
    return next((n for n, x in enumerate(line[1:], 1) if x.type == "QUOTE"), 0)


def _read_as_text(t: Trouble) -> None:
    t.skip(_closing(t))
    t.swap("STRING")
    t.token.text = '""'


def _missing_word(t: Trouble) -> Names | bool:
    """An ``if`` without ``then`` or ``else``."""
    missing = next((w for w in ("THEN", "ELSE") if t.automaton.accepts(w)), None)
    return missing is not None and {"missing": missing.lower()}


def _insert_word(t: Trouble) -> None:
    missing = "THEN" if t.automaton.accepts("THEN") else "ELSE"
    if is_kind(t, t.token, "LBRACE COLON"):
        t.panic()
    elif t.begins_line or is_kind(t, t.token, "newline eof closer SEMICOLON COMMA ELSE"):
        t.insert(missing, "NUMBER")
    else:
        t.insert(missing)


def _value_missing(t: Trouble) -> bool:
    ends = is_kind(t, t.token, _NOTHING_ENDS) or t.begins_line or is_kind(t, t.token, "starter")
    return ends and not _misplaced_let(t)


def _not_let(t: Trouble) -> bool:
    return not _misplaced_let(t)


def _misplaced_let(t: Trouble) -> bool:
    return t.before is None or (t.token.type == "LET" and not t.begins_line)


def _insert_number(t: Trouble) -> None:
    opener = t.opener()
    statement = t.begins_line and (opener is None or opener.type == "LBRACE")
    t.insert("NUMBER", *([NEWLINE] if statement else []))


ROWS = (
    Mistake(
        "E0110", "stray character `~`", "write `not`",
        token="TILDE", operand=True, repair="swap NOT",
    ),
    Mistake(
        "E0112", 'text is quoted with `"`', "`'` is the transpose", help='write `"{quoted}"`',
        place="span", token="QUOTE", when=_quoted, repair=_read_as_text,
    ),
    Mistake(
        "E0138", "`'` has nothing before it to transpose", "a transpose follows its matrix: `M'`",
        token="QUOTE", when=_text_fits, repair="skip; panic",
    ),
    Mistake(
        "E0134", "comparisons do not chain", "second comparison", help="write `a < b and b < c`",
        token="comparison", operand=False, repair="swap AND",
    ),
    Mistake(
        "E0137", "arael has no `? :`", help=_WRITE_IF, token="QUESTION", accepted="PLUS",
    ),
    Mistake(
        "E0137", "`if` without `{missing}`", "expected `{missing}` here", help=_WRITE_IF,
        related=("IF", "the `if`"),
        within="IF", operand=False, when=_missing_word, repair=_insert_word,
    ),
    _operator(
        "E0138", "`{before}` is followed by `{token}`", related=("before", "after this"),
        before="operator", repair="skip",
    ),
    _operator("E0138", "`{token}` has nothing before it", before="opener", repair="skip"),
    Mistake(
        "E0138", "nothing between `{before}` and `{token}`", "expected a value",
        place="before..token", before="opener", token="RPAR RSQB", operand=True,
        when=_not_let, repair=_insert_number,
    ),
    Mistake(
        "E0138", "nothing follows `{before}`", "expected a value after this", place="before",
        operand=True, when=_value_missing, repair=_insert_number,
    ),
    Mistake(
        "E0136", "no operator between `{before}` and `{token}`", "unexpected second value",
        help="write `*` for a product, or begin a new line for a new statement",
        related=("before", "after this value"),
        token="operand", accepted="PLUS STAR", operand=False, begins=False,
        when=lambda t: t.before is not None, repair="insert STAR",
    ),
)  # fmt: skip
