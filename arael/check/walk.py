"""Traversal of expressions without recursion, for any depth."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from arael.check.typed import (
    Apply,
    Component,
    Formula,
    Invoke,
    LookUp,
    Pack,
    Select,
    Total,
    Typed,
)
from arael.syntax import tree


def operands(node: Typed) -> tuple[Typed, ...]:
    """The operands of a typed expression, in order."""
    if isinstance(node, Apply):
        return node.args
    if isinstance(node, Invoke):
        return node.args if node.value is None else (*node.args, node.value)
    if isinstance(node, Component | Formula | Total):
        return (node.of,)
    if isinstance(node, LookUp):
        return (node.of, *node.rows)
    if isinstance(node, Pack):
        return node.items
    if isinstance(node, Select):
        return (node.cond, node.then, node.otherwise)
    return ()


def with_operands(node: Typed, given: Sequence[Typed]) -> Typed:
    """The same operation on other operands, which are as many as `operands` has."""
    if tuple(given) == operands(node):
        return node
    if isinstance(node, Apply):
        return replace(node, args=tuple(given))
    if isinstance(node, Invoke):
        count = len(node.args)
        value = None if node.value is None else given[count]
        return replace(node, args=tuple(given[:count]), value=value)
    if isinstance(node, Component | Formula | LookUp | Total):
        return replace(node, of=given[0])
    if isinstance(node, Pack):
        return replace(node, items=tuple(given))
    assert isinstance(node, Select)
    return replace(node, cond=given[0], then=given[1], otherwise=given[2])


def postorder(results: Iterable[Typed]) -> list[Typed]:
    """Every node below `results` once, operands before their users."""
    order: list[Typed] = []
    seen: set[Typed] = set()
    for result in results:
        waiting: list[tuple[Typed, bool]] = [(result, False)]
        while waiting:
            node, ready = waiting.pop()
            if ready:
                order.append(node)
            elif node not in seen:
                seen.add(node)
                waiting.append((node, True))
                waiting.extend((o, False) for o in reversed(operands(node)))
    return order


def subtrees(node: tree.Expr) -> Iterator[tree.Expr]:
    """`node` and every expression within it, as written."""
    waiting: list[tree.Expr | tree.Slice] = [node]
    while waiting:
        here = waiting.pop()
        if not isinstance(here, tree.Slice):
            yield here
        waiting.extend(reversed(_parts(here)))


def _parts(node: tree.Expr | tree.Slice) -> tuple[tree.Expr | tree.Slice, ...]:
    match node:
        case tree.Slice():
            return tuple(end for end in (node.low, node.high) if end is not None)
        case tree.Attribute():
            return (node.obj,)
        case tree.Index():
            return (node.obj, *node.indices)
        case tree.Call():
            return (node.func, *node.args)
        case tree.Unary() | tree.Transpose():
            return (node.operand,)
        case tree.Binary():
            return (node.left, node.right)
        case tree.Chain():
            return (node.low, node.middle, node.high)
        case tree.Conditional():
            return (node.cond, node.then, node.otherwise)
        case tree.ListExpr():
            return node.items
        case tree.Sum():
            return (node.over, *(let.value for let in node.body.lets), node.body.result)
        case tree.Lambda():
            return (node.body,)
        case _:
            return ()
