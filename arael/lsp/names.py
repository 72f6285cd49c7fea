"""What the files of a model declare, by name, with the places of the declarations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

from arael.check.members import prior_name
from arael.check.types import type_text
from arael.diagnostics.records import Span
from arael.syntax import tree
from arael.syntax.walk import walk

Kind = Literal[
    "struct", "component", "root", "param", "field", "formula", "constraint", "fit", "prior",
    "pass", "const", "function", "argument", "let", "element",
]  # fmt: skip


@dataclass(frozen=True)
class Symbol:
    """One declaration.

    Attributes
    ----------
    span : place of the declared name
    owner : name of the struct of a member; "" for items and for names of a body
    text : the declaration on one line
    struct : name of the struct that a field holds, collects or refers to, or a name stands for
    value : place of the formula of a constant, a `let`, a formula
    """

    kind: Kind
    name: str
    span: Span
    owner: str = ""
    text: str = ""
    doc: str = ""
    struct: str = ""
    type: tree.TypeExpr | None = None
    value: Span | None = None

    @property
    def key(self) -> tuple[str, int]:
        """Identity: file and place of the declaration."""
        return self.span.source.name, self.span.start


@dataclass
class StructNames:
    """A struct and its members; constraints may have the names of fields."""

    symbol: Symbol
    members: dict[str, Symbol] = field(default_factory=dict)
    constraints: dict[str, Symbol] = field(default_factory=dict)
    passes: dict[str, Symbol] = field(default_factory=dict)


@dataclass
class Names:
    """The declarations of all files of a model."""

    structs: dict[str, StructNames] = field(default_factory=dict)
    consts: dict[str, Symbol] = field(default_factory=dict)
    functions: dict[str, Symbol] = field(default_factory=dict)
    arguments: dict[str, tuple[Symbol, ...]] = field(default_factory=dict)  # of functions

    @property
    def root(self) -> StructNames | None:
        """The first root."""
        return next((s for s in self.structs.values() if s.symbol.kind == "root"), None)

    def owners(self, struct: str) -> list[StructNames]:
        """The structs that hold or collect `struct`."""
        return [
            s
            for s in self.structs.values()
            if any(
                m.struct == struct and not isinstance(m.type, tree.RefType)
                for m in s.members.values()
            )
        ]

    def symbols(self) -> Iterable[Symbol]:
        """Every declaration."""
        for s in self.structs.values():
            yield s.symbol
            yield from s.members.values()
            yield from s.constraints.values()
            yield from s.passes.values()
        yield from self.consts.values()
        yield from self.functions.values()
        for arguments in self.arguments.values():
            yield from arguments


def names_of(files: Iterable[tree.File]) -> Names:
    """The declarations of `files`; of two with one name the first counts."""
    found = Names()
    for file in files:
        for item in file.items:
            if isinstance(item, tree.Struct):
                found.structs.setdefault(item.name.id, _struct(item))
            elif isinstance(item, tree.Const):
                text = f"const {item.name.id} = {item.value.span.text}"
                found.consts.setdefault(
                    item.name.id,
                    Symbol(
                        "const", item.name.id, item.name.span, "", text, item.doc,
                        value=item.value.span,
                    ),
                )  # fmt: skip
            elif isinstance(item, tree.Function) and item.name.id not in found.functions:
                found.functions[item.name.id] = Symbol(
                    "function", item.name.id, item.name.span, "", _one_line(item.span), item.doc
                )
                found.arguments[item.name.id] = tuple(
                    Symbol("argument", p.id, p.span, "", f"argument of {item.name.id}")
                    for p in item.params
                )
    return found


def held_struct(type_: tree.TypeExpr) -> str:
    """Name of the struct that a field of this type holds, collects or refers to; "" for values."""
    for node in walk(type_):
        if isinstance(node, tree.RefType):
            return node.target.id
        if isinstance(node, tree.CollectionType):
            return node.element.name
        if isinstance(node, tree.NamedType):
            return node.name
    return ""


def _struct(item: tree.Struct) -> StructNames:
    owner = item.name.id
    precision = f" : {item.precision}" if item.precision else ""
    text = f"{item.kind} {owner}{precision}"
    found = StructNames(Symbol(item.kind, owner, item.name.span, "", text, item.doc, struct=owner))
    for member in item.members:
        match member:
            case tree.Field():
                role = "" if member.role == "data" else f"{member.role} "
                text = f"{role}{member.name.id}: {_one_line(member.type.span)}"
                if member.bounds is not None:
                    text += f" {_one_line(member.bounds.span)}"
                if member.default is not None:
                    text += f" = {member.default.span.text}"
                symbol = Symbol(
                    "param" if member.role == "param" else "field",
                    member.name.id, member.name.span, owner, text, member.doc,
                    held_struct(member.type), member.type,
                )  # fmt: skip
                found.members.setdefault(symbol.name, symbol)
            case tree.Tie() | tree.Symbolic() | tree.Compute():
                symbol = Symbol(
                    "formula", member.name.id, member.name.span, owner,
                    _one_line(member.span), member.doc, value=member.value.span,
                )  # fmt: skip
                found.members.setdefault(symbol.name, symbol)
            case tree.Constraint():
                word = "require" if isinstance(member, tree.Require) else "constraint"
                symbol = Symbol(
                    "constraint", member.name.id, member.name.span, owner,
                    f"{word} {owner}.{member.name.id}", member.doc,
                )  # fmt: skip
                found.constraints.setdefault(symbol.name, symbol)
            case tree.Fit():
                symbol = Symbol(
                    "fit", str(member.collection), member.collection.span, owner,
                    f"fit {member.collection} as {member.element.id}", member.doc,
                )  # fmt: skip
                found.constraints.setdefault(symbol.name, symbol)
            case tree.Prior():
                name = prior_name(member)
                symbol = Symbol(
                    "prior", name, member.target.span, owner, _one_line(member.span), member.doc
                )
                found.constraints.setdefault(name, symbol)
            case tree.Solve():
                for one in member.passes:
                    symbol = Symbol(
                        "pass", one.name.id, one.name.span, owner, f"pass {one.name.id}", one.doc
                    )
                    found.passes.setdefault(one.name.id, symbol)
            case _:
                pass
    return found


def _one_line(span: Span) -> str:
    return " ".join(span.text.split())


__all__ = ["Kind", "Names", "StructNames", "Symbol", "held_struct", "names_of", "type_text"]
