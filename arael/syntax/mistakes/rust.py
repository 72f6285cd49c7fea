"""Forms of the Rust framework's models and of programs, with the arael equivalent."""

from __future__ import annotations

import re

from arael.syntax.mistakes.table import Mistake, Names, span
from arael.syntax.rust_names import PARAMETERS, plain_type
from arael.syntax.tokens import Token
from arael.syntax.trouble import Trouble

_INSIDE_TYPES = frozenset(["COLON", "COMMA", "NUMBER", "SEMICOLON", "SLASH", "STAR", "CARET"])
_COLLECTIONS = {
    "Vec": "list", "List": "list", "list": "list", "vector": "list", "array": "list", "set": "list",
    "Deque": "deque", "VecDeque": "deque", "deque": "deque", "Arena": "arena", "arena": "arena",
}  # fmt: skip
_REF = re.compile(r"#\[\s*arael\s*\(\s*ref\s*=\s*([\w.]+)\s*\)\s*\]\s*(?:pub\s+)?$")
_PATH = "where PATH leads to the collection"
# By the name of a type with parameters: {name} of the field, {type} in them, {pair} of the first.
_FORMS = {
    "Param": "`param {name}: {type}`",
    **{outer: f"`param {{name}}: {kind}`" for outer, kind in PARAMETERS.items()},
    **{outer: f"`{kind} of {{type}}`" for outer, kind in _COLLECTIONS.items()},
    **dict.fromkeys(("Option", "Optional", "optional"), "`{type}?`"),
    **dict.fromkeys(("Ref", "ref"), f"`ref {{type}} in PATH`, {_PATH}, as in `root.poses`"),
    "SelfBlock": "`block {type}`, or omit it: blocks are inferred",
    "CrossBlock": "`block ({pair})`, or omit it: blocks are inferred",
    "TripletBlock": "`triplets`, or omit it: blocks are inferred",
}
_PROGRAM = "a model contains no statements to run: fill and solve it from Python, with `arael.load`"
_FILE = 'another file is read with `import "file.arael"`'
_ITEMS_ONLY = "a model has structs, constraints and a root only"
_ITEMS = {
    "use": _FILE,
    "mod": _FILE,
    "impl": "constraints are written inside the struct: `constraint name { ... }`",
    "trait": _ITEMS_ONLY,
    "enum": _ITEMS_ONLY,
    "type": "there are no type aliases",
    **dict.fromkeys(("for", "while", "loop", "match", "println", "eprintln", "print"), _PROGRAM),
}


def _generic_type(t: Trouble) -> Names | bool:
    """``Param<vect3f>``, ``refs::Vec<T>``, ``Option<T>``, ``list[T]`` and their like."""
    first, end = _type_at(t)
    if end <= t.index:
        return False
    text, start = t.log.source.text, t.tokens[first].start
    written = text[start : t.tokens[end - 1].end]
    plain = re.sub(r"\w+\s*::\s*", "", re.sub(r"\s+", "", written))
    found = re.fullmatch(r"(\w+)[<\[](.*)[>\]]", plain)
    if not (found or "::" in written):
        return False
    name = t.tokens[first - 2]
    form = _arael_form(found[1], found[2], name.text) if found else f"`{plain_type(plain)}`"
    path = _REF.search(text[: name.start][-200:])
    if path and found and found[1] in ("Ref", "ref"):
        form = f"`ref {plain_type(found[2])} in {path[1]}`"
    return {"written": written, "form": form, **span(start, t.tokens[end - 1].end)}


def _known_type(t: Trouble) -> Names | bool:
    found = _generic_type(t)
    return found if isinstance(found, dict) and bool(found["form"]) else False


def _type_at(t: Trouble) -> tuple[int, int]:
    """Tokens of the current type, as other languages write it: the first, and after the last."""
    limits = ("_NEWLINE", "LBRACE", "SEMICOLON")
    i = t.index - 1
    while i > 0 and t.tokens[i].type not in limits:
        i -= 1
    start = i + 1 if t.tokens[i].type in limits else i
    colons = (j for j in range(start, t.index + 1) if t.tokens[j].type == "COLON")
    colon = next(colons, t.index) if t.in_members else t.index
    return (colon + 1, _type_end(t, colon + 1)) if colon < t.index else (0, 0)


def _type_end(t: Trouble, first: int) -> int:
    """Return the index after a type that begins at `first`, in the syntax of other languages."""
    depth = 0
    for end in range(first, len(t.tokens)):
        token, last = t.tokens[end], t.tokens[end - 1]
        path = token.type == "COLON" or last.type == "COLON" or end == first
        if token.type in ("LT", "LSQB", "LPAR"):
            if depth == 0 and last.type == "GT":
                return end
            depth += 1
        elif token.type in ("GT", "RSQB", "RPAR"):
            depth -= 1
            if depth < 0:
                return end
        elif (depth == 0 and not (path and (t.is_word(token) or token.type == "COLON"))) or (
            depth > 0 and not (t.is_word(token) or token.type in _INSIDE_TYPES)
        ):
            return end
    return len(t.tokens)


def _replace_type(t: Trouble) -> None:
    first, end = _type_at(t)
    entries = t.automaton.entries
    while entries and not (isinstance(entries[-1][0], Token) and entries[-1][0].type == "COLON"):
        t.automaton.pop(1)
    start = t.tokens[first].start
    t.tokens[t.index : end] = [Token("NAME", "_", start, start)]


def _arael_form(outer: str, inner: str, name: str) -> str:
    """How arael writes the type `outer` with the parameters `inner`; "" if it is unknown."""
    inner = inner.split(";")[0]
    target = re.fullmatch(r"[Rr]ef[<\[](\w+)[>\]]", inner)
    if target and outer in ("Option", "Optional", "optional"):
        return f"`ref {target[1]} in PATH?`, {_PATH}"
    parts = inner.split(",")
    element, pair = plain_type(parts[0]), ", ".join(parts[:2])
    return _FORMS.get(outer, "").format(name=name, type=element, pair=pair)


def _is_program(t: Trouble) -> bool:
    """``model.solve(...)``, ``x = 3``, ``a::b(...)`` where an item should begin."""
    kinds = [token.type for token in t.line_tokens()[1:3]]
    return kinds[:1] in (["DOT"], ["EQUAL"]) or kinds == ["COLON", "COLON"]


def _path(t: Trouble) -> Names | bool:
    """``vect3f::new(x, y, z)`` in a body or in brackets."""
    opener, before, name = t.opener(), t.before, t.ahead(2).text
    if before is None or not (t.in_body or (opener is not None and opener.type != "LBRACE")):
        return False
    if name in ("new", "from", "zeros") or plain_type(before.text) != before.text:
        return {"advice": "a vector is written as a list: `[x, y, z]`", "second": name}
    return {"advice": f"write `{name}` alone", "second": name}


ROWS = (
    Mistake(
        "E0150", "arael has no `pub`", "everything in a model is visible", help="omit it",
        token="NAME", opener="none", begins=True, text="pub", repair="skip",
    ),
    Mistake(
        "E0150", "arael has no `{token}`", help="{meant}",
        token="NAME", opener="none", begins=True, meant=_ITEMS,
    ),
    Mistake(
        "E0150", "arael has no `{token}`", help=_PROGRAM,
        token="NAME", opener="none", begins=True, when=_is_program,
    ),
    Mistake(
        "E0151", "`{written}` is not an arael type", "unknown form of type", help="write {form}",
        place="span", when=_known_type, repair=_replace_type,
    ),
    Mistake(
        "E0127", "`{written}` is not an arael type", "unknown form of type",
        help="types are names such as `real`, `vec3`, `mat<2,3>`, `Pose?` or `list of Pose`",
        place="span", when=_generic_type, repair=_replace_type,
    ),
    Mistake(
        "E0150", "`{before}::{second}` is not a name in arael", help="{advice}",
        place="before..second", token="COLON", before="word", ahead="COLON", second="word",
        when=_path, repair="skip 3",
    ),
    Mistake(
        "E0150", "arael has no `{before}`", help="omit it", place="before", last=True,
        before_text="pub mut impl static final private public", repair="pop",
    ),
)  # fmt: skip
