"""Values of expressions: numbers, and in commands also coordinates."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, NoReturn, Protocol, cast

from arael.diagnostics.records import AraelError, Diagnostic, Span
from arael.diagnostics.suggest import closest
from arael.sketch.expressions.functions import GEOMETRY, TRIGONOMETRY, scalar_functions
from arael.sketch.expressions.reading import Expression, chain, path_of, read
from arael.sketch.expressions.units import SPELLED, UNITS, factor
from arael.sketch.expressions.vectors import Vec
from arael.syntax import tree

Value = float | Vec


class NoValueError(Exception):
    """A name has no value; `help` proposes what to write."""

    def __init__(self, message: str, help: str = "", code: str = "E1262") -> None:
        super().__init__(message)
        self.help = help
        self.code = code


class Scope(Protocol):
    """What names mean."""

    @property
    def unit(self) -> str:
        """Unit of lengths."""

    def value(self, path: str) -> Value:
        """Value of a name; raises `NoValueError`."""

    def operand(self, path: str) -> Any:
        """What a geometric function reads by a name; raises `NoValueError`."""

    def quantity(self, path: str) -> str:
        """``length``, ``angle`` (in degrees) or ``area`` if a name is one, else empty."""


class Compiled(NamedTuple):
    """A part of an expression as a function of the scope.

    Attributes
    ----------
    run : its value
    quantity : ``length``, ``angle`` or ``area`` if it is one, empty for a plain number and where it
        is not known; raises E1261 where a length is added to an angle
    """

    run: Callable[[Scope], Value]
    quantity: Callable[[Scope], str]


def evaluate(text: str, scope: Scope) -> Value:
    """Value of an expression.

    Trigonometric functions take angles (``30 deg``, ``L0.angle``) as what they are, and plain
    numbers as radians; inverse ones give radians as in models.

    Raises
    ------
    AraelError
        Errors of reading; E1262: a name without value; E1263: no finite value; E1253: numbers and
        coordinates mixed; E1261: a length added to an angle. Places are in a source of the text.
    """
    found = compiled(text)
    value = found.run(scope)
    found.quantity(scope)
    if not (math.isfinite(value) if type(value) is float else _is_finite(value)):
        expression = read(text)
        _wrong("E1263", f"its value is not finite: {value}", _whole(expression), "no finite value")
    return value


def number(text: str, scope: Scope) -> float:
    """Value of an expression that is to be a number; AraelError as of `evaluate`."""
    value = evaluate(text, scope)
    if isinstance(value, Vec):
        help_ = "take a part of it: `p.x` or `p.y`, or use `dist`"
        _wrong("E1254", "expected a number, found a coordinate", _whole(read(text)), help_=help_)
    return value


class _Literals:
    """A scope in which only literals have units."""

    def quantity(self, path: str) -> str:
        return ""


def require_quantity(text: str, quantity: str) -> None:
    """Refuse ``12 mm`` for an angle and ``30 deg`` for a length; names may be taken as numbers.

    Raises
    ------
    AraelError
        E1261 with the place in the text.
    """
    if quantity not in ("length", "angle"):
        return
    found = compiled(text).quantity(cast(Scope, _Literals()))
    if not found or found == quantity:
        return
    names = ", ".join(
        written for written, name in SPELLED.items() if UNITS[name].quantity == quantity
    )
    message = f"expected {_article(quantity)}, found {_article(found)}"
    help_ = f"units of {quantity}s are {names}"
    _wrong("E1261", message, _whole(read(text)), help_=help_)


@lru_cache(maxsize=8192)
def compiled(text: str) -> Compiled:
    """An expression as a function; AraelError as of `read`."""
    return _compile(read(text).node)


def _whole(expression: Expression) -> Span:
    return Span(expression.source, 0, len(expression.text))


def _is_finite(value: Value) -> bool:
    if isinstance(value, Vec):
        return math.isfinite(value.x) and math.isfinite(value.y)
    return math.isfinite(value)


def _wrong(code: str, message: str, span: Span, label: str = "", help_: str = "") -> NoReturn:
    raise AraelError(Diagnostic(code, message, span, label, help=(help_,) if help_ else ()))


def _plain(scope: Scope) -> str:
    return ""


def _length(scope: Scope) -> str:
    return "length"


def _angle(scope: Scope) -> str:
    return "angle"


def _compile(node: tree.Expr) -> Compiled:
    if isinstance(node, tree.Number):
        return _number(node)
    path = path_of(node)
    if path:
        return _named(path, node.span)
    if isinstance(node, tree.Attribute):
        return _part(node)
    if isinstance(node, tree.Unary):
        inner = _compile(node.operand)
        if node.op == "+":
            return inner
        return Compiled(lambda scope: -inner.run(scope), inner.quantity)
    if isinstance(node, tree.Binary):
        return _binary(node)
    if isinstance(node, tree.Conditional):
        return _conditional(node)
    assert isinstance(node, tree.Call)
    return _call(node)


def _number(node: tree.Number) -> Compiled:
    value = float(node.text)
    if node.unit is None:
        return Compiled(lambda scope: value, _plain)
    unit = node.unit.text
    unit = "in" if unit == "inch" else unit
    if unit in ("deg", "rad"):
        degrees = value * factor(unit, "mm")
        return Compiled(lambda scope: degrees, _angle)
    return Compiled(lambda scope: value * factor(unit, scope.unit), _length)


def _named(path: str, span: Span) -> Compiled:
    def run(scope: Scope) -> Value:
        try:
            return scope.value(path)
        except NoValueError as error:
            _unnamed(error, span)

    return Compiled(run, lambda scope: scope.quantity(path))


def _unnamed(error: NoValueError, span: Span) -> NoReturn:
    _wrong(error.code, str(error), span, help_=error.help)


def _part(node: tree.Attribute) -> Compiled:
    """``midpoint(L0).x``."""
    inner = _compile(node.obj)

    def run(scope: Scope) -> Value:
        value = inner.run(scope)
        if isinstance(value, Vec) and node.name in ("x", "y"):
            return value.x if node.name == "x" else value.y
        what = "a coordinate has `x` and `y`" if isinstance(value, Vec) else "a number has no parts"
        _wrong("E1262", what, node.name_span, help_="write `.x` or `.y` after a coordinate")

    return Compiled(run, _plain)


_BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "^": math.pow,
}
_COMPARISONS = frozenset({"<", "<=", ">", ">=", "==", "!="})


def _binary(node: tree.Binary) -> Compiled:
    """A chain of operations, one after the other."""
    first_node, links = chain(node)
    first = _compile(first_node)
    steps = [(link.op, _compile(link.right), link.span) for link in links]

    def run(scope: Scope) -> Value:
        value = first.run(scope)
        for op, right, span in steps:
            value = _apply(op, value, right.run(scope), span)
        return value

    def quantity(scope: Scope) -> str:
        found = first.quantity(scope)
        for op, right, span in steps:
            other = right.quantity(scope)
            if op in _COMPARISONS or op in ("+", "-"):
                if found and other and found != other:
                    verb = "compared" if op in _COMPARISONS else "added"
                    what = f"{_article(found)} and {_article(other)} cannot be {verb}"
                    _wrong("E1261", what, span)
                found = "" if op in _COMPARISONS else found or other
            elif op == "*":
                found = "" if found and other else found or other
            else:
                found = found if op == "/" and not other else ""
        return found

    return Compiled(run, quantity)


def _apply(op: str, a: Value, b: Value, span: Span) -> Value:
    try:
        found: Value = _BINARY[op](a, b)
    except ZeroDivisionError:
        _wrong("E1263", "division by zero", span, "no value")
    except (OverflowError, ValueError):
        _wrong("E1263", f"`{op}` has no value here: {a} {op} {b}", span, "no value")
    except TypeError:
        what = f"`{op}` does not take {_kind(a)} and {_kind(b)}"
        _wrong("E1253", what, span, help_="coordinates are added, and multiplied by numbers")
    return float(bool(found)) if op in _COMPARISONS else found


def _article(quantity: str) -> str:
    return "a length" if quantity == "length" else f"an {quantity}"


def _kind(value: Value) -> str:
    return "a coordinate" if isinstance(value, Vec) else "a number"


def _conditional(node: tree.Conditional) -> Compiled:
    cond, then, other = _compile(node.cond), _compile(node.then), _compile(node.otherwise)
    return Compiled(
        lambda scope: then.run(scope) if cond.run(scope) else other.run(scope),
        lambda scope: then.quantity(scope) or other.quantity(scope),
    )


def _call(node: tree.Call) -> Compiled:
    assert isinstance(node.func, tree.Name)
    name = node.func.id
    if name in GEOMETRY:
        return _geometric(node, name)
    functions = scalar_functions()
    if name not in functions:
        near = closest(name, [*functions, *GEOMETRY])
        help_ = f"did you mean `{near[0]}`?" if near else "`help expressions` lists functions"
        _wrong("E0205", f"unknown function `{name}`", node.func.span, "not found", help_)
    function = functions[name]
    low, high = function.arity
    if not low <= len(node.args) <= high:
        takes = f"{low}" if low == high else f"{low} or more"
        plural = "" if takes == "1" else "s"
        message = f"`{name}` takes {takes} argument{plural}, found {len(node.args)}"
        _wrong("E0303", message, node.span, "in this call")
    args = [_compile(arg) for arg in node.args]
    turns = name in TRIGONOMETRY
    apply = function.value

    def run(scope: Scope) -> Value:
        values = [arg.run(scope) for arg in args]
        if turns and args[0].quantity(scope) == "angle" and not isinstance(values[0], Vec):
            values[0] = math.radians(values[0])
        numbers = [value for value in values if not isinstance(value, Vec)]
        if len(numbers) < len(values):
            _wrong("E1253", f"`{name}` does not take a coordinate", node.span)
        try:
            return float(apply(*numbers))
        except (ValueError, OverflowError, ZeroDivisionError):
            shown = ", ".join(f"{value:g}" for value in numbers)
            _wrong("E1263", f"`{name}({shown})` has no value", node.span, "no value")

    keeps = name in ("abs", "min", "max")

    def quantity(scope: Scope) -> str:
        found = [arg.quantity(scope) for arg in args]  # of every one: sums within are checked
        return next(filter(None, found), "") if keeps else ""

    return Compiled(run, quantity)


def _geometric(node: tree.Call, name: str) -> Compiled:
    function = GEOMETRY[name]
    if len(node.args) not in function.counts:
        message = f"`{name}` takes {function.takes}, found {len(node.args)}"
        _wrong("E0303", message, node.span, "in this call", f"write it like `{function.example}`")
    parts = [(path_of(arg), _compile(arg), arg.span) for arg in node.args]

    def run(scope: Scope) -> Value:
        operands: list[Any] = []
        for path, inner, span in parts:
            if not path:
                operands.append(inner.run(scope))
                continue
            try:
                operands.append(scope.operand(path))
            except NoValueError as error:
                _unnamed(error, span)
        try:
            found: Value = function.value(*operands)
        except (TypeError, AttributeError):
            have = ", ".join(_what(one) for one in operands)
            message = f"`{name}` takes {function.takes}, found {have}"
            _wrong("E1256", message, node.span, help_=f"write it like `{function.example}`")
        except ValueError as error:
            _wrong("E1263", f"`{name}` has no value: {error}", node.span, "no value")
        return found

    return Compiled(run, lambda scope: "angle" if name == "angle" else "")


def _what(operand: Any) -> str:
    if isinstance(operand, float):
        return "a number"
    if isinstance(operand, Vec):
        return "a point"
    kind = type(operand).__name__.lower()
    return f"{'an' if kind[0] in 'aeio' else 'a'} {kind}"
