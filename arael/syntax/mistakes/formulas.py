"""Formulas and the statements in a constraint."""

from __future__ import annotations

from arael.syntax.tables import END
from arael.syntax.tokens import CLOSERS, NEWLINE, OPENERS
from arael.syntax.trouble import STARTERS, Trouble

_WRITE_IF = "write `if COND then A else B`"
_COMPARISONS = {"EQ", "NE", "LT", "LE", "GT", "GE"}
_OPERATORS = _COMPARISONS | {
    "PLUS", "MINUS", "STAR", "SLASH", "DOTSTAR", "DOTSLASH", "CARET", "AND", "OR", "NOT", "EQUAL",
    "COMMA",
}  # fmt: skip
_OPERANDS = {
    "NAME", "NUMBER", "STRING", "TRUE", "FALSE", "SELF", "PARENT", "ROOT", "LPAR", "IF", "NOT",
}  # fmt: skip
_ENDS = {*CLOSERS, NEWLINE, END, "SEMICOLON", "COMMA"}


def equal(t: Trouble) -> bool:
    """``=`` where a comparison or a ``let`` is meant."""
    if t.token.type != "EQUAL" or t.wants_operand:
        return False
    if t.within("IF", "WHEN") is not None:
        t.report("E0135", "a comparison is written `==`", "`=` gives a value to a name")
        t.swap("EQ")
        return True
    block = t.block()
    if block is not None and block.type == "REQUIRE" and t.construct() is None:
        t.report(
            "E0135",
            "a comparison is written `==`",
            "`=` gives a value to a name",
            help="write `==` for what must hold, or `let name = ...` for a value",
        )
        t.swap("EQ")
        return True
    if t.in_body and t.construct() is None and t.before is not None:
        name = t.before.text if t.is_name(t.before) else "name"
        t.report(
            "E0135",
            "a value gets its name with `let`",
            at=(t.before.start, t.token.end),
            help=f"write `let {name} = ...`",
        )
    elif t.in_body or t.construct() is not None:
        t.report(
            "E0135",
            "a second `=` in one statement",
            help="end the line before it, or write `==` to compare",
        )
    else:
        return False
    t.panic()
    return True


def word_of_programs(t: Trouble) -> bool:
    """``return x``, ``for p in poses``, ``double y = x`` in a constraint."""
    word = t.last
    if word is None or word.type != "NAME" or not t.in_body or t.begins_line:
        return False
    if t.construct() is not None:
        return False
    if word.text == "return":
        t.report(
            "E0135",
            "a constraint has no `return`",
            at=word,
            help="omit it: the last expression is the residual",
        )
        t.automaton.pop(1)
    elif word.text in ("for", "while"):
        t.report(
            "E0135",
            f"arael has no loops, and no `{word.text}`",
            at=word,
            help="a constraint is evaluated separately for each element: put it in the element's "
            "struct, or use `fit collection as e { ... }` in the root",
        )
        t.panic()
    elif t.is_name(t.token) and t.ahead().type == "EQUAL":
        t.report(
            "E0135",
            "a value gets its name with `let`",
            at=word,
            help=f"write `let {t.token.text} = ...`",
        )
        t.automaton.pop(1)
        t.insert("LET")
    else:
        return False
    return True


def two_statements(t: Trouble) -> bool:
    """``x: real y: real``: a statement begins where another one has not ended."""
    among = t.in_members or t.opener() is None
    starts = (
        t.token.type in STARTERS
        or (among and t.token.type == "ROOT")
        or (t.in_members and t.is_word(t.token))
    )
    if not starts or t.begins_line or t.before is None or not t.automaton.accepts(NEWLINE):
        return False
    t.report(
        "E0122",
        "two statements on one line",
        "a new statement begins here",
        help="begin a new line, or write `;` between them",
        related=(t.before, "the one before ends here"),
    )
    t.insert("SEMICOLON")
    return True


def quoted(t: Trouble) -> bool:
    """``'text'``: two transpose signs on one line."""
    if t.token.type != "QUOTE" or not (t.wants_operand or "STRING" in t.expected):
        return False
    line = t.line_tokens()
    closing = next((n for n, x in enumerate(line[1:], 1) if x.type == "QUOTE"), 0)
    if not closing:
        t.report(
            "E0138",
            "`'` has nothing before it to transpose",
            "a transpose follows its matrix: `M'`",
        )
        t.skip()
        t.panic()
        return True
    text = t.log.source.text[t.token.end : line[closing].start]
    t.report(
        "E0112",
        'text is quoted with `"`',
        "`'` is the transpose",
        at=(t.token.start, line[closing].end),
        help=f'write `"{text}"`',
    )
    t.skip(closing)
    t.swap("STRING")
    t.token.text = '""'
    return True


def chained_comparison(t: Trouble) -> bool:
    """``0 < x < 1``."""
    if t.token.type not in _COMPARISONS or t.wants_operand:
        return False
    t.report(
        "E0134",
        "comparisons do not chain",
        "second comparison",
        help="write `a < b and b < c`",
    )
    t.swap("AND")
    return True


def condition(t: Trouble) -> bool:
    """``x > 0 ? a : b``, or an ``if`` without ``then`` or ``else``."""
    if t.token.type == "QUESTION" and t.automaton.accepts("PLUS"):
        t.report("E0137", "arael has no `? :`", help=_WRITE_IF)
        t.panic()
        return True
    word = t.within("IF")
    missing = next((w for w in ("THEN", "ELSE") if t.automaton.accepts(w)), None)
    if word is None or missing is None or t.wants_operand:
        return False
    t.report(
        "E0137",
        f"`if` without `{missing.lower()}`",
        f"expected `{missing.lower()}` here",
        help=_WRITE_IF,
        related=(word, "the `if`"),
    )
    if t.token.type in ("LBRACE", "COLON"):
        t.panic()
    elif t.begins_line or t.token.type in _ENDS or t.token.type == "ELSE":
        t.insert(missing, "NUMBER")
    else:
        t.insert(missing)
    return True


def missing_operand(t: Trouble) -> bool:
    """``x + * y``, ``f()``, ``x +`` at the end: no value where one should be."""
    before, token = t.before, t.token
    if not t.wants_operand or before is None or (token.type == "LET" and not t.begins_line):
        return False
    if token.type in _OPERATORS and before.type in _OPERATORS:
        t.report(
            "E0138",
            f"`{before.text}` is followed by `{token.text}`",
            "expected a value before this",
            related=(before, "after this"),
        )
        t.skip()
    elif token.type in _OPERATORS and before.type in OPENERS:
        t.report("E0138", f"`{token.text}` has nothing before it", "expected a value before this")
        t.skip()
    elif token.type in ("RPAR", "RSQB") and before.type in OPENERS:
        t.report(
            "E0138",
            f"nothing between `{before.text}` and `{token.text}`",
            "expected a value",
            at=(before.start, token.end),
        )
        t.insert("NUMBER")
    elif token.type in (*_ENDS, "LBRACE", "THEN", "ELSE", *STARTERS) or t.begins_line:
        t.report(
            "E0138", f"nothing follows `{before.text}`", "expected a value after this", at=before
        )
        opener = t.opener()
        ends = t.begins_line and (opener is None or opener.type == "LBRACE")
        t.insert("NUMBER", *([NEWLINE] if ends else []))
    else:
        return False
    return True


def missing_operator(t: Trouble) -> bool:
    """``2 x``: two values side by side."""
    before = t.before
    if t.token.type not in _OPERANDS or t.wants_operand or t.begins_line or before is None:
        return False
    if not (t.automaton.accepts("PLUS") and t.automaton.accepts("STAR")):
        return False
    t.report(
        "E0136",
        f"no operator between `{before.text}` and `{t.token.text}`",
        "unexpected second value",
        help="write `*` for a product, or begin a new line for a new statement",
        related=(before, "after this value"),
    )
    t.insert("STAR")
    return True
