"""Random formulas and central differences, for the tests of this folder."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from arael import sym
from arael.symbolic.scalars import SCALARS

# Smooth where |argument| < 1, so that differences mean something.
SMOOTH = ["sin", "cos", "exp", "atan", "sinh", "cosh", "tanh", "identity", "fast_atan", "deg2rad"]
NAMES = ["x", "y", "z"]


def trees(depth: int = 3) -> st.SearchStrategy[str]:
    """Texts of formulas in x, y and z, defined and smooth everywhere."""
    numbers = st.sampled_from(["1", "2", "0.5", "3", "1e-3", "0", "7.25"])
    leaves = st.one_of(st.sampled_from(NAMES), st.sampled_from(NAMES), numbers)

    def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pair = st.tuples(inner, inner)
        return st.one_of(
            pair.map(lambda p: f"({p[0]} + {p[1]})"),
            pair.map(lambda p: f"({p[0]} - {p[1]})"),
            pair.map(lambda p: f"{p[0]} * {p[1]}"),
            pair.map(lambda p: f"({p[0]}) / (1 + ({p[1]})^2)"),
            inner.map(lambda a: f"(-{a})"),
            inner.map(lambda a: f"({a})^3"),
            pair.map(lambda p: f"starship({p[0]}, 2 + ({p[1]})^2)"),
            pair.map(lambda p: f"safe_atan2({p[0]}, 2 + ({p[1]})^2)"),
            pair.map(lambda p: f"hypot(1, sin({p[0]} - {p[1]}))"),
            st.tuples(st.sampled_from(SMOOTH), inner).map(lambda p: f"{p[0]}(sin({p[1]}))"),
            inner.map(lambda a: f"sqrt(1.5 + sin({a}))"),
            inner.map(lambda a: f"log(3 + cos({a}))"),
            pair.map(lambda p: f"(2 + sin({p[0]}))^({p[1]})"),
        )

    return st.recursive(leaves, grown, max_leaves=2**depth)


def points(n: int = 3) -> st.SearchStrategy[list[float]]:
    return st.lists(st.floats(-0.9, 0.9), min_size=n, max_size=n)


def central(value: Any, name: str, at: dict[str, float], step: float = 1e-6) -> Any:
    """Central difference of a value by a variable."""
    above, below = dict(at), dict(at)
    above[name] += step
    below[name] -= step
    return (np.asarray(sym.eval(value, above)) - np.asarray(sym.eval(value, below))) / (2 * step)


def all_functions() -> list[str]:
    return [name for name, f in SCALARS.items() if f.arity]


def of_symbols(name: str) -> Any:
    """A function of the language applied to x, y, z, as many as it takes."""
    return sym.parse(f"{name}({', '.join(NAMES[: SCALARS[name].arity])})")
