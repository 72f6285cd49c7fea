"""SymPy's values with the types of the language: scalars, vectors, matrices, quaternions.

A vector is a column (`ImmutableMatrix`), a quaternion SymPy's `Quaternion`, a condition a SymPy
`Boolean`. SymPy has no rigid transforms: they are a `Transform`, a tuple.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import sympy as sp
from sympy.logic.boolalg import Boolean

from arael.check.typed import (
    BOOL,
    QUATERNION,
    REAL,
    MatrixType,
    QuaternionType,
    TransformType,
    ValueType,
    VectorType,
)
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError
from arael.sym.errors import fail
from arael.sym.functions import number
from arael.sym.limits import MAX_SCALARS

Value = Any
"""A SymPy expression, condition, matrix or quaternion, or a `Transform`."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*")


class Transform(NamedTuple):
    """``x -> s R x + t``: rigid, or a similarity if it has a scale.

    Compute with it in text: ``parse("A.inverse() * B", names={"A": a, "B": b})``.

    Attributes
    ----------
    translation : t, a column of three
    rotation : R as a unit quaternion
    scale : s; None of a rigid transform
    """

    translation: Any
    rotation: Any
    scale: Any = None


def symbol(name: str) -> Any:
    """Return the variable called `name`: letters, digits and ``_``, parts joined by dots.

    Raises
    ------
    AraelError
        E0651 if that is no name.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name) or len(name) > 200:
        help_ = ("a name has letters, digits and `_`, and begins with no digit",)
        message = f"{str(name)[:60]!r} cannot be the name of a variable"
        fail("E0651", message, origin="symbol", help=help_)
    return sp.Symbol(name)


def symbols(names: str | Iterable[str]) -> tuple[Any, ...]:
    """Return several variables: ``x, y = symbols("x y")``."""
    if isinstance(names, str):
        names = names.replace(",", " ").split()
    elif not isinstance(names, Iterable):
        raise wrong_argument("symbols", "names", "a text or a list of names", names)
    return tuple(symbol(name) for name in names)


def vector(name: str, n: int) -> Any:
    """Return the column of the variables ``name.x name.y name.z``, or ``name._0`` ... if n > 3.

    Raises
    ------
    AraelError
        E0652 if n is not a whole number from 1 to 4096.
    """
    if not isinstance(n, int) or not 1 <= n <= MAX_SCALARS:
        message = f"expected a length from 1 to {MAX_SCALARS}, found {n!r:.40}"
        fail("E0652", message, origin="vector", help=('write for example `vector("p", 3)`',))
    parts = "xyz"[:n] if n <= 3 else [f"_{i}" for i in range(n)]
    return composite(VectorType(n), [symbol(f"{name}.{part}") for part in parts])


def listed_variables(by: Any, function: str) -> list[Any]:
    """Variables or their names in a list; one alone is a list of one.

    Raises
    ------
    AraelError
        E0828 for what is no list of them.
    """
    if isinstance(by, (str, sp.Symbol)):
        return [by]
    found = list(by) if isinstance(by, Iterable) and not isinstance(by, (bytes, sp.Basic)) else None
    if found is None or not all(isinstance(one, (str, sp.Symbol)) for one in found):
        raise wrong_argument(
            function, "by", "a list of variables or of their names", by, 'write `["x", "y"]`'
        )
    return found


def by_variable(values: Any, named: Mapping[str, Any], function: str) -> dict[Any, Any]:
    """What was given by variable, in a mapping and by keyword.

    Raises
    ------
    AraelError
        E0828 for what is no mapping of variables or their names.
    """
    if values is not None and not (
        isinstance(values, Mapping) and all(isinstance(k, (str, sp.Basic)) for k in values)
    ):
        raise wrong_argument(
            function, "values", "a mapping by variable", values, 'write `{"x": 1.0}`, or `x=1.0`'
        )
    return {**(values or {}), **named}


def free_vars(value: Value) -> tuple[str, ...]:
    """Names of the variables of a value, in alphabetical order."""
    value = as_value(value)
    found = (node for node in postorder(entries(value)) if node.is_Symbol)
    return tuple(sorted({node.name for node in found}))


def type_of(value: Value) -> ValueType:
    """Type of a value, as the language names it."""
    if isinstance(value, Boolean) and not value.is_Symbol:
        return BOOL
    if isinstance(value, sp.Quaternion):
        return QUATERNION
    if isinstance(value, Transform):
        return TransformType(scaled=value.scale is not None)
    if isinstance(value, sp.MatrixBase):
        rows, columns = value.shape
        return VectorType(rows) if columns == 1 else MatrixType(rows, columns)
    return REAL


def entries(value: Value) -> tuple[Any, ...]:
    """Scalars of a value: a matrix row by row, a quaternion w, x, y, z."""
    if isinstance(value, sp.MatrixBase):
        return tuple(value)
    if isinstance(value, sp.Quaternion):
        return tuple(value.args)
    if isinstance(value, Transform):
        scale = () if value.scale is None else (value.scale,)
        return (*value.translation, *value.rotation.args, *scale)
    return (value,)


def composite(type_: ValueType, scalars: Sequence[Any]) -> Value:
    """Return a value of type `type_`; a scalar as itself."""
    if len(scalars) > MAX_SCALARS:
        help_ = (f"at most {MAX_SCALARS} are allowed",)
        fail("E0653", f"{len(scalars)} scalars in one value", origin="expression", help=help_)
    if isinstance(type_, VectorType):
        return sp.ImmutableMatrix(scalars)
    if isinstance(type_, MatrixType):
        return sp.ImmutableMatrix(type_.rows, type_.columns, list(scalars))
    if isinstance(type_, QuaternionType):
        return sp.Quaternion(*scalars)
    if isinstance(type_, TransformType):
        translation = composite(VectorType(3), scalars[:3])
        return Transform(translation, sp.Quaternion(*scalars[3:7]), *scalars[7:])
    (scalar,) = scalars
    return scalar


def with_entries(value: Value, scalars: Iterable[Any]) -> Value:
    """Return a value of the same type with other scalars."""
    return composite(type_of(value), list(scalars))


def as_value(x: Any) -> Value:
    """Return what a caller gave as a value: numbers, lists and arrays become SymPy's.

    Raises
    ------
    AraelError
        E0828 for what is no value: text, None, a list with rows of different lengths.
    """
    if isinstance(x, Transform):
        return _checked(x)
    if isinstance(x, sp.MatrixBase):
        return sp.ImmutableMatrix(x)
    if isinstance(x, (sp.Expr, Boolean)) and not isinstance(x, sp.MatrixExpr):
        return x
    if hasattr(x, "ndim") and hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, (list, tuple)):
        table = x if x and isinstance(x[0], (list, tuple)) else [[item] for item in x]
        if not table or not table[0] or len({len(row) for row in table}) != 1:
            raise _no_value(x, "a matrix needs rows of one length, one at least")
        scalars = [as_value(item) for row in table for item in row]
        for scalar in scalars:
            if type_of(scalar) not in (REAL, BOOL):
                raise _no_value(x, f"entries are scalars, one is {type_of(scalar)}")
        return composite(MatrixType(len(table), len(table[0])), scalars)
    if isinstance(x, (str, bytes)):
        raise _no_value(x, "`parse` reads formulas, `symbol` names variables")
    try:
        return number(float(x))
    except (TypeError, ValueError, OverflowError):
        raise _no_value(x) from None


def _no_value(x: Any, help: str = "") -> AraelError:
    return wrong_argument("arael.sym", "value", "an expression, number, list or array", x, help)


def _checked(x: Transform) -> Transform:
    """Return a transform whose parts are values of their types; one by hand may have others."""
    translation = as_value(x.translation)
    scale = None if x.scale is None else as_value(x.scale)
    if (
        type_of(translation) == VectorType(3)
        and isinstance(x.rotation, sp.Quaternion)
        and (scale is None or type_of(scale) == REAL)
    ):
        return Transform(translation, x.rotation, scale)
    raise _no_value(x, "a transform has a vector of three, a quaternion, and a scalar or None")


def postorder(roots: Iterable[Any]) -> Iterator[Any]:
    """Every expression that `roots` are made of, once, operands first.

    SymPy's own traversals visit a shared part as often as it occurs.
    """
    done: set[Any] = set()
    for root in roots:
        stack: list[tuple[Any, bool]] = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if ready:
                yield node
            elif node not in done:
                done.add(node)
                stack.append((node, True))
                stack.extend((a, False) for a in reversed(node.args) if a not in done)


def size(roots: Iterable[Any]) -> int:
    """Operations of `roots` written out in full, nothing shared."""
    counts: dict[Any, int] = {}
    roots = list(roots)
    for node in postorder(roots):
        inner = sum(counts[a] for a in node.args)
        joins = max(1, len(node.args) - 1) if node.args and not node.is_number else 0
        counts[node] = inner + joins
    return sum(counts[root] for root in roots)


def require_size(roots: Iterable[Any], most: int, what: str, *help_: str) -> None:
    """Raise E0653 if `roots`, written out, have more than `most` operations."""
    if size(roots) > most:
        fail("E0653", f"{what} has more than {most} operations", origin="expression", help=help_)
