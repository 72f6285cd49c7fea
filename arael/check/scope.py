"""Name resolution inside a constraint, a function or a constant, in the language's order."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Protocol

from arael.check.binding import Binding, Entity
from arael.check.declared import Declarations
from arael.check.paths import Paths
from arael.diagnostics.records import Span


@dataclass(frozen=True)
class Candidate:
    """One candidate for a name; `bind` creates the binding for a use at a span.

    `longer` is an unambiguous form of it, "" if there is none.
    """

    what: str
    span: Span | None
    bind: Callable[[Span], Binding]
    entity: Entity | None = None
    longer: str = ""


class Scope(Protocol):
    """A set of names that can be looked up."""

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`, in order of precedence."""

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""

    def advice(self, name: str) -> list[str]:
        """Specific help for the unknown name `name`, instead of a spelling suggestion."""


FieldBinder = Callable[[Entity, str, Span], Binding]
ConstantBinder = Callable[[str, Span], Binding]


@dataclass
class ConstantScope:
    """Inside a constant expression, and inside a function (whose parameters are `locals`)."""

    declarations: Declarations
    constant: ConstantBinder
    locals: dict[str, tuple[Binding, Span]] = field(default_factory=dict)
    inside: str = "a constant"

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`, in order of precedence."""
        candidates = []
        if name in self.locals:
            binding, span = self.locals[name]
            candidates.append(Candidate("a parameter of the function", span, lambda _: binding))
        if name in self.declarations.consts:
            candidates.append(_const(self.declarations, self.constant, name))
        return candidates

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        return [*self.locals, *self.declarations.consts]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        if self.inside == "a constant":
            return ["a constant may use numbers, other constants and functions"]
        return [
            f"{self.inside} uses its parameters and constants only; pass `{name}` as an argument"
        ]


@dataclass
class BodyScope:
    """Inside a constraint.

    `own` is the entity whose fields are written without a prefix: the constraint's struct, or the
    root in a `fit`. `home` is the entity of the constraint's row.
    """

    declarations: Declarations
    paths: Paths
    home: Entity
    own: Entity
    bind: FieldBinder
    constant: ConstantBinder
    lets: dict[str, tuple[Binding, Span]] = field(default_factory=dict)

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`, in order of precedence."""
        candidates = []
        if name in self.lets:
            binding, span = self.lets[name]
            bound = binding if isinstance(binding, Entity) else None
            candidates.append(Candidate("a `let` of this body", span, lambda _: binding, bound))
        own = self.own
        if name in own.place.struct.fields:
            declared = own.place.struct.fields[name]
            followed = None
            if declared.kind == "ref":
                target = self.paths.follow(own, declared)
                followed = target if isinstance(target, Entity) else None
            candidates.append(
                Candidate(
                    f"a field of {own.place.struct.name}",
                    declared.span,
                    lambda span: self.bind(own, name, span),
                    followed,
                    f"self.{name}",
                )
            )
        if name in own.place.struct.formulas and not own.place.struct.component:
            node = own.place.struct.formulas[name]
            candidates.append(
                Candidate(
                    f"a field of {own.place.struct.name}",
                    node.name.span,
                    lambda span: self.bind(own, name, span),
                    None,
                    f"self.{name}",
                )
            )
        for what, entity, longer in self._entities(name):
            candidates.append(
                Candidate(what, None, lambda _, e=entity: e, entity, longer)  # type: ignore[misc]
            )
        if name in self.declarations.consts:
            candidates.append(_const(self.declarations, self.constant, name))
        return candidates

    def _entities(self, name: str) -> Iterable[tuple[str, Entity, str]]:
        root = self.paths.root(self.home)
        if name == "self":
            yield "this entity", self.own, "self"
        elif name == "root":
            yield "the root", root, "root"
        elif name == "parent":
            owner = self.paths.owner(self.own)
            if owner is not None:
                yield "the owner of this entity", owner, "parent"
        else:
            struct = self.own.place.struct.name
            if name == struct.lower():
                yield f"this {struct}", self.own, "self"
            elif name == self.paths.root_name:
                yield f"the root {root.place.struct.name}", root, "root"

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        return [
            *self.lets,
            *self.own.place.struct.fields,
            *self.own.place.struct.formulas,
            self.own.place.struct.name.lower(),
            self.paths.root_name,
            "self",
            "parent",
            "root",
            *self.declarations.consts,
        ]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        if name == "parent":
            return ["the root has no owner"]
        if name in self.paths.root(self.home).place.struct.fields:
            return [f"the root has a `{name}`: write `root.{name}`"]
        owner = self.paths.owner(self.own)
        if owner is not None and name in owner.place.struct.fields:
            return [f"the parent has a `{name}`: write `parent.{name}`"]
        return []


@dataclass
class ComponentScope:
    """Inside the formulas and the update of a component: its own members, and constants."""

    declarations: Declarations
    own: Entity
    bind: FieldBinder
    constant: ConstantBinder

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`, in order of precedence."""
        struct = self.own.place.struct
        candidates = []
        member = struct.formulas.get(name)
        span = member.name.span if member is not None else None
        if name in struct.fields:
            span = struct.fields[name].span
        if span is not None:
            what = f"a member of {struct.name}"
            candidates.append(Candidate(what, span, lambda use: self.bind(self.own, name, use)))
        if name in self.declarations.consts:
            candidates.append(_const(self.declarations, self.constant, name))
        return candidates

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        struct = self.own.place.struct
        return [*struct.fields, *struct.formulas, *self.declarations.consts]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        if not self.own.place.struct.component:
            return ["a derived parameter uses parameters of its own struct, and constants"]
        if name in ("root", "parent", "self"):
            return ["a component uses its own members and constants only; store other values in it"]
        return []


def _const(declarations: Declarations, constant: ConstantBinder, name: str) -> Candidate:
    span = declarations.consts[name].name.span
    return Candidate("a constant", span, lambda use: constant(name, use))
