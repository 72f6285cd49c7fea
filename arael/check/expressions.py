"""Expressions: operators, lists, conditionals; the table of typing functions by node class."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from arael.check.access import attribute, index, name
from arael.check.binding import BROKEN, Binding, Broken, Entity, OptionalValue, describe
from arael.check.builtins import widened
from arael.check.calls import call
from arael.check.field_reads import presence
from arael.check.guards import Fact, facts_of
from arael.check.operators import OPERATIONS, advice, result_type
from arael.check.sums import sum_over
from arael.check.typed import (
    BOOL,
    INT,
    QUATERNION,
    REAL,
    Literal_,
    MatrixType,
    Pack,
    ScalarType,
    Select,
    TransformType,
    Typed,
    VectorType,
)
from arael.check.types import size_of
from arael.check.typist import Typist
from arael.check.units_fields import unit_of
from arael.diagnostics.records import Label
from arael.syntax import tree


def _number(t: Typist, node: tree.Number) -> Binding:
    value = node.value
    if value in (float("inf"), float("-inf")):
        return t.fail("E0310", node.span, "number is too large", label="beyond 1.8e308")
    type_ = INT if node.is_integer else REAL
    if node.unit is None:
        return t.make(Literal_(type=type_, span=node.span, value=value))
    unit = unit_of(node.unit, t.report)
    if unit is None:
        return BROKEN
    return t.make(Literal_(type=type_, span=node.span, value=value, unit=unit))


def _boolean(t: Typist, node: tree.Boolean) -> Binding:
    return t.make(Literal_(type=BOOL, span=node.span, value=float(node.value)))


def _string(t: Typist, node: tree.String) -> Binding:
    return t.fail("E0304", node.span, "text cannot be computed with", label="this is a string")


def _lambda(t: Typist, node: tree.Lambda) -> Binding:
    return t.fail(
        "E0304",
        node.span,
        "expected a value here",
        label="`|s| ...` is written after `loss`",
    )


def _unary(t: Typist, node: tree.Unary) -> Binding:
    if node.op == "not":
        inner = condition(t, node.operand)
        return BROKEN if isinstance(inner, Broken) else t.apply(node, "not", [inner], BOOL)
    value = t.number(node.operand)
    if isinstance(value, Broken) or node.op == "+":
        return value
    if isinstance(value, Literal_):
        constant = value.constant
        if constant is not None:
            constant = replace(constant, negative=not constant.negative)
        return t.make(replace(value, span=node.span, value=-value.value, constant=constant))
    if isinstance(value.type, TransformType):
        return t.fail(
            "E0301",
            node.span,
            f"`-{value.type}` does not fit",
            label=f"this is {value.type}",
            help=("write `T.inverse()` for the inverse transform",),
        )
    return t.apply(node, "neg", [value], widened(value.type))


def _binary(t: Typist, node: tree.Binary) -> Binding:
    """A chain ``a + b - c``; long chains are left-deep trees, so they are handled in a loop."""
    if node.op in ("and", "or"):
        return _logic(t, node)
    chain = [node]
    while isinstance(chain[-1].left, tree.Binary) and chain[-1].left.op not in ("and", "or"):
        chain.append(chain[-1].left)
    left: Binding = t.number(chain[-1].left)
    for step in reversed(chain):
        right = t.number(step.right)
        if isinstance(left, Typed) and left.type == BOOL:
            left = t.fail(
                "E0307",
                step.left.span,
                "expected a number here",
                label="this is a bool",
                help=["join comparisons with `and`: `a < b and b < c`"],
            )
        both = isinstance(left, Typed) and isinstance(right, Typed)
        left = _operation(t, step, left, right) if both else BROKEN  # type: ignore[arg-type]
    return left


def _operation(t: Typist, node: tree.Binary, left: Typed, right: Typed) -> Binding:
    type_ = result_type(node.op, left.type, right.type)
    if type_ is not None:
        return t.apply(node, OPERATIONS[node.op], [left, right], widened(type_))
    return t.fail(
        "E0301",
        node.span,
        f"`{left.type} {node.op} {right.type}` does not fit",
        labels=[
            Label(left.span, f"this is {left.type}"),
            Label(right.span, f"this is {right.type}"),
            *t.origin(left),
            *t.origin(right),
        ],
        help=advice(node.op, left.type, right.type),
    )


def _logic(t: Typist, node: tree.Binary) -> Binding:
    chain = [node]
    while isinstance(chain[-1].left, tree.Binary) and chain[-1].left.op == node.op:
        chain.append(chain[-1].left)
    left: Binding = condition(t, chain[-1].left)
    before = t.facts
    for step in reversed(chain):
        if isinstance(left, Typed):
            holds, fails = facts_of(left, t.slots.steps)
            t.facts = before | (holds if node.op == "and" else fails)
        right = condition(t, step.right)
        if isinstance(left, Typed) and isinstance(right, Typed):
            left = t.apply(step, node.op, [left, right], BOOL)
        else:
            left = BROKEN
    t.facts = before
    return left


def condition(t: Typist, node: tree.Expr) -> Typed | Broken:
    """A boolean: a comparison, a flag, or the presence test of an optional."""
    binding = t.visit(node)
    asked = t.presence_of(binding, node.span)
    if asked is not None:
        return asked
    if isinstance(binding, OptionalValue):
        path = binding.entity.place.column(binding.field)
        test = presence(t, binding.entity, (*binding.entity.place.optionals, path), node.span)
        return test if isinstance(test, Typed) else BROKEN
    if isinstance(binding, Entity):
        place = binding.place
        optional = place.prefix and place.optionals and place.optionals[-1] + "." == place.prefix
        if optional or binding.needs:
            test = presence(t, binding, place.optionals, node.span)
            return test if isinstance(test, Typed) else BROKEN
        return t.fail(
            "E0502",
            node.span,
            f"`{node.span.text}` is always present",
            label=f"this is {describe(binding)}, not an optional",
            help=["only a field declared with `?` can be absent"],
        )
    value = t.as_value(binding, node.span)
    if isinstance(value, Typed) and value.type != BOOL:
        return t.fail(
            "E0307",
            node.span,
            "expected a condition here",
            label=f"this is {value.type}",
            labels=t.origin(value),
            help=["compare it: `x > 0`"] if isinstance(value.type, ScalarType) else [],
        )
    return value


def _transpose(t: Typist, node: tree.Transpose) -> Binding:
    value = t.number(node.operand)
    if isinstance(value, Broken):
        return BROKEN
    if isinstance(value.type, MatrixType):
        return t.apply(node, "transpose", [value], MatrixType(value.type.columns, value.type.rows))
    help_ = []
    if isinstance(value.type, VectorType):
        help_ = ["write `dot(a, b)` for a' * b; `a * M` treats a vector as a row"]
    elif value.type == QUATERNION:
        help_ = ["write `q.conj()` for the inverse rotation"]
    return t.fail(
        "E0301",
        node.span,
        f"only a matrix can be transposed, found {value.type}",
        labels=t.origin(value),
        help=help_,
    )


def _conditional(t: Typist, node: tree.Conditional) -> Binding:
    cond = condition(t, node.cond)
    holds: frozenset[Fact] = frozenset()
    fails: frozenset[Fact] = frozenset()
    if isinstance(cond, Typed):
        holds, fails = facts_of(cond, t.slots.steps)
    with t.knowing(holds):
        then = t.value(node.then)
    with t.knowing(fails):
        otherwise = t.value(node.otherwise)
    if isinstance(cond, Broken) or isinstance(then, Broken) or isinstance(otherwise, Broken):
        return BROKEN
    if widened(then.type) != widened(otherwise.type):
        return t.fail(
            "E0306",
            node.span,
            f"the two branches of `if` differ: {then.type} and {otherwise.type}",
            labels=[
                Label(then.span, f"this is {then.type}"),
                Label(otherwise.span, f"this is {otherwise.type}"),
            ],
        )
    type_ = widened(then.type)
    return t.make(Select(type=type_, span=node.span, cond=cond, then=then, otherwise=otherwise))


def _list(t: Typist, node: tree.ListExpr) -> Binding:
    """``[a, v, b]`` joins scalars and vectors; ``[[a, b], [c, d]]`` is a matrix of such rows."""
    if node.items and all(isinstance(part, tree.ListExpr) for part in node.items):
        return _matrix(t, node)
    items: list[Typed] = []
    broken = False
    for part in node.items:
        value = t.number(part)
        if isinstance(value, Broken):
            broken = True
        elif isinstance(value.type, VectorType) or value.type in (REAL, INT):
            items.append(value)
        else:
            broken = True
            help_ = ["take a part of it: `q.vec`"] if value.type == QUATERNION else []
            if isinstance(value.type, TransformType):
                help_ = ["take its twist, `T.log()`, or a part of it: `T.translation`"]
            t.fail(
                "E0312",
                part.span,
                "a list joins scalars and vectors",
                label=f"this is {value.type}",
                labels=t.origin(value),
                help=help_,
            )
    if broken:
        return BROKEN
    if not items:
        return t.fail("E0312", node.span, "an empty list has no value", label="put numbers in it")
    size = sum(size_of(i.type) for i in items)
    return t.make(Pack(type=VectorType(size), span=node.span, items=tuple(items)))


def _matrix(t: Typist, node: tree.ListExpr) -> Binding:
    rows = [t.number(part) for part in node.items]
    typed_rows = [row for row in rows if isinstance(row, Typed)]
    if len(typed_rows) < len(rows):
        return BROKEN
    sizes = [size_of(row.type) for row in typed_rows]
    odd = next((row for row in typed_rows if not isinstance(row.type, VectorType)), None)
    if odd is not None:
        return t.fail(
            "E0312",
            odd.span,
            "a row of a matrix is a list of scalars and vectors",
            label=f"this is {odd.type}",
        )
    for row, size in zip(typed_rows, sizes, strict=True):
        if size != sizes[0]:
            return t.fail(
                "E0312",
                row.span,
                "the rows of a matrix have one length",
                label=f"{size} element{'s' * (size != 1)}",
                labels=[Label(typed_rows[0].span, f"{sizes[0]} element{'s' * (sizes[0] != 1)}")],
                help=["for a vector, write all elements in one list: `[a, b, c]`"],
            )
    type_ = MatrixType(len(rows), sizes[0])
    return t.make(Pack(type=type_, span=node.span, items=tuple(typed_rows)))


HANDLERS: Mapping[type, Callable[[Typist, Any], Binding]] = {
    tree.Number: _number,
    tree.Boolean: _boolean,
    tree.String: _string,
    tree.Lambda: _lambda,
    tree.Name: name,
    tree.Attribute: attribute,
    tree.Index: index,
    tree.Call: call,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.Transpose: _transpose,
    tree.Conditional: _conditional,
    tree.ListExpr: _list,
    tree.Sum: sum_over,
}
