"""Operators and built-in functions on values: the language's own tables, applied to expressions.

Types, names and formulas are those of models (`arael.check`, `arael.compiler.scalarise`); here
they run on expressions in place of nodes of a graph.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from arael.check.builtins import FUNCTIONS, IDENTITIES
from arael.check.operators import OPERATIONS, advice, result_type
from arael.check.typed import BOOL, MatrixType, TransformType, ValueType, VectorType
from arael.compiler.scalarise import apply
from arael.diagnostics.records import Label, Span
from arael.sym.building import build
from arael.sym.errors import fail
from arael.sym.expr import Expr, arity, const
from arael.sym.shapes import as_value, composite
from arael.sym.value import Value
from arael.symbolic.graph import Graph
from arael.symbolic.prescribed import Prescribed
from arael.symbolic.scalars import SCALARS

Operand = tuple[Value, Span | None]
"""A value, and where it was written."""


class Written:
    """Takes the part of a graph whose nodes are expressions, made as they are written."""

    def op(self, name: str, *args: Expr) -> Expr:
        """Make an operation."""
        return build(name, *args)

    def const(self, value: float) -> Expr:
        """Make a constant."""
        return const(value)

    def value(self, node: Expr) -> float | None:
        """Value of a constant."""
        return node.value

    def call(self, function: Prescribed, args: Sequence[Expr], value: Expr) -> Expr:
        """Make the value of a function; its derivatives are looked up by its name."""
        return value


# The formulas are typed for graphs, whose nodes are numbers; they use no more than is above.
WRITTEN = cast(Graph, Written())


def operate_on_any(operator: str, a: Any, b: Any) -> Any:
    """``a operator b`` as Python's operators have it."""
    try:
        left, right = as_value(a), as_value(b)
    except (TypeError, ValueError):
        return NotImplemented
    if operator == "@":
        if isinstance(left.type, VectorType) and isinstance(right.type, VectorType):
            return call("dot", [(left, None), (right, None)])
        operator = "*"
    return operate(operator, (left, None), (right, None))


def operate(operator: str, a: Operand, b: Operand, at: Span | None = None) -> Value:
    """``a operator b`` with the language's operators.

    Raises
    ------
    AraelError
        E0301 if the shapes do not fit, E0307 if one is a condition.
    """
    left, right = number(*a), number(*b)
    type_ = result_type(operator, left.type, right.type)
    if type_ is None:
        fail(
            "E0301",
            f"`{left.type} {operator} {right.type}` does not fit",
            at,
            labels=_labels([a, b]),
            help=tuple(advice(operator, left.type, right.type)),
            origin="" if at else "expression",
        )
    return _applied(OPERATIONS[operator], [left, right], type_)


def negative(value: Value, at: Span | None = None) -> Value:
    """Opposite value."""
    if isinstance(value.type, TransformType):
        fail(
            "E0301",
            f"{value.type} has no opposite",
            at,
            help=("write `T.inverse()` for the way back",),
            origin="" if at else "expression",
        )
    return _applied("neg", [number(value, None)], value.type)


def logic(name: str, *args: Expr) -> Expr:
    """``and``, ``or``, ``not`` of conditions."""
    return build(name, *args)


def transposed(value: Value, at: Span | None) -> Value:
    """``M'``."""
    if not isinstance(value.type, MatrixType):
        hint = "write `dot(a, b)` for a' * b; `a * M` takes a vector as a row as it stands"
        fail(
            "E0301",
            f"only a matrix can be transposed, found {value.type}",
            at,
            help=(hint,) if isinstance(value.type, VectorType) else (),
        )
    return call("transpose", [(value, at)], at)


def call_on_any(name: str, *args: Any) -> Any:
    """Call a built-in function on what a Python caller gives."""
    return call(name, [(as_value(a), None) for a in args])


def call(name: str, args: Sequence[Operand], at: Span | None = None) -> Value:
    """Call the built-in function `name`.

    Raises
    ------
    AraelError
        E0303 for a wrong number of arguments, E0302 for wrong types, E0307 for conditions.
    """
    origin = "" if at else f"{name}()"
    if name in IDENTITIES:
        _count(name, len(args), 0, 0, "no", at)
        return _applied(name, [], IDENTITIES[name])
    signature = FUNCTIONS[name]
    _count(name, len(args), signature.least, signature.most, signature.arity, at)
    values = [number(value, place) for value, place in args]
    result = signature.result([v.type for v in values])
    if result is None:
        found = ", ".join(str(v.type) for v in values)
        fail(
            "E0302",
            f"`{name}` takes {signature.takes}, found {found}",
            at,
            labels=_labels(args),
            origin=origin,
        )
    operation, type_ = result if isinstance(result, tuple) else (name, result)
    if operation in ("min", "max"):
        first, *rest = values
        for other in rest:
            first = _applied(operation, [first, other], type_)
        return first
    return _applied(operation, values, type_)


def number(value: Value, at: Span | None) -> Value:
    """Return `value`, which must not be a condition."""
    if value.type == BOOL:
        fail(
            "E0307",
            "expected a number here",
            at,
            "this is a bool",
            help=("turn it into a number: `if ... then 1 else 0`",),
            origin="" if at else "expression",
        )
    return value


def _count(
    name: str, given: int, least: int, most: int | None, takes: str, at: Span | None
) -> None:
    if given < least or (most is not None and given > most):
        noun = "argument" if takes == "1" else "arguments"
        fail(
            "E0303",
            f"`{name}` takes {takes} {noun}, found {given}",
            at,
            "in this call",
            origin="" if at else f"{name}()",
        )


def _applied(operation: str, values: Sequence[Value], type_: ValueType) -> Value:
    entries = [list(v.entries) for v in values]
    made: Sequence[Expr]
    if values and isinstance(values[0].type, TransformType):
        from arael.sym.transforms import apply as on_transforms

        made = on_transforms(operation, values)
    elif operation in SCALARS:
        made = _elementwise(operation, entries)
    else:
        types = [v.type for v in values]
        lowered = cast(Callable[..., list[Expr]], apply)
        made = lowered(WRITTEN, operation, types, entries)
    return composite(type_, tuple(made))


def _elementwise(name: str, args: Sequence[Sequence[Expr]]) -> list[Expr]:
    assert len(args) == arity(name)
    n = max(map(len, args), default=1)
    columns = [a if len(a) == n else list(a) * n for a in args]
    return [build(name, *scalars) for scalars in zip(*columns, strict=True)]


def _labels(args: Sequence[Operand]) -> tuple[Label, ...]:
    return tuple(Label(at, f"this is {value.type}") for value, at in args if at is not None)
