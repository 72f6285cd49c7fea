"""Names and units of the scalars of parameters, free or fixed."""

from __future__ import annotations

import re

from arael.runtime.layout import Entity, Layout
from arael.runtime.problem import Problem

# Parameters whose tangent is an angle or a rotation vector.
_TURNS = frozenset({"euler", "rotation", "quaternion", "angle", "direction"})
_INDEX = re.compile(r"\[\d+\]")


def tangent_units(layout: Layout, entity: Entity) -> list[str]:
    """Unit of each tangent scalar of an entity, "" if there is none.

    The unit of a transform or a similarity is that of its translation; its rotation is in radians,
    its scale, whose tangent is a logarithm, has no unit.
    """
    found = [""] * entity.tangent
    table = layout.table(entity.table)
    for use in entity.params:
        column = table.column(use.column)
        unit = column.unit or ("rad" if use.kind in _TURNS else "")
        found[use.tangent_start : use.tangent_start + use.tangent] = [unit] * use.tangent
        for part in column.param.parts if column.param is not None else ():
            own = {"rotation": "rad", "scale": ""}.get(part.name, column.unit)
            first = use.tangent_start + part.first
            found[first : first + part.count] = [own] * part.count
    return found


def scalar_names_within(problem: Problem, name: str) -> list[str]:
    """Names of all scalars of a row or a parameter, whether or not they are solved for.

    Parameters
    ----------
    name : ``poses[3]``, ``poses[3].pos``, ``poses[3].pos.x``, a parameter of the root, or "" for
        all those of the root

    Returns
    -------
    In order of declaration; empty if there is no such row or parameter. Members of absent optional
    structs are omitted.
    """
    found = []
    plain = _INDEX.sub("", name)
    for entity in problem.layout.entities:
        path = entity.table
        if path and plain != path and not plain.startswith(f"{path}."):
            continue
        # The name of a row has as many parts as the path of its table.
        head = ".".join(name.split(".")[: path.count(".") + 1]) if path else ""
        table = problem.store.tables[path]
        row = next((r for r in range(table.size) if table.row_name(r) == head), None)
        if row is None:
            continue
        start = f"{head}." if head else ""
        for use in entity.params:
            if not table.present(use.column)[row]:
                continue
            for k in range(use.tangent_start, use.tangent_start + use.tangent):
                full = f"{start}{entity.prefix}{entity.tangent_names[k]}"
                if name in ("", full, head) or full.startswith(f"{name}."):
                    found.append(full)
    return found
