"""The functions of a model as scalar programs: for calls in constraints, and for the runtime."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from arael.check.typed import MatrixType, TypedFunction, VectorType
from arael.compiler.bounded import BoundedGraph
from arael.compiler.scalarise import FormulaScalariser
from arael.runtime.layout import Function
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.jacobian import jacobian


class Functions:
    """Functions with prescribed derivatives, as graph functions."""

    def __init__(self, functions: Iterable[TypedFunction] = ()) -> None:
        self.typed = tuple(functions)
        self._known = {f.name: self._prescribed(f) for f in self.typed if f.derivs is not None}

    def __getitem__(self, name: str) -> Prescribed:
        """Return the function of that name."""
        return self._known[name]

    def _prescribed(self, function: TypedFunction) -> Prescribed:
        assert function.derivs is not None
        derivs = function.derivs

        def partials(graph: Graph, args: Sequence[int]) -> list[int]:
            scalariser = FormulaScalariser(graph, args, self)
            return [scalariser.nodes(d)[0] for d in derivs]

        return Prescribed(function.name, function.native, partials)

    def layouts(self) -> tuple[Function, ...]:
        """Return the functions as stored in the layout.

        Raises
        ------
        AraelError
            E0620: all together take too many operations.
        """
        layouts, used = [], 0
        for function in self.typed:
            graph = BoundedGraph(f"fn {function.name}", function.span, used)
            layouts.append(self._layout(function, graph))
            used += len(graph.ops)
        return tuple(layouts)

    def _layout(self, function: TypedFunction, graph: Graph) -> Function:
        keys = range(len(function.params))
        inputs = [graph.input(k) for k in keys]
        shape: tuple[int, ...] = ()
        if function.body is None and function.native:
            outputs = [graph.call(self[function.name], inputs)]
        elif function.body is None:
            outputs = []
        else:
            outputs = FormulaScalariser(graph, inputs, self).nodes(function.body)
            shape = _shape(function)
            if function.derivs is not None:
                outputs = [graph.call(self[function.name], inputs, outputs[0])]
        one, zero = graph.const(1.0), graph.const(0.0)
        rows = jacobian(graph, outputs, {node: {k: one} for k, node in enumerate(inputs)})
        partials = [row.get(k, zero) for row in rows for k in keys]
        return Function(
            name=function.name,
            params=function.params,
            native=function.native,
            text=function.text,
            derivs=function.deriv_texts,
            where=str(function.span),
            shape=shape,
            tape=graph.tape(outputs, inputs=keys) if outputs else None,
            partials=graph.tape(partials, inputs=keys) if outputs else None,
            doc=function.doc,
        )


def _shape(function: TypedFunction) -> tuple[int, ...]:
    type_ = function.body.type if function.body is not None else None
    if isinstance(type_, VectorType):
        return (type_.n,)
    return (type_.rows, type_.columns) if isinstance(type_, MatrixType) else ()
