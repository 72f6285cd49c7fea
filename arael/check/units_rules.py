"""Rule: how each operation and function treats the units of its arguments.

Allowed: sums and comparisons of one unit, any product, powers and roots of units, angles in `sin`,
pure numbers in `exp`; literal numbers anywhere.

Not allowed: ``m + rad``, ``sin(m)``, ``exp(m)``, ``deg`` where radians are meant.

The result of an operation that is not listed here has an unknown unit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from arael.check.arithmetic import NotConstant, evaluate
from arael.check.typed import Apply, Literal_, MatrixType, TransformType, Typed, VectorType
from arael.check.types import size_of
from arael.check.units import DEG, ONE, RAD, Unit
from arael.check.units_quantities import (
    NUMBER,
    UNKNOWN,
    Clash,
    Quantity,
    Scalar,
    all_joined,
    joined,
    packed,
    power,
    spread,
    times,
)
from arael.operations import OPERATIONS

Rule = Callable[[Apply, Sequence[Quantity]], Quantity]
MAX_EXPONENT = 100


class Misfit(Exception):
    """Argument `index` is in `unit` instead of `wanted`: ``an angle``, ``a pure number``."""

    def __init__(self, index: int, unit: Unit, wanted: str) -> None:
        super().__init__(f"{unit}, not {wanted}")
        self.index = index
        self.unit = unit
        self.wanted = wanted


def result_of(node: Apply, args: Sequence[Quantity]) -> Quantity:
    """Unit of an operation.

    Raises
    ------
    Clash
        If the units of a sum differ.
    Misfit
        If an argument has another unit than the operation takes.
    """
    rule = RULES.get(node.name)
    return UNKNOWN if rule is None else rule(node, args)


def _same(node: Apply, args: Sequence[Quantity]) -> Quantity:
    return args[0]


def _sum(node: Apply, args: Sequence[Quantity]) -> Quantity:
    a, b = args[0], args[1]
    if not isinstance(a, tuple) and not isinstance(b, tuple):
        return joined(a, b)
    size = size_of(node.args[0].type)
    return packed(tuple(map(joined, spread(a, size), spread(b, size))))


def _compare(node: Apply, args: Sequence[Quantity]) -> Quantity:
    _sum(node, args)
    return UNKNOWN


def _joined(node: Apply, args: Sequence[Quantity]) -> Quantity:
    total: Scalar = NUMBER
    for arg in args:
        total = joined(total, all_joined(arg))
    return total


def _product(node: Apply, args: Sequence[Quantity]) -> Quantity:
    a, b = args[0], args[1]
    first, second = node.args[0].type, node.args[1].type
    if isinstance(first, TransformType):
        return all_joined(a) if first.scaled else joined(all_joined(a), all_joined(b))
    if isinstance(a, tuple) or isinstance(b, tuple):
        if isinstance(first, MatrixType) and isinstance(second, VectorType):
            return UNKNOWN if a is UNKNOWN else times(all_joined(a), all_joined(b))
        if isinstance(first, VectorType) and isinstance(second, MatrixType):
            return UNKNOWN if b is UNKNOWN else times(all_joined(a), all_joined(b))
    return _elements(node, a, b, 1)


def _quotient(node: Apply, args: Sequence[Quantity]) -> Quantity:
    return _elements(node, args[0], args[1], -1)


def _by_element(sign: int) -> Rule:
    return lambda node, args: _elements(node, args[0], args[1], sign)


def _elements(node: Apply, a: Quantity, b: Quantity, sign: int) -> Quantity:
    if not isinstance(a, tuple) and not isinstance(b, tuple):
        return times(a, power(b, sign))
    size = size_of(node.type)
    pairs = zip(spread(a, size), spread(b, size), strict=True)
    return packed(tuple(times(x, power(y, sign)) for x, y in pairs))


def _map(change: Callable[[Scalar], Scalar]) -> Rule:
    def rule(node: Apply, args: Sequence[Quantity]) -> Quantity:
        x = args[0]
        return packed(tuple(map(change, x))) if isinstance(x, tuple) else change(x)

    return rule


def _to(exponent: Fraction | int) -> Rule:
    return _map(lambda x: power(x, exponent))


def _need(x: Scalar, index: int, wanted: str, *allowed: Unit) -> None:
    if isinstance(x, Unit) and x not in allowed:
        raise Misfit(index, x, wanted)


def _from(wanted: str, allowed: tuple[Unit, ...], gives: Unit, fixed: bool = False) -> Rule:
    """A function of values in `allowed`; literal numbers stay so unless the result is `fixed`."""

    def rule(node: Apply, args: Sequence[Quantity]) -> Quantity:
        bare = True
        for index, arg in enumerate(args):
            for x in arg if isinstance(arg, tuple) else (arg,):
                _need(x, index, wanted, *allowed)
                bare = bare and x is NUMBER
        return NUMBER if bare and not fixed else gives

    return rule


def _any(gives: Unit) -> Rule:
    return lambda node, args: NUMBER if all(a is NUMBER for a in args) else gives


def _angle_of(node: Apply, args: Sequence[Quantity]) -> Quantity:
    _joined(node, args)
    return RAD


def _power(node: Apply, args: Sequence[Quantity]) -> Quantity:
    base, exponent = all_joined(args[0]), all_joined(args[1])
    _need(exponent, 1, "a pure number", ONE)
    if not isinstance(base, Unit) or base.is_one:
        return base
    value = _constant(node.args[1])
    if value is None:
        raise Misfit(0, base, "a pure number, unless its exponent is a constant")
    return power(base, value) if abs(value) <= MAX_EXPONENT else UNKNOWN


def _constant(node: Typed) -> Fraction | None:
    if not isinstance(node, Literal_):
        try:
            value = evaluate(node)[0]
        except NotConstant:
            return None
    else:
        value = node.value
    return Fraction(value).limit_denominator(1000)


def _inverse(node: Apply, args: Sequence[Quantity]) -> Quantity:
    type_ = node.args[0].type
    if isinstance(type_, TransformType):
        return UNKNOWN if type_.scaled else args[0]
    return power(all_joined(args[0]), -1)


def _rotation_matrix(node: Apply, args: Sequence[Quantity]) -> Quantity:
    if isinstance(node.args[0].type, TransformType):
        return ONE
    return _from(*_ANGLE, ONE)(node, args)


def _rigid(node: Apply, args: Sequence[Quantity]) -> Quantity:
    """The unit of the translation; a homogeneous matrix has none."""
    if len(args) == 1:
        return UNKNOWN
    return all_joined(args[0 if isinstance(node.args[0].type, VectorType) else 1])


def _twist(node: Apply, args: Sequence[Quantity]) -> Quantity:
    parts = (all_joined(args[0]),) * 3 + (RAD,) * 3
    return packed(parts) if size_of(node.type) == 6 else UNKNOWN


def _det(node: Apply, args: Sequence[Quantity]) -> Quantity:
    matrix = node.args[0].type
    return power(all_joined(args[0]), matrix.rows if isinstance(matrix, MatrixType) else 1)


def _dot(node: Apply, args: Sequence[Quantity]) -> Quantity:
    size = size_of(node.args[0].type)
    pairs = zip(spread(args[0], size), spread(args[1], size), strict=True)
    return all_joined(packed(tuple(times(a, b) for a, b in pairs)))


def _cross(node: Apply, args: Sequence[Quantity]) -> Quantity:
    a, b = spread(args[0], 3), spread(args[1], 3)
    around = ((1, 2), (2, 0), (0, 1))
    return packed(tuple(joined(times(a[i], b[j]), times(a[j], b[i])) for i, j in around))


def _norm(node: Apply, args: Sequence[Quantity]) -> Quantity:
    return all_joined(args[0])


def _perp(node: Apply, args: Sequence[Quantity]) -> Quantity:
    return args[0][::-1] if isinstance(args[0], tuple) else args[0]


def _rotated(node: Apply, args: Sequence[Quantity]) -> Quantity:
    return all_joined(args[1])


def _starship(node: Apply, args: Sequence[Quantity]) -> Quantity:
    gamma = all_joined(args[1])
    r = args[0]
    return packed(tuple(joined(x, gamma) for x in (r if isinstance(r, tuple) else (r,))))


_ANGLE = ("an angle", (RAD, ONE))
_PURE = ("a pure number", (ONE,))

# Rules that operations name (`arael.operations`).
OF_OPERATIONS: dict[str, Rule] = {
    "same": _same,
    "sum": _sum,
    "product": _product,
    "quotient": _quotient,
    "comparison": _compare,
    "joined": _joined,
    "count": _any(ONE),
    "angle": _from(*_ANGLE, ONE),
    "angle of": _from(*_PURE, RAD),
    "angle of two": _angle_of,
    "radians": _from(*_ANGLE, RAD, True),
    "to radians": _from("an angle in degrees", (DEG, ONE), RAD, True),
    "to degrees": _from("an angle in radians", (RAD, ONE), DEG, True),
    "pure": _from(*_PURE, ONE),
    "square root": _to(Fraction(1, 2)),
    "cube root": _to(Fraction(1, 3)),
    "power": _power,
    "starship": _starship,
}

RULES: dict[str, Rule] = {
    **{one.name: OF_OPERATIONS[one.units] for one in OPERATIONS.values() if one.units},
    **dict.fromkeys(("transpose", "row", "column", "conj", "vee", "trace"), _same),
    **dict.fromkeys(("gt", "ge", "require"), _compare),
    **dict.fromkeys(("identity2", "identity3"), lambda node, args: NUMBER),
    "emul": _by_element(1),
    "ediv": _by_element(-1),
    "inverse": _inverse,
    "det": _det,
    "dot": _dot,
    "cross": _cross,
    "norm": _norm,
    "norm2": lambda node, args: power(all_joined(args[0]), 2),
    "unit": lambda node, args: (all_joined(args[0]), ONE)[1],
    "perp": _perp,
    "skew": _norm,
    "quat_vec": _same,
    "quat_exp": _from(*_ANGLE, ONE),
    "quat_log": _from(*_PURE, RAD, True),
    "rotation_matrix": _rotation_matrix,
    **dict.fromkeys(("transform", "similarity"), _rigid),
    "translation": _norm,
    "quaternion": _from(*_PURE, ONE),
    "direction_log": _from(*_PURE, RAD, True),
    "rotation": lambda node, args: ONE,
    "tf_log": _twist,
    "euler_angles": _from(*_PURE, RAD, True),
    "rotation_vector": _from(*_PURE, RAD, True),
    "rotate": _rotated,
}

__all__ = ["RULES", "Clash", "Misfit", "result_of"]
