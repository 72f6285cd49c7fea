"""Between the language's functions and SymPy's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, reduce
from typing import Any

import sympy as sp

from arael.operations import OPERATIONS
from arael.sym.functions import OWN, UserFunction, operation, remade, written_out
from arael.sym.values import Value, as_value, entries, postorder, with_entries

_HALF = sp.Rational(1, 2)


def _safe_asin(a: Any) -> Any:
    return sp.Piecewise((sp.asin(a), sp.Abs(a) < 1), (sp.sign(a) * sp.pi / 2, True))


_KNOWN: Mapping[str, Callable[..., Any]] = {
    "abs": sp.Abs,
    "sign": sp.sign,
    "min": sp.Min,
    "max": sp.Max,
    "floor": sp.floor,
    "ceil": sp.ceiling,
    "round": lambda a: sp.sign(a) * sp.floor(sp.Abs(a) + _HALF),
    "heaviside": lambda a: sp.Heaviside(a, _HALF),
    "identity": lambda a: a,
    "cbrt": lambda a: sp.sign(a) * sp.Abs(a) ** sp.Rational(1, 3),
    "log2": lambda a: sp.log(a, 2),
    "log10": lambda a: sp.log(a, 10),
    "hypot": lambda a, b: sp.sqrt(a**2 + b**2),
    "expm1": lambda a: sp.exp(a) - 1,
    "log1p": lambda a: sp.log(1 + a),
    "lgamma": sp.loggamma,
    "digamma": sp.digamma,
    "sinc": sp.sinc,
    "fast_atan": sp.atan,
    "fast_atan2": sp.atan2,
    # Piecewise, since the derivative of sqrt(Max(0, a)) would be 0 * oo below 0.
    "safe_sqrt": lambda a: sp.Piecewise((sp.sqrt(a), a > 0), (0, True)),
    "safe_asin": _safe_asin,
    "safe_acos": lambda a: sp.pi / 2 - _safe_asin(a),
    "safe_atan2": lambda y, x: sp.Piecewise((sp.atan2(y, x), x**2 + y**2 > 0), (0, True)),
}
_LANGUAGE: Mapping[Any, Callable[..., Any]] = {
    **{_KNOWN[n]: OWN[n] for n in ("abs", "sign", "floor", "ceil", "lgamma", "digamma")},
    sp.Max: lambda *a: _paired("max", a),
    sp.Min: lambda *a: _paired("min", a),
}


def to_sympy(value: Any) -> Value:
    """Write the language's functions by SymPy's own: `Abs`, `Max`, `Piecewise`.

    Values are the same, those of `fast_atan` to within 6e-8; derivatives too but for kinks and
    jumps, where SymPy has its own. A call of a function that is native or has its own derivatives
    stays.
    """
    return rewritten(value, lambda node: _standard(node, _KNOWN))


def over_numpy(value: Any) -> Value:
    """Write the functions that NumPy and `scipy.special` lack by others."""
    lacking = {n: make for n, make in _KNOWN.items() if not OPERATIONS[n].primitive}
    return rewritten(value, lambda node: _standard(node, lacking))


def from_sympy(value: Any) -> Value:
    """Write SymPy's `Abs`, `Max`, `floor` and the like by the functions of the language.

    Values are the same; derivatives at kinks and jumps are then those of models.
    """
    return rewritten(value, lambda node: _LANGUAGE.get(type(node)))


def over_the_reals(value: Any) -> tuple[Any, dict[Any, Any]]:
    """Write an expression over real variables, which SymPy simplifies further; and the way back."""
    names = {s: sp.Symbol(s.name, real=True) for s in value.free_symbols}
    simple = {name: _KNOWN[name] for name in ("abs", "sign")}
    found = rewritten(value.xreplace(names), lambda node: simple.get(type(node).__name__))
    return found, {new: old for old, new in names.items()}


def _standard(node: Any, known: Mapping[str, Callable[..., Any]]) -> Callable[..., Any] | None:
    name = type(node).__name__
    if isinstance(node, UserFunction) or OWN.get(name) is not type(node):
        return None
    if name in known:
        return known[name]
    if OPERATIONS[name].primitive:
        return None
    return lambda *args: rewritten(written_out(name, *args), lambda inner: _standard(inner, known))


def rewritten(value: Any, rule: Callable[[Any], Callable[..., Any] | None]) -> Value:
    """Make a value again, from its operands up, where `rule` gives what makes a part of its own."""
    value = as_value(value)
    made: dict[Any, Any] = {}
    for node in postorder(entries(value)):
        args = tuple(made[a] for a in node.args)
        new = rule(node)
        if new is not None:
            made[node] = new(*args)
        else:
            made[node] = node if args == node.args else remade(node, args)
    return with_entries(value, [made[e] for e in entries(value)])


def _paired(name: str, args: tuple[Any, ...]) -> Any:
    return reduce(partial(operation, name), sorted(args, key=sp.default_sort_key))
