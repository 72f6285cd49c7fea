"""Members: fields, constraints, solve schedules."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import Span
from arael.syntax import tree
from arael.syntax.building.base import Builder
from arael.syntax.building.body import REQUIRE, SUM, check_body
from arael.syntax.tokens import Token


class MemberBuilder(Builder):
    """Builds the members of an item."""

    def _make_field(self, parts: list[Any], span: Span) -> tree.Field:
        role, name, type_, bounds, default = parts
        return tree.Field(
            span=span,
            name=name,
            type=type_,
            role=role.text if role else "data",
            bounds=bounds,
            default=default,
            doc=self._docs.of(span),
        )

    def _make_tie(self, parts: list[Any], span: Span) -> tree.Tie:
        _, name, value = parts
        return tree.Tie(span=span, name=name, value=value, doc=self._docs.of(span))

    def _make_bounds(self, parts: list[Any], span: Span) -> tree.Bounds:
        _, low, _, high = parts
        if low is None and high is None:
            self._log.error(
                "E0144",
                "bounds without a limit",
                span.start,
                span.end,
                "neither a lower nor an upper bound",
                help="write `in 0 ..`, `in .. 10` or `in 0 .. 10`",
            )
        return tree.Bounds(span=span, low=low, high=high)

    def _make_constraint(self, parts: list[Any], span: Span) -> tree.Constraint:
        name, clauses, body = parts
        return tree.Constraint(
            span=span,
            name=name,
            body=body,
            guard=clauses.get("when"),
            loss=clauses.get("loss"),
            into=clauses.get("into", ()),
            doc=self._docs.of(span),
        )

    def _make_require(self, parts: list[Any], span: Span) -> tree.Require:
        name, clauses, body = parts
        for word, reason in (
            ("loss", "it adds nothing to the cost: it holds, or the problem is infeasible"),
            ("into", "it adds to no block of the Hessian"),
        ):
            if word in clauses:
                where = clauses[word][0].span if word == "into" else clauses[word].span
                self._log.error(
                    "E0141",
                    f"`require` takes no `{word}`",
                    where.start,
                    where.end,
                    reason,
                    help=f"delete the clause, or write a `constraint` to have a `{word}`",
                )
        return tree.Require(
            span=span, name=name, body=body, guard=clauses.get("when"), doc=self._docs.of(span)
        )

    def _make_prior(self, parts: list[Any], span: Span) -> tree.Prior:
        target, _, distribution, args, clauses = parts
        if "into" in clauses:
            where = clauses["into"][0].span
            self._log.error(
                "E0141",
                "`prior` takes no `into`",
                where.start,
                where.end,
                "it couples no two entities",
                help="write a `constraint` to name Hessian blocks",
            )
        return tree.Prior(
            span=span,
            target=target,
            distribution=distribution,
            args=args or (),
            guard=clauses.get("when"),
            loss=clauses.get("loss"),
            doc=self._docs.of(span),
        )

    def _make_fit(self, parts: list[Any], span: Span) -> tree.Fit:
        collection, element, clauses, body = parts
        if "into" in clauses:
            where = clauses["into"][0].span
            self._log.error(
                "E0141",
                "`fit` takes no `into`",
                where.start,
                where.end,
                "its elements have no parameters of their own",
                help="write a `constraint` in the element's struct to name Hessian blocks",
            )
        return tree.Fit(
            span=span,
            collection=collection,
            element=element,
            body=body,
            guard=clauses.get("when"),
            loss=clauses.get("loss"),
            doc=self._docs.of(span),
        )

    def _make_clauses(self, parts: list[Any], span: Span) -> dict[str, Any]:
        clauses: dict[str, Any] = {}
        places: dict[str, Span] = {}
        for word, value, where in parts:
            if word in clauses:
                first = places[word]
                self._log.error(
                    "E0141",
                    f"second `{word}` clause",
                    where.start,
                    where.start + len(word),
                    "write it once",
                    labels=[(first.start, first.start + len(word), "the first one is here")],
                    help="join the guards with `and`" if word == "when" else (),
                )
            clauses.setdefault(word, value)
            places.setdefault(word, where)
        return clauses

    def _make_when(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        return "when", parts[1], span

    def _make_loss(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        return "loss", self._make_loss_alone(parts[1:], span), span

    def _make_loss_alone(self, parts: list[Any], span: Span) -> tree.Expr:
        kernel: tree.Expr = parts[0]
        if not isinstance(kernel, (tree.Call, tree.Lambda)):
            where = kernel.span
            name = kernel.id if isinstance(kernel, tree.Name) else "cauchy"
            self._log.error(
                "E0141",
                "`loss` needs a kernel with its argument",
                where.start,
                where.end,
                "not a call",
                help=f"write `loss {name}(1.0)`, or `loss |s| expression`",
            )
        return kernel

    def _make_into(self, parts: list[Any], span: Span) -> tuple[str, Any, Span]:
        return "into", tuple(parts[1:]), span

    def _make_body(self, parts: list[Any], span: Span) -> tree.Body:
        return check_body(parts, span, self._log)

    def _make_require_body(self, parts: list[Any], span: Span) -> tree.Body:
        return check_body(parts, span, self._log, REQUIRE)

    def _make_sum_body(self, parts: list[Any], span: Span) -> tree.Body:
        return check_body(parts, span, self._log, SUM)

    def _make_let(self, parts: list[Any], span: Span) -> tree.Let:
        name, value = parts
        return tree.Let(span=span, name=name, value=value)

    def _make_fixed(self, parts: list[Any], span: Span) -> tree.Fixed:
        return tree.Fixed(span=span, paths=tuple(parts))

    def _make_key(self, parts: list[Any], span: Span) -> tree.Key:
        return tree.Key(span=span, field=parts[0])

    def _make_marginalize(self, parts: list[Any], span: Span) -> tree.Marginalize:
        return tree.Marginalize(span=span, paths=tuple(parts))

    def _make_skip_self_block(self, parts: list[Any], span: Span) -> tree.SkipSelfBlock:
        return tree.SkipSelfBlock(span=span)

    def _make_symbolic(self, parts: list[Any], span: Span) -> tree.Symbolic:
        name, value = parts
        return tree.Symbolic(span=span, name=name, value=value, doc=self._docs.of(span))

    def _make_compute(self, parts: list[Any], span: Span) -> tree.Compute:
        name, value = parts
        return tree.Compute(span=span, name=name, value=value, doc=self._docs.of(span))

    def _make_update(self, parts: list[Any], span: Span) -> tree.Update:
        steps = tuple(p for p in parts if isinstance(p, tree.Setting))
        return tree.Update(span=span, steps=steps, doc=self._docs.of(span))

    def _make_solve(self, parts: list[Any], span: Span) -> tree.Solve:
        passes = tuple(p for p in parts if isinstance(p, tree.PassBlock))
        return tree.Solve(span=span, passes=passes, doc=self._docs.of(span))

    def _make_pass_(self, parts: list[Any], span: Span) -> tree.PassBlock:
        name, *rest = parts
        steps = tuple(p for p in rest if not isinstance(p, Token))
        return tree.PassBlock(span=span, name=name, steps=steps, doc=self._docs.of(span))

    def _make_setting(self, parts: list[Any], span: Span) -> tree.Setting:
        target, value = parts
        return tree.Setting(span=span, target=target, value=value)

    def _make_freeze(self, parts: list[Any], span: Span) -> tree.Freeze:
        word, *paths = parts
        return tree.Freeze(span=span, paths=tuple(paths), free=word.text == "free")
