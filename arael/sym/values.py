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
from arael.diagnostics.arguments import as_list, as_mapping, fail, require
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
    listed = names.replace(",", " ").split() if isinstance(names, str) else names
    return tuple(map(symbol, as_list(listed, str, "symbols", "names", "a text or a list of names")))


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


def variables(value: Value, by: Any, function: str) -> list[Any]:
    """Return the variables `by`, or their names; None: those of `value`, in alphabetical order."""
    if by is None:
        return list(free_vars(value))
    expected, help_ = "a list of variables or of their names", 'write `["x", "y"]`'
    return as_list(by, (str, sp.Symbol), function, "by", expected, help_)


def by_variable(values: Any, named: Mapping[str, Any], function: str) -> dict[Any, Any]:
    """Return what was given by variable, in a mapping and by keyword."""
    expected, help_ = "a mapping by variable", 'write `{"x": 1.0}`, or `x=1.0`'
    return {**as_mapping(values, (str, sp.Basic), function, "values", expected, help_), **named}


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
        return _transform(x)
    if isinstance(x, sp.MatrixBase):
        return sp.ImmutableMatrix(x)
    if isinstance(x, (sp.Expr, Boolean)) and not isinstance(x, sp.MatrixExpr):
        return x
    if hasattr(x, "ndim") and hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, (list, tuple)):
        table = x if x and isinstance(x[0], (list, tuple)) else [[item] for item in x]
        lengths = {len(row) for row in table}
        _require(len(lengths) == 1 and 0 not in lengths, x, "rows have one length, one at least")
        scalars = [as_value(item) for row in table for item in row]
        for one in map(type_of, scalars):
            _require(one in (REAL, BOOL), x, f"entries are scalars, one is {one}")
        return composite(MatrixType(len(table), len(table[0])), scalars)
    help_ = "`parse` reads formulas, `symbol` names variables"
    _require(not isinstance(x, (str, bytes)), x, help_)
    try:
        return number(float(x))
    except (TypeError, ValueError, OverflowError):
        _require(False, x)


def _require(ok: bool, x: Any, help: str = "") -> None:
    require(ok, "arael.sym", "value", "an expression, number, list or array", x, help)


def _transform(x: Transform) -> Transform:
    """Return a transform whose parts are values of their types; one by hand may have others."""
    made = Transform(*(None if part is None else as_value(part) for part in x))
    found = (*map(type_of, made[:2]), REAL if made.scale is None else type_of(made.scale))
    help_ = "a transform has a vector of three, a quaternion, and a scalar or None"
    _require(found == (VectorType(3), QUATERNION, REAL), x, help_)
    return made


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


def require_size(operations: int, most: int, what: str, *help_: str) -> None:
    """Raise E0653 if there are more than `most` operations."""
    if operations > most:
        fail("E0653", f"{what} has more than {most} operations", origin="expression", help=help_)
