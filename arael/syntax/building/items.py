"""Items: imports, constants, functions, structs."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import Span
from arael.syntax import tree
from arael.syntax.building.base import Builder
from arael.syntax.building.strings import make_string
from arael.syntax.tokens import Token

_PLACES: dict[str, tuple[type, ...]] = {
    "struct": (
        tree.Field,
        tree.Tie,
        tree.Constraint,
        tree.Prior,
        tree.Fixed,
        tree.Key,
        tree.SkipSelfBlock,
    ),
    "root": (
        tree.Field,
        tree.Tie,
        tree.Constraint,
        tree.Prior,
        tree.Fixed,
        tree.Fit,
        tree.Marginalize,
        tree.SkipSelfBlock,
        tree.Solve,
    ),
    "component": (tree.Field, tree.Fixed, tree.Symbolic, tree.Compute, tree.Update),
}


_MEMBER_WORDS: dict[type, str] = {
    tree.Tie: "param",
    tree.Constraint: "constraint",
    tree.Require: "require",
    tree.Prior: "prior",
    tree.Fixed: "fixed",
    tree.Fit: "fit",
    tree.Key: "key",
    tree.Marginalize: "marginalize",
    tree.SkipSelfBlock: "skip_self_block",
    tree.Solve: "solve",
    tree.Symbolic: "symbolic",
    tree.Compute: "compute",
    tree.Update: "update",
}


class ItemBuilder(Builder):
    """Builds the file and its items."""

    def _make_start(self, parts: list[Any], span: Span) -> tuple[tree.Item, ...]:
        return tuple(parts)

    def _make_expression(self, parts: list[Any], span: Span) -> tree.Expr:
        expr: tree.Expr = parts[0]
        return expr

    def _make_rule_alone(self, parts: list[Any], span: Span) -> tree.Expr:
        return self._make_expression(parts, span)

    def _make_import_(self, parts: list[Any], span: Span) -> tree.Import:
        return tree.Import(
            span=span, path=make_string(parts[0], self._log), doc=self._docs.of(span)
        )

    def _make_const(self, parts: list[Any], span: Span) -> tree.Const:
        name, value = parts
        return tree.Const(span=span, name=name, value=value, doc=self._docs.of(span))

    def _make_function(self, parts: list[Any], span: Span) -> tree.Function:
        extern, name, params, derivs, body = parts
        what = f"`extern fn {name.id}`" if extern else f"`fn {name.id}`"
        if extern and derivs is None:
            self._log.error(
                "E0142",
                f"{what} has no derivatives",
                name.span.start,
                name.span.end,
                "its value comes from native code, which cannot be differentiated",
                help=f"write `extern fn {name.id}(...) derivs [...]`, one expression per argument",
            )
        if extern and body is not None:
            self._log.error(
                "E0142",
                f"{what} has a body",
                body.span.start,
                body.span.end,
                "its value comes from native code",
                help="delete the body, or delete `extern`",
            )
        if not extern and body is None:
            self._log.error(
                "E0142",
                f"{what} has no body",
                name.span.start,
                name.span.end,
                "the formula is missing",
                help=f"write `fn {name.id}(...) = expression`, or `extern fn` for native code",
            )
        return tree.Function(
            span=span,
            name=name,
            params=params,
            body=body,
            derivs=derivs,
            extern=bool(extern),
            doc=self._docs.of(span),
        )

    def _make_params(self, parts: list[Any], span: Span) -> tuple[tree.Ident, ...]:
        return tuple(parts)

    def _make_derivs(self, parts: list[Any], span: Span) -> tuple[tree.Expr, ...]:
        return tuple(parts)

    def _make_struct(self, parts: list[Any], span: Span) -> tree.Struct:
        keyword, name, members = parts
        return self._struct(keyword.text, name, None, members, span)

    def _make_root(self, parts: list[Any], span: Span) -> tree.Struct:
        _, name, precision, members = parts
        return self._struct("root", name, precision, members, span)

    def _struct(
        self, kind: Any, name: Any, precision: Any, members: Any, span: Span
    ) -> tree.Struct:
        if precision is not None and precision.id not in ("f32", "f64"):
            self._log.error(
                "E0143",
                f"unknown precision `{precision.id}`",
                precision.span.start,
                precision.span.end,
                "a root computes in `f32` or `f64`",
            )
            precision = None
        for member in members:
            if not isinstance(member, _PLACES[kind]):
                self._misplaced(member, kind, name)
        return tree.Struct(
            span=span,
            kind=kind,
            name=name,
            members=members,
            precision=precision.id if precision else "",
            doc=self._docs.of(span),
        )

    def _misplaced(self, member: tree.Member, kind: str, name: tree.Ident) -> None:
        word = _MEMBER_WORDS[type(member)]
        homes = [home for home, allowed in _PLACES.items() if isinstance(member, allowed)]
        start = member.span.start
        self._log.error(
            "E0140",
            f"`{word}` does not belong in a {kind}",
            start,
            min(start + len(word), member.span.end),  # a misspelt keyword was read as this one
            f"a {' or a '.join(homes)} may have it",
            labels=[(name.span.start, name.span.end, f"this is a {kind}")],
        )

    def _make_members(self, parts: list[Any], span: Span) -> tuple[tree.Member, ...]:
        return tuple(p for p in parts if not isinstance(p, Token))
