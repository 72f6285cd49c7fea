"""Statements that are not separated, or are written as in other languages."""

from __future__ import annotations

from arael.syntax.mistakes.table import Mistake, is_kind
from arael.syntax.trouble import Trouble

_EQUAL = ("E0135", "a comparison is written `==`", "`=` gives a value to a name")


def _no_construct(t: Trouble) -> bool:
    return t.construct() is None


def _second_equal(t: Trouble) -> bool:
    return t.in_body or t.construct() is not None


def _statement_begins(t: Trouble) -> bool:
    """A word that begins a statement; a word of any kind among members."""
    if is_kind(t, t.token, "starter"):
        return True
    among = t.in_members or t.opener() is None
    return (among and t.token.type == "ROOT") or (t.in_members and t.is_word(t.token))


ROWS = (
    Mistake(
        "E0135", "a `let` takes no type", help="omit it: the type is that of the value",
        token="COLON", within="LET", expected="EQUAL", repair="skip_to EQUAL",
    ),
    Mistake(
        "E0135", "`{before}` does not belong in a `let`", help="write `let {token} = ...`",
        place="before", token="word", last=True, within="LET", expected="EQUAL", begins=False,
        repair="pop",
    ),
    *(
        Mistake(
            "E0135", "`=` is missing in this `{construct}`", "expected `=` and a value after this",
            help="write `{construct} {before} = ...`", place="before",
            token=token, construct="LET CONST SYMBOLIC COMPUTE", expected="EQUAL", operand=False,
            repair=repair,
        )
        for token, repair in (
            ("end", "insert EQUAL NUMBER"), ("EQ", "swap EQUAL"), ("", "insert EQUAL"),
        )
    ),
    Mistake(*_EQUAL, token="EQUAL", within="IF WHEN", operand=False, repair="swap EQ"),
    *(
        Mistake(
            "E0135", "a value gets its name with `let`", help=f"write `let {name} = ...`",
            place="before..token", token="EQUAL", before=before, part="body", operand=False,
            when=_no_construct,
        )
        for before, name in (("name", "{before}"), ("", "name"))
    ),
    Mistake(
        "E0135", "a second `=` in one statement",
        help="end the line before it, or write `==` to compare",
        token="EQUAL", operand=False, when=_second_equal,
    ),
    Mistake(
        "E0135", "a constraint has no `return`",
        help="omit it: the last expression is the residual",
        place="before", before="NAME", before_text="return", last=True, part="body", begins=False,
        when=_no_construct, repair="pop",
    ),
    Mistake(
        "E0135", "arael has no loops, and no `{before}`",
        help="a constraint is evaluated separately for each element: put it in the element's "
        "struct, or use `fit collection as e {{ ... }}` in the root",
        place="before", before="NAME", before_text="for while foreach loop", last=True, part="body",
        begins=False, when=_no_construct,
    ),
    Mistake(
        "E0135", "a value gets its name with `let`", help="write `let {token} = ...`",
        place="before", before="NAME", before_text="var const auto val double float int real",
        last=True, part="body", begins=False, when=_no_construct, repair="pop; insert LET",
    ),
    Mistake(
        "E0122", "two statements on one line", "a new statement begins here",
        help="begin a new line, or write `;` between them",
        related=("before", "the one before ends here"),
        accepted="_NEWLINE", begins=False, when=_statement_begins, repair="insert SEMICOLON",
    ),
)  # fmt: skip
