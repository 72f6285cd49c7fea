"""The tree of fields of a table's rows.

A `Layout` lists columns by dotted path. Readers, writers and the Python interface traverse the
fields as nested in the model: values, structs held by value, collections.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from arael.runtime import layout


@dataclass(frozen=True, eq=False)
class Leaf:
    """A field with values. `optional`: it may be null itself."""

    path: str
    column: layout.Column
    optional: bool


@dataclass(frozen=True, eq=False)
class Nested:
    """A collection; `table` is the path of its table."""

    path: str
    table: layout.Table


@dataclass(frozen=True, eq=False)
class Group:
    """A struct: the row itself (path "") or one held by value within it.

    A list of `refs` refs is one too, with the members ``0``, ``1``, ... The `plain` members by
    dotted path are those that Python has read, which are no formulas or blocks.
    """

    path: str
    struct: str
    optional: bool
    where: str
    refs: int = 0
    members: dict[str, Leaf | Nested | Group] = field(default_factory=dict)
    plain: dict[str, Leaf | Nested | Group] = field(default_factory=dict)

    def leaves(self) -> Iterator[Leaf]:
        """All leaves at and below this group."""
        for member in self.members.values():
            if isinstance(member, Leaf):
                yield member
            elif isinstance(member, Group):
                yield from member.leaves()

    def find(self, path: str) -> Leaf | Nested | Group | None:
        """Return the member at a dotted path below this group, if there is one."""
        member: Leaf | Nested | Group | None = self
        for name in path.split("."):
            if not isinstance(member, Group):
                return None
            member = member.members.get(name)
        return member


def fields_of(model: layout.Layout, table: layout.Table) -> Group:
    """Return the tree of fields of one table's rows."""
    root = Group("", table.struct, False, table.where)
    groups = {"": root}
    for value in sorted(table.values, key=lambda v: v.path.count(".")):
        groups[value.path] = Group(
            value.path, value.struct, value.optional, value.where, value.refs
        )
    present = {c.path for c in table.columns if c.role == "present"}
    members: list[Leaf | Nested | Group] = [
        Leaf(c.path, c, c.path in present) for c in table.columns if c.role != "present"
    ]
    members += [groups[v.path] for v in table.values]
    members += [
        Nested(t.field, t) for t in model.tables if t.parent == table.path and t is not table
    ]
    for member in members:
        owner, _, name = member.path.rpartition(".")
        groups[owner].members[name] = member
    return root
