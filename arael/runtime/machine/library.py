"""Functions of the C library that formulas may call: one record each, for every part of arael.

The language, units, derivatives, generated code, the expression machine, the NumPy interpreter and
LaTeX all read these records. A function that is added here needs nothing elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np


@dataclass(frozen=True)
class LibraryFunction:
    """A function of one or two scalars.

    Attributes
    ----------
    name : as the language and tapes spell it
    arity : number of operands
    numpy : its value on arrays
    sympy : where its SymPy function is, ``module:name``; that function differentiates it
    units : which rule of `arael.check.units_rules` its units follow
    derivative : its partial derivatives in words, separated by semicolons
    singular : value and derivative at the singular points; empty where there are none
    value : what it is, where the name does not say it
    c : name in the C library, for double; that for float ends with ``f``
    number : its value on numbers of Python; None where that is what `numpy` gives
    vector : since which glibc there is a form for vectors; empty for none
    parity : whether a change of the operand's sign goes through, or drops out
    latex : its name in LaTeX
    opcode : whether the expression machine has an instruction for it; it calls others by address
    """

    name: str
    arity: int
    numpy: Callable[..., Any]
    sympy: str
    units: str
    derivative: str
    singular: str = ""
    value: str = ""
    c: str = ""
    number: Callable[..., float] | None = None
    vector: Literal["", "2.22", "2.35"] = ""
    parity: Literal["", "odd", "even"] = ""
    latex: str = ""
    opcode: bool = False

    @property
    def c_name(self) -> str:
        """Name in the C library."""
        return self.c or self.name

    @property
    def python(self) -> str:
        """How Python code calls it that has imported NumPy as ``np``, and `scipy.special`."""
        if isinstance(self.numpy, np.ufunc):
            return f"np.{self.numpy.__name__}"
        return f"scipy.special.{self.numpy.__name__}"

    def fold(self, *values: float) -> float:
        """Value on numbers."""
        return float((self.number or self.numpy)(*values))


def _scipy(name: str) -> Callable[..., Any]:
    """Return a function of `scipy.special`, which is imported with the first call."""

    def call(x: Any) -> Any:
        from scipy import special

        return getattr(special, name)(x)

    call.__name__ = name
    return call


_OWN = "arael.symbolic.functions"

FUNCTIONS: list[LibraryFunction] = [
    LibraryFunction(
        "pow", 2, np.power, f"{_OWN}:power", "power", "y x^(y - 1); x^y ln(x)",
        "x^0 = 1, also at 0, with derivative NaN by x there; at x = 0 the derivative by y is 0; "
        "NaN for x < 0 unless y is an integer", "x^y", number=math.pow, vector="2.22", opcode=True,
    ),
    LibraryFunction(
        "sqrt", 1, np.sqrt, "sympy:sqrt", "square root", "1 / (2 sqrt(x))",
        "0 at 0 with derivative inf; NaN for x < 0", number=math.sqrt, opcode=True,
    ),
    LibraryFunction(
        "cbrt", 1, np.cbrt, "sympy:cbrt", "cube root", "1 / (3 cbrt(x)^2)",
        "0 at 0 with derivative inf", vector="2.35", parity="odd", opcode=True,
        number=lambda x: float(np.cbrt(x)),
    ),
    LibraryFunction(
        "exp", 1, np.exp, "sympy:exp", "pure", "exp(x)", number=math.exp, vector="2.22",
        latex="\\exp", opcode=True,
    ),
    LibraryFunction(
        "log", 1, np.log, "sympy:log", "pure", "1 / x",
        "-inf at 0 with derivative inf; NaN for x < 0", "ln(x)", number=math.log, vector="2.22",
        latex="\\log", opcode=True,
    ),
    LibraryFunction(
        "log2", 1, np.log2, f"{_OWN}:log2", "pure", "1 / (x ln 2)",
        "-inf at 0 with derivative inf; NaN for x < 0", number=math.log2, vector="2.35",
        latex="\\log_{2}", opcode=True,
    ),
    LibraryFunction(
        "log10", 1, np.log10, f"{_OWN}:log10", "pure", "1 / (x ln 10)",
        "-inf at 0 with derivative inf; NaN for x < 0", number=math.log10, vector="2.35",
        latex="\\log_{10}", opcode=True,
    ),
    LibraryFunction(
        "sin", 1, np.sin, "sympy:sin", "angle", "cos(x)", number=math.sin, vector="2.22",
        parity="odd", latex="\\sin", opcode=True,
    ),
    LibraryFunction(
        "cos", 1, np.cos, "sympy:cos", "angle", "-sin(x)", number=math.cos, vector="2.22",
        parity="even", latex="\\cos", opcode=True,
    ),
    LibraryFunction(
        "tan", 1, np.tan, "sympy:tan", "angle", "1 + tan(x)^2", number=math.tan, vector="2.35",
        parity="odd", latex="\\tan", opcode=True,
    ),
    LibraryFunction(
        "asin", 1, np.arcsin, "sympy:asin", "angle of", "1 / sqrt(1 - x^2)",
        "NaN for |x| > 1; derivative inf at x = -1, 1", number=math.asin, vector="2.35",
        parity="odd", latex="\\arcsin", opcode=True,
    ),
    LibraryFunction(
        "acos", 1, np.arccos, "sympy:acos", "angle of", "-1 / sqrt(1 - x^2)",
        "NaN for |x| > 1; derivative -inf at x = -1, 1", number=math.acos, vector="2.35",
        latex="\\arccos", opcode=True,
    ),
    LibraryFunction(
        "atan", 1, np.arctan, "sympy:atan", "angle of", "1 / (1 + x^2)", number=math.atan,
        vector="2.35", parity="odd", latex="\\arctan", opcode=True,
    ),
    LibraryFunction(
        "atan2", 2, np.arctan2, "sympy:atan2", "angle of two",
        "y / (x^2 + y^2); -x / (x^2 + y^2)",
        "0 at (0, 0) with derivative NaN; jumps across the negative half axis of y",
        "angle of the vector (y, x): atan2(x, y) has the sine's side first", number=math.atan2,
        vector="2.35", opcode=True,
    ),
    LibraryFunction(
        "sinh", 1, np.sinh, "sympy:sinh", "pure", "cosh(x)", number=math.sinh, vector="2.35",
        parity="odd", latex="\\sinh", opcode=True,
    ),
    LibraryFunction(
        "cosh", 1, np.cosh, "sympy:cosh", "pure", "sinh(x)", number=math.cosh, vector="2.35",
        parity="even", latex="\\cosh", opcode=True,
    ),
    LibraryFunction(
        "tanh", 1, np.tanh, "sympy:tanh", "pure", "1 - tanh(x)^2", number=math.tanh, vector="2.35",
        parity="odd", latex="\\tanh", opcode=True,
    ),
    LibraryFunction(
        "hypot", 2, np.hypot, f"{_OWN}:hypot", "joined", "x / hypot(x, y); y / hypot(x, y)",
        "0 at (0, 0) with derivative NaN", "sqrt(x^2 + y^2) without overflow", number=math.hypot,
        vector="2.35", opcode=True,
    ),
    LibraryFunction(
        "erf", 1, _scipy("erf"), "sympy:erf", "pure", "2 exp(-x^2) / sqrt(pi)",
        value="error function", number=math.erf, parity="odd",
    ),
    LibraryFunction(
        "erfc", 1, _scipy("erfc"), "sympy:erfc", "pure", "-2 exp(-x^2) / sqrt(pi)",
        value="1 - erf(x), without cancellation for large x", number=math.erfc,
    ),
    LibraryFunction(
        "expm1", 1, np.expm1, f"{_OWN}:expm1", "pure", "exp(x)",
        value="exp(x) - 1, without cancellation near 0", number=math.expm1,
    ),
    LibraryFunction(
        "log1p", 1, np.log1p, f"{_OWN}:log1p", "pure", "1 / (1 + x)",
        "-inf at -1 with derivative inf; NaN for x < -1",
        "ln(1 + x), without cancellation near 0", number=math.log1p,
    ),
    LibraryFunction(
        "lgamma", 1, _scipy("gammaln"), f"{_OWN}:lgamma", "pure", "digamma(x)",
        "inf at 0, -1, -2, ...; derivative -inf at 0, of size 1e15 at -1, -2, ...", "ln |gamma(x)|",
        number=math.lgamma, latex="\\ln\\Gamma",
    ),
]  # fmt: skip
