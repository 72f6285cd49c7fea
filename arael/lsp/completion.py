"""What may be typed next."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from arael.check.access import QUATERNION_PARTS
from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES, METHODS
from arael.check.losses import LOSSES
from arael.check.types import FIXED_TYPES, PARAM_READINGS, PARAM_TYPES, TYPE_NAMES
from arael.check.units_table import known_names
from arael.config import LmConfig
from arael.highlighting import keywords
from arael.lsp.document import Document
from arael.lsp.hover import builtin
from arael.lsp.names import StructNames, Symbol
from arael.lsp.outline import Scope
from arael.lsp.resolution import chain_at
from arael.syntax import tree

Sort = Literal["field", "param", "function", "constant", "variable", "keyword", "struct", "type",
               "unit", "loss", "setting", "constraint"]  # fmt: skip


@dataclass(frozen=True)
class Completion:
    """One proposal; `insert` is what is typed, the cursor at ``$0`` if it has one."""

    label: str
    sort: Sort
    detail: str = ""
    doc: str = ""
    insert: str = ""


_VECTOR_PARTS = ("x", "y", "z")
_PARTS = {
    "quat": (*QUATERNION_PARTS, "vec"),
    "quaternion": (*QUATERNION_PARTS, "vec"),
    "transform": ("translation", "rotation"),
    "similarity": ("translation", "rotation", "scale"),
    "vec2": _VECTOR_PARTS[:2],
    "vec3": _VECTOR_PARTS,
    "euler": _VECTOR_PARTS,
    "direction": _VECTOR_PARTS,
}


def completions(document: Document, offset: int) -> list[Completion]:
    """Proposals for the word that ends at `offset`, best first; an editor filters by letters."""
    i = document.before(offset - 1) if offset else -1
    tokens = document.tokens
    typing = i >= 0 and tokens[i].end >= offset and tokens[i].text.isidentifier()
    last = i - 1 if typing else i  # the last token before the word
    scope = document.scopes[i] if 0 <= i < len(document.scopes) else Scope()
    if not typing and 0 <= i + 1 < len(document.scopes):
        scope = document.scopes[i + 1]
    before = tokens[last].type if last >= 0 else ""
    if before == "DOT":
        return _unique(_after_dot(document, last, scope))
    if before in ("LOSS",):
        return _unique(Completion(n, "loss", "robust loss", builtin(n), f"{n}($0)") for n in LOSSES)
    if before == "LSQB" and scope.where in ("type", "members"):
        return [Completion(n, "unit", "unit") for n in known_names()]
    return _unique(_bare(document, scope, before))


def _bare(document: Document, scope: Scope, before: str) -> Iterator[Completion]:
    where = scope.where
    starts = before in ("", "_NEWLINE", "SEMICOLON", "LBRACE")
    if where == "file":
        yield from _words(keywords.ITEMS)
    elif where == "members" and starts:
        yield from _words(keywords.MEMBERS)
    elif where == "type" or (where == "members" and before == "COLON"):
        yield from _types(document, before)
    elif where in ("solve", "pass"):
        yield from _words(keywords.PASSES)
        yield from _settings()
        yield from _symbols(_of_root(document))
    else:
        yield from _symbols(document.resolver.visible(scope))
        yield from _around(document, scope)
        if where == "body" and starts:
            yield from _words({"let": keywords.FORMULAS["let"]})
        if where == "clauses":
            yield from _words({k: keywords.CLAUSES[k] for k in ("when", "loss", "into")})
        yield from _functions()
        yield from _words({k: keywords.FORMULAS[k] for k in ("if", "and", "or", "not")})


def _after_dot(document: Document, dot: int, scope: Scope) -> Iterator[Completion]:
    tokens = document.tokens
    value: tree.TypeExpr | None = None
    type_ = ""
    if dot > 0 and tokens[dot - 1].text.isidentifier():
        chain = chain_at(tokens, dot - 1)
        struct = None if chain.open else document.resolver.struct_of(chain.parts, scope)
        if struct is not None:
            yield from _symbols(struct.members.values())
            if document.names.owners(struct.symbol.name):
                yield Completion("parent", "keyword", keywords.FORMULAS["parent"])
            return
        symbol = document.resolver.resolve(chain, scope)
        if symbol is not None:
            value = symbol.type
            if symbol.value is not None and symbol.value.source.name == document.source.name:
                type_ = document.type_at(symbol.value)
            if symbol.kind == "param":
                yield Completion("value", "field", "value at the start of the solve")
    if isinstance(value, tree.NamedType):
        type_ = value.name
    type_ = type_.split(" ")[0]
    for part in _PARTS.get(type_, () if type_ else _VECTOR_PARTS):
        yield Completion(part, "field", f"part of {type_ or 'a vector'}")
    for name in sorted(METHODS):
        takes = FUNCTIONS[name].takes if name in FUNCTIONS else "a matrix"
        if type_ and not _takes(name, type_):
            continue
        yield Completion(name, "function", f"of {takes}", builtin(name), f"{name}($0)")


def _takes(method: str, type_: str) -> bool:
    """Whether a value of this type, as written, has the method; unknown types have all."""
    read = PARAM_READINGS.get(type_, FIXED_TYPES.get(type_))
    if read is None or method not in FUNCTIONS:
        return True
    one = FUNCTIONS[method]
    if one.least > 1:
        return True
    return one.result([read]) is not None


def _types(document: Document, before: str) -> Iterator[Completion]:
    yield from _symbols(
        s.symbol for s in document.names.structs.values() if s.symbol.kind != "root"
    )
    if before in ("OF", "REF"):
        return
    if before == "IN":
        yield Completion("root", "keyword", keywords.FORMULAS["root"])
        yield from _symbols(_of_root(document))
        return
    for name in sorted(TYPE_NAMES):
        yield Completion(name, "type", "parameter" if name in PARAM_TYPES else "type")
    yield from _words({k: v for k, v in keywords.TYPES.items() if k not in ("of", "in")})


def _of_root(document: Document) -> Iterable[Symbol]:
    root = document.names.root
    return root.members.values() if root is not None else ()


def _around(document: Document, scope: Scope) -> Iterator[Completion]:
    """The entities of a body: the row, its owner, the root."""
    own: StructNames | None = document.names.structs.get(scope.struct)
    root = document.names.root
    if own is None:
        return
    yield Completion("self", "variable", f"this {own.symbol.name}")
    yield Completion(own.symbol.name.lower(), "variable", f"this {own.symbol.name}")
    for owner in document.names.owners(own.symbol.name)[:1]:
        yield Completion("parent", "variable", f"the {owner.symbol.name} that contains it")
    if root is not None:
        yield Completion("root", "variable", f"the root {root.symbol.name}")
        yield Completion(root.symbol.name.lower(), "variable", f"the root {root.symbol.name}")


def _functions() -> Iterator[Completion]:
    for name in sorted(FUNCTIONS):
        yield Completion(
            name, "function", f"takes {FUNCTIONS[name].takes}", builtin(name), f"{name}($0)"
        )
    for name in (*CONSTANTS, *IDENTITIES):
        yield Completion(name, "constant", "", builtin(name))


def _settings() -> Iterator[Completion]:
    for one in dataclasses.fields(LmConfig):
        if one.name not in ("observer", "verbose"):
            yield Completion(one.name, "setting", f"= {one.default}", "", f"{one.name} = $0")


_SORTS: dict[str, Sort] = {
    "struct": "struct", "component": "struct", "root": "struct", "param": "param",
    "field": "field", "formula": "field", "const": "constant", "function": "function",
    "constraint": "constraint", "fit": "constraint", "prior": "constraint",
}  # fmt: skip


def _symbols(symbols: Iterable[Symbol]) -> Iterator[Completion]:
    for one in symbols:
        sort = _SORTS.get(one.kind, "variable")
        insert = f"{one.name}($0)" if one.kind == "function" else ""
        yield Completion(one.name, sort, one.text, one.doc, insert)


def _words(words: dict[str, str]) -> Iterator[Completion]:
    for word, written in words.items():
        yield Completion(word, "keyword", written)


def _unique(found: Iterable[Completion]) -> list[Completion]:
    """The first proposal of each name: what hides the others in the language comes first."""
    return list({one.label: one for one in reversed(list(found))}.values())[::-1]
