"""The functions of a model, for use from Python: on numbers, on arrays, on symbolic expressions."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic, Source
from arael.runtime import layout as layouts
from arael.runtime.evaluation.unbound import unbound
from arael.runtime.layout import Layout
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.machine.native_binding import Binding
from arael.runtime.machine.programs import evaluate
from arael.runtime.machine.tape import Array, Tape

if TYPE_CHECKING:
    from arael.sym.user_functions import FunctionBag

__all__ = ["Function", "Functions"]


class Function:
    """A function declared in a model, with the derivatives that the solver uses.

    Attributes
    ----------
    name : as the model declares it
    params : names of its parameters
    native : whether its value comes from native code (``extern fn``)
    bound : whether it can be evaluated: always for a formula; for native code after it was bound
    formula : source text of the formula; "" for a native function
    derivs : source text of the derivatives; empty if the formula is differentiated
    doc : the comment above it in the model

    Notes
    -----
    Numbers and arrays are scalar arguments: arrays are broadcast, and a function whose value is a
    vector appends axes. With an expression, a matrix or a quaternion of SymPy among the arguments
    the value is symbolic too. A function of vectors can only be called with columns of SymPy.
    """

    def __init__(self, declared: layouts.Function, family: Functions) -> None:
        self._declared = declared
        self._family = family
        self.name = declared.name
        self.params = declared.params
        self.native = declared.native
        self.formula = declared.text
        self.derivs = declared.derivs
        self.doc = declared.doc

    @property
    def bound(self) -> bool:
        """Whether the function can be evaluated."""
        return not self.native or self.name in self._family.bindings

    def __call__(self, *args: Any) -> Any:
        """Value for these arguments: a float if all are numbers, else an array, or symbolic.

        Raises
        ------
        TypeError
            For another number of arguments.
        AraelError
            E0820: a native function that it calls is not bound; E0302: it takes vectors, but
            numbers were passed.
        """
        if self._is_symbolic(args):
            return self._family.bag[self.name](*args)
        (value,) = self._values(self._declared.tape, args, (self._declared.shape,))
        return value

    def partials(self, *args: Any) -> tuple[Any, ...]:
        """Partial derivatives for these arguments, one per parameter, with the shape of the value.

        If the model has `derivs`, these are used.
        """
        if self._is_symbolic(args):
            # imported here: start-up time
            from arael import sym

            value = self._family.bag[self.name](*sym.symbols(self.params))
            given = dict(zip(self.params, args, strict=True))
            return tuple(sym.subs(sym.diff(value, x), given) for x in self.params)
        n, shape = len(self.params), self._declared.shape
        return self._values(self._declared.partials, args, (shape,) * n, n)

    def _is_symbolic(self, args: tuple[Any, ...]) -> bool:
        if len(args) != len(self.params):
            raise TypeError(f"{self!r} takes {len(self.params)} arguments, found {len(args)}")
        sympy = sys.modules.get("sympy")  # without it there is no value of its types
        return sympy is not None and any(
            isinstance(a, sympy.Basic | sympy.MatrixBase) for a in args
        )

    def _values(
        self, tape: Tape | None, args: tuple[Any, ...], shapes: tuple[Any, ...], stride: int = 1
    ) -> tuple[Any, ...]:
        if tape is None:
            raise AraelError(
                Diagnostic(
                    "E0302",
                    f"`{self.name}` does not take numbers",
                    origin=self._declared.where,
                    notes=(f"it is {self!r}",),
                    help=(
                        "call it with columns, `sympy.Matrix([1, 2])`; `sym.eval` gives numbers",
                    ),
                )
            )
        missing = tape.natives - self._family.bindings.keys()
        if missing:
            raise AraelError(self._family.unbound(sorted(missing)[0]))
        inputs = [np.asarray(a, dtype=np.float64) for a in args]
        flat = evaluate(tape, inputs, natives=self._family.table)
        around = np.broadcast_shapes(*(i.shape for i in inputs))
        found = []
        for k, shape in enumerate(shapes):
            parts: list[Array] = flat[k::stride]
            value = np.stack(parts, axis=-1).reshape(*around, *shape) if shape else parts[0]
            found.append(float(value) if value.ndim == 0 else np.array(value))
        return tuple(found)

    def __repr__(self) -> str:
        return f"<{self._declared.item}>"


class Functions(Mapping[str, Function]):
    """The functions of a model by name.

    Parameters
    ----------
    layout : the compiled model
    bindings : functions bound by the caller to its native functions
    """

    def __init__(self, layout: Layout, bindings: Mapping[str, Binding]) -> None:
        self.layout = layout
        self.bindings = dict(bindings)
        self.table = NativeTable([f for f in layout.functions if f.native], self.bindings)
        self._functions = {f.name: Function(f, self) for f in layout.functions}

    def __getitem__(self, name: str) -> Function:
        """Return the function of that name; KeyError if there is none."""
        return self._functions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)

    def __repr__(self) -> str:
        return f"<functions {', '.join(self._functions)}>"

    @cached_property
    def bag(self) -> FunctionBag:
        """The functions in the form of `sym.parse`: ``sym.parse("sigmoid(t)", M.functions.bag)``.

        Unbound native functions can be differentiated, but have no value (E0820).
        """
        # imported here: start-up time
        from arael.sym import FunctionBag

        source = Source(f"functions of {self.layout.source}", self.layout.items)
        return FunctionBag.from_source(source, {n: self._native(n) for n in self.layout.natives})

    def _native(self, name: str) -> Callable[..., float]:
        def value(*args: float) -> float:
            if name not in self.bindings:
                raise AraelError(self.unbound(name))
            return float(self.table[name](*args))

        return value

    def unbound(self, name: str) -> Diagnostic:
        """Raise the error for an unbound native function."""
        return unbound(next(f for f in self.layout.functions if f.name == name), self.layout)
