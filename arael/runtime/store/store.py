"""One instance of a model's data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError
from arael.runtime.layout import Layout, Step
from arael.runtime.store import references
from arael.runtime.store.messages import problem
from arael.runtime.store.slots import Ints
from arael.runtime.store.table import Table
from arael.runtime.store.use import Use
from arael.runtime.store.values import blank, default_value


class Store:
    """Tables of a model instance by path; the root is ``tables[""]`` and has one row.

    Attributes
    ----------
    layout : the compiled model
    tables : path -> `Table`
    kernels : compiled kernels of the model, or None
    bindings : bindings of its native functions, by name
    residuals : the runtime residuals of this instance, or None
    model : gives the instance itself, None if there is none
    structure_version : changes whenever that of any table does
    use : the thread that solves this instance; its lock protects changes of rows and the
        preparation of problems
    angles_checked : whether angles were looked at that may be degrees
    """

    def __init__(self, layout: Layout, *, first_generations: dict[str, int] | None = None) -> None:
        self.layout = layout
        self.kernels: Any = None
        self.bindings: dict[str, Any] = {}
        self.residuals: Any = None
        self.model: Callable[[], Any] = _none
        self.structure_version = 0
        self.angles_checked = not layout.angles
        self.use = Use(layout.root)
        self.tables: dict[str, Table] = {}
        first = first_generations or {}
        for table in layout.tables:
            self.tables[table.path] = Table(self, table, first.get(table.path, 0))
        self._make_root()

    def _make_root(self) -> None:
        """Create the root's row with defaults, and record the fields without one."""
        root = self.tables[""]
        values, missing = {}, set()
        for path, column in root.data.items():
            if column.role == "ref":
                optional = root.ref_is_optional(column)
            else:
                has_default = column.default is not None
                values[path] = default_value(column) if has_default else blank(column)
                optional = has_default or column.role == "constraint_index"
            if not optional and not any(
                path == o or path.startswith(f"{o}.") for o in root.optionals
            ):
                missing.add(path)
        root.make_single_row(values)
        root.missing = missing

    @property
    def root(self) -> Table:
        """The root's table."""
        return self.tables[""]

    def next_version(self) -> int:
        """Increment the structure version."""
        self.structure_version += 1
        return self.structure_version

    def walk(self, table: str, steps: tuple[Step, ...]) -> tuple[Table, Ints]:
        """Follow `steps` from each row: the table reached and dense rows, -1 for null."""
        start = self.tables[table]
        return references.walk(start, steps, np.arange(start.size))

    def check_complete(self) -> None:
        """Raise E0702 for unset fields of the root; a solve needs every field without default.

        The first time angles that may be degrees are warned of.
        """
        root = self.root
        if root.missing:
            raise AraelError(
                [
                    problem(
                        "E0702",
                        f"`{path}` is not set",
                        self.layout.root,
                        root.data[path],
                        help=f"give it in the data, as `model.{path} = ...`, or declare a default",
                    )
                    for path in root.data
                    if path in root.missing
                ]
            )
        if not self.angles_checked:
            self.check_angles()

    def check_angles(self) -> None:
        """Warn of angles that may be degrees, W0702, once for each field."""
        # Imported here for start-up time: few models have angles as data.
        from arael.runtime.store.angles import warn_of_degrees

        self.angles_checked = warn_of_degrees(self)

    def fresh(self) -> Store:
        """Return an empty store of the same model to be filled and adopted."""
        store = Store(
            self.layout,
            first_generations={p: t.next_generation for p, t in self.tables.items()},
        )
        for path, table in self.tables.items():
            store.tables[path].take_flags_of_new(table)
        return store

    def adopt(self, other: Store) -> None:
        """Take over the data of a store created by `fresh`; all previous handles become stale.

        Raises AraelError: E1040 while the instance is being solved.
        """
        with self.use.changing("replace the data"):
            if self.residuals is not None:
                for label in self.residuals.priors:  # of rows that are replaced
                    self.residuals.remove(label)
            for path, table in self.tables.items():
                table.take_over(other.tables[path])


def _none() -> None:
    """No model."""
