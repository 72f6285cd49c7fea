"""Values of expressions: numbers, and in commands also coordinates."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, NoReturn, Protocol

from arael.diagnostics.records import AraelError, Diagnostic, Span
from arael.diagnostics.suggest import closest
from arael.sketch.expressions.functions import GEOMETRY, TRIGONOMETRY, scalar_functions
from arael.sketch.expressions.reading import Expression, path_of, read
from arael.sketch.expressions.units import factor
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

    def is_angle(self, path: str) -> bool:
        """Whether a name is an angle in degrees."""


class Compiled(NamedTuple):
    """A part of an expression as a function of the scope."""

    run: Callable[[Scope], Value]
    is_angle: Callable[[Scope], bool]


def evaluate(text: str, scope: Scope) -> Value:
    """Value of an expression.

    Trigonometric functions take angles (``30 deg``, ``L0.angle``) as what they are, and plain
    numbers as radians; inverse ones give radians as in models.

    Raises
    ------
    AraelError
        Errors of reading; E1262: a name without value; E1263: no finite value; E1253: numbers and
        coordinates mixed. Places are in a source of the text.
    """
    value = compiled(text).run(scope)
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


def _never(scope: Scope) -> bool:
    return False


def _always(scope: Scope) -> bool:
    return True


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
        return Compiled(lambda scope: -inner.run(scope), inner.is_angle)
    if isinstance(node, tree.Binary):
        return _binary(node)
    if isinstance(node, tree.Conditional):
        return _conditional(node)
    assert isinstance(node, tree.Call)
    return _call(node)


def _number(node: tree.Number) -> Compiled:
    value = float(node.text)
    if node.unit is None:
        return Compiled(lambda scope: value, _never)
    unit = node.unit.text
    unit = "in" if unit == "inch" else unit
    if unit in ("deg", "rad"):
        degrees = value * factor(unit, "mm")
        return Compiled(lambda scope: degrees, _always)
    return Compiled(lambda scope: value * factor(unit, scope.unit), _never)


def _named(path: str, span: Span) -> Compiled:
    def run(scope: Scope) -> Value:
        try:
            return scope.value(path)
        except NoValueError as error:
            _unnamed(error, span)

    return Compiled(run, lambda scope: scope.is_angle(path))


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

    return Compiled(run, _never)


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
}


def _power(a: float, b: float) -> float:
    return math.pow(a, b)


def _binary(node: tree.Binary) -> Compiled:
    left, right = _compile(node.left), _compile(node.right)
    apply = _BINARY.get(node.op, _power)
    span = node.span
    compares = node.op not in ("+", "-", "*", "/", "^")

    def run(scope: Scope) -> Value:
        a, b = left.run(scope), right.run(scope)
        try:
            found: Value = apply(a, b)
        except ZeroDivisionError:
            _wrong("E1263", "division by zero", span, "no value")
        except (OverflowError, ValueError):
            _wrong("E1263", f"`{node.op}` has no value here: {a} {node.op} {b}", span, "no value")
        except TypeError:
            what = f"`{node.op}` does not take {_kind(a)} and {_kind(b)}"
            _wrong("E1253", what, span, help_="coordinates are added, and multiplied by numbers")
        return float(bool(found)) if compares else found

    def is_angle(scope: Scope) -> bool:
        if node.op in ("+", "-"):
            return left.is_angle(scope) or right.is_angle(scope)
        if node.op == "*":
            return left.is_angle(scope) != right.is_angle(scope)
        return node.op == "/" and left.is_angle(scope) and not right.is_angle(scope)

    return Compiled(run, is_angle)


def _kind(value: Value) -> str:
    return "a coordinate" if isinstance(value, Vec) else "a number"


def _conditional(node: tree.Conditional) -> Compiled:
    cond, then, other = _compile(node.cond), _compile(node.then), _compile(node.otherwise)
    return Compiled(
        lambda scope: then.run(scope) if cond.run(scope) else other.run(scope),
        lambda scope: then.is_angle(scope) or other.is_angle(scope),
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
        if turns and args[0].is_angle(scope) and not isinstance(values[0], Vec):
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
    return Compiled(run, lambda scope: keeps and any(arg.is_angle(scope) for arg in args))


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

    return Compiled(run, lambda scope: name == "angle")


def _what(operand: Any) -> str:
    if isinstance(operand, float):
        return "a number"
    if isinstance(operand, Vec):
        return "a point"
    kind = type(operand).__name__.lower()
    return f"{'an' if kind[0] in 'aeio' else 'a'} {kind}"
