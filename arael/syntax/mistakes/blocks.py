"""Headers of structs, constraints, functions and passes, and text outside of them."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.syntax.tokens import NEWLINE, Token
from arael.syntax.trouble import ITEM_WORDS, MEMBER_WORDS, Trouble

_ITEM_WORDS = ("import", "const", "fn", "extern", "struct", "root", "component")
_OTHER_ITEMS = {
    "class": "struct", "entity": "struct", "record": "struct", "object": "struct",
    "model": "root", "problem": "root", "main": "root", "def": "fn", "func": "fn",
    "function": "fn", "include": "import", "from": "import", "using": "import", "let": "const",
    "define": "const", "constant": "const", "param": "root",
}  # fmt: skip
_MEMBER_ONLY = frozenset(
    ["PARAM", "CONSTRAINT", "FIT", "SOLVE", "KEY", "MARGINALIZE", "UPDATE", "SYMBOLIC", "COMPUTE"]
)


def outside(t: Trouble) -> bool:
    """Recognise a member, a field or an unknown word at the top of the file."""
    if t.opener() is not None or t.construct() is not None or not t.automaton.accepts("STRUCT"):
        return False
    token, after = t.token, t.ahead()
    if token.type in _MEMBER_ONLY and (t.is_word(after) or after.type == "LBRACE"):
        t.log.error(
            "E0140",
            f"`{token.text}` outside of a struct",
            token.start,
            token.end,
            "belongs in the braces of a struct or root",
            help="a `}` before it may have closed the struct too early",
        )
        _skip_statement(t)
        return True
    if t.is_name(token) and after.type == "COLON":
        t.log.error(
            "E0140",
            "a field outside of a struct",
            token.start,
            token.end,
            "belongs in the braces of a struct or root",
            help="a `}` before it may have closed the struct too early",
        )
        _skip_statement(t)
        return True
    if token.type == "LET":
        t.log.error(
            "E0140",
            "`let` outside of a constraint",
            token.start,
            token.end,
            help="a value for the whole file is written `const name = ...`",
        )
        t.swap("CONST")
        return True
    if not t.is_name(token):
        return False
    meant = _OTHER_ITEMS.get(token.text) or next(iter(closest(token.text, _ITEM_WORDS)), None)
    if meant and (t.is_word(after) or after.type == "STRING"):
        t.log.error(
            "E0128",
            f"unknown word `{token.text}`",
            token.start,
            token.end,
            f"did you mean `{meant}`?",
        )
        t.swap(meant.upper())
        return True
    t.log.error(
        "E0128",
        f"`{token.text}` does not begin an item",
        token.start,
        token.end,
        "expected `struct`, `root`, `fn`, `const` or `import`",
    )
    _skip_statement(t)
    return True


def _skip_statement(t: Trouble) -> None:
    t.skip()
    t.panic()


def header(t: Trouble) -> bool:
    """Recognise text between a name and its ``{``."""
    construct = t.construct()
    if construct is None or "LBRACE" not in t.expected or t.wants_operand:
        return False
    token = t.token
    if construct.type in ("CONSTRAINT", "FIT", "WHEN", "LOSS", "INTO"):
        return _clause(t, token)
    if construct.type == "ROOT" and token.text in ("f32", "f64"):
        t.log.error(
            "E0143",
            "`:` is missing before the precision",
            token.start,
            token.end,
            help=f"write `: {token.text}`",
        )
        t.insert("COLON")
        return True
    if token.type == "COLON" and construct.type in ("STRUCT", "COMPONENT"):
        base = t.ahead()
        t.log.error(
            "E0129",
            f"a {construct.text} takes nothing between its name and `{{`",
            token.start,
            base.end if t.is_word(base) else token.end,
            "not in the language",
            help="the precision belongs to the root, `root NAME : f32`"
            if base.text in ("f32", "f64")
            else "there is no inheritance; declare the other struct as a field",
        )
        t.skip_to("LBRACE")
        return True
    braces_follow = any(x.type == "LBRACE" for x in t.line_tokens()[1:])
    if (braces_follow and not t.begins_line) or token.type == "LPAR":
        t.log.error(
            "E0129",
            f"expected `{{` after the header of this {construct.text}",
            token.start,
            token.end,
            "does not belong here",
        )
        t.skip_to("LBRACE")
        return True
    return _missing_brace(t, construct)


def _missing_brace(t: Trouble, construct: Token) -> bool:
    before = t.before or construct
    t.log.error(
        "E0129",
        f"this {construct.text} has no braces",
        before.start,
        before.end,
        "expected `{` after this",
    )
    elsewhere = t.token.type in ITEM_WORDS | MEMBER_WORDS | {"RBRACE"}
    elsewhere = elsewhere or (t.is_name(t.token) and t.ahead().type == "COLON")
    elsewhere = elsewhere or (t.token.type == "ROOT" and t.is_name(t.ahead()))
    if t.begins_line and elsewhere:
        t.insert("LBRACE", "RBRACE", "_NEWLINE")
    elif t.begins_line:
        t.insert("LBRACE")
    else:
        t.panic()
    return True


def _clause(t: Trouble, token: Token) -> bool:
    conditions = {"IF": "if", "NAME": token.text}
    word = conditions.get(token.type)
    if word in ("if", "where", "unless", "for", "guard", "given"):
        t.log.error(
            "E0141",
            f"a guard begins with `when`, not `{word}`",
            token.start,
            token.end,
            "did you mean `when`?",
        )
        t.swap("WHEN")
        return True
    if word in ("robust", "kernel", "huber", "cauchy", "tukey", "robustify"):
        t.log.error(
            "E0141",
            "a robust kernel is named after `loss`",
            token.start,
            token.end,
            help="write for example `loss huber(1.0)`",
        )
        if t.ahead().type == "LPAR":
            t.insert("LOSS")
        else:
            t.swap("LOSS")
        return True
    if token.type == "NAME":
        meant = closest(token.text, ("when", "loss", "into"))
        if meant:
            t.log.error(
                "E0128",
                f"unknown word `{token.text}`",
                token.start,
                token.end,
                f"did you mean `{meant[0]}`?",
            )
            t.swap(meant[0].upper())
            return True
    if token.type in (NEWLINE, "RBRACE") or t.begins_line:
        construct = t.within("CONSTRAINT", "FIT")
        return construct is not None and _missing_brace(t, construct)
    if token.type == "EQUAL":
        guard = t.within("WHEN")
        if guard is not None:
            t.log.error(
                "E0135",
                "a comparison is written `==`",
                token.start,
                token.end,
                "`=` gives a value to a name",
            )
            t.swap("EQ")
            return True
    if token.type in ("EQ", "NE", "LT", "LE", "GT", "GE"):
        return False
    if token.type == "COMMA" and t.within("INTO") is not None:
        t.log.error(
            "E0129",
            "several blocks are written in brackets",
            token.start,
            token.end,
            "not in a list",
            help="write `into [a, b]`",
        )
        if any(x.type == "LBRACE" for x in t.line_tokens()):
            t.skip_to("LBRACE")
        else:
            t.panic()
        return True
    label = "expected `{` or one of `when`, `loss`, `into`"
    t.log.error(
        "E0129",
        f"`{token.text}` does not belong in the header of a constraint",
        token.start,
        token.end,
        label,
    )
    if any(x.type == "LBRACE" for x in t.line_tokens()):
        t.skip_to("LBRACE")
        if not t.automaton.accepts("LBRACE"):
            t.panic()
    else:
        t.skip()
        t.panic()
    return True


def function(t: Trouble) -> bool:
    """Typed arguments, arrows and braces of functions."""
    head = t.within("FN")
    if head is None:
        return False
    token = t.token
    if token.type == "COLON" and t.within("LPAR"):
        t.log.error(
            "E0142",
            "arguments of a function take no type",
            token.start,
            token.end,
            help="omit it: shapes follow from the call",
        )
        t.skip_to("COMMA", "RPAR")
        return True
    if token.type == "LBRACE":
        t.log.error(
            "E0142",
            "a function is one expression, without braces",
            token.start,
            token.end,
            help="write `fn name(x) = expression`; parts of it can be functions too",
        )
        t.skip()
        _skip_braces(t)
        t.insert("EQUAL", "NUMBER")
        return True
    if token.type == "NAME" and t.before is not None and t.before.type == "RPAR":
        t.log.error(
            "E0142",
            "a function declares no type",
            token.start,
            token.end,
            help="write `fn name(x) = expression`",
        )
        t.skip()
        return True
    return False


def _skip_braces(t: Trouble) -> None:
    depth = 1
    while depth and t.token is not t.tokens[-1]:
        depth += {"LBRACE": 1, "RBRACE": -1}.get(t.token.type, 0)
        t.skip()


RECOGNISERS = (outside, function, header)
