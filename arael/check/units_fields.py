"""Rule: a declared unit exists and fits its type, and constants of a field have its unit.

Allowed: ``pos: vec3 [m]``, ``param ea: euler [rad]``, ``s: real [m] = 1``, ``s: real [m] = 1 [m]``.

Not allowed: ``[metrs]``, ``param ea: euler [m]``, ``name: string [m]``,
``s: real [m] = deg2rad(1)``, ``s: real [m] = 1 [mm]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from arael.check.declared import FieldDecl
from arael.check.suggest import nearest
from arael.check.typed import BOOL, QUATERNION, STRING
from arael.check.units import DEG, ONE, RAD, Unit
from arael.check.units_parsing import BadUnit, parse_unit
from arael.check.units_quantities import UNKNOWN, Clash, Quantity, all_joined, joined
from arael.check.units_table import known_names, short_name
from arael.diagnostics.records import Label
from arael.syntax import tree

if TYPE_CHECKING:
    from arael.check.report import Reporter

# The unit of each parameter type, and the declarations allowed for it.
_OF_PARAMS: dict[str, tuple[Unit, Sequence[Unit]]] = {
    "euler": (RAD, (RAD,)),
    "angle": (RAD, (RAD,)),
    "rotation": (ONE, (ONE, RAD)),
    "quaternion": (ONE, (ONE, RAD)),
    "direction": (ONE, (ONE, RAD)),
}


def declare_unit(field: FieldDecl, report: Reporter) -> None:
    """Resolve the unit of the values of `field`."""
    node = _declared(field.node.type)
    declared: Unit | None = None
    if node is not None:
        declared = unit_of(node, report)
        if declared is None:
            return
    kind = field.param.kind if field.param else ""
    if kind in _OF_PARAMS:
        unit, allowed = _OF_PARAMS[kind]
        field.quantity = unit
        if node is not None and declared not in allowed:
            _wrong(field, node, f"`{kind}` is in {allowed[-1]}, found {node.text}", report)
    elif field.type == QUATERNION:
        field.quantity = ONE
        if node is not None and declared != ONE:
            _wrong(field, node, f"a unit quaternion has no unit, found {node.text}", report)
    elif node is not None and (field.kind != "column" or field.type in (BOOL, STRING)):
        what = field.text.split(" [")[0]
        _wrong(field, node, f"`{what}` has no unit, found {node.text}", report)
    elif declared is not None:
        field.quantity = declared


def unit_of(node: tree.Unit, report: Reporter) -> Unit | None:
    """The unit that `node` names; None after an error."""
    try:
        return parse_unit(node.text)
    except BadUnit as wrong:
        _bad(node, wrong, report)
        return None


def _declared(type_: tree.TypeExpr) -> tree.Unit | None:
    if isinstance(type_, tree.OptionalType):
        return type_.inner.unit
    if isinstance(type_, tree.CollectionType):
        return type_.element.unit
    return type_.unit if isinstance(type_, tree.NamedType) else None


def _bad(node: tree.Unit, wrong: BadUnit, report: Reporter) -> None:
    if not wrong.name:
        report.error("E0320", node.span, f"`{node.text}` is not a unit", label=wrong.reason)
        return
    near = nearest(wrong.name, known_names())
    near = near and short_name(near)
    help_ = [f"did you mean `{near}`?"] if near else []
    report.error(
        "E0320",
        node.span,
        f"unknown unit `{wrong.name}`",
        label="not a unit",
        help=[
            *help_,
            "a unit is a product of m, kg, s, A, K, rad, deg, px, N, Hz ... such as `m/s^2` or "
            "`1/rad`; omit it to disable the check",
        ],
    )


def _wrong(field: FieldDecl, node: tree.Unit, message: str, report: Reporter) -> None:
    help_ = "omit the unit"
    if "rad" in message and "euler" in message + field.text:
        help_ = "omit the unit: Euler angles are radians; `deg2rad` converts data in degrees"
    report.error("E0323", node.span, message, label="does not fit this type", help=[help_])
    field.quantity = UNKNOWN


def check_constant(field: FieldDecl, node: tree.Expr, quantity: Quantity, report: Reporter) -> bool:
    """Whether a constant for `field` (a default, a bound, a setting of a pass) has its unit."""
    if not field.unit or field.quantity is UNKNOWN:
        return True
    try:
        joined(all_joined(field.quantity), all_joined(quantity))
    except Clash as clash:
        report.error(
            "E0323",
            node.span,
            f"`{field.name}` is in {clash.first}, found {clash.second}",
            label=f"this is in {clash.second}",
            labels=[Label(field.span, f"`{field.name}` is declared `{field.text}` here")],
            help=[_conversion(node, clash)],
        )
        return False
    return True


def _conversion(node: tree.Expr, clash: Clash) -> str:
    """Help for a constant in another unit than its field."""
    wanted, found = clash.first, clash.second
    number = node.text if isinstance(node, tree.Number) else ""
    if wanted == RAD and found == DEG:
        return f"units are not converted: write `deg2rad({number or 'x'})`"
    if number and wanted.dimensions() == found.dimensions():
        value = float(number) * found.factor / wanted.factor
        return f"units are not converted: write `{value:.12g} [{wanted}]`"
    return "correct the unit, or the value; a literal number takes the unit of the field"
