"""The scalar functions of the language: those of the table of operations, and constants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType

from arael.operations import OPERATIONS, Operation
from arael.operations.constants import CONSTANTS, Constant
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.operators import Scalar


@dataclass(frozen=True)
class ScalarFunction:
    """A function of scalars, or a constant if it takes none.

    Attributes
    ----------
    name, arity : as in its record
    build : makes the node of its value from a graph and the nodes of its arguments
    value : what it is, as a formula or a phrase
    derivative, singular : as in its record
    """

    name: str
    arity: int
    build: Callable[..., int]
    value: str
    derivative: str
    singular: str = ""

    def __call__(self, g: Graph, *args: int) -> int:
        """Make the function's node for these arguments."""
        if len(args) != self.arity:
            raise ValueError(f"{self.name} takes {self.arity} arguments, not {len(args)}")
        return self.build(g, *args)


def _constant(name: str, one: Constant) -> ScalarFunction:
    return ScalarFunction(name, 0, lambda g: g.const(one.number), one.text, "0")


def _function(one: Operation) -> ScalarFunction:
    value = one.value or f"{one.name}({', '.join('xyz'[: one.arity])})"
    return ScalarFunction(one.name, one.arity, _build(one), value, one.derivative, one.singular)


def _build(one: Operation) -> Callable[..., int]:
    """Return what makes the node: an operation of graphs, or what is composed of such.

    Where a composed function has a SymPy function, that gives its derivatives, and differentiation
    does not look into its value.
    """
    if one.primitive:
        return lambda g, *args: g.op(one.name, *args)
    formula: Callable[..., Scalar] = import_module(one.build).FORMULAS[one.name]
    function = Prescribed(one.name, native=False)

    def build(g: Graph, *args: int) -> int:
        value = formula(*(Scalar(g, a) for a in args)).node
        return g.call(function, args, value) if one.sympy else value

    return build


SCALARS: Mapping[str, ScalarFunction] = MappingProxyType(
    {
        **{one.name: _function(one) for one in OPERATIONS.values() if one.function},
        **{name: _constant(name, one) for name, one in CONSTANTS.items()},
    }
)
