"""Names of counts and refs in C, and the way from a constraint's row to the rows it reads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from arael.exporting.c_functions import Functions
from arael.exporting.identifiers import Names, identifier
from arael.runtime.layout import Group, Layout, Step


class Rows:
    """The rows of collections as C arrays see them.

    Parameters
    ----------
    functions : of the model
    tables : paths of the tables that constraints read, the root's ``""`` among them

    Attributes
    ----------
    tables : in the order of the layout
    names : by table, the name of its rows: ``edges`` of ``edges_count``
    refs : by table and step, the name of the array of the rows that it leads to
    """

    def __init__(self, functions: Functions, tables: Iterable[str]) -> None:
        self.layout: Layout = functions.layout
        read = set(tables)
        self.tables = [table.path for table in self.layout.tables if table.path in read]
        members = ["parameters"]
        for one in functions.arrays.parameters:
            members += [one.stored.name, f"{one.stored.name}_fixed"]
        members += [array.name for array in functions.arrays.data.values()]
        self.names: dict[str, str] = {}
        numbered = Names()
        for path in filter(None, self.tables):
            name = numbered.take(identifier(path))
            while f"{name}_count" in members:
                name = numbered.take(f"{name}_rows")
            self.names[path] = name
            members.append(f"{name}_count")
        taken = Names(tuple(members))
        self.refs: dict[tuple[str, Step], str] = {}
        for function in functions.constraints:
            for slot in function.group.slots:
                table = function.group.table
                for step in slot.steps:
                    if step.kind != "root" and (table, step) not in self.refs:
                        name = f"{self.names[table]}_{identifier(step.ref or 'parent')}"
                        self.refs[table, step] = taken.take(name)
                    table = self.target(table, step)

    def target(self, table: str, step: Step) -> str:
        """The table that a step from `table` leads to."""
        if step.kind == "root":
            return ""
        if step.kind == "parent":
            return self.layout.table(table).parent
        target = self.layout.table(table).column(step.ref).target
        assert target is not None
        return target.table

    def walk(
        self, group: Group, owner: str, cast: str = "", failure: str = "", slots: Sequence[int] = ()
    ) -> tuple[list[str], dict[int, str]]:
        """Statements that find the rows of slots from row `i`, and the row of each slot.

        Parameters
        ----------
        group : whose slots
        owner : before the name of an array: ``data->``
        cast : C++ cast of an index
        failure : statement where a row is out of range; "" does not check
        slots : numbers of the slots; all by default
        """
        lines: list[str] = []
        found: dict[int, str] = {}
        known: dict[tuple[Step, ...], str] = {(): "i"}
        for number in slots or range(len(group.slots)):
            table, steps = group.table, group.slots[number].steps
            for length, step in enumerate(steps, 1):
                before, way = known[steps[: length - 1]], steps[:length]
                if step.kind == "root":
                    known[way] = "0"
                elif way not in known:
                    row = known[way] = f"row{len(known)}"
                    at = f"{cast}({before})" if cast else before
                    lines.append(f"const int {row} = {owner}{self.refs[table, step]}[{at}];")
                    if failure:
                        target = self.target(table, step)
                        limit = f"{owner}{self.names[target]}_count" if target else "1"
                        lines.append(f"if ({row} < 0 || {row} >= {limit}) {failure}")
                table = self.target(table, step)
            row = known[steps]
            found[number] = f"{cast}({row})" if cast else row
        return lines, found
