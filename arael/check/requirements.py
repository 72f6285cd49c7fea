"""Rule: a `require` compares two values of one shape and one unit.

Allowed: ``E == F``, ``E >= F``, ``E <= F`` of numbers or vectors, by component; a chain
``A <= E <= B``; a comparison of data alone, which is checked before a solve.

Not allowed: anything but a comparison; ``!=`` and strict comparisons, whose limit would not be
included; values of different shapes; a comparison that never holds; a guard over parameters, since
what must hold would change during a solve.

What holds becomes rows: ``E - F``, which are zero, or not negative.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from arael.check.arithmetic import NotConstant, evaluate
from arael.check.binding import Broken
from arael.check.builtins import is_number
from arael.check.guards import moves
from arael.check.typed import Apply, LookUp, Read, Typed, VectorType
from arael.check.types import size_of
from arael.check.typist import Typist
from arael.check.units import Unit
from arael.check.walk import postorder
from arael.diagnostics.records import Label
from arael.syntax import tree

Sense = Literal["equal", "at_least"]

_ONE_SIDED = {"<=": -1, ">=": 1}
_STRICT = {"<": "<=", ">": ">="}
_NEVER_NEGATIVE = frozenset({"norm", "norm2", "abs", "sqrt", "exp", "hypot", "cosh"})


@dataclass(frozen=True)
class Requirement:
    """Rows that hold: of each, the unit in which it is measured ("" if unknown or none)."""

    sense: Sense
    rows: tuple[Typed, ...]
    units: tuple[str, ...]


def is_requirement(node: tree.Expr) -> bool:
    """Whether a formula given at run time states what holds: a comparison with its limit."""
    return isinstance(node, tree.Chain) or (
        isinstance(node, tree.Binary) and node.op in ("==", *_ONE_SIDED)
    )


def requirement_of(t: Typist, comparison: tree.Expr) -> Requirement | None:
    """The rows of a comparison; None after an error."""
    if isinstance(comparison, tree.Chain):
        return _chained(t, comparison)
    if not isinstance(comparison, tree.Binary) or comparison.op not in ("==", *_ONE_SIDED):
        _no_comparison(t, comparison)
        return None
    left, right = t.value(comparison.left), t.value(comparison.right)
    if isinstance(left, Broken) or isinstance(right, Broken):
        return None
    row = _difference(t, comparison, comparison.op, left, right)
    if row is None or _never(t, comparison, row, comparison.op == "=="):
        return None
    sense: Sense = "equal" if comparison.op == "==" else "at_least"
    return Requirement(sense, (row,), _units(t, row, left, right))


def check_guard(t: Typist, node: tree.Require, guard: Typed | None) -> bool:
    """Whether the guard of a `require` is over data alone."""
    if guard is None or not moves(guard):
        return True
    assert node.guard is not None
    read = next(
        n
        for n in postorder([guard])
        if isinstance(n, LookUp) or (isinstance(n, Read) and n.version in ("trial", "computed"))
    )
    t.fail(
        "E0682",
        node.guard.span,
        "the guard of a `require` is over data",
        label="looks rows up" if isinstance(read, LookUp) else "reads a parameter",
        labels=t.origin(read),
        notes=["what must hold would change during a solve"],
        help=["write what must hold in both cases as one inequality, with `if`, `min` or `max`"],
    )
    return False


def _chained(t: Typist, chain: tree.Chain) -> Requirement | None:
    for op in (chain.first, chain.second):
        if op in _STRICT:
            _strict(t, chain, op)
            return None
    if chain.first != chain.second:
        t.fail(
            "E0680",
            chain.span,
            f"a chain has one direction, found `{chain.first}` and `{chain.second}`",
            label="in this chain",
            help=["write `low <= value <= high`"],
        )
        return None
    values = [t.value(part) for part in (chain.low, chain.middle, chain.high)]
    good = [value for value in values if isinstance(value, Typed)]
    if len(good) < len(values):
        return None
    rows: list[Typed] = []
    units: list[str] = []
    for left, right in ((good[0], good[1]), (good[1], good[2])):
        row = _difference(t, chain, chain.first, left, right)
        if row is None or _never(t, chain, row, False):
            return None
        rows.append(row)
        units += _units(t, row, left, right)
    low, high = (good[0], good[2]) if chain.first == "<=" else (good[2], good[0])
    ends = _constant(low), _constant(high)
    if ends[0] and ends[1] and any(a > b for a, b in zip(*ends, strict=True)):
        _cannot(t, chain, "the lower limit is above the upper one")
        return None
    return Requirement("at_least", tuple(rows), tuple(units))


def _difference(
    t: Typist, node: tree.Binary | tree.Chain, op: str, left: Typed, right: Typed
) -> Typed | None:
    """``left - right`` for ``==`` and ``>=``, ``right - left`` for ``<=``."""
    fits = left.type == right.type or (is_number(left.type) and is_number(right.type))
    if not fits or not (is_number(left.type) or isinstance(left.type, VectorType)):
        both = "two matrices, rotations or transforms" if fits else ""
        t.fail(
            "E0681",
            node.span,
            f"`{left.type} {op} {right.type}` cannot be required"
            if fits
            else f"the sides of `{op}` differ in shape: {left.type} and {right.type}",
            labels=[
                Label(left.span, f"this is {left.type}"),
                Label(right.span, f"this is {right.type}"),
                *t.origin(left),
                *t.origin(right),
            ],
            help=["compare vectors: `rotation_vector(A' * B) == [0, 0, 0]`"]
            if both
            else ["write both sides with the same number of components"],
        )
        return None
    if op == "<=":
        left, right = right, left
    row = Apply(type=left.type, span=node.span, name="require", args=(left, right))
    found = t.make(row, size_of(left.type))
    if isinstance(found, Broken):
        return None
    return Apply(type=left.type, span=node.span, name="sub", args=(left, right))


def _units(t: Typist, row: Typed, left: Typed, right: Typed) -> tuple[str, ...]:
    """The unit of each scalar of a row."""
    size = size_of(row.type)
    for side in (left, right):
        found = t.units.of(side)
        each = found if isinstance(found, tuple) else (found,) * size
        texts = tuple(str(u) if isinstance(u, Unit) and not u.is_one else "" for u in each)
        if len(texts) == size and any(texts):
            return texts
    return ("",) * size


def _constant(value: Typed) -> tuple[float, ...]:
    try:
        return evaluate(value)
    except NotConstant:
        return ()


def _never(t: Typist, node: tree.Binary | tree.Chain, row: Typed, equal: bool) -> bool:
    """Whether a row never holds, which is reported."""
    values = _constant(row)
    if values and any(value != 0 if equal else value < 0 for value in values):
        _cannot(t, node, "this is false")
        return True
    if values or not is_number(row.type):
        return False
    assert isinstance(row, Apply)
    least, most = _range(row)
    if most < 0 or (equal and least > 0):
        _cannot(t, node, "the two sides are apart for all values")
        return True
    return False


def _range(value: Typed) -> tuple[float, float]:
    """Bounds of a number, from the functions it consists of."""
    known = _constant(value)
    if known:
        return known[0], known[0]
    open_ = -math.inf, math.inf
    if not isinstance(value, Apply):
        return open_
    if value.name in _NEVER_NEGATIVE:
        return 0.0, math.inf
    if value.name in ("sin", "cos", "tanh"):
        return -1.0, 1.0
    if value.name == "pow":
        power = _constant(value.args[1])
        return (0.0, math.inf) if power and power[0] % 2 == 0 else open_
    if value.name in ("add", "sub", "neg"):
        ends = [_range(arg) for arg in value.args]
        if value.name == "neg":
            return -ends[0][1], -ends[0][0]
        (a, b), (c, d) = ends
        return (a + c, b + d) if value.name == "add" else (a - d, b - c)
    return open_


def _cannot(t: Typist, node: tree.Expr, why: str) -> None:
    t.fail("E0683", node.span, "this can never hold", label=why)


def _no_comparison(t: Typist, node: tree.Expr) -> None:
    if isinstance(node, tree.Binary) and node.op in _STRICT:
        _strict(t, node, node.op)
        return
    if isinstance(node, tree.Binary) and node.op == "and":
        t.fail(
            "E0680",
            node.span,
            "a `require` has one comparison",
            label="two are joined here",
            help=["write a `require` for each, or a chain `low <= value <= high`"],
        )
        return
    unequal = isinstance(node, tree.Binary) and node.op == "!="
    t.fail(
        "E0680",
        node.span,
        "`!=` cannot be required" if unequal else "a `require` states a comparison",
        label="excludes single values only" if unequal else "nothing is compared",
        help=["write what must hold: `norm(a - b) == 1`, `x >= 0`, `low <= x <= high`"],
    )


def _strict(t: Typist, node: tree.Expr, op: str) -> None:
    t.fail(
        "E0680",
        node.span,
        f"`{op}` cannot be required, because its limit is not included",
        label="a strict comparison",
        help=[f"write `{_STRICT[op]}`; keep a distance from the limit by a number: `x >= 1e-6`"],
    )
