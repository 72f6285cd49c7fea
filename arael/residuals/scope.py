"""The names of a model's runtime residuals, and what formulas can read by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from arael.diagnostics.suggest import closest
from arael.face.ref import Refs
from arael.residuals.code import CodeResidual, CodeUpdate
from arael.residuals.code_arguments import PlacedArgument
from arael.residuals.code_group import CodeGroup
from arael.residuals.derivation import Derived
from arael.residuals.dotted import clash, within
from arael.residuals.expression import Definition, Expression, RuntimeResidual
from arael.residuals.further import Further
from arael.residuals.messages import error
from arael.residuals.schema import Row, schema_of


class ResidualNames:
    """Residuals, named expressions and parameters by name (`Surroundings` of formulas)."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self.schema = schema_of(model._compiled)
        self._derived: dict[str, Derived] = {}
        self._definitions: dict[str, Definition] = {}
        self._named: dict[str, RuntimeResidual] = {}  # owner of each parameter
        self._functions = Further.of(self.schema)
        self._adding: RuntimeResidual | None = None
        self._codes: dict[str, CodeResidual] = {}
        self._code_groups: dict[str, CodeGroup] = {}  # as far as they were asked for
        self._updates: dict[str, tuple[CodeUpdate, tuple[PlacedArgument, ...]]] = {}

    def parameter_owner(self, name: str) -> Expression | None:
        """The residual that owns the parameter `name`."""
        if self._adding is not None and name in self._adding.parameters:
            return self._adding
        return self._named.get(name)

    def definition(self, name: str) -> Definition | None:
        """The named expression `name`."""
        return self._definitions.get(name)

    def names(self) -> Iterable[str]:
        """Names of parameters and named expressions."""
        adding = () if self._adding is None else tuple(self._adding.parameters)
        return [*adding, *self._named, *self._definitions]

    def element(self, owner: Row, path: str, index: int) -> Refs | int:
        """Element `index` of the collection `path` of one row, or their number."""
        table = self._model._store.tables[path]
        if owner.refs is None:
            rows = np.arange(table.size)
        else:
            rows = np.flatnonzero(table.parent_rows() == owner.refs.rows[0])
        if index >= len(rows):
            return len(rows)
        return Refs(table, table.handles(rows[index : index + 1]))

    def _check_free(self, name: str, what: str, label: str = "residuals") -> None:
        owner = self.parameter_owner(name)
        taken = ""
        if owner is not None:
            taken = f"it is a parameter of `{owner.label}`"
        elif name in self._definitions:
            taken = "an expression has that name"
        elif what == "label" and (name in self._derived or name in self._codes):
            taken = "a residual has that label"
        elif what == "label" and name in self._updates:
            taken = "a function called before linearisations has that name"
        elif what == "parameter" and within(name, self._definitions):
            taken = f"an expression is named `{within(name, self._definitions)[0]}`"
        if taken:
            raise error("E0760", f"`{name}` cannot be a {what}: {taken}", label)

    def _check_clear(self, name: str) -> None:
        constants = self._functions.declared.declarations.consts
        fields = [*self.schema.members(Row((), "", known="")), *constants]
        meant = clash(name, fields, self._named, self._definitions)
        if meant:
            first = name.partition(".")[0]
            raise error(
                "E0760",
                f"`{name}` cannot be a name: {meant}",
                "residuals",
                f"`{name}` could be a part of it; choose another name before the dot"
                if first != name
                else "choose another name",
            )

    def _free_label(self) -> str:
        number = 1
        while f"residual_{number}" in (*self._derived, *self._codes):
            number += 1
        return f"residual_{number}"

    def _expression(self, label: str) -> Expression:
        if label in self._derived:
            return self._derived[label].residual
        if label in self._definitions:
            return self._definitions[label]
        raise self._unknown(label)

    def _unknown(self, label: str) -> Exception:
        near = closest(label, [*self._derived, *self._definitions, *self._codes])
        return error(
            "E0763",
            f"there is no runtime residual or expression `{label}`",
            "residuals",
            f"did you mean `{near[0]}`?" if near else "",
        )
