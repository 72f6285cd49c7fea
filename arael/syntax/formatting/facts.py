"""Information from the tree that the formatter needs, by offset."""

from __future__ import annotations

from dataclasses import dataclass, field

from arael.syntax import tree
from arael.syntax.walk import walk

Aligned = tree.Field | tree.Let | tree.Setting | tree.PassBlock


@dataclass
class Facts:
    """Offsets of tokens whose meaning does not follow from their type."""

    names: set[int] = field(default_factory=set)
    signs: set[int] = field(default_factory=set)
    lists: set[int] = field(default_factory=set)
    units: dict[int, int] = field(default_factory=dict)
    dimensioned: set[int] = field(default_factory=set)
    slices: set[int] = field(default_factory=set)
    lambdas: set[int] = field(default_factory=set)
    roots: set[int] = field(default_factory=set)
    steps: set[int] = field(default_factory=set)
    aligned: dict[int, Aligned] = field(default_factory=dict)


def gather(file: tree.File) -> Facts:
    """Facts of `file`; `units` maps the start of a unit to its end."""
    facts = Facts()
    for node in walk(file):
        start = node.span.start
        if isinstance(node, (tree.Name, tree.Ident, tree.Sum)):
            facts.names.add(start)
        elif isinstance(node, tree.Attribute):
            facts.names.add(node.name_span.start)
        elif isinstance(node, tree.Unary):
            facts.signs.add(start)
        elif isinstance(node, tree.ListExpr):
            facts.lists.add(start)
        elif isinstance(node, tree.Slice):
            facts.slices.add(node.colon)
        elif isinstance(node, tree.Unit):
            facts.units[start] = node.span.end
        elif isinstance(node, tree.NamedType):
            facts.names.add(start)
            if node.dims:
                facts.dimensioned.add(start)
        elif isinstance(node, tree.Lambda):
            facts.lambdas.add(start)
        elif isinstance(node, tree.Struct) and node.precision:
            facts.roots.add(node.name.span.start)
        if isinstance(node, (tree.Setting, tree.Freeze, tree.PassBlock)):
            facts.steps.add(start)
        if isinstance(node, (tree.Field, tree.Let, tree.Setting, tree.PassBlock)):
            facts.aligned[start] = node
    return facts
