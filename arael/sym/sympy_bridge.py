"""Expressions to SymPy and back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NoReturn

from arael.sym.building import build
from arael.sym.derivatives import WRITTEN_OUT
from arael.sym.errors import fail
from arael.sym.expr import Expr, const, postorder, symbol
from arael.sym.limits import MAX_SUPERSCRIPT
from arael.symbolic.folding import fold

_LARGEST_DENOMINATOR = 1024
_LARGEST_WHOLE = 1e15
_KNOWN = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp",
          "erf", "erfc")  # fmt: skip


class Bridge:
    """Takes expressions over to SymPy, and back.

    Operations that SymPy does not know, or would work out at any price (``floor`` of a number with
    many digits), cross as symbols of their own. So do conditions, ``max`` and the like, which
    algebra here takes as they are, unless everything is to go over as a `whole`.
    """

    def __init__(self, whole: bool = False) -> None:
        self._whole = whole
        self._opaque: dict[Expr, Any] = {}
        self._meaning: dict[Any, Expr] = {}

    # --- over -------------------------------------------------------------------------------------

    def over(self, root: Expr) -> Any:
        """`root` as a SymPy expression over the real numbers."""
        import sympy as sp

        table = _operations(self._whole)
        made: dict[int, Any] = {}
        values: dict[int, float | None] = {}
        for node in postorder([root]):
            args = [made[id(a)] for a in node.args]
            values[id(node)] = value = _number(node, [values[id(a)] for a in node.args])
            if node.op == "symbol":
                made[id(node)] = sp.Symbol(node.data, real=True)
            elif node.op == "const":
                made[id(node)] = _sympy_number(node.data)
            elif (
                self._whole and value is not None and math.isfinite(value) and _extreme(node, value)
            ):
                made[id(node)] = sp.Float(value, 17)
            elif self._whole and node.op in WRITTEN_OUT and node.op not in table:
                from arael.sym.sympy_whole import written

                made[id(node)] = written(node.op, args, to_sympy)
            elif node.op not in table or _untold(node, args) or _extreme(node, value):
                made[id(node)] = self._stand_in(node)
            elif node.op == "pow":
                made[id(node)] = args[0] ** _exponent(args[1])
            else:
                made[id(node)] = table[node.op](*args)
        return made[id(root)]

    def _stand_in(self, node: Expr) -> Any:
        import sympy as sp

        known = self._opaque.get(node)
        if known is None:
            known = self._opaque[node] = sp.Dummy(f"{node.op}{len(self._opaque)}", real=True)
            self._meaning[known] = node
        return known

    # --- back -------------------------------------------------------------------------------------

    def back(self, root: Any) -> Expr:
        """SymPy's `root` as an expression.

        Raises
        ------
        AraelError
            E0654 if there is something in it that has no counterpart.
        """
        import sympy as sp

        made: dict[Any, Expr] = {}
        stack = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if node in made:
                continue
            parts = _parts(node)
            if not ready:
                stack.append((node, True))
                stack.extend((p, False) for p in parts)
                continue
            args = [made[p] for p in parts]
            if node in self._meaning:
                made[node] = self._meaning[node]
            elif isinstance(node, sp.Symbol):
                made[node] = symbol(node.name)
            elif isinstance(node, sp.Number):
                made[node] = _from_number(node)
            elif isinstance(node, sp.Add):
                made[node] = _sum(args)
            elif isinstance(node, sp.Mul):
                made[node] = _product(node, args)
            elif isinstance(node, sp.Pow):
                made[node] = _power(*args)
            elif isinstance(node, (sp.Piecewise, sp.logic.boolalg.Boolean)):
                made[node] = _piecewise(node, args)
            else:
                made[node] = _function(node, args)
        return made[root]


def to_sympy(e: Expr) -> Any:
    """Return `e` as a SymPy expression over real symbols of the same names.

    ``if``, ``cbrt`` become `Piecewise`, ``min`` and ``max`` `Min` and `Max`, ``safe_sqrt`` and its
    like the formulas they stand for. At jumps and kinks, SymPy's derivatives may have a
    `DiracDelta` where those here are 0. Functions of the user with derivatives of their own stay
    behind as symbols. Numbers that are short binary fractions become rational.
    """
    return Bridge(whole=True).over(e)


def from_sympy(expression: Any) -> Expr:
    """Return a SymPy expression as one of ours.

    Raises
    ------
    AraelError
        E0654 if there is something in it that has no counterpart here.
    """
    return Bridge().back(expression)


def _operations(whole: bool) -> dict[str, Callable[..., Any]]:
    import sympy as sp

    more: dict[str, Callable[..., Any]] = {}
    if whole:
        from arael.sym.sympy_whole import OPERATIONS as more
    return {
        **more,
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
        "neg": lambda a: -a,
        "pow": lambda a, b: a**b,
        "sqrt": sp.sqrt,
        "log": sp.log,
        "abs": sp.Abs,
        "hypot": lambda a, b: sp.sqrt(a**2 + b**2),
        "pi": lambda: sp.pi,
        "e": lambda: sp.E,
        "expm1": lambda a: sp.exp(a) - 1,
        "log1p": lambda a: sp.log(1 + a),
        "lgamma": sp.loggamma,
        **{name: getattr(sp, name) for name in _KNOWN},
    }


def _number(node: Expr, args: list[float | None]) -> float | None:
    """Value of an expression without variables, by floating point; NaN where it has none."""
    if node.op == "const":
        return float(node.data)
    if node.op in ("pi", "e", "epsilon"):
        return {"pi": math.pi, "e": math.e}.get(node.op, 2.0**-52)
    if not args or any(a is None for a in args):
        return None
    found = fold(node.op, *(a for a in args if a is not None))
    return math.nan if found is None else found


def _untold(node: Expr, args: list[Any]) -> bool:
    """Whether SymPy's answer would not be a real number, as 0 / 0."""
    import sympy as sp

    if node.op == "div" and args[1] == 0:
        return True
    if node.op in ("asin", "acos"):
        return bool(args[0].is_number) and bool(sp.Abs(args[0]) > 1)
    if node.op == "atan2":
        return bool(args[0] == 0 and args[1] == 0)
    if node.op == "pow" and args[0] == 0:
        return not (args[1].is_number and args[1] > 0)
    return bool(node.op in ("sqrt", "log") and args[0].is_number and not args[0] > 0)


def _extreme(node: Expr, value: float | None) -> bool:
    """Whether a number is such that exact arithmetic would go on for ever."""
    if value is None:
        return False
    return not math.isfinite(value) or (value != 0 and not 1e-15 < abs(value) < _LARGEST_WHOLE)


def _exponent(exponent: Any) -> Any:
    import sympy as sp

    large = exponent.is_Rational and (
        abs(exponent.p) > MAX_SUPERSCRIPT or exponent.q > MAX_SUPERSCRIPT
    )
    return sp.Float(exponent) if large else exponent


def _sympy_number(value: float) -> Any:
    import sympy as sp

    if not math.isfinite(value):
        return sp.nan if math.isnan(value) else sp.oo if value > 0 else -sp.oo
    numerator, denominator = value.as_integer_ratio()
    if denominator <= _LARGEST_DENOMINATOR and abs(value) < _LARGEST_WHOLE:
        return sp.Rational(numerator, denominator)
    return sp.Float(value, 17)


def _parts(node: Any) -> list[Any]:
    import sympy as sp
    from sympy.core.function import Application

    if isinstance(node, sp.Piecewise):
        return [part for pair in node.args for part in pair.args]
    if isinstance(node, sp.core.relational.Relational):
        return list(node.args)
    if isinstance(node, sp.Heaviside):
        return list(node.args[:1])
    if isinstance(node, sp.Add):
        return list(node.as_ordered_terms())
    if isinstance(node, sp.Mul):
        return list(node.as_ordered_factors())
    return list(node.args) if isinstance(node, (sp.Pow, Application)) else []


def _from_number(number: Any) -> Expr:
    if number.is_Rational and number.q != 1:
        p, q = int(number.p), int(number.q)
        if q & (q - 1) == 0 and q <= 8:
            return const(p / q)
        return build("div", const(p), const(q))
    if number.is_finite is False or number.is_real is not True:
        _unknown(number)
    return const(float(number))


def _sum(terms: list[Expr]) -> Expr:
    result = terms[0]
    for term in terms[1:]:
        result = _added(result, term)
    return result


def _added(a: Expr, b: Expr) -> Expr:
    """Add, with a leading minus sign of `b` turned into a difference."""
    if b.op == "mul" and (number := b.args[0].value) is not None and number < 0:
        return build("sub", a, build("mul", const(-number), b.args[1]))
    if b.op == "div" and b.args[0].op == "neg":
        return build("sub", a, build("div", b.args[0].args[0], b.args[1]))
    return build("add", a, b)


def _product(node: Any, args: list[Expr]) -> Expr:
    """A product, with what has a negative power below the bar."""
    above: list[Expr] = []
    below: list[Expr] = []
    for part, arg in zip(_parts(node), args, strict=True):
        if part.is_Rational and part.q != 1:
            p, q = int(part.p), int(part.q)
            if p < 0:
                above.insert(0, const(-1.0))
            if abs(p) != 1:
                above.append(const(abs(p)))
            below.append(const(q))
        elif arg.op == "div" and arg.args[0].value == 1:
            below.append(arg.args[1])
        else:
            above.append(arg)
    top = _times(above)
    return build("div", top, _times(below)) if below else top


def _times(factors: list[Expr]) -> Expr:
    if not factors:
        return const(1.0)
    sign = factors[0].value == -1 and len(factors) > 1
    first, *rest = factors[1:] if sign else factors
    numbers = [f for f in rest if f.value is not None]
    result = first
    for factor in [*numbers, *(f for f in rest if f.value is None)]:
        result = build("mul", result, factor)
    return build("neg", result) if sign else result


def _power(base: Expr, exponent: Expr) -> Expr:
    if exponent.value == 0.5:
        return build("sqrt", base)
    if exponent.value is not None and exponent.value < 0:
        return build("div", const(1.0), _power(base, const(-exponent.value)))
    return build("pow", base, exponent)


_RELATIONS = {
    "StrictLessThan": ("lt", False),
    "LessThan": ("le", False),
    "StrictGreaterThan": ("lt", True),
    "GreaterThan": ("le", True),
    "Equality": ("eq", False),
    "Unequality": ("ne", False),
}


def _piecewise(node: Any, args: list[Expr]) -> Expr:
    """Conditions, and what depends on them."""
    import sympy as sp

    if node in (sp.true, sp.false):
        return build("eq", const(float(node is sp.true)), const(1.0))
    name = type(node).__name__
    if name in _RELATIONS:
        op, swapped = _RELATIONS[name]
        return build(op, *(reversed(args) if swapped else args))
    if name == "ITE":
        condition, arm, other = args
        first = build("and", condition, arm)
        return build("or", first, build("and", build("not", condition), other))
    if name in ("And", "Or", "Not"):
        result = args[0] if name != "Not" else build("not", args[0])
        for other in args[1:]:
            result = build(name.lower(), result, other)
        return result
    if name != "Piecewise" or node.args[-1].cond != sp.true:
        _unknown(node)  # without a last arm it has no value somewhere
    result = args[-2]
    for arm, condition in reversed(list(zip(args[:-2:2], args[1:-2:2], strict=True))):
        result = build("select", condition, arm, result)
    return result


def _function(node: Any, args: list[Expr]) -> Expr:
    import sympy as sp

    if node is sp.pi:
        return build("pi")
    if node is sp.E:
        return build("e")
    name = type(node).__name__
    name = {"Abs": "abs", "ceiling": "ceil", "loggamma": "lgamma"}.get(name, name)
    if name == "log" and len(args) == 2:
        return build("div", build("log", args[0]), build("log", args[1]))
    if name in ("Max", "Min") and args:
        result = args[0]
        for other in args[1:]:
            result = build(name.lower(), result, other)
        return result
    if name == "Heaviside" and node.args[1] != sp.Rational(1, 2):
        _unknown(node)
    name = name.lower()
    if name in (*_KNOWN, "log", "abs", "sign", "heaviside", "floor", "ceil", "lgamma") and args:
        return build(name, *args)
    _unknown(node)


def _unknown(node: Any) -> NoReturn:
    fail(
        "E0654",
        f"`{str(node)[:60]}` has no counterpart among expressions",
        origin="SymPy",
        help=("expressions are over the real numbers, with the functions of the language",),
    )
