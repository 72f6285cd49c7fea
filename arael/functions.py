"""The functions of a model, for use from Python: on numbers, on arrays, on symbolic expressions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime import layout as layouts
from arael.runtime.layout import Layout
from arael.runtime.native_binding import Binding
from arael.runtime.natives import NativeTable
from arael.runtime.tape import Array, Tape, evaluate
from arael.runtime.unbound import unbound

__all__ = ["Function", "Functions"]


class Function:
    """A function that a model declares, with the derivatives that the solver uses.

    Attributes
    ----------
    name : as the model declares it
    params : names of its parameters
    native : whether its value comes from native code (``extern fn``)
    bound : whether it can be evaluated: a formula always, native code once the caller gave it
    formula : as the model writes it; "" of a native function
    derivs : derivatives as the model writes them; empty where the formula is differentiated
    doc : the comment above it in the model

    Notes
    -----
    Only functions of scalars can be called from Python. The arguments may be arrays, which are
    broadcast against each other; a function whose value is a vector adds axes at the end.
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
        """Value for these arguments: a float where all are numbers, else an array.

        Raises
        ------
        TypeError
            For another number of arguments.
        AraelError
            E0820: nothing is bound to native code that it calls.
        """
        (value,) = self._values(self._declared.tape, args, (self._declared.shape,))
        return value

    def partials(self, *args: Any) -> tuple[Any, ...]:
        """Partial derivatives for these arguments, one per parameter, shaped as the value is."""
        n, shape = len(self.params), self._declared.shape
        return self._values(self._declared.partials, args, (shape,) * n, n)

    def _values(
        self, tape: Tape | None, args: tuple[Any, ...], shapes: tuple[Any, ...], stride: int = 1
    ) -> tuple[Any, ...]:
        if len(args) != len(self.params):
            raise TypeError(f"{self!r} takes {len(self.params)} arguments, found {len(args)}")
        assert tape is not None
        missing = tape.natives - self._family.bindings.keys()
        if missing:
            raise AraelError(self._family.unbound(sorted(missing)[0]))
        inputs = [np.asarray(a, dtype=np.float64) for a in args]
        nodes = evaluate(tape, inputs, natives=self._family.table)
        around = np.broadcast_shapes(*(i.shape for i in inputs))
        flat = [np.broadcast_to(nodes[o], around) for o in tape.outputs]
        found = []
        for k, shape in enumerate(shapes):
            parts: list[Array] = flat[k::stride]
            value = np.stack(parts, axis=-1).reshape(*around, *shape) if shape else parts[0]
            found.append(float(value) if value.ndim == 0 else np.array(value))
        return tuple(found)

    def __repr__(self) -> str:
        head = "extern fn" if self.native else "fn"
        derivs = f" derivs [{', '.join(self.derivs)}]" if self.derivs else ""
        formula = f" = {self.formula}" if self.formula else ""
        return f"<{head} {self.name}({', '.join(self.params)}){derivs}{formula}>"


class Functions(Mapping[str, Function]):
    """The functions of a model by name.

    Parameters
    ----------
    layout : the compiled model
    bindings : what the caller bound to its native functions
    """

    def __init__(self, layout: Layout, bindings: Mapping[str, Binding]) -> None:
        self.layout = layout
        self.bindings = dict(bindings)
        self.table = NativeTable([f for f in layout.functions if f.native], self.bindings)
        self._functions = {
            f.name: Function(f, self) for f in layout.functions if f.tape is not None
        }

    def __getitem__(self, name: str) -> Function:
        """Return the function of that name; KeyError if there is none that takes scalars."""
        return self._functions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)

    def __repr__(self) -> str:
        return f"<functions {', '.join(self._functions)}>"

    def unbound(self, name: str) -> Diagnostic:
        """Tell that nothing is bound to a native function."""
        return unbound(next(f for f in self.layout.functions if f.name == name), self.layout)
