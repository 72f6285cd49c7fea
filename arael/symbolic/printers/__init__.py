"""Expressions as C; other notations are SymPy's, in `arael.sym`."""

from arael.symbolic.printers.c import c, c_literal, c_operation, c_prelude

__all__ = ["c", "c_literal", "c_operation", "c_prelude"]
