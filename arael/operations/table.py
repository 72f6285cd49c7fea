"""The table of operations: what is added here needs nothing elsewhere.

The language, units, derivatives, generated code, the expression machine, the printers, and messages
about operands outside of the domain all read these records. SymPy is named and not imported, so
that the runtime can read the table too.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from arael.operations.record import Domain, Operation

Array = Any


def _heaviside(x: Array) -> Array:
    return np.heaviside(x, 0.5)


def _round(x: Array) -> Array:
    """Round as C does: halves go away from zero, unlike NumPy's."""
    return np.copysign(np.floor(np.abs(x) + 0.5), x)


def _select(condition: Array, taken: Array, otherwise: Array) -> Array:
    return np.where(condition != 0, taken, otherwise)


def _test(compare: Callable[..., Array]) -> Callable[..., Array]:
    """A comparison that gives 1 or 0."""
    return lambda *a: compare(*a).astype(np.result_type(*a, np.float32))


def _scipy(name: str) -> Callable[..., Any]:
    """Return a function of `scipy.special`, which is imported with the first call."""

    def call(x: Any) -> Any:
        # Imported here for start-up time: SciPy's functions take a tenth of a second.
        from scipy import special

        return getattr(special, name)(x)

    call.__name__ = name
    return call


def _power_holds(x: float, y: float) -> bool:
    return x > 0 or (y == math.floor(y) and (x != 0 or y >= 0)) or (x == 0 and y > 0)


def _whole(x: float) -> bool:
    return math.isfinite(x) and x == math.floor(x)


_OWN = "arael.symbolic.derivatives"
_COMPOSED = "arael.symbolic.scalars.composed"

_NOT_NEGATIVE = Domain("x >= 0", lambda x: x >= 0)
_POSITIVE = Domain("x > 0", lambda x: x > 0)
_WITHIN_ONE = Domain("-1 <= x <= 1", lambda x: -1 <= x <= 1)
_ABOVE_MINUS_ONE = Domain("x > -1", lambda x: x > -1)
_NO_POLE = Domain("x other than 0, -1, -2, ...", lambda x: not (x <= 0 and _whole(x)))
_POWER = Domain(
    "x > 0, x = 0 with y >= 0, or x < 0 with a whole number y", _power_holds
)  # fmt: skip
_NOT_BY_ZERO = Domain("y != 0", lambda x, y: y != 0)

_AT_JUMP = "derivative 0 at the jumps too"
_LOG_AT_0 = "-inf at 0 with derivative inf; NaN for x < 0"

_RECORDS = [
    # Arithmetic.
    Operation(
        "add", 2, np.add, "operator:add", "sum", number=operator.add, opcode=True,
        c="{0} + {1}", python="{0} + {1}", text="{0} + {1}", binding=6, operands=(6, 7),
    ),
    Operation(
        "sub", 2, np.subtract, "operator:sub", "sum", number=operator.sub, opcode=True,
        c="{0} - {1}", python="{0} - {1}", text="{0} - {1}", binding=6, operands=(6, 7),
    ),
    Operation(
        "mul", 2, np.multiply, "operator:mul", "product", number=operator.mul, opcode=True,
        c="{0} * {1}", python="{0} * {1}", text="{0} * {1}", binding=8, operands=(7, 9),
    ),
    Operation(
        "div", 2, np.divide, "operator:truediv", "quotient", domain=_NOT_BY_ZERO,
        number=operator.truediv, opcode=True,
        c="{0} / {1}", python="{0} / {1}", text="{0} / {1}", binding=8, operands=(7, 9),
        costly=True,
    ),
    Operation(
        "neg", 1, np.negative, "operator:neg", "same", number=operator.neg, opcode=True,
        c="-{0}", python="-{0}", text="-{0}", binding=7, operands=(8,),
    ),
    # Functions of the C library.
    Operation(
        "pow", 2, np.power, f"{_OWN}:power", "power", "y x^(y - 1); x^y ln(x)",
        "x^0 = 1, also at 0, with derivative NaN by x there; at x = 0 the derivative by y is 0; "
        "NaN for x < 0 unless y is an integer", "x^y", _POWER, number=math.pow, vector="2.22",
        opcode=True, python="{0} ** {1}", text="{0}^{1}", binding=10, operands=(11, 100),
        costly=True,
    ),
    Operation(
        "sqrt", 1, np.sqrt, "sympy:sqrt", "square root", "1 / (2 sqrt(x))",
        "0 at 0 with derivative inf; NaN for x < 0", domain=_NOT_NEGATIVE, number=math.sqrt,
        opcode=True, costly=True,
    ),
    Operation(
        "cbrt", 1, np.cbrt, "sympy:cbrt", "cube root", "1 / (3 cbrt(x)^2)",
        "0 at 0 with derivative inf", vector="2.35", parity="odd", opcode=True,
        number=lambda x: float(np.cbrt(x)), latex="\\sqrt[3]{{{0}}}", costly=True,
    ),
    Operation(
        "exp", 1, np.exp, "sympy:exp", "pure", "exp(x)", number=math.exp, vector="2.22",
        latex="\\exp", opcode=True, costly=True,
    ),
    Operation(
        "log", 1, np.log, "sympy:log", "pure", "1 / x", _LOG_AT_0, "ln(x)", _POSITIVE,
        number=math.log, vector="2.22", latex="\\log", opcode=True, costly=True,
    ),
    Operation(
        "log2", 1, np.log2, f"{_OWN}:log2", "pure", "1 / (x ln 2)", _LOG_AT_0, domain=_POSITIVE,
        number=math.log2, vector="2.35", latex="\\log_{2}", opcode=True, costly=True,
    ),
    Operation(
        "log10", 1, np.log10, f"{_OWN}:log10", "pure", "1 / (x ln 10)", _LOG_AT_0,
        domain=_POSITIVE, number=math.log10, vector="2.35", latex="\\log_{10}", opcode=True,
        costly=True,
    ),
    Operation(
        "sin", 1, np.sin, "sympy:sin", "angle", "cos(x)", number=math.sin, vector="2.22",
        parity="odd", latex="\\sin", opcode=True, costly=True,
    ),
    Operation(
        "cos", 1, np.cos, "sympy:cos", "angle", "-sin(x)", number=math.cos, vector="2.22",
        parity="even", latex="\\cos", opcode=True, costly=True,
    ),
    Operation(
        "tan", 1, np.tan, "sympy:tan", "angle", "1 + tan(x)^2", number=math.tan, vector="2.35",
        parity="odd", latex="\\tan", opcode=True, costly=True,
    ),
    Operation(
        "asin", 1, np.arcsin, "sympy:asin", "angle of", "1 / sqrt(1 - x^2)",
        "NaN for |x| > 1; derivative inf at x = -1, 1", domain=_WITHIN_ONE, number=math.asin,
        vector="2.35", parity="odd", latex="\\arcsin", opcode=True, costly=True,
    ),
    Operation(
        "acos", 1, np.arccos, "sympy:acos", "angle of", "-1 / sqrt(1 - x^2)",
        "NaN for |x| > 1; derivative -inf at x = -1, 1", domain=_WITHIN_ONE, number=math.acos,
        vector="2.35", latex="\\arccos", opcode=True, costly=True,
    ),
    Operation(
        "atan", 1, np.arctan, "sympy:atan", "angle of", "1 / (1 + x^2)", number=math.atan,
        vector="2.35", parity="odd", latex="\\arctan", opcode=True, costly=True,
    ),
    Operation(
        "atan2", 2, np.arctan2, "sympy:atan2", "angle of two", "y / (x^2 + y^2); -x / (x^2 + y^2)",
        "0 at (0, 0) with derivative NaN; jumps across the negative half axis of y",
        "angle of the vector (y, x): atan2(x, y) has the sine's side first", number=math.atan2,
        vector="2.35", opcode=True, costly=True,
    ),
    Operation(
        "sinh", 1, np.sinh, "sympy:sinh", "pure", "cosh(x)", number=math.sinh, vector="2.35",
        parity="odd", latex="\\sinh", opcode=True, costly=True,
    ),
    Operation(
        "cosh", 1, np.cosh, "sympy:cosh", "pure", "sinh(x)", number=math.cosh, vector="2.35",
        parity="even", latex="\\cosh", opcode=True, costly=True,
    ),
    Operation(
        "tanh", 1, np.tanh, "sympy:tanh", "pure", "1 - tanh(x)^2", number=math.tanh, vector="2.35",
        parity="odd", latex="\\tanh", opcode=True, costly=True,
    ),
    Operation(
        "hypot", 2, np.hypot, f"{_OWN}:hypot", "joined", "x / hypot(x, y); y / hypot(x, y)",
        "0 at (0, 0) with derivative NaN", "sqrt(x^2 + y^2) without overflow", number=math.hypot,
        vector="2.35", opcode=True, costly=True,
    ),
    Operation(
        "erf", 1, _scipy("erf"), "sympy:erf", "pure", "2 exp(-x^2) / sqrt(pi)",
        value="error function", number=math.erf, parity="odd", costly=True,
    ),
    Operation(
        "erfc", 1, _scipy("erfc"), "sympy:erfc", "pure", "-2 exp(-x^2) / sqrt(pi)",
        value="1 - erf(x), without cancellation for large x", number=math.erfc, costly=True,
    ),
    Operation(
        "expm1", 1, np.expm1, f"{_OWN}:expm1", "pure", "exp(x)",
        value="exp(x) - 1, without cancellation near 0", number=math.expm1, costly=True,
    ),
    Operation(
        "log1p", 1, np.log1p, f"{_OWN}:log1p", "pure", "1 / (1 + x)",
        "-inf at -1 with derivative inf; NaN for x < -1",
        "ln(1 + x), without cancellation near 0", _ABOVE_MINUS_ONE, number=math.log1p, costly=True,
    ),
    Operation(
        "lgamma", 1, _scipy("gammaln"), f"{_OWN}:lgamma", "pure", "digamma(x)",
        "inf at 0, -1, -2, ...; derivative -inf at 0, of size 1e15 at -1, -2, ...", "ln |gamma(x)|",
        _NO_POLE, number=math.lgamma, latex="\\ln\\Gamma", costly=True,
    ),
    # Composed of others.
    Operation(
        "sinc", 1, None, "", "angle", "(cos(x) - sinc(x)) / x", "1 at 0 with derivative 0",
        "sin(x) / x", build=_COMPOSED,
    ),
    Operation(
        "digamma", 1, None, "", "pure", "by that of its series",
        "-inf at 0; of size 1e15 at -1, -2, ...", "derivative of lgamma(x)", _NO_POLE,
        build=_COMPOSED,
    ),
    Operation(
        "identity", 1, np.positive, "", "same", "1",
        value="x; simplification does not look through it", opcode=True,
        c="{0}", python="+{0}", binding=7, operands=(8,),
    ),
    Operation(
        "deg2rad", 1, None, "", "to radians", repr(math.pi / 180), value="pi / 180 x",
        build=_COMPOSED,
    ),
    Operation(
        "rad2deg", 1, None, "", "to degrees", repr(180 / math.pi), value="180 / pi x",
        build=_COMPOSED,
    ),
    # Kinks and jumps: finite in value and derivative everywhere.
    Operation(
        "floor", 1, np.floor, "sympy:floor", "same", "0", _AT_JUMP, "largest integer not above x",
        flat=True, opcode=True,
    ),
    Operation(
        "ceil", 1, np.ceil, "sympy:ceiling", "same", "0", _AT_JUMP, "smallest integer not below x",
        flat=True, opcode=True,
    ),
    Operation(
        "abs", 1, np.abs, "sympy:Abs", "same", "sign(x)", "derivative 0 at 0", "|x|", c="fabs",
        latex="\\left|{{{0}}}\\right|",
        parity="even", opcode=True, python="np.abs({0})",
    ),
    Operation(
        "sign", 1, np.sign, "sympy:sign", "count", "0", "0 at 0; derivative 0 there too",
        "-1, 0 or 1", parity="odd", flat=True, opcode=True,
        c="({0} > ZERO ? ONE : {0} < ZERO ? -ONE : {0})",
        cython="({0} if {0} != {0} else <real>({0} > 0) - <real>({0} < 0))",
        machine="({0} != {0} ? {0} : (real)(({0} > ZERO) - ({0} < ZERO)))",
    ),
    Operation(
        "heaviside", 1, _heaviside, "", "count", "0", "0.5 at 0; derivative 0 there too",
        "0 for x < 0, 1 for x > 0", flat=True, opcode=True, python="np.heaviside({0}, 0.5)",
        c="({0} > ZERO ? ONE : {0} < ZERO ? ZERO : {0} == ZERO ? HALF : {0})",
        cython="({0} if {0} != {0} else <real>0.5 * (<real>({0} > 0) + <real>({0} >= 0)))",
        machine="({0} != {0} ? {0} : HALF * (real)(({0} > ZERO) + ({0} >= ZERO)))",
    ),
    Operation(
        "round", 1, _round, "", "same", "0", _AT_JUMP, "nearest integer, halves away from zero",
        parity="odd", flat=True, opcode=True,
        python="np.copysign(np.floor(np.abs({0}) + 0.5), {0})",
        cython="m_copysign(m_floor(m_abs({0}) + <real>0.5), {0})",
        machine="CALL(copysign)(CALL(floor)(CALL(fabs)({0}) + HALF), {0})",
    ),
    Operation(
        "min", 2, np.minimum, f"{_OWN}:minimum", "joined", "1 if x <= y else 0; 1 if y < x else 0",
        "at x = y the derivative is that of x", "the smaller", several=True, opcode=True,
        latex="\\min", c="({0} < {1} || {0} != {0} ? {0} : {1})", python="np.minimum({0}, {1})",
        cython="({0} if ({0} < {1}) | ({0} != {0}) else {1})",
    ),
    Operation(
        "max", 2, np.maximum, f"{_OWN}:maximum", "joined", "1 if y <= x else 0; 1 if x < y else 0",
        "at x = y the derivative is that of x", "the larger", several=True, opcode=True,
        latex="\\max", c="({0} > {1} || {0} != {0} ? {0} : {1})", python="np.maximum({0}, {1})",
        cython="({0} if ({0} > {1}) | ({0} != {0}) else {1})",
    ),
    Operation(
        "clamp", 3, None, f"{_OWN}:clamp", "joined",
        "1 if y <= x <= z else 0; 1 if x < y else 0; 1 if z < x else 0",
        "at x = y and at x = z the derivative is that of x",
        "min(max(x, y), z): x held in y .. z", takes="three scalars: value, low, high",
        build=_COMPOSED,
    ),
    # Regularised.
    Operation(
        "safe_sqrt", 1, None, f"{_OWN}:safe_sqrt", "square root",
        "1 / (2 sqrt(x + 1e-12)) if x >= 0 else 0",
        "0 at 0 with derivative 5e5; 0 with derivative 0 for x < 0", "sqrt(max(x, 0))",
        build=_COMPOSED,
    ),
    Operation(
        "safe_asin", 1, None, f"{_OWN}:safe_asin", "angle of",
        "1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "pi/2 at 1, -pi/2 at -1, derivative 1e6 at both; constant with derivative 0 beyond",
        "asin(clamp(x, -1, 1))", build=_COMPOSED,
    ),
    Operation(
        "safe_acos", 1, None, f"{_OWN}:safe_acos", "angle of",
        "-1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "0 at 1, pi at -1, derivative -1e6 at both; constant with derivative 0 beyond",
        "acos(clamp(x, -1, 1))", build=_COMPOSED,
    ),
    Operation(
        "safe_atan2", 2, None, f"{_OWN}:safe_atan2", "angle of two",
        "y / (x^2 + y^2 + 1e-12); -x / (x^2 + y^2 + 1e-12)",
        "0 at (0, 0) with derivatives 0 and 0; derivatives never above 5e5", "atan2(x, y)",
        build=_COMPOSED,
    ),
    # Angles.
    Operation(
        "rad_diff", 2, None, "", "radians", "1; -1",
        "pi at a half turn, from either side; derivatives 1 and -1 there too",
        "x - y, wrapped to (-pi, pi]", build=_COMPOSED,
    ),
    Operation(
        "rad_sum", 2, None, "", "radians", "1; 1",
        "pi at a half turn, from either side; derivatives 1 and 1 there too",
        "x + y, wrapped to (-pi, pi]", build=_COMPOSED,
    ),
    Operation(
        "fast_atan", 1, None, f"{_OWN}:fast_atan", "angle of", "1 / (1 + x^2)",
        "jumps by less than 1e-7 at |x| = 1", "atan(x) to within 6e-8, by a polynomial",
        build=_COMPOSED,
    ),
    Operation(
        "fast_atan2", 2, None, f"{_OWN}:fast_atan2", "angle of two",
        "y / (x^2 + y^2); -x / (x^2 + y^2)",
        "0 at (0, 0) with derivative NaN; jumps by less than 1e-7 at |x| = |y|",
        "atan2(x, y) to within 6e-8, by a polynomial", build=_COMPOSED,
    ),
    # Bounded residuals.
    Operation(
        "starship", 2, None, f"{_OWN}:starship", "starship",
        "1 / (1 + (x / y)^2); atan(x / y) - (x / y) / (1 + (x / y)^2)",
        "at y = 0: 0 with derivatives 0 and NaN; all NaN at (0, 0)", "y atan(x / y)",
        takes="a scalar or a vector, and a scalar gamma", build=_COMPOSED,
    ),
    Operation(
        "starship_gamma", 1, None, "", "pure", "1 / (pi sqrt(x))",
        "0 at 0 with derivative inf; NaN for x < 0",
        "2 sqrt(x) / pi: the y of starship that bounds the cost of a residual by x",
        _NOT_NEGATIVE, build=_COMPOSED,
    ),
    # Comparisons and conditions, as 1 or 0.
    Operation(
        "lt", 2, _test(np.less), f"{_OWN}:lt", "comparison", flat=True, opcode=True,
        c="({0} < {1} ? ONE : ZERO)", cython="<real>({0} < {1})",
        python="np.where({0} < {1}, 1.0, 0.0)",
        text="{0} < {1}", binding=5, operands=(6, 6),
    ),
    Operation(
        "le", 2, _test(np.less_equal), f"{_OWN}:le", "comparison", flat=True, opcode=True,
        c="({0} <= {1} ? ONE : ZERO)", cython="<real>({0} <= {1})",
        python="np.where({0} <= {1}, 1.0, 0.0)",
        text="{0} <= {1}", binding=5, operands=(6, 6),
    ),
    Operation(
        "eq", 2, _test(np.equal), f"{_OWN}:eq", "comparison", flat=True, opcode=True,
        c="({0} == {1} ? ONE : ZERO)", cython="<real>({0} == {1})",
        python="np.where({0} == {1}, 1.0, 0.0)",
        text="{0} == {1}", binding=5, operands=(6, 6),
    ),
    Operation(
        "ne", 2, _test(np.not_equal), "", "comparison", flat=True, opcode=True,
        c="({0} != {1} ? ONE : ZERO)", cython="<real>({0} != {1})",
        python="np.where({0} != {1}, 1.0, 0.0)",
        text="{0} != {1}", binding=5, operands=(6, 6),
    ),
    Operation(
        "and", 2, _test(np.logical_and), f"{_OWN}:both", flat=True, opcode=True,
        c="({0} != ZERO && {1} != ZERO ? ONE : ZERO)", cython="<real>(({0} != 0) & ({1} != 0))",
        python="np.where(({0} != 0) & ({1} != 0), 1.0, 0.0)",
        text="{0} and {1}", binding=3, operands=(3, 4),
    ),
    Operation(
        "or", 2, _test(np.logical_or), f"{_OWN}:either", flat=True, opcode=True,
        c="({0} != ZERO || {1} != ZERO ? ONE : ZERO)", cython="<real>(({0} != 0) | ({1} != 0))",
        python="np.where(({0} != 0) | ({1} != 0), 1.0, 0.0)",
        text="{0} or {1}", binding=2, operands=(2, 3),
    ),
    Operation(
        "not", 1, _test(np.logical_not), "", flat=True, opcode=True,
        c="({0} == ZERO ? ONE : ZERO)", cython="<real>({0} == 0)",
        python="np.where({0} == 0, 1.0, 0.0)",
        text="not {0}", binding=4, operands=(4,),
    ),
    Operation(
        "select", 3, _select, f"{_OWN}:select", opcode=True,
        c="({0} != ZERO ? {1} : {2})", cython="({1} if {0} != 0 else {2})",
        python="np.where({0}, {1}, {2})",
        text="if {0} then {1} else {2}", binding=0, operands=(1, 1, 0),
    ),
]  # fmt: skip

OPERATIONS: dict[str, Operation] = {record.name: record for record in _RECORDS}
"""By name."""
