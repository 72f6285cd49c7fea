"""Fields without a colon or a type, and types that are not written that way."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.syntax.tokens import NEWLINE
from arael.syntax.trouble import Trouble

_MEMBERS = (
    "param", "skip", "constraint", "require", "prior", "fixed", "fit", "key", "marginalize",
    "solve", "symbolic", "compute", "update",
)  # fmt: skip
# Words of papers and other solvers for the members of a struct.
_OTHER_MEMBERS = {
    "variable": "param", "parameter": "param", "residual": "constraint", "factor": "constraint",
    "cost": "constraint", "schur": "marginalize",
}  # fmt: skip
_VALUES = {"NUMBER", "MINUS", "LPAR", "LSQB", "STRING", "TRUE", "FALSE"}
_IN_FORMULAS = {"LPAR", "PLUS", "MINUS", "STAR", "SLASH", "DOT"}
_TYPE_WORDS = {"LIST", "DEQUE", "ARENA", "REF", "BLOCK", "TRIPLETS", "NAME"}
_TYPES = "types are names such as `real`, `vec3`, `mat<2,3>`, `Pose?` or `list of Pose`"


def field(t: Trouble) -> bool:
    """After the first name of a member: no colon, no type, or a misspelt word."""
    name = t.last
    if name is None or not (t.in_members and t.is_name(name) and "COLON" in t.expected):
        return False
    meant = _meant_member(t)
    if meant is not None:
        t.report("E0128", f"unknown word `{name.text}`", f"did you mean `{meant}`?", at=name)
        t.automaton.pop(1)
        t.insert(meant.upper())
    elif t.token.type == "EQUAL" and not _value_follows(t):
        ahead = t.ahead().text
        t.report(
            "E0126",
            "`=` where `:` belongs",
            f"the type of `{name.text}` follows a `:`",
            help=f"write `{name.text}: {ahead}`",
        )
        t.swap("COLON")
    elif t.token.type in _TYPE_WORDS and not t.begins_line:
        t.report(
            "E0126",
            f"`:` is missing after `{name.text}`",
            "a field is written `name: type`",
            at=(name.end, name.end + 1),
            help=f"write `{name.text}: {t.token.text}`",
        )
        t.insert("COLON")
    elif t.begins_line or t.ends_statement or t.token.type in ("COMMA", "EQUAL"):
        t.report(
            "E0126",
            f"field `{name.text}` has no type",
            "a type is missing after the name",
            at=name,
            help=f"write `{name.text}: real = ...`"
            if t.token.type == "EQUAL"
            else f"write for example `{name.text}: real` or `{name.text}: vec3`",
        )
        t.insert("COLON", "NAME")
    else:
        return False
    return True


def _meant_member(t: Trouble) -> str | None:
    """``constrain drift { ... }``: the word that was meant by the name just read."""
    name = t.last
    assert name is not None
    block_follows = any(x.type == "LBRACE" for x in t.line_tokens())
    if t.within("PARAM", "SKIP") or t.begins_line:
        return None
    if not (t.is_word(t.token) or t.token.type == "LBRACE"):
        return None
    meant = _OTHER_MEMBERS.get(name.text) or next(iter(closest(name.text, _MEMBERS)), None)
    if meant is None and block_follows and t.is_word(t.token):
        meant = "constraint"
    is_field = meant in ("param", "skip")
    fits = is_field == (t.ahead().type == "COLON" or not block_follows) or meant == "key"
    return meant if fits else None


def _value_follows(t: Trouble) -> bool:
    """``sigma = 0.01``, in contrast to ``sigma = real``."""
    return t.ahead().type in _VALUES or t.ahead(2).type in _IN_FORMULAS


def type_(t: Trouble) -> bool:
    """After the colon of a field: no type, or something that begins none."""
    if t.last is None or t.last.type != "COLON" or not t.in_members:
        return False
    if t.ends_statement or t.token.type in ("EQUAL", "COMMA"):
        t.report(
            "E0126",
            "a type is missing after `:`",
            "the field ends here",
            at=t.last,
            help="write a type such as `real`, `vec3`, `list of Pose`",
        )
        t.insert("NAME")
        return True
    before_name = t.token.type == "PARAM"
    t.report(
        "E0127",
        f"`{t.token.text}` does not begin a type",
        help="`param` comes before the name: `param name: type`" if before_name else _TYPES,
    )
    t.skip_to("EQUAL", "SEMICOLON", "RBRACE")
    t.insert("NAME")
    return True


def type_parameters(t: Trouble) -> bool:
    """``vec(3)``, ``vec<n>``, ``Option<Pose>``, ``[real]``: what follows the name of a type."""
    before = t.before
    if before is None or not t.in_members or t.within("REF") is not None:
        return False
    if before.type == "LSQB" and "REF" in t.expected:
        t.report(
            "E0127",
            "`[` begins a list of refs",
            "expected `ref`",
            help="write `[ref T in PATH; 4]` for a list of refs, `list of T` for a collection, "
            "`vec<n>` for a vector of n numbers",
        )
        t.skip_past("RSQB")
        t.insert("REF", "NAME", "IN", "NAME", "SEMICOLON", "NUMBER", "RSQB")
        return True
    if before.type == "NAME" and t.token.type == "LPAR" and "LT" in t.expected:
        size = t.ahead().text if t.ahead().type == "NUMBER" else "n"
        t.report("E0127", "dimensions go in `<` `>`", help=f"write `{before.text}<{size}>`")
        t.skip_past("RPAR")
        return True
    if before.type == "LT" and t.last is before and not t.wants_operand:
        t.report("E0127", f"`{t.token.text}` is not a dimension", "expected a number", help=_TYPES)
        t.skip_to("GT", "SEMICOLON", "RBRACE", "EQUAL")
        t.insert("NUMBER", *([] if t.token.type == "GT" else ["GT"]))
        return True
    return False


def element_type(t: Trouble) -> bool:
    """``list Pose``, ``list<Pose>``, ``list of``, ``list of ref Pose``."""
    before = t.last
    if before is None or not t.in_members:
        return False
    if before.type in ("LIST", "DEQUE", "ARENA") and "OF" in t.expected:
        word = before.text
        t.report("E0127", f"`{word}` without `of`", at=before, help=f"write `{word} of T`")
        if t.token.type in ("LT", "LSQB"):
            t.skip_past("GT", "RSQB")
        fits = t.token.type == "NAME" and not t.begins_line
        t.insert("OF", *([] if fits else ["NAME"]))
        return True
    if before.type != "OF":
        return False
    if t.token.type in ("REF", "LIST", "DEQUE", "ARENA"):
        what = "refs" if t.token.type == "REF" else "collections"
        t.report(
            "E0127",
            f"a collection of {what} is not in the language",
            help="put a struct between: `list of Row`, and in `struct Row` a field of type "
            f"`{t.token.text} ...`",
        )
        t.skip_to("SEMICOLON", "RBRACE", "EQUAL")
    elif t.ends_statement:
        t.report(
            "E0127",
            "the collection has no element type",
            "of what?",
            at=before,
            help="name a struct or `real`",
        )
    else:
        return False
    t.insert("NAME")
    return True


def collection_of_ref(t: Trouble) -> bool:
    """``ref Pose`` without ``in PATH``."""
    ref, name = t.within("REF"), t.before
    if ref is None or name is None or name.type != "NAME" or "IN" not in t.expected:
        return False
    t.report(
        "E0127",
        f"`ref {name.text}` does not name its collection",
        "the collection is missing",
        at=(ref.start, name.end),
        help=f"write `ref {name.text} in PATH`, with the path of the collection, as in "
        "`root.poses`",
    )
    if t.token.type == "QUESTION":
        t.skip()
    t.insert("IN", "NAME")
    return True


def comma(t: Trouble) -> bool:
    """``x: real,``: commas between statements."""
    opener = t.opener()
    if t.token.type != "COMMA" or opener is None or opener.type != "LBRACE" or t.wants_operand:
        return False
    if not t.automaton.accepts(NEWLINE):
        return False
    t.report(
        "E0122",
        "statements are not separated by commas",
        help="end the line here, or write `;` between statements on one line",
    )
    t.skip()
    if not t.ends_statement:
        t.insert("SEMICOLON")
    return True
