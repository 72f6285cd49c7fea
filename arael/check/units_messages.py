"""Messages for units that do not fit: both operands, and the origin of each unit.

They require at least one declared unit: in a model without units, the radians of Euler angles and
arctangents are not checked.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.check.context import Context
from arael.check.typed import Apply, Literal_, Read, Select, Typed
from arael.check.units import DEG, ONE, RAD, Unit
from arael.check.units_quantities import NUMBER, Clash, Open, Quantity
from arael.check.units_rules import Misfit
from arael.check.walk import operands
from arael.diagnostics.records import Label, Span
from arael.operations import OPERATIONS

MAX_SOURCES = 2
MAX_WALK = 2000

# Functions whose result has a fixed unit.
_RESULTS = {
    **dict.fromkeys(("angle of", "angle of two", "radians", "to radians"), RAD),
    "to degrees": DEG,
    **dict.fromkeys(("angle", "pure"), ONE),
}
_GIVES = {
    **{one.name: _RESULTS[one.units] for one in OPERATIONS.values() if one.units in _RESULTS},
    **dict.fromkeys(("euler_angles", "rotation_vector", "quat_log"), RAD),
    **dict.fromkeys(("unit", "rotation_matrix"), ONE),
}

_SUMS = {"add": "add", "sub": "subtract", "lt": "compare", "le": "compare", "gt": "compare"}
_SUMS |= {"ge": "compare", "eq": "compare", "ne": "compare", "require": "compare"}
_WORDS = {"add": "to", "subtract": "from", "compare": "with"}


def unit_text(unit: Unit) -> str:
    """A unit in the middle of a sentence."""
    return "a pure number" if unit.is_one else str(unit)


def report_units(t: Context, node: Typed, problem: Clash | Misfit) -> None:
    """Report units of operands that do not fit."""
    if isinstance(problem, Clash):
        report_clash(t, node, problem)
    else:
        assert isinstance(node, Apply)
        report_misfit(t, node, problem)


def report_clash(t: Context, node: Typed, clash: Clash) -> None:
    """Report two different units in one sum."""
    parts = node.args if isinstance(node, Apply) else operands(node)
    if isinstance(node, Select):
        parts = (node.then, node.otherwise)
    if not any(written(t, part) for part in parts):
        return
    first, second = clash.first, clash.second
    t.fail(
        "E0321",
        node.span,
        _clash_message(node, first, second),
        labels=_sides(t, parts, (first, second)),
        help=_advice(first, second),
    )


def report_misfit(t: Context, node: Apply, misfit: Misfit) -> None:
    """Report an argument in the wrong unit."""
    arg = node.args[misfit.index]
    if not written(t, arg):
        return
    name = _shown_name(node)
    help_ = []
    text = arg.span.text if len(arg.span.text) <= 40 else "x"
    if misfit.unit == DEG and "angle" in misfit.wanted:
        help_ = [f"write `deg2rad({text})`"]
    elif misfit.wanted.startswith("a pure number"):
        help_ = [f"divide it by something in {misfit.unit} first"]
        if misfit.index == 1:
            help_ = ["an exponent has no unit"]
    elif "angle" in misfit.wanted:
        help_ = ["declare it in `[rad]`, or without a unit to disable the check"]
    if misfit.wanted == "an angle in degrees" and misfit.unit == RAD:
        help_ = [f"`{text}` is in radians already: omit `deg2rad`"]
    if misfit.wanted == "an angle in radians" and misfit.unit == DEG:
        help_ = [f"`{text}` is in degrees already: omit `rad2deg`"]
    t.fail(
        "E0322",
        node.span,
        f"{name} takes {misfit.wanted}, found {unit_text(misfit.unit)}",
        labels=[Label(arg.span, f"this is in {misfit.unit}"), *sources(t, arg)],
        help=help_,
    )


def _shown_name(node: Apply) -> str:
    names = {"quat_exp": "exp", "quat_log": "log", "pow": "a power"}
    name = names.get(node.name, node.name)
    return name if " " in name else f"`{name}`"


def _clash_message(node: Typed, first: Unit, second: Unit) -> str:
    a, b = unit_text(first), unit_text(second)
    if isinstance(node, Select):
        return f"the two branches of `if` differ in their units: {a} and {b}"
    assert isinstance(node, Apply)
    verb = _SUMS.get(node.name)
    if verb is None:
        what = "this product" if node.name == "mul" else f"`{node.name}`"
        return f"{what} adds {a} and {b}"
    if verb == "subtract":
        a, b = b, a
    return f"cannot {verb} {a} {_WORDS[verb]} {b}"


def _sides(t: Context, parts: Sequence[Typed], units: tuple[Unit, Unit]) -> list[Label]:
    """Each operand with its unit, and the origin of the unit."""
    labels: list[Label] = []
    for part in parts[:3]:
        quantity = t.units.of(part)
        if isinstance(quantity, tuple):
            text = "this is in " + _listed(quantity)
        elif isinstance(quantity, Unit):
            text = "this is a pure number" if quantity.is_one else f"this is in {quantity}"
        else:
            continue
        labels.append(Label(part.span, text))
    for part in parts[:3]:
        labels += [label for label in sources(t, part) if label not in labels]
    return labels


def _listed(quantity: Quantity) -> str:
    seen: list[str] = []
    for item in quantity if isinstance(quantity, tuple) else (quantity,):
        text = "?" if isinstance(item, Open) else str(item)
        if text not in seen:
            seen.append(text)
    return ", ".join(seen)


def _advice(first: Unit, second: Unit) -> list[str]:
    if {first, second} == {RAD, DEG}:
        return ["convert degrees to radians: `deg2rad(x)`"]
    if first.dimensions() == second.dimensions():
        factor = f"k: real [{first / second}] = {(second / first).factor:.12g}"
        return [
            "there is no implicit conversion: use one unit, or multiply the value in "
            f"{second} by a field `{factor}`"
        ]
    return [
        "a sum has one unit: multiply by what is missing, or correct a declared unit (a field "
        "without one is not checked)"
    ]


def sources(t: Context, node: Typed) -> list[Label]:
    """The declaration or the function that the unit of `node` comes from."""
    labels: list[Label] = []
    for here in _below(node, lambda n: isinstance(n, Apply) and n.name in _GIVES):
        label: Label | None = None
        quantity = t.units.of(here)
        if isinstance(here, Read) and not isinstance(quantity, Open):
            label = t.origins.get(here)
            declared = t.units.fields.get(here)
            if label is not None and declared is not None and not declared.unit:
                label = Label(label.span, f"{label.text}, in {quantity}")
        elif isinstance(here, Apply) and here is not node and here.name in _GIVES:
            unit = _GIVES[here.name]
            what = "a pure number" if unit.is_one else f"an angle, in {unit}"
            label = Label(here.span, f"this is {what}")
        if label is not None and label not in labels:
            labels.append(label)
        if len(labels) == MAX_SOURCES:
            break
    return labels


def written(t: Context, node: Typed) -> bool:
    """Whether `node` contains a value with a declared unit."""
    fields = t.units.fields
    for here in _below(node, lambda n: False):
        declared = fields.get(here)
        if declared is not None and declared.unit:
            return True
        if isinstance(here, Literal_) and isinstance(here.unit, Unit):
            return True
    return False


def _below(node: Typed, stop: object) -> list[Typed]:
    """`node` and its operands in depth-first order, down to where `stop` holds."""
    nodes: list[Typed] = []
    seen: set[Typed] = set()
    waiting = [node]
    while waiting and len(nodes) < MAX_WALK:
        here = waiting.pop()
        if here in seen:
            continue
        seen.add(here)
        nodes.append(here)
        if not (callable(stop) and stop(here)):
            waiting.extend(reversed(operands(here)))
    return nodes


def residual_units(t: Context, parts: Sequence[Typed]) -> None:
    """Warn of each part of a residual that has a unit."""
    for part in parts:
        quantity = t.units.of(part)
        units: list[Unit] = []
        for item in quantity if isinstance(quantity, tuple) else (quantity,):
            if isinstance(item, Unit) and not item.is_one and item not in units:
                units.append(item)
        if units and written(t, part):
            _warn(t, part.span, part, units)


def _with_unit(part: Typed, unit: Unit) -> str:
    """How to give the number a unit by which a residual is divided or multiplied; "" if none is."""
    if isinstance(part, Apply) and part.name in ("div", "mul"):
        number = part.args[1]
        if isinstance(number, Literal_) and number.unit == NUMBER and number.span.text:
            right = unit if part.name == "div" else ONE / unit
            return f"give the number its unit: `{number.span.text} [{right}]`"
    return ""


def _warn(t: Context, span: Span, part: Typed, kept: Sequence[Unit]) -> None:
    units = " and ".join(map(str, kept))
    inverse = ONE / kept[0]
    text = span.text if len(span.text) <= 40 and "\n" not in span.text else "..."
    shown = text if text.isidentifier() else f"({text})"
    t.report.warning(
        "W0301",
        span,
        f"the residual has the unit{'s' if len(kept) > 1 else ''} {units}",
        label=f"in {units}",
        labels=[] if isinstance(part, Read) and not t.origins else sources(t, part),
        notes=["a residual is dimensionless: divide it by the standard deviation of its noise"],
        help=[
            _with_unit(part, kept[0])
            or f"declare `isigma: real [{inverse}]` and write `{shown} * isigma`"
            if len(kept) == 1
            else "multiply each part by its inverse sigma: "
            + ", ".join(f"`[{ONE / unit}]`" for unit in kept)
        ],
    )
