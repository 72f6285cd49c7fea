"""Forms of the Rust framework's models, with the arael equivalent."""

from __future__ import annotations

import re

from arael.syntax.rust_names import PARAMETERS, plain_type
from arael.syntax.tokens import Token
from arael.syntax.trouble import Trouble

_INSIDE_TYPES = frozenset(["COLON", "COMMA", "NUMBER", "SEMICOLON", "SLASH", "STAR", "CARET"])
_COLLECTIONS = {
    "Vec": "list", "List": "list", "list": "list", "vector": "list", "array": "list", "set": "list",
    "Deque": "deque", "VecDeque": "deque", "deque": "deque", "Arena": "arena", "arena": "arena",
}  # fmt: skip

_REF = re.compile(r"#\[\s*arael\s*\(\s*ref\s*=\s*([\w.]+)\s*\)\s*\]\s*(?:pub\s+)?$")


def generic_type(t: Trouble) -> bool:
    """``Param<vect3f>``, ``refs::Vec<T>``, ``Option<T>``, ``list[T]`` and their like."""
    first = _type_start(t)
    if first is None:
        return False
    end = _type_end(t, first)
    written = t.log.source.text[t.tokens[first].start : t.tokens[end - 1].end]
    plain = re.sub(r"\w+\s*::\s*", "", re.sub(r"\s+", "", written))
    found = re.fullmatch(r"(\w+)[<\[](.*)[>\]]", plain)
    if end <= t.index or not (found or "::" in written):
        return False
    name = t.tokens[first - 2].text
    form = _arael_form(found[1], found[2], name) if found else f"`{plain_type(plain)}`"
    before = t.log.source.text[: t.tokens[first - 2].start]
    path = re.search(
        r"#\[\s*arael\s*\(\s*ref\s*=\s*([\w.]+)\s*\)\s*\]\s*(?:pub\s+)?$", before[-200:]
    )
    if path and found and found[1] in ("Ref", "ref"):
        form = f"`ref {plain_type(found[2])} in {path[1]}`"
    start, stop = t.tokens[first].start, t.tokens[end - 1].end
    t.log.error(
        "E0151" if form else "E0127",
        f"`{written}` is not an arael type",
        start,
        stop,
        "unknown form of type",
        help=f"write {form}"
        if form
        else "types are names such as `real`, `vec3`, `mat<2,3>`, `Pose?` or `list of Pose`",
    )
    _replace_type(t, first, end)
    return True


def _type_start(t: Trouble) -> int | None:
    """Index of the first token of the current type, on this line."""
    if not t.in_members:
        return None
    i = t.index - 1
    while i > 0 and t.tokens[i].type not in ("_NEWLINE", "LBRACE", "SEMICOLON"):
        i -= 1
    start = i + 1 if t.tokens[i].type in ("_NEWLINE", "LBRACE", "SEMICOLON") else i
    for j in range(start, t.index + 1):
        if t.tokens[j].type == "COLON":
            return j + 1 if j < t.index else None
    return None


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


def _replace_type(t: Trouble, first: int, end: int) -> None:
    entries = t.automaton.entries
    while entries and not (isinstance(entries[-1][0], Token) and entries[-1][0].type == "COLON"):
        t.automaton.pop(1)
    start = t.tokens[first].start
    t.tokens[t.index : end] = [Token("NAME", "_", start, start)]


def _arael_form(outer: str, inner: str, name: str) -> str:
    inner = inner.split(";")[0]
    element = plain_type(inner.split(",")[0])
    if outer == "Param":
        return f"`param {name}: {element}`"
    if outer in PARAMETERS:
        return f"`param {name}: {PARAMETERS[outer]}`"
    if outer in _COLLECTIONS:
        return f"`{_COLLECTIONS[outer]} of {element}`"
    if outer in ("Option", "Optional", "optional"):
        target = re.fullmatch(r"[Rr]ef[<\[](\w+)[>\]]", inner)
        if target:
            return f"`ref {target[1]} in PATH?`, where PATH leads to the collection"
        return f"`{element}?`"
    if outer in ("Ref", "ref"):
        return f"`ref {element} in PATH`, where PATH leads to the collection, as in `root.poses`"
    if outer == "SelfBlock":
        return f"`block {element}`, or omit it: blocks are inferred"
    if outer == "CrossBlock":
        pair = ", ".join(inner.split(",")[:2])
        return f"`block ({pair})`, or omit it: blocks are inferred"
    if outer == "TripletBlock":
        return "`triplets`, or omit it: blocks are inferred"
    return ""


def rust_word(t: Trouble) -> bool:
    """``pub``, ``mut``, ``impl`` and ``type`` before an arael construct."""
    word = t.top
    if word is None or word.text not in (
        "pub",
        "mut",
        "impl",
        "static",
        "final",
        "private",
        "public",
    ):
        return False
    if word is not t.before:
        return False
    t.log.error("E0150", f"arael has no `{word.text}`", word.start, word.end, help="omit it")
    t.automaton.pop(1)
    return True


_PROGRAM = "a model contains no statements to run: fill and solve it from Python, with `arael.load`"


def _is_program(t: Trouble) -> bool:
    """``model.solve(...)``, ``x = 3``, ``a::b(...)`` where an item should begin."""
    line = t.line_tokens()
    kinds = [token.type for token in line[1:3]]
    return kinds[:1] in (["DOT"], ["EQUAL"]) or kinds == ["COLON", "COLON"]


def rust_item(t: Trouble) -> bool:
    """``pub struct``, ``impl Pose { ... }``, ``use x;``, ``mod x;`` at the top of a file."""
    word = t.token
    if word.type != "NAME" or t.opener() is not None or not t.begins_line:
        return False
    if word.text == "pub":
        t.log.error(
            "E0150",
            "arael has no `pub`",
            word.start,
            word.end,
            "everything in a model is visible",
            help="omit it",
        )
        t.skip()
        return True
    hints = {
        "use": 'another file is read with `import "file.arael"`',
        "mod": 'another file is read with `import "file.arael"`',
        "impl": "constraints are written inside the struct: `constraint name { ... }`",
        "trait": "a model has structs, constraints and a root only",
        "enum": "a model has structs, constraints and a root only",
        "type": "there are no type aliases",
        **dict.fromkeys(
            ("for", "while", "loop", "match", "println", "eprintln", "print"), _PROGRAM
        ),
    }
    if word.text not in hints and _is_program(t):
        hints = {word.text: _PROGRAM}
    if word.text not in hints:
        return False
    t.log.error("E0150", f"arael has no `{word.text}`", word.start, word.end, help=hints[word.text])
    t.panic()
    return True


def rust_path(t: Trouble) -> bool:
    """``vect3f::new(x, y, z)`` in a body."""
    opener = t.opener()
    nested = opener is not None and opener.type != "LBRACE"
    if not (t.in_body or nested) or t.token.type != "COLON":
        return False
    before, after, name = t.before, t.ahead(), t.ahead(2)
    if after.type != "COLON" or before is None or not t.is_word(before) or not t.is_word(name):
        return False
    help_ = f"write `{name.text}` alone"
    if name.text in ("new", "from", "zeros") or plain_type(before.text) != before.text:
        help_ = "a vector is written as a list: `[x, y, z]`"
    t.log.error(
        "E0150",
        f"`{before.text}::{name.text}` is not a name in arael",
        before.start,
        name.end,
        help=help_,
    )
    t.skip(3)
    return True


RECOGNISERS = (rust_item, generic_type, rust_path, rust_word)
