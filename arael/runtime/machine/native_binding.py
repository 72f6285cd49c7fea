"""What the caller bound to a native function of a model, ready to be called."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

SCALARS, SCALARS_USER, DISPATCHED, SINGLE, ARRAY, ARRAY_USER, PYTHON = range(7)
"""How a function takes its arguments: ``double f(double, ...)``; the same with ``void* user_data``
last; the same with the ``int`` that Cython's ``cpdef`` functions take last; ``float f(float,
...)``; ``double f(int n, double* x)``; the same with user data; Python."""

LARGEST_ARITY = 6
"""Arguments that are passed one by one; more go as an array."""


@dataclass(frozen=True)
class Binding:
    """A function bound to a name.

    Attributes
    ----------
    function : what the caller gave; kept alive, and called where `style` is ``PYTHON``
    style : one of the constants of this module
    address, user_data : of native code
    signature : as messages show it
    """

    function: Any
    style: int
    address: int = 0
    user_data: int = 0
    signature: str = "a Python function"

    @property
    def needs_gil(self) -> bool:
        """Whether each call takes the GIL."""
        return self.style == PYTHON
