"""Headers of structs, constraints, functions and passes, and text outside of them."""

from __future__ import annotations

from functools import partial

from arael.syntax.mistakes.table import Mistake, Names, is_kind, span
from arael.syntax.trouble import Trouble

_ITEM_WORDS = ("import", "const", "fn", "extern", "struct", "root", "component")
_OTHER_ITEMS = {
    "class": "struct", "entity": "struct", "record": "struct", "object": "struct",
    "model": "root", "problem": "root", "main": "root", "def": "fn", "func": "fn",
    "function": "fn", "include": "import", "from": "import", "using": "import", "let": "const",
    "define": "const", "constant": "const", "param": "root",
}  # fmt: skip
_CLAUSES = "CONSTRAINT FIT WHEN LOSS INTO"
_OTHERS = (
    "STRUCT ROOT COMPONENT SOLVE PASS UPDATE FN CONST IMPORT LET KEY PARAM SKIP MARGINALIZE FREEZE "
    "FREE SYMBOLIC COMPUTE DERIVS REF BLOCK IF"
)


def _at_item(t: Trouble) -> bool:
    return t.construct() is None


def _brace_follows(t: Trouble) -> bool:
    return any(x.type == "LBRACE" for x in t.line_tokens()[1:])


def _head(t: Trouble) -> Names:
    head = t.within("CONSTRAINT", "FIT")
    assert head is not None
    return {"head": head.text}


def _no_comparison(t: Trouble) -> bool:
    return not is_kind(t, t.token, "comparison newline RBRACE")


def _base(t: Trouble) -> Names:
    """``struct A : B``: the colon and the name."""
    base = t.ahead()
    precision = base.text in ("f32", "f64")
    return {
        "advice": "the precision belongs to the root, `root NAME : f32`"
        if precision
        else "there is no inheritance; declare the other struct as a field",
        **span(t.token.start, base.end if t.is_word(base) else t.token.end),
    }


def _insert_braces(t: Trouble) -> None:
    field = t.is_name(t.token) and t.ahead().type == "COLON"
    root = t.token.type == "ROOT" and t.is_name(t.ahead())
    elsewhere = is_kind(t, t.token, "item member RBRACE") or field or root
    if t.begins_line and elsewhere:
        t.insert("LBRACE", "RBRACE", "_NEWLINE")
    elif t.begins_line:
        t.insert("LBRACE")
    else:
        t.panic()


def _insert_loss(t: Trouble) -> None:
    if t.ahead().type == "LPAR":
        t.insert("LOSS")
    else:
        t.swap("LOSS")


def _to_brace(t: Trouble) -> None:
    if any(x.type == "LBRACE" for x in t.line_tokens()):
        t.skip_to("LBRACE")
    else:
        t.panic()


def _to_brace_if_it_fits(t: Trouble) -> None:
    if any(x.type == "LBRACE" for x in t.line_tokens()):
        t.skip_to("LBRACE")
        if not t.automaton.accepts("LBRACE"):
            t.panic()
    else:
        t.skip()
        t.panic()


def _skip_body(t: Trouble) -> None:
    t.skip()
    depth = 1
    while depth and t.token is not t.tokens[-1]:
        depth += {"LBRACE": 1, "RBRACE": -1}.get(t.token.type, 0)
        t.skip()
    t.insert("EQUAL", "NUMBER")


_TOO_EARLY = "a `}}` before it may have closed the struct too early"
_BELONGS = "belongs in the braces of a struct or root"


# At the top of the file; between a name and its `{`; in the clauses of a constraint.
_item = partial(Mistake, opener="none", accepted="STRUCT", when=_at_item)
_header = partial(Mistake, expected="LBRACE", operand=False)
_clause = partial(_header, construct=_CLAUSES)

_OUTSIDE = (
    *(
        _item(
            "E0140", "`{token}` outside of a struct", _BELONGS, help=_TOO_EARLY, ahead=ahead,
            token="PARAM CONSTRAINT FIT SOLVE KEY MARGINALIZE UPDATE SYMBOLIC COMPUTE",
            repair="skip; panic",
        )
        for ahead in ("word", "LBRACE")
    ),
    _item(
        "E0140", "a field outside of a struct", _BELONGS, help=_TOO_EARLY,
        token="name", ahead="COLON", repair="skip; panic",
    ),
    _item(
        "E0140", "`let` outside of a constraint",
        help="a value for the whole file is written `const name = ...`",
        token="LET", repair="swap CONST",
    ),
    _item(
        "E0128", "unknown word `{token}`", "did you mean `{meant}`?",
        token="name", ahead="word STRING", meant=_OTHER_ITEMS, near=_ITEM_WORDS,
        repair="swap {meant}",
    ),
    _item(
        "E0128", "`{token}` does not begin an item",
        "expected `struct`, `root`, `fn`, `const` or `import`",
        token="name", repair="skip; panic",
    ),
)  # fmt: skip

_FUNCTIONS = (
    Mistake(
        "E0142", "arguments of a function take no type",
        help="omit it: shapes follow from the call",
        token="COLON", within="FN", when=lambda t: t.within("LPAR") is not None,
        repair="skip_to COMMA RPAR",
    ),
    Mistake(
        "E0142", "a function is one expression, without braces",
        help="write `fn name(x) = expression`; parts of it can be functions too",
        token="LBRACE", within="FN", repair=_skip_body,
    ),
    Mistake(
        "E0142", "a function declares no type", help="write `fn name(x) = expression`",
        token="NAME", before="RPAR", within="FN", repair="skip",
    ),
)  # fmt: skip

_CLAUSE_ROWS = (
    _clause(
        "E0141", "a guard begins with `when`, not `{token}`", "did you mean `when`?",
        token="IF NAME", text="if where unless for guard given", repair="swap WHEN",
    ),
    _clause(
        "E0141", "a robust kernel is named after `loss`",
        help="write for example `loss huber(1.0)`",
        token="NAME", text="robust kernel huber cauchy tukey robustify", repair=_insert_loss,
    ),
    _clause(
        "E0128", "unknown word `{token}`", "did you mean `{meant}`?",
        token="NAME", near=("when", "loss", "into"), repair="swap {meant}",
    ),
    *(
        _clause(
            "E0129", "this {head} has no braces", "expected `{{` after this", place="before",
            token=token, begins=begins, within="CONSTRAINT FIT", when=_head, repair=_insert_braces,
        )
        for token, begins in (("newline RBRACE", None), ("", True))
    ),
    _clause(
        "E0135", "a comparison is written `==`", "`=` gives a value to a name",
        token="EQUAL", within="WHEN", begins=False, repair="swap EQ",
    ),
    _clause(
        "E0129", "several blocks are written in brackets", "not in a list",
        help="write `into [a, b]`", token="COMMA", within="INTO", begins=False, repair=_to_brace,
    ),
    _clause(
        "E0129", "`{token}` does not belong in the header of a constraint",
        "expected `{{` or one of `when`, `loss`, `into`",
        begins=False, when=_no_comparison, repair=_to_brace_if_it_fits,
    ),
)  # fmt: skip

_HEADERS = (
    _header(
        "E0143", "`:` is missing before the precision", help="write `: {token}`",
        text="f32 f64", construct="ROOT", repair="insert COLON",
    ),
    _header(
        "E0129", "a {construct} takes nothing between its name and `{{`", "not in the language",
        help="{advice}", place="span",
        token="COLON", construct="STRUCT COMPONENT", when=_base, repair="skip_to LBRACE",
    ),
    *(
        _header(
            "E0129", "expected `{{` after the header of this {construct}", "does not belong here",
            token=token, begins=begins, construct=_OTHERS, when=when, repair="skip_to LBRACE",
        )
        for token, begins, when in (("", False, _brace_follows), ("LPAR", None, None))
    ),
    _header(
        "E0129", "this {construct} has no braces", "expected `{{` after this", place="before",
        construct=_OTHERS, repair=_insert_braces,
    ),
)  # fmt: skip

ROWS = (*_OUTSIDE, *_FUNCTIONS, *_CLAUSE_ROWS, *_HEADERS)
