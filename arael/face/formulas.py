"""Python access to formulas of components, evaluated from the stored values on each read."""

from __future__ import annotations

from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.runtime.layout import Entity, Formula
from arael.runtime.machine.tape import evaluate

if TYPE_CHECKING:
    from arael.face.fields import Fields


def formula_at(fields: Fields, path: str) -> tuple[Entity, Formula] | None:
    """The ``symbolic`` or ``compute`` field at a dotted path below `fields`, if it is one."""
    full = f"{fields._group.path}.{path}" if fields._group.path else path
    for entity in fields._table.store.layout.entities:
        if entity.table == fields._table.layout.path:
            for formula in entity.formulas:
                if formula.path == full:
                    return entity, formula
    return None


def names(fields: Fields) -> set[str]:
    """Names of the formulas directly in `fields`."""
    here = f"{fields._group.path}." if fields._group.path else ""
    return {
        formula.path.removeprefix(here)
        for entity in fields._table.store.layout.entities
        if entity.table == fields._table.layout.path
        for formula in entity.formulas
        if formula.path.startswith(here) and "." not in formula.path.removeprefix(here)
    }


def read_formula(fields: Fields, entity: Entity, formula: Formula) -> Any:
    """Its value at one row, or (n, *shape) at many; None if an enclosing optional is absent."""
    table, rows = fields._table, fields._rows()
    if isinstance(rows, int) and not table.present(formula.path.rpartition(".")[0])[rows]:
        return None
    assert entity.values is not None
    stored = np.concatenate(
        [np.reshape(table.column(u.column)[rows], (-1, u.stored)) for u in entity.params], axis=1
    )
    nodes = evaluate(entity.values, list(stored.astype(np.float64).T))
    outputs = [nodes[output] for output in entity.values.outputs[formula.first :]]
    scalars = [np.broadcast_to(o, len(stored)) for o in outputs[: prod(formula.shape)]]
    found = np.stack(scalars, axis=-1).astype(np.bool_ if formula.kind == "bool" else table.real)
    found = found.reshape(len(stored), *formula.shape)
    if not isinstance(rows, int):
        return found
    return found[0] if formula.shape else found[0].item()
