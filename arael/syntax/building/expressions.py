"""Expressions."""

from __future__ import annotations

from typing import Any, TypeVar

from arael.diagnostics.records import Source, Span
from arael.syntax import tree
from arael.syntax.building.base import Builder
from arael.syntax.building.strings import make_string
from arael.syntax.docs import DocComments
from arael.syntax.limits import MAX_HEIGHT
from arael.syntax.log import ErrorLog

_Node = TypeVar("_Node", bound=tree.Node)


class ExpressionBuilder(Builder):
    """Builds expressions, and limits their height."""

    def __init__(self, source: Source, docs: DocComments, log: ErrorLog) -> None:
        super().__init__(source, docs, log)
        self._heights: dict[Span, int] = {}  # by place: a part is shorter than its whole

    def _measured(self, node: _Node, *parts: tree.Node) -> _Node:
        """Record the height of `node` and report a tree that is too high for later stages."""
        heights = self._heights
        height = 1 + max((heights.get(p.span, 0) for p in parts), default=0)
        if isinstance(node, tree.Binary) and isinstance(node.left, tree.Binary):
            # A chain `a + b + c` is left-deep, and later stages handle it in a loop.
            height = max(heights[node.left.span], 1 + heights.get(node.right.span, 0))
        heights[node.span] = height
        if height > MAX_HEIGHT:
            self._log.error(
                "E0105",
                f"an expression of more than {MAX_HEIGHT} levels",
                node.span.start,
                min(node.span.end, node.span.start + 40),
                "is nested too deeply",
                help="name inner parts of it with `let`",
            )
            self._log.stop()
        return node

    def _make_conditional(self, parts: list[Any], span: Span) -> tree.Expr:
        cond, then, otherwise = parts
        node = tree.Conditional(span=span, cond=cond, then=then, otherwise=otherwise)
        return self._measured(node, *parts)

    def _make_binary(self, parts: list[Any], span: Span) -> tree.Expr:
        left, op, right = parts
        node = tree.Binary(span=span, op=op.text, left=left, right=right)
        return self._measured(node, left, right)

    def _make_chained(self, parts: list[Any], span: Span) -> tree.Expr:
        low, first, middle, second, high = parts
        node = tree.Chain(
            span=span, low=low, first=first.text, middle=middle, second=second.text, high=high
        )
        return self._measured(node, low, middle, high)

    def _make_unary(self, parts: list[Any], span: Span) -> tree.Expr:
        op, operand = parts
        node = tree.Unary(span=span, op=op.text, operand=operand)
        return self._measured(node, operand)

    def _make_transpose(self, parts: list[Any], span: Span) -> tree.Expr:
        return self._measured(tree.Transpose(span=span, operand=parts[0]), parts[0])

    def _make_attribute(self, parts: list[Any], span: Span) -> tree.Expr:
        obj, name = parts
        node = tree.Attribute(span=span, obj=obj, name=name.id, name_span=name.span)
        return self._measured(node, obj)

    def _make_index(self, parts: list[Any], span: Span) -> tree.Expr:
        obj, *indices = parts
        return self._measured(tree.Index(span=span, obj=obj, indices=tuple(indices)), *parts)

    def _make_slice(self, parts: list[Any], span: Span) -> tree.Slice:
        low, colon, high = parts
        node = tree.Slice(span=span, low=low, high=high, colon=colon.start)
        return self._measured(node, *(end for end in (low, high) if end is not None))

    def _make_call(self, parts: list[Any], span: Span) -> tree.Expr:
        func, args = parts
        if not isinstance(func, (tree.Name, tree.Attribute)):
            self._log.error(
                "E0136",
                "this is not a function",
                func.span.start,
                func.span.end,
                "called with brackets",
                help="write `*` for a product",
            )
        node = tree.Call(span=span, func=func, args=args or ())
        return self._measured(node, func, *node.args)

    def _make_sum_over(self, parts: list[Any], span: Span) -> tree.Expr:
        func, names, _, over, body = parts
        if not (isinstance(func, tree.Name) and func.id == "sum"):
            self._log.error(
                "E0136",
                "only `sum` runs over a list",
                func.span.start,
                func.span.end,
                "not `sum`",
                help="write `sum(k in self.knots) { ... }`",
            )
        if not all(isinstance(n, tree.Name) for n in names) or len(names) > 2:
            self._log.error(
                "E0136",
                "a sum names its element, or index and element",
                names[0].span.start,
                names[-1].span.end,
                "expected one name or two",
                help="write `sum(k in list) { ... }` or `sum(i, k in list) { ... }`",
            )
            names = (tree.Name(span=names[0].span, id="k"),)
        index, element = names if len(names) == 2 else (None, names[0])
        node = tree.Sum(
            span=span,
            index=None if index is None else tree.Ident(span=index.span, id=index.id),
            element=tree.Ident(span=element.span, id=element.id),
            over=over,
            body=body,
        )
        return self._measured(node, over, body.result, *(let.value for let in body.lets))

    def _make_arguments(self, parts: list[Any], span: Span) -> tuple[tree.Expr, ...]:
        return tuple(parts)

    def _make_number(self, parts: list[Any], span: Span) -> tree.Number:
        number, unit = parts
        return tree.Number(span=span, text=number.text, unit=unit)

    def _make_boolean(self, parts: list[Any], span: Span) -> tree.Boolean:
        return tree.Boolean(span=span, value=parts[0].text == "true")

    def _make_string(self, parts: list[Any], span: Span) -> tree.String:
        return make_string(parts[0], self._log)

    def _make_name(self, parts: list[Any], span: Span) -> tree.Name:
        return tree.Name(span=span, id=parts[0].id)

    def _make_list_expr(self, parts: list[Any], span: Span) -> tree.Expr:
        items = parts[0] or ()
        return self._measured(tree.ListExpr(span=span, items=items), *items)

    def _make_parens(self, parts: list[Any], span: Span) -> tree.Expr:
        inner: tree.Expr = parts[0]
        return inner

    def _make_lambda_(self, parts: list[Any], span: Span) -> tree.Lambda:
        *params, body = parts
        return self._measured(tree.Lambda(span=span, params=tuple(params), body=body), body)
