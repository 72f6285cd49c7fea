"""Rule: a function with `derivs`, and each derivative, maps scalars to a scalar.

Allowed: ``fn f(x) derivs [2 * x] = x * x``, ``extern fn f(x, y) derivs [g(x), f(x, y)]``.

Not allowed: a vector, a truth value or a matrix as the formula or as one of the derivatives.

Functions without `derivs` may take any types that their formulas accept; those that accept scalars
are typed here too, so that Python can call them. The others are stored as text.
"""

from __future__ import annotations

import re
from dataclasses import replace

from arael.check.binding import Binding, Broken
from arael.check.builtins import is_number
from arael.check.constants import Constants
from arael.check.expressions import HANDLERS
from arael.check.limits import MAX_EXPANDED, MAX_MODEL_EXPANDED, MAX_OPERATIONS
from arael.check.report import Reporter
from arael.check.scope import ConstantScope
from arael.check.typed import REAL, Formal, MatrixType, Typed, TypedFunction, VectorType
from arael.check.typist import Slots, Typist
from arael.diagnostics.records import AraelError, Findings, Label, Span
from arael.syntax import tree


def type_functions(constants: Constants, report: Reporter) -> tuple[TypedFunction, ...]:
    """Every function of the model; those that do not accept scalars without a body."""
    found = []
    operations = expansion = 0
    for name, function in constants.declarations.functions.items():
        if name in constants.declarations.broken:
            continue
        prescribed = function.derivs is not None
        if not prescribed and (operations > MAX_OPERATIONS or expansion > MAX_EXPANDED):
            found.append(_as_text(function))  # a library of large formulas
            continue
        speaking = report if prescribed else Reporter(Findings())
        try:
            typed, t = _typed(function, constants, speaking)
        except AraelError:
            if prescribed:
                raise
            operations += MAX_OPERATIONS  # over the size limit
            found.append(_as_text(function))
            continue
        operations += t.operations
        expansion += t.expansion
        if prescribed and expansion > MAX_MODEL_EXPANDED:
            t.fail(
                "E0606",
                function.name.span,
                "the functions of this model are too large together",
                label=f"calls add more than {MAX_MODEL_EXPANDED} operations up to here",
            )
            return tuple(found)
        if typed is None and prescribed:
            constants.declarations.broken.add(name)
            continue
        found.append(typed or _as_text(function))
    return tuple(found)


def _typed(
    function: tree.Function, constants: Constants, report: Reporter
) -> tuple[TypedFunction | None, Typist]:
    before = len(report.findings.errors)
    formals = {p.id: Formal(type=REAL, span=p.span, index=i) for i, p in enumerate(function.params)}
    locals_: dict[str, tuple[Binding, Span]] = {
        p.id: (formals[p.id], p.span) for p in function.params
    }
    name = function.name.id
    scope = ConstantScope(constants.declarations, constants.named, locals_, f"`{name}`")
    t = Typist(constants.declarations, report, HANDLERS, scope, constants.named, Slots([]))
    vectors = function.derivs is None
    body = _scalar(t, function, function.body, "the formula", vectors) if function.body else None
    derivs = None
    if function.derivs is not None:
        derivs = [
            _scalar(t, function, node, f"the derivative by `{p.id}`", False)
            for p, node in zip(function.params, function.derivs, strict=True)
        ]
    if len(report.findings.errors) > before:
        return None, t
    derivatives = None if derivs is None else tuple(d for d in derivs if d is not None)
    return replace(_as_text(function), body=body, derivs=derivatives), t


def _as_text(function: tree.Function) -> TypedFunction:
    """A function without typed formulas."""
    return TypedFunction(
        name=function.name.id,
        params=tuple(p.id for p in function.params),
        native=function.extern,
        body=None,
        derivs=None,
        text="" if function.body is None else source_text(function.body),
        deriv_texts=tuple(source_text(d) for d in function.derivs or ()),
        span=function.name.span,
        doc=function.doc,
    )


def _scalar(
    t: Typist, function: tree.Function, node: tree.Expr, what: str, vectors: bool
) -> Typed | None:
    value = t.value(node)
    if isinstance(value, Broken):
        return None
    if is_number(value.type) or (vectors and isinstance(value.type, VectorType | MatrixType)):
        return value
    t.fail(
        "E0671",
        node.span,
        f"{what} of `{function.name.id}` is not a scalar, found {value.type}",
        label=f"this is {value.type}",
        labels=[Label(function.name.span, "a function with `derivs`")],
        help=["write one function per component, or omit `derivs`"],
    )
    return None


def source_text(node: tree.Expr) -> str:
    """The source text, on one line and without comments."""
    return " ".join(re.sub(r"#[^\n]*", " ", node.span.text).split())
