"""Numbers from SymPy expressions, on arrays, by the programs that evaluate models."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import reduce
from typing import Any, NoReturn

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.core.relational import Relational
from sympy.logic.boolalg import BooleanFunction

from arael.check.typed import BOOL, REAL, ValueType
from arael.check.types import shape_of
from arael.diagnostics.arguments import as_numbers, fail
from arael.diagnostics.suggest import closest
from arael.operations import OPERATIONS
from arael.runtime.machine.programs import evaluate as run
from arael.sym.functions import OWN, UserFunction
from arael.sym.values import Value, as_value, by_variable, entries, free_vars, type_of, variables
from arael.symbolic.derivatives import OPERATION_OF
from arael.symbolic.graph import Graph
from arael.symbolic.sharing import Writer

Array = NDArray[Any]

_NAME_OF: Mapping[Any, str] = {
    **OPERATION_OF,
    **{made: name for name, made in OWN.items()},
    **{sp.Max: "max", sp.Min: "min", sp.loggamma: "lgamma", sp.sinc: "sinc"},
    **{sp.StrictLessThan: "lt", sp.LessThan: "le", sp.Eq: "eq", sp.Ne: "ne"},
    **{sp.And: "and", sp.Or: "or", sp.Not: "not", sp.ITE: "select"},
}
_RECIPROCAL_OF = {
    **{sp.cot: sp.tan, sp.sec: sp.cos, sp.csc: sp.sin},
    **{sp.coth: sp.tanh, sp.sech: sp.cosh, sp.csch: sp.sinh},
}


class Lowered(Writer):
    """Expressions as operations of a graph, whose inputs are their variables.

    Functions with a formula are written out; a call of a native one is an input of the graph, keyed
    by the call.

    Attributes
    ----------
    calls : native calls, in order of evaluation
    """

    def __init__(self, roots: Sequence[Any], *, simplify: bool = True) -> None:
        super().__init__(Graph(simplify=simplify), {}, {})
        self.calls: list[Any] = []
        self.roots = [self.node(root) for root in roots]

    def _write(self, term: Any) -> int:
        g = self.graph
        if term.is_Symbol:
            return g.input(term.name)
        if term in (sp.true, sp.false):
            return g.op("eq", g.const(float(term is sp.true)), g.const(1.0))
        if isinstance(term, UserFunction):
            return self._user(term)
        if isinstance(term, (Relational, BooleanFunction, sp.Piecewise)):
            return self._condition(term)
        if term.is_number or term.is_Add or term.is_Mul or term.is_Pow:
            return super()._write(term)
        if isinstance(term, sp.Heaviside) and term.args[1] == sp.S.Half:
            return g.op("heaviside", self.node(term.args[0]))
        if type(term) in _RECIPROCAL_OF:
            return self.node(1 / _RECIPROCAL_OF[type(term)](*term.args))
        return self._named(term)

    def _named(self, term: Any) -> int:
        name = _NAME_OF.get(type(term))
        if name is None:
            _unknown(term)
        args = [self.node(a) for a in term.args]
        if name in ("min", "max", "and", "or"):
            return reduce(lambda a, b: self.graph.op(name, a, b), args)
        if OPERATIONS[name].arity != len(args):
            _unknown(term)
        return self._operation(name, args)

    def _condition(self, term: Any) -> int:
        if isinstance(term, sp.Gt | sp.Ge):
            return self.node(term.reversed)
        if not isinstance(term, sp.Piecewise):
            return self._named(term)
        *arms, (last, rest) = term.args
        if rest != sp.true:
            _unknown(term)  # without a last arm it has no value somewhere
        node = self.node(last)
        for arm, chosen in reversed(arms):
            node = self.graph.op("select", self.node(chosen), self.node(arm), node)
        return node

    def _user(self, call: Any) -> int:
        function = call.declared
        if not function.is_native:
            return self.node(function.formula(call.args))
        self.calls.append(call)
        return self.graph.input(call)

    def _factors(self, factors: Sequence[Any]) -> int:
        """Multiply; a fraction divides at the end, which rounds once."""
        below = 1
        kept = []
        for factor in factors:
            if factor.is_Rational and factor.q & (factor.q - 1):
                below *= factor.q
                factor = sp.Integer(factor.p)
            kept.append(factor)
        product = super()._factors(kept)
        return product if below == 1 else self.graph.op("div", product, self.graph.const(below))


def _unknown(term: Any) -> NoReturn:
    help_ = ("formulas are over the real numbers, with the functions of the language",)
    message = f"`{str(term)[:60]}` has no counterpart in the language"
    fail("E0654", message, origin="SymPy", help=help_)


class Compiled:
    """A value made ready for evaluation: a function of its variables.

    Attributes
    ----------
    names : the variables, in the order of the arguments
    operations : arithmetic operations of one evaluation, after sharing
    """

    def __init__(self, value: Value, names: Sequence[str]) -> None:
        self.value = value
        self.names = tuple(names)
        lowered = Lowered(entries(value))
        self._calls = [(c.declared, Compiled(as_value(c.args), names)) for c in lowered.calls]
        self._tape = lowered.graph.tape(lowered.roots, [*names, *lowered.calls])
        inner = sum(arguments.operations + 1 for _, arguments in self._calls)
        self.operations: int = self._tape.operations + inner

    def __call__(self, *inputs: Any) -> Any:
        """Evaluate; arguments are numbers or arrays that broadcast against each other."""
        return _shaped(type_of(self.value), self._scalars(inputs))

    def _scalars(self, inputs: Sequence[Any]) -> list[Array]:
        if len(inputs) != len(self.names):
            message = f"expected {len(self.names)} values ({', '.join(self.names)})"
            fail("E0303", f"{message}, found {len(inputs)}", origin="evaluation")
        arrays = [as_numbers(x, "evaluation", n) for n, x in zip(self.names, inputs, strict=True)]
        _require_broadcast(self.names, arrays)
        found = [np.asarray(f.native_value(*a._scalars(inputs))) for f, a in self._calls]
        return run(self._tape, [*arrays, *found])


def compiled(value: Any, by: Sequence[Any] | None = None) -> Compiled:
    """Make a fast function of a value, for evaluation at many points.

    Its arguments are the variables `by`, or all in alphabetical order.

    Raises
    ------
    AraelError
        E0650 if a variable of `value` is not among `by`; E0654 if it has something that the
        language lacks.
    """
    value = as_value(value)
    return Compiled(value, parameters(value, by, "compiled"))


def eval(value: Any, values: Mapping[Any, Any] | None = None, /, **named: Any) -> Any:
    """Value at a point: a float, or an array with the shape of a vector or matrix behind.

    Variables, given by name or as symbols, may be arrays, which are broadcast against each other: a
    scalar expression gives an array of their common shape, a vector one with its length as the last
    axis.

    Raises
    ------
    AraelError
        E0650 if a variable has no value; E0654 as for `compiled`; E0828 for a value that is no
        number; E0704 for arrays that do not broadcast.
    """
    value = as_value(value)
    given = {str(k): v for k, v in by_variable(values, named, "eval").items()}
    names = free_vars(value)
    _require(names, given)
    return Compiled(value, names)(*(given[n] for n in names))


def _require_broadcast(names: Sequence[str], arrays: Sequence[Array]) -> None:
    try:
        np.broadcast_shapes(*(a.shape for a in arrays))
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in zip(names, arrays, strict=True) if a.ndim)
        message = f"the values do not broadcast against each other: {shapes}"
        help_ = ("give arrays of one shape, or numbers",)
        fail("E0704", message, origin="evaluation", help=help_)


def parameters(value: Value, by: Any, function: str) -> list[str]:
    """Names of the variables `by`, all of `value` if None; E0650 if one of `value` is missing."""
    names = [*map(str, variables(value, by, function))]
    _require(free_vars(value), names)
    return names


def _require(names: Sequence[str], given: Collection[str]) -> None:
    missing = [n for n in names if n not in given]
    if not missing:
        return
    near = closest(missing[0], [n for n in given if n not in names])
    hint = f"give it one: `eval(f, {missing[0]}=1.0)`"
    if near:
        hint = f"did you mean `{missing[0]}` by `{near[0]}`?"
    notes = (f"without a value are {', '.join(missing)}",) if len(missing) > 1 else ()
    message = f"variable `{missing[0]}` has no value"
    fail("E0650", message, origin="evaluation", notes=notes, help=(hint,))


def _shaped(type_: ValueType, scalars: list[Array]) -> Any:
    if type_ in (REAL, BOOL):
        result = scalars[0] != 0 if type_ == BOOL else scalars[0]
        return result if np.ndim(result) else result.item()
    stacked = np.stack(np.broadcast_arrays(*scalars), axis=-1)
    return stacked.reshape(*stacked.shape[:-1], *shape_of(type_))
