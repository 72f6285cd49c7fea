"""Productions to tree nodes, with the checks that the grammar leaves to this place."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import Source, Span
from arael.syntax import tree
from arael.syntax.docs import DocComments
from arael.syntax.limits import MAX_HEIGHT
from arael.syntax.log import ErrorLog
from arael.syntax.tokens import Token

_ESCAPES = {'"': '"', "\\": "\\", "n": "\n", "t": "\t"}
_PLACES: dict[str, tuple[type, ...]] = {
    "struct": (tree.Field, tree.Constraint, tree.Key, tree.SkipSelfBlock),
    "root": (
        tree.Field,
        tree.Constraint,
        tree.Fit,
        tree.Marginalize,
        tree.SkipSelfBlock,
        tree.Solve,
    ),
    "component": (tree.Field, tree.Symbolic, tree.Compute, tree.Update),
}


class TreeBuilder:
    """Builds nodes bottom-up; one method per production, called with its kept parts and its place."""

    def __init__(self, source: Source, docs: DocComments, log: ErrorLog) -> None:
        self._source = source
        self._docs = docs
        self._log = log
        self._heights: dict[int, int] = {}
        self._too_high = False

    def __call__(self, production: str, parts: list[Any], start: int, end: int) -> Any:
        """Value of `production`."""
        return getattr(self, "make_" + production)(parts, Span(self._source, start, end))

    # --- file and items ---

    def make_start(self, parts: list[Any], span: Span) -> tuple[tree.Item, ...]:
        return tuple(parts)

    def make_expression(self, parts: list[Any], span: Span) -> tree.Expr:
        (expr,) = parts
        return expr  # type: ignore[no-any-return]

    def make_import_(self, parts: list[Any], span: Span) -> tree.Import:
        return tree.Import(span=span, path=self.make_string(parts, span), doc=self._docs.of(span))

    def make_const(self, parts: list[Any], span: Span) -> tree.Const:
        name, value = parts
        return tree.Const(span=span, name=name, value=value, doc=self._docs.of(span))

    def make_function(self, parts: list[Any], span: Span) -> tree.Function:
        extern, name, params, derivs, body = parts
        what = f"`extern fn {name.id}`" if extern else f"`fn {name.id}`"
        if extern and derivs is None:
            self._log.error(
                "E0142", f"{what} has no derivatives", name.span.start, name.span.end,
                "its value comes from native code, which cannot be differentiated",
                help=f"write `extern fn {name.id}(...) derivs [...]`, one expression per argument",
            )  # fmt: skip
        if extern and body is not None:
            self._log.error(
                "E0142", f"{what} has a body", body.span.start, body.span.end,
                "its value comes from native code",
                help="delete the body, or delete `extern`",
            )  # fmt: skip
        if not extern and body is None:
            self._log.error(
                "E0142", f"{what} has no body", name.span.start, name.span.end, "defined as what?",
                help=f"write `fn {name.id}(...) = expression`, or `extern fn` for native code",
            )  # fmt: skip
        return tree.Function(
            span=span, name=name, params=params, body=body, derivs=derivs, extern=bool(extern),
            doc=self._docs.of(span),
        )  # fmt: skip

    def make_params(self, parts: list[Any], span: Span) -> tuple[tree.Ident, ...]:
        return tuple(parts)

    def make_derivs(self, parts: list[Any], span: Span) -> tuple[tree.Expr, ...]:
        return tuple(parts)

    def make_struct(self, parts: list[Any], span: Span) -> tree.Struct:
        keyword, name, members = parts
        return self._struct(keyword.text, name, None, members, span)

    def make_root(self, parts: list[Any], span: Span) -> tree.Struct:
        _, name, precision, members = parts
        return self._struct("root", name, precision, members, span)

    def _struct(self, kind: Any, name: Any, precision: Any, members: Any, span: Span) -> tree.Struct:
        if precision is not None and precision.id not in ("f32", "f64"):
            self._log.error(
                "E0143", f"unknown precision `{precision.id}`",
                precision.span.start, precision.span.end, "a root computes in `f32` or `f64`",
            )  # fmt: skip
            precision = None
        for member in members:
            if not isinstance(member, _PLACES[kind]):
                self._misplaced(member, kind, name)
        return tree.Struct(
            span=span, kind=kind, name=name, members=members,
            precision=precision.id if precision else "", doc=self._docs.of(span),
        )  # fmt: skip

    def _misplaced(self, member: tree.Member, kind: str, name: tree.Ident) -> None:
        word = _MEMBER_WORDS[type(member)]
        homes = [home for home, allowed in _PLACES.items() if isinstance(member, allowed)]
        start = member.span.start
        self._log.error(
            "E0140",
            f"`{word}` does not belong in a {kind}",
            start,
            start + len(word),
            f"a {' or a '.join(homes)} may have it",
            labels=[(name.span.start, name.span.end, f"this is a {kind}")],
        )

    def make_members(self, parts: list[Any], span: Span) -> tuple[tree.Member, ...]:
        return tuple(p for p in parts if not isinstance(p, Token))

    # --- members ---

    def make_field(self, parts: list[Any], span: Span) -> tree.Field:
        role, name, type_, bounds, default = parts
        return tree.Field(
            span=span, name=name, type=type_, role=role.text if role else "data", bounds=bounds,
            default=default, doc=self._docs.of(span),
        )  # fmt: skip

    def make_bounds(self, parts: list[Any], span: Span) -> tree.Bounds:
        _, low, _, high = parts
        if low is None and high is None:
            self._log.error(
                "E0144", "bounds without an end", span.start, span.end,
                "neither a lower nor an upper bound",
                help="write `in 0 ..`, `in .. 10` or `in 0 .. 10`",
            )  # fmt: skip
        return tree.Bounds(span=span, low=low, high=high)

    def make_constraint(self, parts: list[Any], span: Span) -> tree.Constraint:
        name, clauses, body = parts
        return tree.Constraint(
            span=span, name=name, body=body, guard=clauses.get("when"), loss=clauses.get("loss"),
            into=clauses.get("into", ()), doc=self._docs.of(span),
        )  # fmt: skip

    def make_fit(self, parts: list[Any], span: Span) -> tree.Fit:
        collection, element, clauses, body = parts
        if "into" in clauses:
            where = clauses["into"][0].span
            self._log.error(
                "E0141", "`fit` takes no `into`", where.start, where.end,
                "its elements have no parameters of their own",
                help="write a `constraint` in the element's struct to name Hessian blocks",
            )  # fmt: skip
        return tree.Fit(
            span=span, collection=collection, element=element, body=body,
            guard=clauses.get("when"), loss=clauses.get("loss"), doc=self._docs.of(span),
        )  # fmt: skip

    def make_clauses(self, parts: list[Any], span: Span) -> dict[str, Any]:
        clauses: dict[str, Any] = {}
        places: dict[str, Span] = {}
        for word, value, where in parts:
            if word in clauses:
                first = places[word]
                self._log.error(
                    "E0141", f"second `{word}` clause", where.start, where.start + len(word),
                    "once is enough",
                    labels=[(first.start, first.start + len(word), "the first one is here")],
                    help="join the guards with `and`" if word == "when" else (),
                )  # fmt: skip
            clauses.setdefault(word, value)
            places.setdefault(word, where)
        return clauses

    def make_when(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        return "when", parts[1], span

    def make_loss(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        kernel = parts[1]
        if not isinstance(kernel, (tree.Call, tree.Lambda)):
            where = kernel.span
            name = kernel.id if isinstance(kernel, tree.Name) else "cauchy"
            self._log.error(
                "E0141", "`loss` needs a kernel with its argument", where.start, where.end,
                "not a call", help=f"write `loss {name}(1.0)`, or `loss |s| expression`",
            )  # fmt: skip
        return "loss", kernel, span

    def make_into(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        return "into", tuple(parts[1:]), span

    def make_lambda_(self, parts: list[Any], span: Span) -> tree.Lambda:
        *params, body = parts
        return self._measured(
            tree.Lambda(span=span, params=tuple(params), body=body), body
        )

    def make_body(self, parts: list[Any], span: Span) -> tree.Body:
        from arael.syntax.body import check_body

        return check_body(parts, span, self._log)

    def make_let(self, parts: list[Any], span: Span) -> tree.Let:
        name, value = parts
        return tree.Let(span=span, name=name, value=value)

    def make_key(self, parts: list[Any], span: Span) -> tree.Key:
        return tree.Key(span=span, field=parts[0])

    def make_marginalize(self, parts: list[Any], span: Span) -> tree.Marginalize:
        return tree.Marginalize(span=span, paths=tuple(parts[1:]))

    def make_skip_self_block(self, parts: list[Any], span: Span) -> tree.SkipSelfBlock:
        return tree.SkipSelfBlock(span=span)

    def make_symbolic(self, parts: list[Any], span: Span) -> tree.Symbolic:
        name, value = parts
        return tree.Symbolic(span=span, name=name, value=value, doc=self._docs.of(span))

    def make_compute(self, parts: list[Any], span: Span) -> tree.Compute:
        name, value = parts
        return tree.Compute(span=span, name=name, value=value, doc=self._docs.of(span))

    def make_update(self, parts: list[Any], span: Span) -> tree.Update:
        steps = tuple(p for p in parts if isinstance(p, tree.Setting))
        return tree.Update(span=span, steps=steps, doc=self._docs.of(span))

    def make_solve(self, parts: list[Any], span: Span) -> tree.Solve:
        passes = tuple(p for p in parts if isinstance(p, tree.Pass))
        return tree.Solve(span=span, passes=passes, doc=self._docs.of(span))

    def make_pass_(self, parts: list[Any], span: Span) -> tree.Pass:
        name, *rest = parts
        steps = tuple(p for p in rest if not isinstance(p, Token))
        return tree.Pass(span=span, name=name, steps=steps, doc=self._docs.of(span))

    def make_setting(self, parts: list[Any], span: Span) -> tree.Setting:
        target, value = parts
        return tree.Setting(span=span, target=target, value=value)

    def make_freeze(self, parts: list[Any], span: Span) -> tree.Freeze:
        word, *paths = parts
        return tree.Freeze(span=span, paths=tuple(paths), free=word.text == "free")

    # --- types ---

    def make_optional_type(self, parts: list[Any], span: Span) -> tree.OptionalType:
        return tree.OptionalType(span=span, inner=parts[0])

    def make_collection_type(self, parts: list[Any], span: Span) -> tree.CollectionType:
        word, element = parts
        return tree.CollectionType(span=span, kind=word.text, element=element)

    def make_ref_type(self, parts: list[Any], span: Span) -> tree.RefType:
        target, path = parts
        return tree.RefType(span=span, target=target, path=path)

    def make_block_type(self, parts: list[Any], span: Span) -> tree.BlockType:
        return tree.BlockType(span=span, entities=tuple(parts))

    def make_triplets_type(self, parts: list[Any], span: Span) -> tree.TripletsType:
        return tree.TripletsType(span=span)

    def make_named_type(self, parts: list[Any], span: Span) -> tree.NamedType:
        name, dims, unit = parts
        return tree.NamedType(span=span, name=name.text, dims=dims or (), unit=unit)

    def make_dims(self, parts: list[Any], span: Span) -> tuple[int, ...]:
        dims = []
        for number in parts:
            whole = number.text.isdigit() and len(number.text) <= 9 and int(number.text) > 0
            if not whole:
                self._log.error(
                    "E0127", f"`{number.text}` is not a dimension", number.start, number.end,
                    "a whole number from 1 on belongs here",
                )  # fmt: skip
            dims.append(int(number.text) if whole else 1)
        return tuple(dims)

    def make_unit(self, parts: list[Any], span: Span) -> tree.Unit:
        return tree.Unit(span=span, text="".join(t.text for t in parts[1:-1]))

    def make_path(self, parts: list[Any], span: Span) -> tree.Path:
        return tree.Path(span=span, parts=tuple(parts))

    def make_ident(self, parts: list[Any], span: Span) -> tree.Ident:
        return tree.Ident(span=span, id=parts[0].text)

    # --- expressions ---

    def _measured(self, node: Any, *parts: Any) -> Any:
        """Keep the height of `node` and refuse a tree that later stages could not walk."""
        heights = self._heights
        height = 1 + max((heights.get(id(p), 0) for p in parts), default=0)
        heights[id(node)] = height
        if height > MAX_HEIGHT and not self._too_high:
            self._too_high = True
            self._log.error(
                "E0105", f"an expression of more than {MAX_HEIGHT} steps", node.span.start,
                min(node.span.end, node.span.start + 40), "goes on for too long",
                help="name parts of it with `let`, or split the sum with brackets",
            )  # fmt: skip
            self._log.stop()
        return node

    def make_conditional(self, parts: list[Any], span: Span) -> tree.Expr:
        cond, then, otherwise = parts
        node = tree.Conditional(span=span, cond=cond, then=then, otherwise=otherwise)
        return self._measured(node, *parts)  # type: ignore[no-any-return]

    def make_binary(self, parts: list[Any], span: Span) -> tree.Expr:
        left, op, right = parts
        node = tree.Binary(span=span, op=op.text, left=left, right=right)
        return self._measured(node, left, right)  # type: ignore[no-any-return]

    def make_unary(self, parts: list[Any], span: Span) -> tree.Expr:
        op, operand = parts
        node = tree.Unary(span=span, op=op.text, operand=operand)
        return self._measured(node, operand)  # type: ignore[no-any-return]

    def make_transpose(self, parts: list[Any], span: Span) -> tree.Expr:
        return self._measured(tree.Transpose(span=span, operand=parts[0]), parts[0])  # type: ignore[no-any-return]

    def make_attribute(self, parts: list[Any], span: Span) -> tree.Expr:
        obj, name = parts
        node = tree.Attribute(span=span, obj=obj, name=name.id, name_span=name.span)
        return self._measured(node, obj)  # type: ignore[no-any-return]

    def make_index(self, parts: list[Any], span: Span) -> tree.Expr:
        obj, *indices = parts
        return self._measured(tree.Index(span=span, obj=obj, indices=tuple(indices)), *parts)  # type: ignore[no-any-return]

    def make_call(self, parts: list[Any], span: Span) -> tree.Expr:
        func, args = parts
        if not isinstance(func, (tree.Name, tree.Attribute)):
            self._log.error(
                "E0136", "this is not a function", func.span.start, func.span.end,
                "called with brackets", help="write `*` for a product",
            )  # fmt: skip
        node = tree.Call(span=span, func=func, args=args or ())
        return self._measured(node, func, *node.args)  # type: ignore[no-any-return]

    def make_arguments(self, parts: list[Any], span: Span) -> tuple[tree.Expr, ...]:
        return tuple(parts)

    def make_number(self, parts: list[Any], span: Span) -> tree.Number:
        return tree.Number(span=span, text=parts[0].text)

    def make_boolean(self, parts: list[Any], span: Span) -> tree.Boolean:
        return tree.Boolean(span=span, value=parts[0].text == "true")

    def make_string(self, parts: list[Any], span: Span) -> tree.String:
        token: Token = parts[0]
        value, rest = [], iter(enumerate(token.text[1:-1], token.start + 1))
        for at, char in rest:
            if char == "\\":
                _, char = next(rest)
                if char not in _ESCAPES:
                    self._log.error(
                        "E0112", f"unknown escape `\\{char}`", at, at + 2, "not one of `\\\"` `\\\\` `\\n` `\\t`",
                        help="folders in a path are separated with `/`",
                    )  # fmt: skip
                char = _ESCAPES.get(char, char)
            value.append(char)
        return tree.String(span=Span(self._source, token.start, token.end), value="".join(value))

    def make_name(self, parts: list[Any], span: Span) -> tree.Name:
        return tree.Name(span=span, id=parts[0].id)

    def make_list_expr(self, parts: list[Any], span: Span) -> tree.Expr:
        items = parts[0] or ()
        return self._measured(tree.ListExpr(span=span, items=items), *items)  # type: ignore[no-any-return]

    def make_parens(self, parts: list[Any], span: Span) -> tree.Expr:
        return parts[0]  # type: ignore[no-any-return]


_MEMBER_WORDS: dict[type, str] = {
    tree.Constraint: "constraint",
    tree.Fit: "fit",
    tree.Key: "key",
    tree.Marginalize: "marginalize",
    tree.SkipSelfBlock: "skip_self_block",
    tree.Solve: "solve",
    tree.Symbolic: "symbolic",
    tree.Compute: "compute",
    tree.Update: "update",
}
