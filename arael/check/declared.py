"""Declarations of a model from all its files: structs with their fields, consts, functions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from arael.check.typed import ValueType
from arael.check.units_quantities import UNKNOWN, Quantity
from arael.diagnostics.records import Span
from arael.runtime.layout import Param
from arael.syntax import tree

FieldKind = Literal[
    "column", "struct", "collection", "ref", "refs", "block", "triplets", "constraint_index"
]


@dataclass(eq=False)
class FieldDecl:
    """One field, resolved as far as possible without the places of its struct.

    Attributes
    ----------
    kind : kind of field; ``column`` for every plain value, parameters included
    type : type as an expression reads it (``euler`` reads as ``vec3``); None unless a column
    text : the type as declared, for messages (``vec3 [m]``)
    shape : shape of the stored value; ``rotation`` and ``quaternion`` store four scalars
    struct : name of the struct held by value, collected or referred to
    elements : the refs of a list of refs, each a field ``knots.0`` of its own
    component : whether `struct` is a component, which belongs to the entity that contains it
    quantity : unit of its values, if known; `unit` is the text
    """

    name: str
    node: tree.Field
    kind: FieldKind
    text: str
    type: ValueType | None = None
    shape: tuple[int, ...] = ()
    optional: bool = False
    unit: str = ""
    struct: str = ""
    collection: Literal["list", "deque", "arena"] = "list"
    param: Param | None = None
    component: bool = False
    elements: tuple[FieldDecl, ...] = ()
    default: tuple[float, ...] | str | None = None
    quantity: Quantity = UNKNOWN

    @property
    def span(self) -> Span:
        """Place of the field's name."""
        return self.node.name.span

    @property
    def shown(self) -> str:
        """The name as a model writes it: ``knots[0]`` for an element of a list of refs."""
        name, _, number = self.name.partition(".")
        return f"{name}[{number}]" if number else name

    @property
    def where(self) -> str:
        """Place of the declaration for messages."""
        return str(self.node.span)


@dataclass(eq=False)
class StructDecl:
    """A struct, root or component with its members sorted by kind."""

    node: tree.Struct
    fields: dict[str, FieldDecl] = field(default_factory=dict)
    constraints: list[tree.Constraint] = field(default_factory=list)
    priors: list[tuple[str, tree.Prior]] = field(default_factory=list)
    fits: list[tree.Fit] = field(default_factory=list)
    marginalize: list[tree.Marginalize] = field(default_factory=list)
    solve: tree.Solve | None = None
    formulas: dict[str, tree.Symbolic | tree.Compute | tree.Tie] = field(default_factory=dict)
    update: tree.Update | None = None
    key: str = ""
    order: str = ""  # a key that is a number: `at` looks rows up in its order

    @property
    def component(self) -> bool:
        """Whether this is a component: a parameter of the entity that contains it."""
        return self.node.kind == "component"

    @property
    def name(self) -> str:
        """Name of the struct."""
        return self.node.name.id

    def field_at(self, name: str) -> FieldDecl | None:
        """The field of that name; ``knots[0]``, ``knots.0``: an element of a list of refs."""
        name, _, number = name.replace("[", ".").rstrip("]").partition(".")
        field = self.fields.get(name)
        if field is None or not number:
            return field
        k = int(number)
        return field.elements[k] if k < len(field.elements) else None

    @property
    def has_params(self) -> bool:
        """Whether the struct itself has parameters; not those of structs within it."""
        return any(f.param is not None or f.component for f in self.fields.values())


@dataclass(eq=False)
class Declarations:
    """All items of a model, by name."""

    structs: dict[str, StructDecl] = field(default_factory=dict)
    consts: dict[str, tree.Const] = field(default_factory=dict)
    functions: dict[str, tree.Function] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)  # names with reported errors

    @property
    def roots(self) -> list[StructDecl]:
        """All roots, in order."""
        return [s for s in self.structs.values() if s.node.kind == "root"]
