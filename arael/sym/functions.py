"""The functions of the language, for use from Python.

Arguments may be expressions, numbers, vectors, matrices and quaternions, as the language has it:
``sin`` of a vector is elementwise, ``exp`` of a vector of length 3 the quaternion of a rotation
vector, ``log`` of a quaternion that vector.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arael.check.builtins import FUNCTIONS
from arael.sym.building import build
from arael.sym.expr import Expr, as_expr
from arael.sym.operations import call_on_any, logic
from arael.sym.shapes import Matrix, as_value, composite
from arael.symbolic.scalars import SCALARS

Call = Callable[..., Any]


def _function(name: str) -> Call:
    def apply(*args: Any) -> Any:
        return call_on_any(name, *args)

    apply.__name__ = apply.__qualname__ = name
    scalar = SCALARS.get(name)
    if scalar is not None:
        singular = f"\nSingular points: {scalar.singular}." if scalar.singular else ""
        apply.__doc__ = f"{scalar.value}.\n\nDerivative: {scalar.derivative}.{singular}"
    else:
        apply.__doc__ = f"{name} of {FUNCTIONS[name].takes}." if name in FUNCTIONS else None
    return apply


sin, cos, tan = _function("sin"), _function("cos"), _function("tan")
asin, acos, atan = _function("asin"), _function("acos"), _function("atan")
atan2, hypot, pow = _function("atan2"), _function("hypot"), _function("pow")
sinh, cosh, tanh = _function("sinh"), _function("cosh"), _function("tanh")
exp, log, log2, log10 = (_function(n) for n in ("exp", "log", "log2", "log10"))
sqrt, cbrt = _function("sqrt"), _function("cbrt")
abs, sign, heaviside = _function("abs"), _function("sign"), _function("heaviside")
min, max, clamp = _function("min"), _function("max"), _function("clamp")
floor, ceil, round = _function("floor"), _function("ceil"), _function("round")
identity = _function("identity")
safe_sqrt, safe_asin = _function("safe_sqrt"), _function("safe_asin")
safe_acos, safe_atan2 = _function("safe_acos"), _function("safe_atan2")
rad_diff, rad_sum = _function("rad_diff"), _function("rad_sum")
deg2rad, rad2deg = _function("deg2rad"), _function("rad2deg")
fast_atan, fast_atan2 = _function("fast_atan"), _function("fast_atan2")
starship, starship_gamma = _function("starship"), _function("starship_gamma")
erf, erfc, lgamma, digamma = (_function(n) for n in ("erf", "erfc", "lgamma", "digamma"))
expm1, log1p, sinc = _function("expm1"), _function("log1p"), _function("sinc")
dot, cross, norm, norm2 = (_function(n) for n in ("dot", "cross", "norm", "norm2"))
unit, perp = _function("unit"), _function("perp")
det, transpose, inverse, trace = (_function(n) for n in ("det", "transpose", "inverse", "trace"))
skew, vee = _function("skew"), _function("vee")
rotation_matrix, euler_angles = _function("rotation_matrix"), _function("euler_angles")
rotation_vector = _function("rotation_vector")
conj, rotate = _function("conj"), _function("rotate")
transform, similarity = _function("transform"), _function("similarity")
matrix = _function("matrix")
mat3, quaternion = _function("mat3"), _function("quaternion")

pi: Expr = build("pi")
e: Expr = build("e")
epsilon: Expr = build("epsilon")


def identity2() -> Matrix:
    """Identity matrix, 2 x 2."""
    return call_on_any("identity2")  # type: ignore[no-any-return]


def identity3() -> Matrix:
    """Identity matrix, 3 x 3."""
    return call_on_any("identity3")  # type: ignore[no-any-return]


def where(condition: Expr, then: Any, otherwise: Any) -> Any:
    """``if condition then a else b``; only the arm that is taken counts, also for derivatives."""
    a, b = as_value(then), as_value(otherwise)
    if a.type != b.type:
        raise TypeError(f"the two arms differ: {a.type} and {b.type}")
    pairs = zip(a.entries, b.entries, strict=True)
    return composite(a.type, tuple(build("select", as_expr(condition), x, y) for x, y in pairs))


def eq(a: Expr | float, b: Expr | float) -> Expr:
    """Condition ``a == b``; the operator ``==`` compares how expressions are written."""
    return build("eq", as_expr(a), as_expr(b))


def ne(a: Expr | float, b: Expr | float) -> Expr:
    """Condition ``a != b``."""
    return build("ne", as_expr(a), as_expr(b))


def both(a: Expr, b: Expr) -> Expr:
    """Condition ``a and b``."""
    return logic("and", a, b)


def either(a: Expr, b: Expr) -> Expr:
    """Condition ``a or b``."""
    return logic("or", a, b)


def negated(a: Expr) -> Expr:
    """Condition ``not a``."""
    return logic("not", a)


__all__ = [
    *(name for name in SCALARS),
    *(name for name in FUNCTIONS if name not in SCALARS),
    *("identity2", "identity3", "where", "eq", "ne", "both", "either", "negated"),
]
