"""Fields without a colon or a type, and types that are not written that way."""

from __future__ import annotations

from functools import partial

from arael.diagnostics.suggest import closest
from arael.syntax.mistakes.table import Mistake, Names, is_kind, span
from arael.syntax.trouble import Trouble

_MEMBER_WORDS = (
    "param", "skip", "constraint", "prior", "fixed", "fit", "key", "marginalize", "solve",
    "symbolic", "compute",
    "update",
)  # fmt: skip
# Words of other languages and tools before a field or constraint.
_OTHER_WORDS = {
    "var": "param", "variable": "param", "parameter": "param", "optimize": "param",
    "optimise": "param", "state": "param", "residual": "constraint", "factor": "constraint",
    "cost": "constraint", "error": "constraint", "measurement": "constraint", "edge": "constraint",
    "schedule": "solve", "schur": "marginalize", "eliminate": "marginalize", "ignore": "skip",
}  # fmt: skip
_VALUES = "NUMBER MINUS LPAR LSQB STRING TRUE FALSE"
_TYPES = "types are names such as `real`, `vec3`, `mat<2,3>`, `Pose?` or `list of Pose`"


def _misspelt_member(t: Trouble) -> Names | bool:
    """``constrain drift { ... }``: a misspelt ``constraint``, or a word of another language."""
    before = t.before
    if before is None or not (t.is_word(t.token) or t.token.type == "LBRACE"):
        return False
    block_follows = any(x.type == "LBRACE" for x in t.line_tokens())
    meant = _OTHER_WORDS.get(before.text) or next(iter(closest(before.text, _MEMBER_WORDS)), None)
    if meant is None and block_follows and t.is_word(t.token):
        meant = "constraint"
    if meant is None:
        return False
    field = meant in ("param", "skip")
    fits = field == (t.ahead().type == "COLON" or not block_follows) or meant == "key"
    return fits and {"meant": meant}


def _replace_member(t: Trouble) -> None:
    found = _misspelt_member(t)
    assert isinstance(found, dict)
    t.automaton.pop(1)
    t.insert(found["meant"].upper())


def _value_follows(t: Trouble) -> Names | bool:
    """``sigma = 0.01``, in contrast to ``sigma = real``."""
    value = is_kind(t, t.ahead(), _VALUES)
    if not value and not is_kind(t, t.ahead(2), "LPAR PLUS MINUS STAR SLASH DOT"):
        return False
    line = t.line_tokens()
    rest = t.log.source.text[line[1].start : line[-1].end] if len(line) > 1 else "..."
    return {"rest": rest if len(rest) <= 30 else "..."}


def _after(t: Trouble) -> Names:
    """The place right after the token before."""
    assert t.before is not None
    return span(t.before.end, t.before.end + 1)


def _insert_of(t: Trouble) -> None:
    t.insert(*(("OF",) if t.token.type == "NAME" and not t.begins_line else ("OF", "NAME")))


def _number(t: Trouble) -> Names:
    return {"number": t.ahead().text if t.ahead().type == "NUMBER" else "n"}


def _separate(t: Trouble) -> None:
    t.skip()
    if not is_kind(t, t.token, "end"):
        t.insert("SEMICOLON")


# A name of a field that was just read, the colon after it, the `of` of a collection.
_name = partial(Mistake, before="name", last=True, part="members", expected="COLON")
_type = partial(Mistake, before="COLON", last=True, part="members")
_element = partial(Mistake, before="OF", last=True, part="members")
_NO_TYPE = ("E0126", "field `{before}` has no type", "a type is missing after the name")

ROWS = (
    _name(
        "E0128", "unknown word `{before}`", "did you mean `{meant}`?", place="before",
        outside="PARAM SKIP", begins=False, when=_misspelt_member, repair=_replace_member,
    ),
    _name(
        *_NO_TYPE, help="write `{before}: real = {rest}`", place="before",
        token="EQUAL", when=_value_follows, repair="insert COLON NAME",
    ),
    _name(
        "E0126", "`=` where `:` belongs", "the type of `{before}` follows a `:`",
        help="write `{before}: {ahead}`", token="EQUAL", repair="swap COLON",
    ),
    _name(
        "E0126", "`:` is missing after `{before}`", "a field is written `name: type`",
        help="write `{before}: {token}`", place="span",
        token="LIST DEQUE ARENA REF BLOCK TRIPLETS NAME", begins=False, when=_after,
        repair="insert COLON",
    ),
    *(
        _name(
            *_NO_TYPE, help="write for example `{before}: real` or `{before}: vec3`",
            place="before", token=token, begins=begins, repair="insert COLON NAME",
        )
        for token, begins in (("", True), ("end COMMA", None))
    ),
    _type(
        "E0126", "a type is missing after `:`", "the field ends here",
        help="write a type such as `real`, `vec3`, `list of Pose`", place="before",
        token="end EQUAL COMMA", repair="insert NAME",
    ),
    *(
        _type(
            "E0127", "`{token}` does not begin a type", help=help_,
            token=token,
            repair="skip_to EQUAL SEMICOLON RBRACE; insert NAME",
        )
        for token, help_ in (
            ("PARAM", "`param` comes before the name: `param name: type`"),
            ("", _TYPES),
        )
    ),
    Mistake(
        "E0127", "`[` begins a list of refs", "expected `ref`",
        help="write `[ref T in PATH; 4]` for a list of refs, `list of T` for a collection, "
        "`vec<n>` for a vector of n numbers",
        before="LSQB", last=True, part="members", expected="REF",
        repair="skip_past RSQB; insert REF NAME IN NAME SEMICOLON NUMBER RSQB",
    ),
    Mistake(
        "E0127", "a list of refs has no length", "the length is missing",
        help="write `[ref T in PATH; 4]`, with the number of refs; `list of T` is a collection of "
        "any number of rows",
        part="members", within="REF", opener="LSQB", token="RSQB", expected="SEMICOLON",
        repair="insert SEMICOLON NUMBER",
    ),
    Mistake(
        "E0127", "the refs of a list cannot be null", "not here",
        help="omit the `?`; where some are missing, write rows of a `list of` with one ref each",
        part="members", within="REF", opener="LSQB", token="QUESTION", expected="SEMICOLON",
        repair="skip",
    ),
    Mistake(
        "E0127", "the length of a list of refs is a number", "expected a number",
        help="write `[ref T in PATH; 4]`",
        part="members", within="REF", opener="LSQB", before="SEMICOLON", expected="NUMBER",
        repair="skip_to RSQB; insert NUMBER",
    ),
    *(
        _element(
            "E0127", f"{what} is not in the language",
            help="put a struct between: `list of Row`, and in `struct Row` "
            "a field of type `{token} ...`" + more,
            token=token,
            repair="skip_to SEMICOLON RBRACE EQUAL; insert NAME",
        )
        for token, what, more in (
            ("REF", "a collection of refs", "; a fixed number of refs is `[ref T in PATH; 4]`"),
            ("LIST DEQUE ARENA", "a collection of collections", ""),
        )
    ),
    _element(
        "E0127", "the collection has no element type", "of what?", help="name a struct or `real`",
        place="before", token="end", repair="insert NAME",
    ),
    Mistake(
        "E0127", "`{before}` without `of`", help="write `{before} of T`", place="before",
        before="LIST DEQUE ARENA", last=True, part="members", expected="OF", repair=_insert_of,
    ),
    *(
        Mistake(
            "E0127", "`ref {before}` does not name its collection", "the collection is missing",
            help="write `ref {before} in PATH`, with the path of the collection, "
            "as in `root.poses`",
            place="REF..before", token=token, before="NAME", within="REF", part="members",
            expected="IN", repair=repair,
        )
        for token, repair in (("QUESTION", "skip; insert IN NAME"), ("", "insert IN NAME"))
    ),
    Mistake(
        "E0127", "dimensions go in `<` `>`", help="write `{before}<{number}>`",
        token="LPAR", before="NAME", part="members", outside="REF", expected="LT", when=_number,
        repair="skip_past RPAR",
    ),
    Mistake(
        "E0122", "statements are not separated by commas",
        help="end the line here, or write `;` between statements on one line",
        token="COMMA", opener="LBRACE", operand=False, accepted="_NEWLINE", repair=_separate,
    ),
)  # fmt: skip
