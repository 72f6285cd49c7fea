"""Formulas from text: the reader of models and of runtime residuals, with SymPy's values for names.

`arael.check` resolves and types a formula, `arael.compiler.scalarise` writes vectors, matrices and
rotations out as scalars; its graph is `Formulas`, so the scalars are SymPy expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import sympy as sp

from arael.check import access, calls, expressions
from arael.check.binding import Binding, Broken
from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES, ROW_METHODS
from arael.check.declared import Declarations
from arael.check.report import Reporter
from arael.check.scope import ConstantScope
from arael.check.suggest import did_you_mean
from arael.check.typed import INT, Apply, Formal, Invoke, Literal_, Typed
from arael.check.typist import Slots, Typist
from arael.check.walk import operands, postorder
from arael.compiler.scalarise import NoUses, Scalariser
from arael.diagnostics.arguments import as_mapping, fail, require
from arael.diagnostics.records import Findings, Source, Span
from arael.sym.functions import Formulas, operation
from arael.sym.limits import MAX_WRITTEN_OUT
from arael.sym.values import Value, as_value, composite, entries, require_size, size, type_of
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from arael.syntax import tree
from arael.syntax.parser import parse_expression

if TYPE_CHECKING:
    from arael.sym.user_functions import Function

Special = Callable[["Reader", tree.Call], Value]
"""A form that looks at its arguments as they are written, as ``diff(f, x)`` does."""


class Reader(Typist):
    """Reads trees of formulas into values.

    A name is, in this order: a parameter of the function that is read; one of `names`; a constant
    of the language; a variable.

    Attributes
    ----------
    bag : functions of the user
    names : values of names; within functions those of `constants`
    constants : the constants that functions see
    special : forms by name
    """

    def __init__(
        self,
        bag: Mapping[str, Function],
        names: Mapping[str, Value],
        constants: Mapping[str, Value],
        special: Mapping[str, Special] | None = None,
    ) -> None:
        declared = Declarations(functions={name: f.node for name, f in bag.items()})
        report = Reporter(Findings())
        scope = ConstantScope(declared, self.leaf_of)
        super().__init__(declared, report, _HANDLERS, scope, self.leaf_of, Slots([]))
        self.bag = bag
        self.names = names
        self.constants = constants
        self.special = special or {}
        self.leaves: list[Sequence[Any]] = []
        self._scalars = _Scalars(self.leaves, bag)

    def read(self, node: tree.Expr) -> Value:
        """Value of a formula.

        Raises
        ------
        AraelError
            With every mistake in it; E0653 if it is too large.
        """
        return self.finished(self.value(node))

    def finished(self, typed: Typed | Broken) -> Value:
        """Value of a formula that has been typed."""
        self.report.stop()
        assert isinstance(typed, Typed)
        _require_size(typed)
        found = self._scalars.nodes(typed)
        require_size(size(found), MAX_WRITTEN_OUT, "the formula, written out,")
        return composite(typed.type, found)

    def leaf(self, value: Value, span: Span) -> Typed | Broken:
        """Bind a value to the place where it is named."""
        if isinstance(value, sp.Integer):
            return self.make(Literal_(type=INT, span=span, value=float(value)))
        self.leaves.append(entries(value))
        return self.make(Formal(type=type_of(value), span=span, index=len(self.leaves) - 1))

    def leaf_of(self, name: str, span: Span) -> Typed | Broken:
        """Value of the name, or the variable of that name."""
        names = self.constants if self.calls else self.names
        return self.leaf(names[name] if name in names else sp.Symbol(name), span)


def parse(
    text: str | Source,
    functions: Mapping[str, Function] | None = None,
    names: Mapping[str, Any] | None = None,
) -> Value:
    """Read a formula in the notation of models.

    Parameters
    ----------
    text : such as ``"a * exp(-b * x) + c"``
    functions : a `FunctionBag`: functions of the user, which shadow built-in ones of the same name
    names : values of names: numbers, expressions, vectors, matrices, quaternions. What is not
        among them is a constant (``pi``, ``e``, ``epsilon``) or else becomes a variable.

    Returns
    -------
    A SymPy expression; a condition; a column for a vector, a matrix (`ImmutableMatrix`); SymPy's
    `Quaternion`; a `Transform`.

    Raises
    ------
    AraelError
        With the place in the text for what is wrong in it. Nothing of the text is ever run.
    """
    if not isinstance(text, str | Source):
        fail(
            "E0652",
            f"a formula is text, found {type(text).__name__}",
            origin="parse",
            help=('write for example `parse("a * x")`; an expression needs no parsing',),
        )
    bag = as_mapping(functions, str, "parse", "functions", "a `FunctionBag`")
    fits = all(hasattr(f, "node") for f in bag.values())
    require(fits, "parse", "functions", "a `FunctionBag`", functions)
    given = as_mapping(names, str, "parse", "names", "a mapping from names to values")
    source = text if isinstance(text, Source) else Source("formula", text)
    return _read(source, functions, {name: as_value(value) for name, value in given.items()})


def call(name: str, args: Sequence[Any], bag: Mapping[str, Function] | None = None) -> Value:
    """Call a function of the language, or of a bag, on values.

    Raises
    ------
    AraelError
        E0303 for a wrong number of arguments, E0302 for wrong types.
    """
    formals = [f"a{i}" for i in range(len(args))]
    source = Source(name, f"{name}({', '.join(formals)})")
    values = dict(zip(formals, map(as_value, args), strict=True))
    return _read(source, bag, values)


def _read(source: Source, bag: Mapping[str, Function] | None, values: Mapping[str, Value]) -> Value:
    reader = Reader({} if bag is None else bag, values, getattr(bag, "constants", {}))
    return reader.read(parse_expression(source))


class _Scalars(Scalariser):
    """Scalars of formulas as SymPy expressions."""

    def __init__(self, leaves: Sequence[Sequence[Any]], bag: Mapping[str, Function]) -> None:
        super().__init__(cast(Graph, Formulas()), NoUses(), cast(Any, bag))
        self.leaves = leaves

    def _needs(self, e: Typed) -> tuple[Typed, ...]:
        if isinstance(e, Invoke):
            return e.args  # not the formula of its value
        terms = _terms(e)
        return tuple(term for _, term in terms) if terms else super()._needs(e)

    def _scalarise(self, e: Typed) -> list[Any]:
        if isinstance(e, Formal):
            return list(self.leaves[e.index])
        if isinstance(e, Invoke):
            return [self.graph.call(self.functions[e.function], [self.nodes(a)[0] for a in e.args])]
        terms = _terms(e)
        if terms:
            # At once: SymPy takes the square of their number for one after the other.
            columns = [[-x if minus else x for x in self.nodes(t)] for minus, t in terms]
            return [operation("sum", *scalars) for scalars in zip(*columns, strict=True)]
        if isinstance(e, Apply) and e.name in SCALARS:
            args: Any = [self.nodes(a) for a in e.args]
            n = max(map(len, args), default=1)
            spread = [a if len(a) == n else list(a) * n for a in args]
            return [operation(e.name, *scalars) for scalars in zip(*spread, strict=True)]
        return cast("list[Any]", super()._scalarise(e))

    def _place(self, span: Span) -> int | None:
        return None


def _terms(e: Typed) -> list[tuple[bool, Typed]]:
    """Terms of a chain of more than one ``+`` or ``-``, and whether they are subtracted."""
    found: list[tuple[bool, Typed]] = []
    while isinstance(e, Apply) and e.name in ("add", "sub"):
        left, right = e.args
        found.append((e.name == "sub", right))
        e = left
    return [(False, e), *reversed(found)] if len(found) > 1 else []


def _require_size(typed: Typed) -> None:
    """Bound what the formula has written out, before it is made."""
    counts: dict[Typed, int] = {}
    for node in postorder([typed]):
        counts[node] = 1 + sum(counts[o] for o in operands(node))
    if counts[typed] > 2 * MAX_WRITTEN_OUT:
        what = f"written out, functions included, more than {MAX_WRITTEN_OUT} operations"
        fail("E0653", "expression is too large", typed.span, what)


def _number(t: Reader, node: tree.Number) -> Binding:
    if node.unit is None:
        return expressions.HANDLERS[tree.Number](t, node)
    label, help_ = "units are checked in model files", [f"write `{node.text}`"]
    return t.fail("E0320", node.unit.span, "this formula has no units", label=label, help=help_)


def _name(t: Reader, node: tree.Name) -> Binding:
    scope = cast(ConstantScope, t.scope)
    if node.id in scope.locals:
        return scope.locals[node.id][0]
    if node.id not in (t.constants if t.calls else t.names):
        if node.id in CONSTANTS:
            return t.leaf(operation(node.id), node.span)
        if node.id in IDENTITIES:
            return t.apply(node, node.id, [], IDENTITIES[node.id])
        if node.id in FUNCTIONS or node.id in t.bag:
            message, help_ = f"`{node.id}` is a function", [f"call it: `{node.id}(...)`"]
            return t.fail("E0304", node.span, message, label="expected a value here", help=help_)
    return t.leaf_of(node.id, node.span)


def _attribute(t: Reader, node: tree.Attribute) -> Binding:
    """``p.x`` of a value, or the variable ``L0.length``."""
    path = node.name
    inner: tree.Expr = node.obj
    while isinstance(inner, tree.Attribute):
        path, inner = f"{inner.name}.{path}", inner.obj
    names = t.constants if t.calls else t.names
    if isinstance(inner, tree.Name):
        path = f"{inner.id}.{path}"
        if path in names:
            return t.leaf_of(path, node.span)
        if inner.id not in cast(ConstantScope, t.scope).locals and inner.id not in names:
            return t.leaf_of(path, node.span)
    return access.attribute(t, node)


def _sum(t: Reader, node: tree.Sum) -> Binding:
    message, help_ = "sums over lists are part of model files", ["write the terms: `a + b + c`"]
    return t.fail("E0612", node.span, message, label="a formula has no lists", help=help_)


def _call(t: Reader, node: tree.Call) -> Binding:
    name = node.func.id if isinstance(node.func, tree.Name) else ""
    if name in t.bag:
        chain = [caller for caller, _ in t.calls]
        if name in chain:
            circle = [*chain[chain.index(name) :], name]
            path = " -> ".join(circle[:6] + ["..."] * (len(circle) > 6))
            message, label = f"function calls itself: {path}", "cannot be written out as a formula"
            help_ = ("formulas have no loops; give the function as a closed formula",)
            fail("E0605", message, t.bag[name].node.name.span, label, help=help_)
    elif name in t.special and not t.calls:
        return t.leaf(t.special[name](t, node), node.span)
    elif name and name not in FUNCTIONS and name not in IDENTITIES:
        near = did_you_mean(name, [*t.bag, *t.special, *FUNCTIONS, *IDENTITIES])
        if name in t.names:
            near = [f"`{name}` is a value; write `{name} * (...)` to multiply"]
        elif name in ROW_METHODS:
            near = [f"write `M.{name}(i)`"]
        message = f"unknown function `{name}`"
        return t.fail("E0205", node.func.span, message, label="not found", help=near)
    return calls.call(t, node)


_HANDLERS: Mapping[type, Callable[[Any, Any], Binding]] = {
    **expressions.HANDLERS,
    tree.Number: _number,
    tree.Name: _name,
    tree.Attribute: _attribute,
    tree.Call: _call,
    tree.Sum: _sum,
}
