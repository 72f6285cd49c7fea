"""Scalar expressions: immutable graphs of operations, written as they were entered."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from arael.check.typed import BOOL, REAL, ScalarType
from arael.runtime.machine.tape import PRIMITIVES
from arael.sym.errors import fail
from arael.sym.value import Value
from arael.symbolic.scalars import SCALARS

if TYPE_CHECKING:
    from arael.sym.evaluation import Program

CONDITIONS = frozenset({"lt", "le", "eq", "ne", "and", "or", "not"})
"""Operations that give a truth value."""

LEAVES = frozenset({"const", "symbol"})

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*")


class Expr(Value):
    """A scalar expression; make one with `symbol`, `parse`, operators and functions.

    Expressions are immutable, may be shared, and are equal (``==``) when they are written alike:
    ``x + 1 == x + 1`` is True, ``x + 1 == 1 + x`` is False. Comparisons by ``<``, ``<=``, ``>`` and
    ``>=`` make conditions, for `where`.

    Attributes
    ----------
    op : ``const``, ``symbol``, an operation of `arael.runtime.machine.tape.PRIMITIVES`, the name
        of a function of the language, or ``call`` of a user's function
    args : operands
    data : value of a constant, name of a symbol, function of a call
    """

    __slots__ = ("_hash", "_program", "args", "data", "op")

    op: str
    args: tuple[Expr, ...]
    data: Any
    _hash: int

    def __init__(self, op: str, args: tuple[Expr, ...] = (), data: Any = None) -> None:
        self.op = op
        self.args = args
        self.data = data
        self._hash = hash((op, data, *(a._hash for a in args)))
        self._program: Program | None = None

    # --- as a value -------------------------------------------------------------------------------

    @property
    def type(self) -> ScalarType:
        """``real``, or ``bool`` of a condition."""
        return BOOL if self.op in CONDITIONS else REAL

    @property
    def entries(self) -> tuple[Expr, ...]:
        """The scalars of this value: itself."""
        return (self,)

    def with_entries(self, entries: Iterable[Expr]) -> Expr:
        """Return the one entry."""
        (entry,) = entries
        return entry

    # --- comparing --------------------------------------------------------------------------------

    def __eq__(self, other: object) -> bool:
        if isinstance(other, (int, float)) and not isinstance(other, bool):
            return self.op == "const" and bool(self.data == other)
        if not isinstance(other, Expr):
            return NotImplemented
        return _alike(self, other)

    def __hash__(self) -> int:
        return self._hash

    def __bool__(self) -> bool:
        if self.op == "const":
            return bool(self.data)
        raise TypeError("an expression has no truth value; use `where(condition, a, b)`")

    def __lt__(self, other: Expr | float) -> Expr:
        return build("lt", self, as_expr(other))

    def __le__(self, other: Expr | float) -> Expr:
        return build("le", self, as_expr(other))

    def __gt__(self, other: Expr | float) -> Expr:
        return build("lt", as_expr(other), self)

    def __ge__(self, other: Expr | float) -> Expr:
        return build("le", as_expr(other), self)

    def __abs__(self) -> Expr:
        return build("abs", self)

    def __float__(self) -> float:
        return float(self.eval())

    @property
    def value(self) -> float | None:
        """The number that a constant is; None of anything else."""
        return self.data if self.op == "const" else None

    @property
    def name(self) -> str:
        """The name of a symbol."""
        if self.op != "symbol":
            raise TypeError(f"`{self}` is no symbol")
        return str(self.data)

    def __reduce__(self) -> Any:
        return rebuild, (flattened(self),)


def _alike(a: Expr, b: Expr) -> bool:
    seen: set[tuple[int, int]] = set()
    stack = [(a, b)]
    while stack:
        x, y = stack.pop()
        if x is y or (id(x), id(y)) in seen:
            continue
        if x._hash != y._hash or x.op != y.op or x.data != y.data or len(x.args) != len(y.args):
            return False
        seen.add((id(x), id(y)))
        stack.extend(zip(x.args, y.args, strict=True))
    return True


# --- making ---------------------------------------------------------------------------------------


def const(value: float) -> Expr:
    """Return the constant `value`; negative zero becomes zero."""
    return Expr("const", (), float(value) + 0.0)


def symbol(name: str) -> Expr:
    """Return the variable called `name`: letters, digits and ``_``, parts joined by dots.

    Raises
    ------
    AraelError
        E0651 if that is no name.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name) or len(name) > 200:
        fail(
            "E0651",
            f"{str(name)[:60]!r} cannot be the name of a variable",
            origin="symbol",
            help=("a name has letters, digits and `_`, and begins with no digit",),
        )
    return Expr("symbol", (), name)


def symbols(names: str | Iterable[str]) -> tuple[Expr, ...]:
    """Return several variables: ``x, y = symbols("x y")``."""
    if isinstance(names, str):
        names = names.replace(",", " ").split()
    return tuple(symbol(name) for name in names)


def as_expr(x: Any) -> Expr:
    """Return `x` as an expression: numbers become constants."""
    if isinstance(x, Expr):
        return x
    if isinstance(x, (Value, str, bytes)):
        raise TypeError(f"expected a scalar expression or a number, found {type(x).__name__}")
    return const(float(x))


def build(op: str, *args: Expr) -> Expr:
    """Make an expression as it was written, but for the arithmetic of constants."""
    from arael.sym.building import build as make

    return make(op, *args)


def arity(op: str) -> int:
    """Number of operands of an operation or function."""
    return PRIMITIVES[op][0] if op in PRIMITIVES else SCALARS[op].arity


# --- walking --------------------------------------------------------------------------------------


def postorder(roots: Iterable[Expr]) -> Iterator[Expr]:
    """Every expression that `roots` are made of, each object once, operands first."""
    done: set[int] = set()
    for root in roots:
        stack: list[tuple[Expr, bool]] = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if ready:
                yield node
            elif id(node) not in done:
                done.add(id(node))
                stack.append((node, True))
                stack.extend((a, False) for a in reversed(node.args) if id(a) not in done)


def free_names(roots: Iterable[Expr]) -> tuple[str, ...]:
    """Names of the variables of `roots`, in alphabetical order."""
    return tuple(sorted({n.data for n in postorder(roots) if n.op == "symbol"}))


def size(roots: Iterable[Expr], bound: int = 10**9) -> int:
    """Operations of `roots` written out in full, nothing shared; not counted beyond `bound`."""
    counts: dict[int, int] = {}
    roots = list(roots)
    for node in postorder(roots):
        inner = sum(counts[id(a)] for a in node.args)
        counts[id(node)] = min(bound, inner + (node.op not in LEAVES))
    return min(bound, sum(counts[id(r)] for r in roots))


Maker = Callable[..., "Expr"]


def rewrite(
    roots: Iterable[Expr], replacement: Mapping[int, Expr], make: Maker | None = None
) -> list[Expr]:
    """Make `roots` again with the objects in `replacement` (by ``id``) exchanged.

    `make` makes operations; by default as they are written.
    """
    roots = list(roots)
    new: dict[int, Expr] = {}
    for node in postorder(roots):
        found = replacement.get(id(node))
        if found is None:
            args = tuple(new[id(a)] for a in node.args)
            same = all(a is b for a, b in zip(args, node.args, strict=True))
            found = node if same else remake(node, args, make)
        new[id(node)] = found
    return [new[id(r)] for r in roots]


def remake(node: Expr, args: tuple[Expr, ...], make: Maker | None = None) -> Expr:
    """Return the operation of `node` on other operands."""
    if node.op == "call":
        return Expr(node.op, args, node.data)
    return (make or build)(node.op, *args)


# --- pickling, without recursion ------------------------------------------------------------------

Row = tuple[str, tuple[int, ...], Any]


def flattened(root: Expr) -> list[Row]:
    """List the nodes of `root`, operands by their number."""
    numbers: dict[int, int] = {}
    rows: list[Row] = []
    for node in postorder([root]):
        numbers[id(node)] = len(rows)
        rows.append((node.op, tuple(numbers[id(a)] for a in node.args), node.data))
    return rows


def rebuild(rows: list[Row]) -> Expr:
    """Undo `flattened`."""
    made: list[Expr] = []
    for op, args, data in rows:
        made.append(Expr(op, tuple(made[i] for i in args), data))
    return made[-1]
