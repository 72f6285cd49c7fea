"""Numbers from expressions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.check.typed import BOOL
from arael.diagnostics.suggest import closest
from arael.runtime.machine.tape import evaluate as run
from arael.sym.errors import fail
from arael.sym.expr import Expr
from arael.sym.lowering import lower
from arael.sym.shapes import as_value
from arael.sym.value import Value

Array = NDArray[Any]


class Program:
    """Expressions made ready for evaluation, many times or on arrays.

    Attributes
    ----------
    names : the variables, in the order in which a call takes them
    operations : arithmetic operations of one evaluation, after sharing
    """

    def __init__(self, entries: Sequence[Expr], names: Sequence[str]) -> None:
        lowered = lower(entries)
        self.names = tuple(names)
        self._calls = lowered.calls
        self._inner = [Program(call.args, self.names) for call in self._calls]
        self._tape = lowered.graph.tape(lowered.nodes, [*self.names, *self._calls])

    @property
    def operations(self) -> int:
        """Count the operations of one evaluation."""
        return self._tape.operations + sum(inner.operations + 1 for inner in self._inner)

    def __call__(self, *inputs: Any) -> list[Array]:
        """Values of the expressions for these values of `names`."""
        if len(inputs) != len(self.names):
            raise TypeError(f"expected {len(self.names)} values ({', '.join(self.names)})")
        arrays = [np.asarray(x, dtype=np.float64) for x in inputs]
        for call, inner in zip(self._calls, self._inner, strict=True):
            arrays.append(_native(call, inner(*arrays[: len(self.names)])))
        values = run(self._tape, arrays)
        return [values[node] for node in self._tape.outputs]


def _native(call: Expr, args: Sequence[Array]) -> Array:
    function = call.data.native
    if all(a.ndim == 0 for a in args):
        return np.asarray(float(function(*(float(a) for a in args))))
    return np.asarray(np.vectorize(function, otypes=[np.float64])(*args))


class Compiled:
    """A value made ready for evaluation: a function of its variables.

    Attributes
    ----------
    names : the variables, in the order of the arguments
    operations : arithmetic operations of one evaluation, after sharing
    """

    def __init__(self, value: Value, names: Sequence[str]) -> None:
        self.value = value
        self._program = Program(value.entries, names)
        self.names = self._program.names
        self.operations = self._program.operations

    def __call__(self, *inputs: Any) -> Any:
        """Evaluate; arguments are numbers or arrays that broadcast against each other."""
        return _shaped(self.value, self._program(*inputs))


def compiled(value: Any, by: Sequence[Expr | str] | None = None) -> Compiled:
    """Make a fast function of a value, for evaluation at many points.

    Parameters
    ----------
    value : expression, vector, matrix, or list of expressions
    by : its arguments; by default all variables in alphabetical order

    Raises
    ------
    AraelError
        E0650 if a variable of `value` is not among `by`.
    """
    value = as_value(value)
    names = value.free_vars if by is None else [str(v) for v in by]
    _require(value, dict.fromkeys(names))
    return Compiled(value, names)


def evaluate(value: Value, values: Mapping[Any, Any] | None, named: Mapping[str, Any]) -> Any:
    """Do what `Value.eval` documents."""
    given = {str(k): v for k, v in {**(values or {}), **named}.items()}
    names = value.free_vars
    _require(value, given)
    program = value._program if isinstance(value, Expr) else None
    if program is None:
        program = Program(value.entries, names)
        if isinstance(value, Expr):
            value._program = program
    return _shaped(value, program(*(given[n] for n in names)))


def _require(value: Value, given: Mapping[str, Any]) -> None:
    missing = [n for n in value.free_vars if n not in given]
    if not missing:
        return
    near = closest(missing[0], [n for n in given if n not in value.free_vars])
    hint = (
        f"did you mean `{missing[0]}` by `{near[0]}`?"
        if near
        else (f"give it one: `eval({missing[0]}=1.0)`")
    )
    fail(
        "E0650",
        f"variable `{missing[0]}` has no value",
        origin="evaluation",
        notes=(f"without a value are {', '.join(missing)}",) if len(missing) > 1 else (),
        help=(hint,),
    )


def _shaped(value: Value, entries: list[Array]) -> Any:
    if isinstance(value, Expr):
        (result,) = entries
        if result.ndim:
            return result != 0 if value.type == BOOL else result
        return bool(result) if value.type == BOOL else float(result)
    from arael.check.types import shape_of

    stacked = np.stack(np.broadcast_arrays(*entries), axis=-1)
    return stacked.reshape(*stacked.shape[:-1], *shape_of(value.type))
