"""Derivatives of expressions, by the same rules as in models."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import Any, cast

from arael.sym.errors import fail
from arael.sym.expr import Expr, const, postorder, rewrite
from arael.sym.limits import MAX_DERIVATIVES, MAX_DIFFERENTIATED
from arael.sym.operations import WRITTEN
from arael.sym.shapes import Matrix, Vector, as_value
from arael.sym.tidy import tidy
from arael.sym.value import V, Value
from arael.symbolic.scalars import SCALARS
from arael.symbolic.varying import FLAT

Partials = list[tuple[Expr, Expr]]


def diff(value: V, by: Expr | str, times: int = 1) -> V:
    """Differentiate every scalar of `value` by the variable `by`, `times` times.

    The derivative of a function of the language is the one that a model uses, with the same values
    at singular points: ``abs(x)`` has 0 at 0, ``sqrt(x)`` infinity.

    Raises
    ------
    AraelError
        E0652 if `by` is no variable, or `times` is out of range.
    """
    name = variable(by)
    if not 0 <= times <= MAX_DERIVATIVES:
        fail(
            "E0652",
            f"the order of a derivative is a whole number, found {times}",
            origin="diff",
            help=(f"write a number from 0 to {MAX_DERIVATIVES}",),
        )
    entries = list(value.entries)
    for _ in range(times):
        (entries,) = _Differentiation(entries).by([name])
    return value.with_entries(entries)


def gradient(value: Expr, by: Iterable[Expr | str] | None = None) -> Vector:
    """Derivatives of a scalar by each variable; by all of them, in alphabetical order."""
    return Vector(jacobian(Vector([value]), by).entries)


def jacobian(
    values: Value | Sequence[Expr | float], by: Iterable[Expr | str] | None = None
) -> Matrix:
    """Matrix of derivatives: a row per scalar of `values`, a column per variable.

    Parameters
    ----------
    values : a vector, or several expressions
    by : variables; by default all, in alphabetical order

    Raises
    ------
    AraelError
        E0652 if one of `by` is no variable, or there is none.
    """
    entries = as_value(values).entries
    names = [variable(v) for v in by] if by is not None else list(as_value(values).free_vars)
    if not names:
        fail(
            "E0652",
            "there is no variable to differentiate by",
            origin="jacobian",
            help=("name variables: `jacobian(f, [x, y])`",),
        )
    columns = _Differentiation(list(entries)).by(names)
    return Matrix([list(row) for row in zip(*columns, strict=True)])


def hessian(value: Expr, by: Iterable[Expr | str] | None = None) -> Matrix:
    """Matrix of second derivatives of a scalar; by all variables, in alphabetical order."""
    names = [variable(v) for v in by] if by is not None else list(value.free_vars)
    return jacobian(gradient(value, names), names)


def variable(by: Expr | str) -> str:
    """Name of the variable `by`; AraelError if it is not a variable."""
    if isinstance(by, str):
        from arael.sym.expr import symbol

        return symbol(by).name
    if isinstance(by, Expr) and by.op == "symbol":
        return by.name
    fail(
        "E0652",
        f"cannot differentiate by `{by}`",
        origin="diff",
        help=("differentiate by a variable, such as `x`",),
    )


class _Differentiation:
    """Forward mode over the expressions that `roots` are made of."""

    def __init__(self, roots: list[Expr]) -> None:
        self.roots = roots
        self.order = list(islice(postorder(roots), MAX_DIFFERENTIATED + 1))
        if len(self.order) > MAX_DIFFERENTIATED:
            fail(
                "E0653",
                f"what is differentiated has more than {MAX_DIFFERENTIATED} operations",
                origin="diff",
                help=(
                    "each derivative of a derivative is about three times as large: work out "
                    "numbers with `eval`, or differentiate a part",
                ),
            )
        self._partials: dict[int, Partials] = {}

    def by(self, names: Sequence[str]) -> list[list[Expr]]:
        """Derivatives of the roots, a list per name."""
        return [self._by(name) for name in names]

    def _by(self, name: str) -> list[Expr]:
        zero = const(0.0)
        found: dict[int, Expr] = {}
        for node in self.order:
            tangent = self._tangent(node, name, found)
            if tangent is not None and tangent.value != 0:
                found[id(node)] = tangent
        return [found.get(id(root), zero) for root in self.roots]

    def _tangent(self, node: Expr, name: str, found: dict[int, Expr]) -> Expr | None:
        if node.op == "symbol":
            return const(1.0) if node.data == name else None
        if not any(id(a) in found for a in node.args) or node.op in FLAT:
            return None
        branch = _branch(node)
        if branch is not None:
            condition, *arms = branch
            taken, otherwise = (found.get(id(arm), const(0.0)) for arm in arms)
            return tidy("select", condition, taken, otherwise)
        total: Expr | None = None
        for operand, partial in self._of(node):
            inner = found.get(id(operand))
            if inner is None or partial.value == 0:
                continue
            term = tidy("mul", partial, inner)
            total = term if total is None else tidy("add", total, term)
        return total

    def _of(self, node: Expr) -> Partials:
        known = self._partials.get(id(node))
        if known is None:
            known = self._partials[id(node)] = partials_of(node)
        return known


def partials_of(node: Expr) -> Partials:
    """Operands of `node` with the derivatives by them."""
    if node.op == "call":
        return list(zip(node.args, node.data.partials(node.args), strict=True))
    formal, slopes = _slopes(node.op, len(node.args))
    at = dict(zip(map(id, formal), (*node.args, node), strict=True))
    return list(zip(node.args, rewrite(slopes, at, tidy), strict=True))


def _branch(node: Expr) -> tuple[Expr, ...] | None:
    """Condition and arms of ``select``, ``min`` and ``max``, as `arael.symbolic.varying` has."""
    if node.op == "select":
        return node.args
    a, b = node.args if node.op in ("min", "max") else (node, node)
    if node.op == "min":
        return tidy("le", a, b), a, b
    return (tidy("le", b, a), a, b) if node.op == "max" else None


def written_out(name: str, *args: Expr) -> Expr:
    """Return the formula of a function of the language, as models have it."""
    build = cast(Any, SCALARS[name].build)
    return cast(Expr, build(WRITTEN, *args))


def from_term(term: Any, known: Mapping[Any, Expr]) -> Expr:
    """Return a derivative of `arael.symbolic.functions.partials` as an expression."""
    from arael.symbolic.functions import CONSTANTS, OPERATION_OF

    if term in known:
        return known[term]
    if term == 0 or term.is_number or term in CONSTANTS:
        return const(float(CONSTANTS.get(term, term)))
    args = [from_term(a, known) for a in term.args]
    if term.is_Pow and term.exp.is_negative:
        return tidy("div", const(1.0), from_term(term.base ** (-term.exp), known))
    if term.is_Pow and term.exp.is_Rational and term.exp.q == 2:
        root = tidy("sqrt", args[0])
        return root if term.exp.p == 1 else tidy("pow", root, const(float(term.exp.p)))
    if term.is_Add or term.is_Mul:
        first, *rest = args if term.is_Mul else sorted(args, key=lambda a: a.op != "const")
        for arg in rest:
            first = tidy("mul" if term.is_Mul else "add", first, arg)
        return first
    return tidy("pow" if term.is_Pow else OPERATION_OF[term.func], *args)


@cache
def _slopes(name: str, count: int) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Formal arguments of an operation, its value, and its derivatives by the arguments."""
    from arael.symbolic.functions import FORMAL, MAKERS, VALUE, partials

    formal = tuple(Expr("symbol", (), f"{name}.{i}") for i in range(count + 1))
    if name in MAKERS:
        symbols = dict(zip((*FORMAL[:count], VALUE), formal, strict=True))
        found = dict(partials(name, count))
        return formal, tuple(from_term(found.get(k, 0), symbols) for k in range(count))
    value = written_out(name, *formal[:count])
    columns = _Differentiation([value]).by([f.name for f in formal[:count]])
    # One object per argument, so that arguments can be put in place of it.
    table = {f.data: f for f in formal}
    unified = [
        rewrite([slope], {id(n): table[n.data] for n in postorder([slope]) if n.op == "symbol"})[0]
        for (slope,) in columns
    ]
    return formal, tuple(unified)


def _is_prescribed(name: str) -> bool:
    from arael.runtime.machine.tape import PRIMITIVES

    return name not in PRIMITIVES and SCALARS[name].arity > 0


WRITTEN_OUT = frozenset(name for name in SCALARS if _is_prescribed(name))
"""Functions whose derivatives come with them, or from the formula they stand for."""
