"""Fields without a colon or a type, and types that are not written that way."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.syntax.tables import END
from arael.syntax.tokens import NEWLINE, Token
from arael.syntax.trouble import Trouble

_MEMBER_WORDS = (
    "param",
    "skip",
    "constraint",
    "prior",
    "fixed",
    "fit",
    "key",
    "marginalize",
    "solve",
    "symbolic",
    "compute",
    "update",
)
# Words of other languages and tools before a field or constraint.
_OTHER_WORDS = {
    "var": "param", "variable": "param", "parameter": "param", "optimize": "param",
    "optimise": "param", "state": "param", "residual": "constraint", "factor": "constraint",
    "cost": "constraint", "error": "constraint", "measurement": "constraint", "edge": "constraint",
    "schedule": "solve", "schur": "marginalize", "eliminate": "marginalize", "ignore": "skip",
}  # fmt: skip
_WORD_TOKENS = {word: word.upper() for word in _MEMBER_WORDS}


def _field_name(t: Trouble) -> Token | None:
    """Return the name that begins a field and was just read."""
    top = t.top
    if top is None or not t.is_name(top) or not t.in_members or top is not t.before:
        return None
    return top if "COLON" in t.expected else None


def misspelt_member(t: Trouble) -> bool:
    """``constrain drift { ... }``: a misspelt ``constraint``."""
    name = _field_name(t)
    begins = t.is_word(t.token) or t.token.type == "LBRACE"
    if name is None or not begins or t.within("PARAM", "SKIP") or t.begins_line:
        return False
    follows_block = any(x.type == "LBRACE" for x in t.line_tokens())
    meant = _OTHER_WORDS.get(name.text) or next(iter(closest(name.text, _MEMBER_WORDS)), None)
    if meant is None and follows_block:
        meant = "constraint" if t.is_word(t.token) else None
    if meant is None:
        return False
    fields = meant in ("param", "skip")
    if fields != (t.ahead().type == "COLON" or not follows_block) and meant != "key":
        return False
    t.log.error(
        "E0128", f"unknown word `{name.text}`", name.start, name.end, f"did you mean `{meant}`?"
    )
    t.automaton.pop(1)
    if meant in ("key", "solve", "fit", "update", "marginalize", "symbolic", "compute", "skip"):
        t.insert(_WORD_TOKENS[meant])
    else:
        t.insert(meant.upper())
    return True


def missing_colon(t: Trouble) -> bool:
    """``pos vec3``, ``sigma = 0.01`` and ``pos`` alone."""
    name = _field_name(t)
    if name is None:
        return False
    token = t.token
    shown = name.text
    if token.type == "EQUAL":
        after = t.ahead()
        value = after.type in ("NUMBER", "MINUS", "LPAR", "LSQB", "STRING", "TRUE", "FALSE")
        if value or t.ahead(2).type in ("LPAR", "PLUS", "MINUS", "STAR", "SLASH", "DOT"):
            t.log.error(
                "E0126",
                f"field `{shown}` has no type",
                name.start,
                name.end,
                "a type is missing after the name",
                help=f"write `{shown}: real = {_rest_of_line(t)}`",
            )
            t.insert("COLON", "NAME")
        else:
            t.log.error(
                "E0126",
                "`=` where `:` belongs",
                token.start,
                token.end,
                f"the type of `{shown}` follows a `:`",
                help=f"write `{shown}: {after.text}`",
            )
            t.swap("COLON")
        return True
    if token.type in ("LIST", "DEQUE", "ARENA", "REF", "BLOCK", "TRIPLETS", "NAME") and (
        not t.begins_line
    ):
        t.log.error(
            "E0126",
            f"`:` is missing after `{shown}`",
            name.end,
            name.end + 1,
            "a field is written `name: type`",
            help=f"write `{shown}: {token.text}`",
        )
        t.insert("COLON")
        return True
    if t.begins_line or token.type in (NEWLINE, "SEMICOLON", "RBRACE", END, "COMMA"):
        t.log.error(
            "E0126",
            f"field `{shown}` has no type",
            name.start,
            name.end,
            "a type is missing after the name",
            help=f"write for example `{shown}: real` or `{shown}: vec3`",
        )
        t.insert("COLON", "NAME")
        return True
    return False


def _rest_of_line(t: Trouble) -> str:
    line = t.line_tokens()
    rest = t.log.source.text[line[1].start : line[-1].end] if len(line) > 1 else "..."
    return rest if len(rest) <= 30 else "..."


def missing_type(t: Trouble) -> bool:
    """``pos:`` without a type, or with something that is not a type."""
    before, token = t.before, t.token
    if before is None or before is not t.top or before.type != "COLON" or not t.in_members:
        return False
    if token.type in (NEWLINE, "SEMICOLON", "RBRACE", END, "EQUAL", "COMMA"):
        t.log.error(
            "E0126",
            "a type is missing after `:`",
            before.start,
            before.end,
            "the field ends here",
            help="write a type such as `real`, `vec3`, `list of Pose`",
        )
        t.insert("NAME")
        return True
    help_ = "types are names such as `real`, `vec3`, `mat<2,3>`, `Pose?` or `list of Pose`"
    if token.type == "PARAM":
        help_ = "`param` comes before the name: `param name: type`"
    elif token.type == "LSQB":
        help_ = "a collection is written `list of T`, a vector of n numbers `vec<n>`"
    t.log.error(
        "E0127", f"`{token.text}` does not begin a type", token.start, token.end, help=help_
    )
    t.skip_to("EQUAL", "SEMICOLON", "RBRACE")
    t.insert("NAME")
    return True


def malformed_type(t: Trouble) -> bool:
    """Recognise collections of collections, refs without a place, misplaced dimensions."""
    before, token = t.before, t.token
    if before is None or not t.in_members:
        return False
    if before.type == "OF" and before is t.top:
        if token.type in ("LIST", "DEQUE", "ARENA", "REF"):
            what = "a collection of refs" if token.type == "REF" else "a collection of collections"
            t.log.error(
                "E0127",
                f"{what} is not in the language",
                token.start,
                token.end,
                help="put a struct between: `list of Row`, and in `struct Row` "
                f"a field of type `{token.text} ...`",
            )
            t.skip_to("SEMICOLON", "RBRACE", "EQUAL")
            t.insert("NAME")
            return True
        if token.type in (NEWLINE, END, "SEMICOLON", "RBRACE"):
            t.log.error(
                "E0127",
                "the collection has no element type",
                before.start,
                before.end,
                "of what?",
                help="name a struct or `real`",
            )
            t.insert("NAME")
            return True
    collection = before.type in ("LIST", "DEQUE", "ARENA") and before is t.top
    if collection and "OF" in t.expected:
        t.log.error(
            "E0127",
            f"`{before.text}` without `of`",
            before.start,
            before.end,
            help=f"write `{before.text} of T`",
        )
        t.insert(*(("OF",) if token.type == "NAME" and not t.begins_line else ("OF", "NAME")))
        return True
    ref = t.within("REF")
    if ref is not None:
        return _ref(t, ref, before)
    if token.type == "LPAR" and before.type == "NAME" and "LT" in t.expected:
        inner = t.ahead().text if t.ahead().type == "NUMBER" else "n"
        t.log.error(
            "E0127",
            "dimensions go in `<` `>`",
            token.start,
            token.end,
            help=f"write `{before.text}<{inner}>`",
        )
        t.skip_past("RPAR")
        return True
    return False


def _ref(t: Trouble, ref: Token, before: Token) -> bool:
    token = t.token
    if "IN" in t.expected and t.within("REF") and before.type == "NAME":
        t.log.error(
            "E0127",
            f"`ref {before.text}` does not name its collection",
            ref.start,
            before.end,
            "the collection is missing",
            help=f"write `ref {before.text} in PATH`, with the path of the collection, "
            "as in `root.poses`",
        )
        if token.type == "QUESTION":
            t.skip()
        t.insert("IN", "NAME")
        return True
    return False


def trailing_comma(t: Trouble) -> bool:
    """``pos: vec3,``: fields do not end with a comma."""
    if t.token.type != "COMMA" or t.opener() is None or t.opener().type != "LBRACE":  # type: ignore[union-attr]
        return False
    if t.wants_operand or not t.automaton.accepts("_NEWLINE"):
        return False
    t.log.error(
        "E0122",
        "statements are not separated by commas",
        t.token.start,
        t.token.end,
        help="end the line here, or write `;` between statements on one line",
    )
    t.skip()
    if t.token.type not in (NEWLINE, "SEMICOLON", "RBRACE", END):
        t.insert("SEMICOLON")
    return True


RECOGNISERS = (misspelt_member, missing_colon, missing_type, malformed_type, trailing_comma)
