"""Warnings: unused declarations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from arael.check.declared import Declarations
from arael.check.places import Place, Sites
from arael.check.report import Reporter
from arael.check.typed import Apply, ComponentSite, ConstraintSite, Definition, Read, Typed
from arael.check.units import RAD
from arael.check.walk import operands, postorder
from arael.diagnostics.records import Label


def warn_unused_structs(declarations: Declarations, report: Reporter) -> None:
    """Warn of structs that no root contains, directly or indirectly."""
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
                label="no root contains it",
                help=[
                    f"add `param x: {name}` to a struct or the root, or remove it"
                    if struct.component
                    else f"add `items: list of {name}` to the root, or remove it"
                ],
            )


def warn_unread_parameters(
    sites: Sites, constraints: Iterable[ConstraintSite], report: Reporter
) -> None:
    """Warn of parameters that no constraint reads: nothing determines them.

    A model without any constraint is made for residuals that are added at run time.
    """
    constraints = list(constraints)
    if not constraints:
        return
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
                    help=["add a constraint that depends on it, or remove `param`"],
                )


def warn_lost_derivatives(
    sites: Sites,
    components: Mapping[Place, tuple[ComponentSite, ...]],
    constraints: Iterable[ConstraintSite],
    report: Reporter,
) -> None:
    """Warn of residuals that depend on a parameter through a ``compute`` field alone."""
    computed: dict[tuple[str, str], Definition] = {}
    for place in sites.places():
        for component in components.get(place, ()):
            for one in component.computed:
                computed[place.table.path, one.column] = one
    for site in constraints:
        for read in postorder(site.residual):
            if isinstance(read, Read) and read.version == "computed":
                table = site.slots[read.slot].table
                origin = _parameter_below(computed[table, read.column].value, table, computed)
                if origin is None:
                    continue
                name = read.column.rpartition(".")[2]
                report.warning(
                    "W0602",
                    read.span,
                    f"`{name}` is computed from the parameter `{origin.span.text}`, and has no "
                    "derivative",
                    label="counts as a constant here",
                    labels=[Label(origin.span, "the parameter is read here")],
                    help=[f"declare `symbolic {name} = ...`, which is differentiated"],
                )


def warn_unwrapped_angles(
    sites: Sites, constraints: Iterable[ConstraintSite], report: Reporter
) -> None:
    """Warn of residuals that subtract an ``angle`` and another angle without ``rad_diff``.

    The other one is an ``angle``, ``atan2``, or data in radians.
    """
    radians = {
        (place.table.path, place.column(field))
        for place in sites.places()
        for field in place.struct.fields.values()
        if field.param is None and field.quantity == RAD
    }
    warned: set[tuple[int, int]] = set()
    for site in constraints:
        waiting: list[tuple[Typed, Typed | None]] = [(part, None) for part in site.residual]
        seen: set[Typed] = set()
        while waiting:
            node, above = waiting.pop()
            if node in seen or (isinstance(node, Apply) and node.name in _PERIODIC):
                continue
            seen.add(node)
            waiting += [(operand, node) for operand in operands(node)]
            if not _is_difference(node) or not any(map(_is_angle, operands(node))):
                continue
            if not all(_may_wrap(site, operand, radians) for operand in operands(node)):
                continue
            place = (node.span.start, node.span.end)
            if place in warned:
                continue
            warned.add(place)
            first, second = (operand.span.text for operand in operands(node))
            right = f"rad_diff({first}, {second})"
            if above is not None and _is_difference(above) and operands(above)[0] is node:
                right = f"rad_diff({first} - {second}, {operands(above)[1].span.text})"
            report.warning(
                "W0603",
                node.span,
                "the difference of two angles jumps by 2 pi where one of them is wrapped",
                label="3.1 and -3.1 differ by 6.2 here",
                help=[f"write `{right}`"],
            )


# Functions of an angle that 2 pi more do not change.
_PERIODIC = frozenset({"rad_diff", "rad_sum", "sin", "cos", "tan"})
# Functions whose value is an angle.
_ANGLES = frozenset({"atan2", "deg2rad"})


def _is_difference(node: Typed) -> bool:
    return isinstance(node, Apply) and node.name == "sub"


def _is_angle(node: Typed) -> bool:
    return isinstance(node, Read) and node.parameter == "angle"


def _may_wrap(site: ConstraintSite, node: Typed, radians: set[tuple[str, str]]) -> bool:
    if isinstance(node, Read) and node.version == "data":
        return (site.slots[node.slot].table, node.column) in radians
    return _is_angle(node) or (isinstance(node, Apply) and node.name in _ANGLES)


def _parameter_below(
    value: Typed, table: str, computed: Mapping[tuple[str, str], Definition]
) -> Read | None:
    """A parameter that `value` depends on, also through other computed fields."""
    for node in postorder([value]):
        if not isinstance(node, Read):
            continue
        if node.version == "trial" and node.parameter:
            return node
        if node.version == "computed":
            parameter = _parameter_below(computed[table, node.column].value, table, computed)
            if parameter is not None:
                return parameter
    return None
