"""Expressions as text, Python, C, LaTeX and SymPy."""

from arael.symbolic.printers.c import c, c_literal, c_operation, c_prelude
from arael.symbolic.printers.python import python
from arael.symbolic.printers.sympy_bridge import latex, to_sympy
from arael.symbolic.printers.text import text

__all__ = ["c", "c_literal", "c_operation", "c_prelude", "latex", "python", "text", "to_sympy"]
