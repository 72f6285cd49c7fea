"""Names, items, functions, and headers of constraints and other blocks."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.syntax.tokens import NEWLINE
from arael.syntax.trouble import NAMES, Trouble

# What a word declares, where a name must follow it.
_NAMED = {
    "struct": "struct", "root": "root", "component": "component", "constraint": "constraint",
    "require": "require", "param": "parameter", "let": "value", "const": "constant",
    "fn": "function", "pass": "pass", "symbolic": "value", "compute": "value", "as": "element",
    "key": "field",
}  # fmt: skip
_EXAMPLES = {"constraint": "constraint drift { ... }", "struct": "struct Pose { ... }"}
_MEANINGS = {
    "root": "the root of the model in expressions",
    "self": "the entity itself in expressions",
    "parent": "the entity that contains this one in expressions",
}
_ITEMS = ("import", "const", "fn", "extern", "struct", "root", "component")
_OTHER_ITEMS = {
    "class": "struct",
    "model": "root",
    "def": "fn",
    "function": "fn",
    "include": "import",
}
_ONLY_MEMBERS = {"PARAM", "CONSTRAINT", "REQUIRE", "FIT", "SOLVE", "KEY", "MARGINALIZE", "UPDATE"}
_WITH_BRACES = (
    "STRUCT", "ROOT", "COMPONENT", "CONSTRAINT", "REQUIRE", "FIT", "SOLVE", "PASS", "UPDATE",
)  # fmt: skip


def reserved_word(t: Trouble) -> bool:
    """``param in: real``: a reserved word in place of a name."""
    word, before = t.token, t.before
    if "NAME" not in t.expected or not word.text.isidentifier() or word.type in NAMES:
        return False
    if before is not None and before.type in ("COLON", "OF"):
        return False
    if t.wants_operand and (t.begins_line or word.type in ("THEN", "ELSE", "OF", "AS")):
        return False
    if t.automaton.accepts(NEWLINE) and t.ahead().type != "COLON":
        return False
    meaning = _MEANINGS.get(word.text)
    t.report(
        "E0125",
        f"`{word.text}` is a reserved word",
        "cannot be a name",
        note=f"`{word.text}` is {meaning}" if meaning else "",
        help=f"choose another name, for example `{word.text}_`",
    )
    t.swap("NAME")
    return True


def missing_name(t: Trouble) -> bool:
    """``constraint { ... }``, ``struct 3 { ... }``: no name after a word that needs one."""
    before = t.last
    if before is None or before.text not in _NAMED or "NAME" not in t.expected or t.wants_operand:
        return False
    what = f"the {_NAMED[before.text]} needs a name"
    if t.token.type in ("NUMBER", "STRING"):
        t.report("E0124", what, "this is not a name", help="a name starts with a letter")
        t.swap("NAME")
        return True
    example = _EXAMPLES.get(before.text)
    t.report(
        "E0124",
        f"`{before.text}` without a name",
        f"{what} after this",
        at=before,
        help=f"write for example `{example}`" if example else "",
    )
    t.insert("NAME")
    return True


def outside(t: Trouble) -> bool:
    """Where an item should begin: a member or a statement, or a word that begins nothing."""
    if t.opener() is not None or t.construct() is not None or "STRUCT" not in t.expected:
        return False
    word, ahead = t.token, t.ahead()
    if t.begins_field or (word.type in _ONLY_MEMBERS and (t.is_word(ahead) or ahead.text == "{")):
        t.report(
            "E0140",
            "a field outside of a struct"
            if ahead.type == "COLON"
            else f"`{word.text}` outside of a struct",
            "belongs in the braces of a struct or root",
            help="a `}` before it may have closed the struct too early",
        )
    elif word.type == "LET":
        t.report(
            "E0140",
            "`let` outside of a constraint",
            help="a value for the whole file is written `const name = ...`",
        )
        t.swap("CONST")
        return True
    elif not t.is_name(word):
        return False
    else:
        meant = _OTHER_ITEMS.get(word.text) or next(iter(closest(word.text, _ITEMS)), None)
        if meant and (t.is_word(ahead) or ahead.type == "STRING"):
            t.report("E0128", f"unknown word `{word.text}`", f"did you mean `{meant}`?")
            t.swap(meant.upper())
            return True
        t.report(
            "E0128",
            f"`{word.text}` does not begin an item",
            "expected `struct`, `root`, `fn`, `const` or `import`",
        )
    t.skip()
    t.panic()
    return True


def let_among_members(t: Trouble) -> bool:
    """A `let` beside the fields of a struct: it would be shared by its constraints."""
    if t.token.type != "LET" or "CONSTRAINT" not in t.expected:
        return False
    t.report(
        "E0140",
        "`let` outside of a constraint",
        "belongs in the braces of a constraint",
        help="write it in each constraint that uses it, or as a function: `fn name(x) = ...`",
    )
    t.skip(1)
    t.panic()
    return True


def function(t: Trouble) -> bool:
    """``fn f(x: real) { x * 2 }``: a function with types or braces, as in programs."""
    if t.within("FN") is None:
        return False
    if t.token.type == "COLON" and t.within("LPAR") is not None:
        t.report(
            "E0142",
            "arguments of a function take no type",
            help="omit it: shapes follow from the call",
        )
        t.skip_to("COMMA", "RPAR")
    elif t.token.type == "LBRACE":
        t.report(
            "E0142",
            "a function is one expression, without braces",
            help="write `fn name(x) = expression`; parts of it can be functions too",
        )
        t.skip()
        depth = 1
        while depth and t.token is not t.tokens[-1]:
            depth += {"LBRACE": 1, "RBRACE": -1}.get(t.token.type, 0)
            t.skip()
        t.insert("EQUAL", "NUMBER")
    else:
        return False
    return True


def clause(t: Trouble) -> bool:
    """Between the name of a constraint and its ``{``: what is none of its clauses."""
    construct = t.construct()
    if (
        "LBRACE" not in t.expected
        or t.wants_operand
        or t.begins_line
        or construct is None
        or construct.type not in ("CONSTRAINT", "REQUIRE", "FIT", "WHEN", "LOSS", "INTO")
    ):
        return False
    word = t.token
    near = closest(word.text, ("when", "loss", "into")) if word.type == "NAME" else []
    if word.text in ("if", "where"):
        t.report("E0141", f"a guard begins with `when`, not `{word.text}`", "did you mean `when`?")
        t.swap("WHEN")
    elif word.text == "robust":
        t.report(
            "E0141",
            "a robust kernel is named after `loss`",
            help="write for example `loss huber(1.0)`",
        )
        t.swap("LOSS")
    elif near:
        t.report("E0128", f"unknown word `{word.text}`", f"did you mean `{near[0]}`?")
        t.swap(near[0].upper())
    elif word.type in (NEWLINE, "RBRACE", "EQUAL", "EQ", "NE", "LT", "LE", "GT", "GE"):
        return False
    else:
        t.report(
            "E0129",
            f"`{word.text}` does not belong in the header of a constraint",
            "expected `{` or one of `when`, `loss`, `into`",
            help="several blocks are written `into [a, b]`" if word.type == "COMMA" else "",
        )
        if any(x.type == "LBRACE" for x in t.line_tokens()):
            t.skip_to("LBRACE")
        else:
            t.skip()
        if not t.automaton.accepts("LBRACE"):
            t.panic()
    return True


def missing_braces(t: Trouble) -> bool:
    """``struct Pose`` without ``{``, or with something between its name and ``{``."""
    head = t.within(*_WITH_BRACES)
    if head is None or t.before is None or "LBRACE" not in t.expected or t.wants_operand:
        return False
    on_line = any(x.type == "LBRACE" for x in t.line_tokens()[1:])
    if on_line and not t.begins_line:
        t.report(
            "E0129", f"expected `{{` after the header of this {head.text}", "does not belong here"
        )
        t.skip_to("LBRACE")
        return True
    if not (t.begins_line or t.token.type in (NEWLINE, "RBRACE")):
        return False
    t.report("E0129", f"this {head.text} has no braces", "expected `{` after this", at=t.before)
    if t.begins_line and (t.begins_member or t.token.type == "RBRACE"):
        t.insert("LBRACE", "RBRACE", NEWLINE)
    elif t.begins_line:
        t.insert("LBRACE")
    else:
        t.panic()
    return True


def import_(t: Trouble) -> bool:
    """``import geometry``: a file's name without quotes."""
    if t.last is None or t.last.type != "IMPORT":
        return False
    name = t.token.text if t.is_word(t.token) else "file"
    t.report(
        "E0112",
        "`import` takes the name of a file in quotes",
        "expected a text after this",
        at=t.last,
        help=f'write `import "{name}.arael"`',
    )
    t.panic()
    return True


def setting(t: Trouble) -> bool:
    """In a schedule: ``x: 1`` for ``x = 1``, or a block without ``pass``."""
    block = t.block()
    if block is None:
        return False
    if block.type in ("PASS", "UPDATE") and t.token.type == "COLON" and "EQUAL" in t.expected:
        before = t.before.text if t.before else "x"
        t.report("E0135", "`:` where `=` belongs", f"a setting is written `{before} = value`")
        t.swap("EQUAL")
        return True
    if block.type == "SOLVE" and t.is_name(t.token) and t.ahead().type == "LBRACE":
        t.report(
            "E0128",
            f"`{t.token.text}` without `pass`",
            "a solve schedule holds passes",
            help=f"write `pass {t.token.text} {{ ... }}`",
        )
        t.insert("PASS")
        return True
    return False


def missing_equal(t: Trouble) -> bool:
    """``let x: real = 2``, ``let x``, ``const a 4``: no ``=`` after the name."""
    head = t.construct()
    if head is None or head.type not in ("LET", "CONST", "SYMBOLIC", "COMPUTE") or t.before is None:
        return False
    if "EQUAL" not in t.expected or t.wants_operand:
        return False
    if t.token.type == "COLON":
        t.report(
            "E0135",
            f"a `{head.text}` takes no type",
            help="omit it: the type is that of the value",
        )
        t.skip_to("EQUAL")
        return True
    if t.last is t.before and t.is_name(t.token) and not t.begins_line:
        t.report(
            "E0135",
            f"`{t.before.text}` does not belong in a `{head.text}`",
            at=t.before,
            help=f"write `{head.text} {t.token.text} = ...`",
        )
        t.automaton.pop(1)
        return True
    t.report(
        "E0135",
        f"`=` is missing in this `{head.text}`",
        "expected `=` and a value after this",
        at=t.before,
        help=f"write `{head.text} {t.before.text} = ...`",
    )
    if t.token.type == "EQ":
        t.swap("EQUAL")
    else:
        t.insert("EQUAL", *(["NUMBER"] if t.ends_statement else []))
    return True
