"""Making expressions in a tidy form: what differentiation builds from.

Beyond `arael.sym.building`: numbers come first in a product, ``x * x`` is ``x^2``, factors move
above a fraction's bar, signs to the front, equal terms are added. Nothing is cancelled from a
fraction, so singular points stay where they are.
"""

from __future__ import annotations

from collections.abc import Callable

from arael.sym.building import build
from arael.sym.expr import Expr, const

_MOST_FACTORS = 24


def tidy(op: str, *args: Expr) -> Expr:
    """Make operation `op` of `args`, tidied."""
    rule = _RULES.get(op)
    found = rule(*args) if rule is not None else None
    return build(op, *args) if found is None else found


def _mul(a: Expr, b: Expr) -> Expr | None:
    if a.value == 0 or b.value == 0:
        return const(0.0)
    sign = False
    if a.op == "neg":
        a, sign = a.args[0], not sign
    if b.op == "neg":
        b, sign = b.args[0], not sign
    if sign:
        return tidy("neg", tidy("mul", a, b))
    if a.op == "div" and b.op == "div":
        above, below = tidy("mul", a.args[0], b.args[0]), tidy("mul", a.args[1], b.args[1])
        return tidy("div", above, below)
    if a.op == "div":
        return tidy("div", tidy("mul", a.args[0], b), a.args[1])
    if b.op == "div":
        return tidy("div", tidy("mul", a, b.args[0]), b.args[1])
    return _product(a, b)


def _product(a: Expr, b: Expr) -> Expr | None:
    factors = [*_factors(a), *_factors(b)]
    if len(factors) > _MOST_FACTORS:
        return None
    number = 1.0
    powers: dict[Expr, Expr] = {}
    for factor in factors:
        if factor.value is not None:
            number *= factor.value
            continue
        base, exponent = _power(factor)
        if base in powers:
            known = powers[base]
            powers[base] = tidy("add", known, exponent)
        else:
            powers[base] = exponent
    if number - number != 0:  # overflow: leave the numbers as they are
        return None
    result = const(number)
    for base, exponent in powers.items():
        result = build("mul", result, base if exponent.value == 1 else build("pow", base, exponent))
    return result


def _factors(e: Expr) -> list[Expr]:
    found: list[Expr] = []
    stack = [e]
    while stack and len(found) <= _MOST_FACTORS:
        node = stack.pop()
        if node.op == "mul":
            stack.extend(reversed(node.args))
        else:
            found.append(node)
    return found if not stack else [e]


def _power(e: Expr) -> tuple[Expr, Expr]:
    """Base and exponent; only positive whole exponents count, so that poles stay."""
    if e.op == "pow":
        exponent = e.args[1].value
        if exponent is not None and exponent >= 1 and exponent.is_integer():
            return e.args[0], e.args[1]
    return e, const(1.0)


def _coefficient(e: Expr) -> tuple[float, Expr]:
    """Number in front of a term, and the rest."""
    if e.op == "neg":
        number, rest = _coefficient(e.args[0])
        return -number, rest
    if e.op == "mul":
        first, *others = _factors(e)
        if first.value is not None and others:
            return first.value, _times(others)
    return 1.0, e


def _times(factors: list[Expr]) -> Expr:
    result = factors[0]
    for factor in factors[1:]:
        result = build("mul", result, factor)
    return result


def _add(a: Expr, b: Expr) -> Expr | None:
    return _joined(a, b, 1.0)


def _sub(a: Expr, b: Expr) -> Expr | None:
    return _joined(a, b, -1.0)


def _joined(a: Expr, b: Expr, sign: float) -> Expr | None:
    (p, x), (q, y) = _coefficient(a), _coefficient(b)
    if x == y and x.op != "const":
        return tidy("mul", const(p + sign * q), x)
    merged = _merged(a, sign * q, y) if a.op in ("add", "sub") else None
    if merged is not None:
        return merged
    if b.op == "mul" and q < 0:
        positive = tidy("mul", const(-q), y)
        return build("sub" if sign > 0 else "add", a, positive)
    if p < 0 and q * sign > 0 and a.value is None:  # -a + b reads better as b - a
        return build("sub", tidy("mul", const(abs(q)), y), tidy("mul", const(-p), x))
    return None


def _merged(total: Expr, number: float, rest: Expr) -> Expr | None:
    """Add ``number * rest`` to the term of `total` that is like it, if there is one."""
    terms = _terms(total)
    at = next((i for i, (_, other) in enumerate(terms) if other == rest), None)
    if at is None or rest.op == "const":
        return None
    terms[at] = (terms[at][0] + number, rest)
    result: Expr | None = None
    for coefficient, other in terms:
        if coefficient == 0:
            continue
        if result is None:
            result = tidy("mul", const(coefficient), other)
        else:
            term = tidy("mul", const(abs(coefficient)), other)
            result = build("add" if coefficient > 0 else "sub", result, term)
    return const(0.0) if result is None else result


def _terms(total: Expr) -> list[tuple[float, Expr]]:
    """Terms of a sum that leans to the left, with their numbers; none of a long one."""
    found: list[tuple[float, Expr]] = []
    while total.op in ("add", "sub") and len(found) < _MOST_FACTORS:
        number, rest = _coefficient(total.args[1])
        found.append((number if total.op == "add" else -number, rest))
        total = total.args[0]
    if total.op in ("add", "sub"):
        return []
    return [_coefficient(total), *reversed(found)]


def _div(a: Expr, b: Expr) -> Expr | None:
    if a.value == 0 and b.value != 0:
        return a
    sign = False
    if a.op == "neg":
        a, sign = a.args[0], not sign
    if b.op == "neg":
        b, sign = b.args[0], not sign
    if sign:
        return tidy("neg", tidy("div", a, b))
    if a.op == "div":
        return tidy("div", a.args[0], tidy("mul", a.args[1], b))
    number, rest = _coefficient(a)
    if b.value and number != 1 and rest.op != "const" and (number / b.value).is_integer():
        return tidy("mul", const(number / b.value), rest)
    return None


def _neg(a: Expr) -> Expr | None:
    if a.op == "sub":
        return build("sub", a.args[1], a.args[0])
    if a.op == "mul":
        number, rest = _coefficient(a)
        return None if number == 1 else tidy("mul", const(-number), rest)
    return None


def _select(condition: Expr, then: Expr, otherwise: Expr) -> Expr | None:
    return then if then == otherwise else None


_RULES: dict[str, Callable[..., Expr | None]] = {
    "mul": _mul,
    "add": _add,
    "sub": _sub,
    "div": _div,
    "neg": _neg,
    "select": _select,
}
