"""What is known of one scalar function of the language."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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


def prescribed(
    name: str,
    arity: int,
    build: Callable[..., int],
    value: str,
    derivative: str,
    singular: str = "",
) -> ScalarFunction:
    """Describe a function whose derivatives are those of its class in `symbolic.functions`.

    `build` makes the node of its value, which differentiation does not look into.
    """
    function = Prescribed(name, native=False)

    def call(g: Graph, *args: int) -> int:
        return g.call(function, args, build(g, *args))

    return ScalarFunction(name, arity, call, value, derivative, singular)


def primitive(
    name: str, arity: int, derivative: str, singular: str = "", value: str = ""
) -> ScalarFunction:
    """Describe a function that is an operation of the graph."""
    arguments = ", ".join(("x", "y", "z")[:arity])

    def build(g: Graph, *args: int) -> int:
        return g.op(name, *args)

    return ScalarFunction(name, arity, build, value or f"{name}({arguments})", derivative, singular)
