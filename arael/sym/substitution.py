"""Putting expressions in place of others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arael.sym.expr import Expr, as_expr, postorder, rewrite, symbol
from arael.sym.tidy import tidy
from arael.sym.value import V


def subs(value: V, values: Mapping[Any, Any] | None, named: Mapping[str, Any]) -> V:
    """Return `value` with what `values` and `named` map replaced, all at once.

    Keys are names of variables, symbols, or other expressions, which are found where they stand as
    they are written. What is put in is not itself searched. Where something was put in, numbers
    come to the front of products.
    """
    table: dict[Expr, Expr] = {}
    for key, new in (*(values or {}).items(), *named.items()):
        table[symbol(key) if isinstance(key, str) else as_expr(key)] = as_expr(new)
    found: dict[int, Expr] = {}
    for node in postorder(value.entries):
        if node in table:
            found[id(node)] = table[node]
    return value.with_entries(rewrite(value.entries, found, tidy)) if found else value
