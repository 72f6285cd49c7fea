"""Rule: a default, and a bound of a parameter, is a constant that fits the type.

Allowed: ``w: real = 1 / 3``, ``m: mat2 = [[1, 0], [0, 1]]`` (or its four numbers),
``param a: vec2 in 0 .. [1, 2]``.

Not allowed: ``v: vec3 = 0`` (write `[0, 0, 0]`), ``n: int = 1.5``, bounds of a rotation, a lower
bound above the upper one.
"""

from __future__ import annotations

import math

import msgspec

from arael.check.constants import Constants
from arael.check.declared import FieldDecl
from arael.check.report import Reporter
from arael.check.typed import BOOL, INT, STRING, MatrixType, ScalarType, VectorType
from arael.check.types import size_of
from arael.check.units_fields import check_constant
from arael.diagnostics.records import Label
from arael.runtime.layout import Param
from arael.syntax import tree

INT_LIMIT = 2**53  # whole numbers beyond are not exact as a double


def default_of(
    field: FieldDecl, node: tree.Expr, constants: Constants, report: Reporter
) -> tuple[float, ...] | str | None:
    """Flat values of a default; None after an error."""
    if field.optional:
        report.error(
            "E0310",
            node.span,
            "an optional field takes no default",
            label="an omitted value is absent",
            help=["drop the `?` or the default"],
        )
        return None
    if field.type == STRING:
        if isinstance(node, tree.String):
            return node.value
        report.error("E0310", node.span, "expected a text in quotes", label="not a string")
        return None
    if isinstance(node, tree.String):
        report.error("E0310", node.span, f"expected {field.text}", label="this is a string")
        return None
    values = constant_for(field, node, constants, report)
    return values if values is None or _is_valid(field, values, node, report) else None


# Which scalars of a type form a unit quaternion or a unit vector.
_UNIT = {
    "quat": slice(4),
    "rotation": slice(4),
    "quaternion": slice(4),
    "direction": slice(3),
    "transform": slice(3, 7),
    "similarity": slice(3, 7),
}
UNIT_TOLERANCE = 1e-3  # the tolerance for data


def _is_valid(
    field: FieldDecl, values: tuple[float, ...], node: tree.Expr, report: Reporter
) -> bool:
    """Whether the default of a rotation, direction or transform is a valid one."""
    name = field.text.split(" ")[0]
    part = values[_UNIT[name]] if name in _UNIT else (1.0,)
    norm = math.hypot(*part)
    if abs(norm - 1) > UNIT_TOLERANCE:
        what = "a unit vector" if name == "direction" else "a unit quaternion (w, x, y, z)"
        report.error("E0310", node.span, f"expected {what}", label=f"its norm is {norm:.6g}")
        return False
    if name == "similarity" and values[7] <= 0:
        report.error("E0310", node.span, "expected a positive scale", label="the last number")
        return False
    return True


def constant_for(
    field: FieldDecl, node: tree.Expr, constants: Constants, report: Reporter
) -> tuple[float, ...] | None:
    """Flat values of a constant for the column `field`; None after an error."""
    constant = constants.evaluate(node)
    if constant is None:
        return None
    size = 1
    for n in field.shape:
        size *= n
    label = Label(field.span, f"`{field.name}` is declared `{field.text}` here")
    scalar = field.shape == ()
    rows = f"[{', '.join(['0'] * field.shape[-1])}]" if field.shape else ""
    table = f"[{', '.join([rows] * field.shape[0])}]" if len(field.shape) == 2 else rows
    shaped = isinstance(constant.type, MatrixType)
    misshapen = shaped and (constant.type != field.type or field.param is not None)
    if len(constant.values) != size or scalar != isinstance(constant.type, ScalarType) or misshapen:
        example = "a single number" if scalar else f"a list of {size} numbers"
        if len(field.shape) == 2:
            example = f"{field.shape[0]} rows of {field.shape[1]} numbers"
        report.error(
            "E0310",
            node.span,
            f"expected {example} for `{field.text}`, found {constant.type}",
            label="does not fit",
            labels=[label],
            help=[f"write `{table}`"] if not scalar and size <= 9 else [],
        )
        return None
    if (field.type == BOOL) != (constant.type == BOOL):
        report.error(
            "E0310",
            node.span,
            f"expected {field.type}, found {constant.type}",
            label="does not fit",
            labels=[label],
        )
        return None
    if field.type == INT and not (
        float(constant.values[0]).is_integer() and abs(constant.values[0]) <= INT_LIMIT
    ):
        report.error(
            "E0310",
            node.span,
            "expected a whole number",
            label=f"this is {constant.values[0]:.17g}",
            labels=[label],
        )
        return None
    return constant.values if check_constant(field, node, constant.unit, report) else None


def bounds_of(
    field: FieldDecl, bounds: tree.Bounds, constants: Constants, report: Reporter
) -> Param | None:
    """The parameter of `field` with its bounds; None after an error."""
    param = field.param
    if param is None or param.kind not in ("real", "vec"):
        report.error(
            "E0408",
            bounds.span,
            "only plain parameters have bounds",
            label=f"`{field.text}` is not one" if param else "this field is data, not a parameter",
            help=["bounds are for `param` of real, vec2, vec3, vec<n>"],
        )
        return None
    low = _bound(field, param, bounds.low, constants, report)
    high = _bound(field, param, bounds.high, constants, report)
    if low is None or high is None:
        return None
    for a, b in zip(low, high, strict=True):
        if a is not None and b is not None and a > b:
            report.error(
                "E0408",
                bounds.span,
                f"the lower bound {a:g} is above the upper bound {b:g}",
                label="no value is allowed",
            )
            return None
    return replace_bounds(param, low, high)


def default_within(field: FieldDecl, param: Param, node: tree.Expr, report: Reporter) -> bool:
    """Whether the default of `field` is within the bounds of `param`; reports an error if not."""
    ends = zip(field.default or (), param.low, param.high, strict=False)
    for value, low, high in ends:
        assert isinstance(value, float | int)
        below, above = low is not None and value < low, high is not None and value > high
        if below or above:
            report.error(
                "E0310",
                node.span,
                f"the default {value:g} of `{field.name}` is outside of its bounds",
                label=f"below {low:g}" if below else f"above {high:g}",
                labels=[Label(field.span, "declared here")],
                help=["a solve starts within the bounds"],
            )
            return False
    return True


def replace_bounds(
    param: Param, low: tuple[float | None, ...], high: tuple[float | None, ...]
) -> Param:
    """`param` with these bounds."""
    return msgspec.structs.replace(param, low=low, high=high)


def _bound(
    field: FieldDecl, param: Param, node: tree.Expr | None, constants: Constants, report: Reporter
) -> tuple[float | None, ...] | None:
    if node is None:
        return (None,) * param.tangent
    constant = constants.evaluate(node)
    if constant is None or not check_constant(field, node, constant.unit, constants.report):
        return None
    if isinstance(constant.type, ScalarType) and constant.type != BOOL:
        return constant.values * param.tangent
    if isinstance(constant.type, VectorType) and size_of(constant.type) == param.tangent:
        return constant.values
    report.error(
        "E0408",
        node.span,
        f"expected a number, or one for each of {param.tangent}, found {constant.type}",
        label="does not fit",
        labels=[Label(field.span, f"`{field.name}` is declared `{field.text}` here")],
    )
    return None
