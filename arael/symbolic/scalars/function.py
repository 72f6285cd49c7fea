"""What is known of one scalar function of the language."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from arael.operations import Operation
from arael.symbolic.graph import Graph
from arael.symbolic.prescribed import Prescribed

REGULARISATION = 1e-12
"""Added under roots and to denominators by the ``safe_`` functions' derivatives."""


@dataclass(frozen=True)
class ScalarFunction:
    """A function of scalars, or a constant if it takes none.

    Attributes
    ----------
    name : as the language spells it
    arity : number of arguments
    build : makes the node of its value from a graph and the nodes of its arguments
    value : what it is, as a formula or a phrase
    derivative : its partial derivatives, one per argument, separated by semicolons
    singular : value and derivative at the singular points; empty where there are none
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


def constant(name: str, number: float, value: str) -> ScalarFunction:
    """Describe a constant."""
    return ScalarFunction(name, 0, lambda g: g.const(number), value, "0")


def scalar_function(one: Operation) -> ScalarFunction:
    """Describe the function of a record.

    It is an operation of graphs; or it is composed of such, and then SymPy's function, where the
    record names one, gives its derivatives, and differentiation does not look into its value.
    """
    build = _build(one)
    arguments = ", ".join(("x", "y", "z")[: one.arity])
    value = one.value or f"{one.name}({arguments})"
    return ScalarFunction(one.name, one.arity, build, value, one.derivative, one.singular)


def _build(one: Operation) -> Callable[..., int]:
    if one.primitive:
        return lambda g, *args: g.op(one.name, *args)
    module, _, name = one.build.partition(":")
    value: Callable[..., int] = getattr(import_module(module), name)
    if not one.sympy:
        return value
    function = Prescribed(one.name, native=False)
    return lambda g, *args: g.call(function, args, value(g, *args))
