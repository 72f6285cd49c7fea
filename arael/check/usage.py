"""Warnings: what a model declares and nothing uses."""

from __future__ import annotations

from collections.abc import Iterable

from arael.check.declared import Declarations
from arael.check.places import Sites
from arael.check.report import Reporter
from arael.check.typed import ConstraintSite, Read
from arael.check.walk import postorder


def warn_unused_structs(declarations: Declarations, report: Reporter) -> None:
    """Warn of structs that no root holds, directly or through others."""
    held = {r.name for r in declarations.roots}
    waiting = list(held)
    while waiting:
        for field in declarations.structs[waiting.pop()].fields.values():
            if field.kind in ("struct", "collection") and field.struct not in held:
                held.add(field.struct)
                waiting.append(field.struct)
    for name, struct in declarations.structs.items():
        if name not in held:
            report.warning(
                "W0401",
                struct.node.name.span,
                f"{struct.node.kind} `{name}` is never used",
                label="no root holds it",
                help=[
                    f"add `param x: {name}` to a struct or the root, or remove it"
                    if struct.component
                    else f"add `items: list of {name}` to the root, or remove it"
                ],
            )


def warn_unread_parameters(
    sites: Sites, constraints: Iterable[ConstraintSite], report: Reporter
) -> None:
    """Warn of parameters that no constraint reads: nothing determines them."""
    read: set[tuple[str, str]] = set()
    for site in constraints:
        for node in postorder(site.residual):
            if isinstance(node, Read) and node.version == "trial":
                read.add((site.slots[node.slot].table, node.column))
    for place in sites.places():
        for field in place.struct.fields.values():
            if field.param and (place.table.path, place.column(field)) not in read:
                where = place.table.path + "." if place.table.path else ""
                report.warning(
                    "W0601",
                    field.span,
                    f"no constraint reads the parameter `{where}{place.column(field)}`",
                    label="nothing determines it",
                    help=["add a constraint that depends on it, or drop `param`"],
                )
