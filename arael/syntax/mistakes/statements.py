"""Statements that are not separated, or are written as in other languages."""

from __future__ import annotations

from arael.syntax.tables import END
from arael.syntax.tokens import NEWLINE
from arael.syntax.trouble import STARTERS, Trouble


def typed_let(t: Trouble) -> bool:
    """``let x: vec3 = ...``."""
    if t.token.type != "COLON" or t.within("LET") is None or "EQUAL" not in t.expected:
        return False
    t.log.error(
        "E0135",
        "a `let` takes no type",
        t.token.start,
        t.token.end,
        help="omit it: the type is that of the value",
    )
    t.skip_to("EQUAL")
    return True


def let_word(t: Trouble) -> bool:
    """``let mut x = ...``."""
    top = t.top
    if t.within("LET") is None or top is None or "EQUAL" not in t.expected or top is not t.before:
        return False
    if not t.is_word(t.token) or t.begins_line:
        return False
    t.log.error(
        "E0135",
        f"`{top.text}` does not belong in a `let`",
        top.start,
        top.end,
        help=f"write `let {t.token.text} = ...`",
    )
    t.automaton.pop(1)
    return True


def missing_equal(t: Trouble) -> bool:
    """``let x`` or ``let x a + b``."""
    construct = t.construct()
    if construct is None or construct.type not in ("LET", "CONST", "SYMBOLIC", "COMPUTE"):
        return False
    if "EQUAL" not in t.expected or t.before is None or t.wants_operand:
        return False
    before = t.before
    t.log.error(
        "E0135",
        f"`=` is missing in this `{construct.text}`",
        before.start,
        before.end,
        "expected `=` and a value after this",
        help=f"write `{construct.text} {before.text} = ...`",
    )
    if t.begins_line or t.token.type in (NEWLINE, "SEMICOLON", "RBRACE", END):
        t.insert("EQUAL", "NUMBER")
    elif t.token.type in ("EQ",):
        t.swap("EQUAL")
    else:
        t.insert("EQUAL")
    return True


def assignment(t: Trouble) -> bool:
    """``x = ...`` in a constraint, and ``if a = b``."""
    if t.token.type != "EQUAL" or t.wants_operand or t.before is None:
        return False
    token = t.token
    if t.within("IF", "WHEN"):
        t.log.error(
            "E0135",
            "a comparison is written `==`",
            token.start,
            token.end,
            "`=` gives a value to a name",
        )
        t.swap("EQ")
        return True
    if t.in_body and t.construct() is None:
        t.log.error(
            "E0135",
            "a value gets its name with `let`",
            t.before.start,
            token.end,
            help=f"write `let {t.before.text} = ...`"
            if t.is_name(t.before)
            else "write `let name = ...`",
        )
        t.panic()
        return True
    if t.in_body or t.construct() is not None:
        t.log.error(
            "E0135",
            "a second `=` in one statement",
            token.start,
            token.end,
            help="end the line before it, or write `==` to compare",
        )
        t.panic()
        return True
    return False


def foreign_statement(t: Trouble) -> bool:
    """``return x``, ``for x in y``, ``while``."""
    word = t.top
    if word is None or word.type != "NAME" or not t.in_body or t.begins_line:
        return False
    if word is not t.before or t.construct() is not None:
        return False
    if word.text == "return":
        t.log.error(
            "E0135",
            "a constraint has no `return`",
            word.start,
            word.end,
            help="omit it: the last expression is the residual",
        )
        t.automaton.pop(1)
        return True
    if word.text in ("for", "while", "foreach", "loop"):
        t.log.error(
            "E0135",
            f"arael has no loops, and no `{word.text}`",
            word.start,
            word.end,
            help="a constraint is evaluated separately for each element: put it in the element's "
            "struct, or use `fit collection as e { ... }` in the root",
        )
        t.panic()
        return True
    if word.text in ("var", "const", "auto", "val", "double", "float", "int", "real"):
        t.log.error(
            "E0135",
            "a value gets its name with `let`",
            word.start,
            word.end,
            help=f"write `let {t.token.text} = ...`",
        )
        t.automaton.pop(1)
        t.insert("LET")
        return True
    return False


def run_together(t: Trouble) -> bool:
    """Two statements on one line, or two operands without an operator."""
    if not t.automaton.accepts("_NEWLINE") or t.before is None or t.begins_line:
        return False
    token, before = t.token, t.before
    starts = STARTERS | {"ROOT"} if t.in_members or t.opener() is None else STARTERS
    if token.type in starts or (t.in_members and (t.is_word(token))):
        t.log.error(
            "E0122",
            "two statements on one line",
            token.start,
            token.end,
            "a new statement begins here",
            labels=[(before.start, before.end, "the one before ends here")],
            help="begin a new line, or write `;` between them",
        )
        t.insert("SEMICOLON")
        return True
    return False


RECOGNISERS = (typed_let, let_word, missing_equal, assignment, foreign_statement, run_together)
