"""What scalars, vectors, matrices and quaternions of expressions have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from arael.check.typed import ValueType

if TYPE_CHECKING:
    from arael.sym.expr import Expr

V = TypeVar("V", bound="Value")


class Value:
    """A value made of scalar expressions.

    Operators are those of the language, with its rules for shapes: ``*`` of two matrices is their
    product, of two quaternions Hamilton's; ``@`` is the same as ``*`` between vectors and matrices,
    and of two vectors their inner product; ``**`` is the power of scalars.
    """

    __slots__ = ()
    __array_ufunc__ = None  # NumPy's numbers and arrays leave operators to us

    @property
    @abstractmethod
    def type(self) -> ValueType:
        """Type of the value, as the language names it."""

    @property
    @abstractmethod
    def entries(self) -> tuple[Expr, ...]:
        """Its scalars: a matrix row by row, a quaternion w, x, y, z."""

    @abstractmethod
    def with_entries(self: V, entries: Iterable[Expr]) -> V:
        """Return a value of the same shape with other scalars."""

    # --- operators --------------------------------------------------------------------------------

    def __add__(self, other: Any) -> Any:
        return _operate("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return _operate("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return _operate("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return _operate("-", other, self)

    def __mul__(self, other: Any) -> Any:
        return _operate("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return _operate("*", other, self)

    def __matmul__(self, other: Any) -> Any:
        return _operate("@", self, other)

    def __rmatmul__(self, other: Any) -> Any:
        return _operate("@", other, self)

    def __truediv__(self, other: Any) -> Any:
        return _operate("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _operate("/", other, self)

    def __pow__(self, other: Any) -> Any:
        return _operate("^", self, other)

    def __rpow__(self, other: Any) -> Any:
        return _operate("^", other, self)

    def __pos__(self: V) -> V:
        return self

    def __neg__(self) -> Any:
        from arael.sym.operations import negative

        return negative(self)

    # --- mathematics ------------------------------------------------------------------------------

    def diff(self: V, by: Expr | str, times: int = 1) -> V:
        """Differentiate by the variable `by`, `times` times.

        Raises
        ------
        AraelError
            E0652 if `by` is no variable.
        """
        from arael.sym.derivatives import diff

        return diff(self, by, times)

    def subs(self: V, values: Mapping[Any, Any] | None = None, /, **named: Expr | float) -> V:
        """Put expressions or numbers in place of variables, all at once.

        `values` maps variables, by name or as symbols, and may map other expressions too.
        """
        from arael.sym.substitution import subs

        return subs(self, values, named)

    def eval(self, values: Mapping[Any, Any] | None = None, /, **named: Any) -> Any:
        """Value at a point: a float, or an array with the shape of a vector or matrix behind.

        Variables may be arrays, which are broadcast against each other: a scalar expression gives
        an array of their common shape, a vector one with its length as the last axis.

        Raises
        ------
        AraelError
            E0650 if a variable has no value.
        """
        from arael.sym.evaluation import evaluate

        return evaluate(self, values, named)

    @property
    def free_vars(self) -> tuple[str, ...]:
        """Names of the variables, in alphabetical order."""
        from arael.sym.expr import free_names

        return free_names(self.entries)

    def expand(self: V) -> V:
        """Multiply out products and whole powers of sums."""
        from arael.sym.algebra import expand

        return expand(self)

    def collect(self: V, *by: Expr | str) -> V:
        """Gather the terms of equal powers of the variables `by`."""
        from arael.sym.algebra import collect

        return collect(self, *by)

    def simplify(self: V) -> V:
        """Find a shorter form that has the same value over the real numbers."""
        from arael.sym.algebra import simplify

        return simplify(self)

    # --- text -------------------------------------------------------------------------------------

    def __str__(self) -> str:
        from arael.sym.printing import text

        return text(self)

    def __repr__(self) -> str:
        return str(self)

    def latex(self) -> str:
        """Write it in LaTeX's mathematics."""
        from arael.sym.printing import latex

        return latex(self)

    def python(self) -> str:
        """Write it as a Python expression over NumPy, imported as ``np``."""
        from arael.sym.printing import python

        return python(self)

    def c(self, real: str = "double") -> str:
        """Write it as a C expression; it may call functions that `c_prelude` defines."""
        from arael.sym.printing import c

        return c(self, real)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


def _operate(operator: str, a: Any, b: Any) -> Any:
    from arael.sym.operations import operate_on_any

    return operate_on_any(operator, a, b)
