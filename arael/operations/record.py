"""What is known of one scalar operation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np


@dataclass(frozen=True)
class Domain:
    """Operands for which an operation has a finite value.

    Attributes
    ----------
    text : the condition, in the notation of the language; operands are named x and y
    holds : the condition on numbers
    """

    text: str
    holds: Callable[..., bool]


@dataclass(frozen=True)
class Operation:
    """A scalar operation, or a function that is composed of operations.

    Attributes
    ----------
    name : in graphs and tapes; of a function, also in the language
    arity : number of operands
    numpy : value on arrays; None for a composed function
    sympy : its SymPy function or class, ``module:name``, whose `diff` gives the derivatives; empty
        where there is nothing to differentiate
    units : name of its rule in `arael.check.units_rules`; empty: its unit is unknown
    derivative : partial derivatives in words, separated by semicolons; empty for what is no
        function of the language
    singular : value and derivative at the singular points; empty where there are none
    value : what it computes, where the name is not enough
    domain : operands for which it has a finite value; None for all, up to overflow
    c : C expression of its operands ``{0}``, ``{1}``, or the name of a C function for double, that
        for float ends with ``f``. ZERO, HALF and ONE are literals. Of a function of that name when
        empty
    cython : expression in generated kernels, where it is not `c`
    machine : C expression in the expression machine, where it is not `c`
    python : expression of Python, where it is not a call of a NumPy function
    text : in the notation of the language, where it is not a call
    binding, operands : how strongly `text` binds, and must bind to stand without parentheses
    number : value on Python numbers; None where `numpy` gives it
    vector : first version of glibc with a vector form; empty for none
    parity : effect of a change of the operand's sign: on the sign of the value, or none
    costly : whether it takes much longer than a product
    flat : whether the derivative is zero wherever there is one
    several : whether the language has it for any number of operands, two at least
    takes : the operands in words, where their number is not enough
    latex : its name in LaTeX, or a template with ``{0}`` for the operand
    opcode : whether the expression machine has an instruction for it; it calls the others by
        address
    build : of a composed function: the module whose `FORMULAS` have it
    """

    name: str
    arity: int
    numpy: Callable[..., Any] | None
    sympy: str = ""
    units: str = ""
    derivative: str = ""
    singular: str = ""
    value: str = ""
    domain: Domain | None = None
    c: str = ""
    cython: str = ""
    machine: str = ""
    python: str = ""
    text: str = ""
    binding: int = 0
    operands: tuple[int, ...] = ()
    number: Callable[..., float] | None = None
    vector: Literal["", "2.22", "2.35"] = ""
    parity: Literal["", "odd", "even"] = ""
    costly: bool = False
    flat: bool = False
    several: bool = False
    takes: str = ""
    latex: str = ""
    opcode: bool = False
    build: str = ""

    @property
    def primitive(self) -> bool:
        """Whether it is an operation of graphs and tapes."""
        return self.numpy is not None

    @property
    def function(self) -> bool:
        """Whether it is a function of the language."""
        return bool(self.derivative)

    @property
    def library(self) -> str:
        """Name of the C function that it is; empty for an expression."""
        c = self.c or self.name
        return c if c.isidentifier() else ""

    @property
    def c_expression(self) -> str:
        """C expression of its operands, for double."""
        return self._called(self.library) if self.library else self.c

    @property
    def kernel_expression(self) -> str:
        """Expression of its operands in generated kernels, which bind C functions as ``m_...``."""
        if self.cython:
            return self.cython
        return self._called(f"m_{self.name}") if self.library else self.c

    @property
    def python_expression(self) -> str:
        """Expression of Python that has imported NumPy as ``np``, and `scipy.special`."""
        if self.python:
            return self.python
        assert self.numpy is not None
        module = "np" if isinstance(self.numpy, np.ufunc) else "scipy.special"
        return self._called(f"{module}.{self.numpy.__name__}")

    def outside(self, *values: float) -> bool:
        """Whether numbers lie outside its domain."""
        return self.domain is not None and not self.domain.holds(*values)

    def on_numbers(self, *values: float) -> float:
        """Value on numbers; as Python's functions do, it may raise instead of being NaN."""
        function = self.number or self.numpy
        assert function is not None
        return float(function(*values))

    def _called(self, name: str) -> str:
        return f"{name}({', '.join(f'{{{k}}}' for k in range(self.arity))})"
