"""From the tree of a formula to a value: names, operators, calls.

This is the language of constraint bodies (`arael.check` types those), read into expressions at
once. A name that means nothing becomes a variable, ``L0.length`` included.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from arael.check.access import QUATERNION_PARTS, VECTOR_PARTS
from arael.check.builtins import CONSTANTS, FUNCTIONS, IDENTITIES, METHODS, ROW_METHODS
from arael.check.suggest import did_you_mean
from arael.check.typed import BOOL, ScalarType, VectorType
from arael.diagnostics.records import AraelError, Diagnostic, Label, Span
from arael.sym import operations
from arael.sym.building import build
from arael.sym.errors import fail
from arael.sym.expr import Expr, const
from arael.sym.limits import MAX_NESTING, MAX_STEPS
from arael.sym.operations import Operand
from arael.sym.shapes import Matrix, Quaternion, Vector, composite
from arael.sym.transforms import Transform, part
from arael.sym.user_functions import Function, FunctionBag, recursion
from arael.sym.value import Value
from arael.syntax import tree

Special = Callable[["Reader", tree.Call], Value]
"""A form that looks at its arguments as they are written, as ``diff(f, x)`` does."""


class Reader:
    """Reads trees into values.

    Attributes
    ----------
    bag : functions of the user
    names : values of names; what is absent is a constant of the language or a variable
    special : forms by name
    """

    def __init__(
        self,
        bag: FunctionBag,
        names: Mapping[str, Value],
        special: Mapping[str, Special] | None = None,
    ) -> None:
        self.bag = bag
        self.names = names
        self.special = special or {}
        self._trail: list[str] = []
        self._steps = 0
        self._nesting = 0
        self._known: dict[tuple[Function, tuple[Value, ...]], Value] = {}

    def value(self, node: tree.Expr) -> Value:
        """Value of `node`."""
        self._steps += 1
        if self._nesting >= MAX_NESTING or self._steps > MAX_STEPS:
            deep = self._nesting >= MAX_NESTING
            raise AraelError(
                Diagnostic(
                    "E0607" if deep else "E0653",
                    "expression is nested too deeply" if deep else "expression is too large",
                    node.span,
                    f"more than {MAX_NESTING} levels, functions included"
                    if deep
                    else f"more than {MAX_STEPS} operations, functions written out",
                )
            )
        self._nesting += 1
        try:
            return _READERS[type(node)](self, node)
        finally:
            self._nesting -= 1

    def operand(self, node: tree.Expr) -> Operand:
        """Value of `node` with its place."""
        return self.value(node), node.span

    def condition(self, node: tree.Expr) -> Expr:
        """Value of `node`, which must be a condition."""
        found = self.value(node)
        if isinstance(found, Expr) and (found.type == BOOL or found.op == "const"):
            return found
        fail(
            "E0307",
            "expected a condition here",
            node.span,
            f"this is {found.type}",
            help=("compare it: `x > 0`",) if isinstance(found.type, ScalarType) else (),
        )

    def within(self, names: Mapping[str, Value], node: tree.Expr) -> Value:
        """Value of `node` where `names` are the only ones."""
        before, self.names = self.names, names
        try:
            return self.value(node)
        finally:
            self.names = before

    def apply(self, function: Function, args: Sequence[Operand], at: Span | None) -> Value:
        """Call a function of the user."""
        values = tuple(value for value, _ in args)
        if len(args) != len(function.parameters):
            n = len(function.parameters)
            fail(
                "E0303",
                f"`{function.name}` takes {n} argument{'' if n == 1 else 's'}, found {len(args)}",
                at,
                "in this call",
                labels=(Label(function.node.name.span, "declared here"),),
                origin="" if at else f"{function.name}()",
            )
        if function.node.derivs is not None:
            return self._kept(function, args, at)
        key = (function, values)
        if key not in self._known:
            if function.name in self._trail:
                raise recursion(self._trail, function.name, function)
            self._known[key] = self._inlined(function, values)
        return self._known[key]

    def _inlined(self, function: Function, values: tuple[Value, ...]) -> Value:
        assert function.node.body is not None
        self._trail.append(function.name)
        bag, special, self.bag, self.special = self.bag, self.special, function.bag, {}
        try:
            called = dict(zip(function.parameters, values, strict=True))
            names: dict[str, Value] = {**function.bag.constants, **called}
            return self.within(names, function.node.body)
        finally:
            self.bag, self.special = bag, special
            self._trail.pop()

    def _kept(self, function: Function, args: Sequence[Operand], at: Span | None) -> Expr:
        """Make a call that stays one, because its derivatives are its own."""
        scalars: list[Expr] = []
        for value, place in args:
            found = operations.number(value, place)
            if not isinstance(found, Expr):
                fail(
                    "E0302",
                    f"`{function.name}` takes scalars, found {found.type}",
                    place or at,
                    origin="" if place or at else f"{function.name}()",
                )
            scalars.append(found)
        return Expr("call", tuple(scalars), function)


# --- names and parts ------------------------------------------------------------------------------


def _number(r: Reader, node: tree.Number) -> Value:
    if node.unit is not None:
        fail(
            "E0320",
            "this formula has no units",
            node.unit.span,
            "units are checked in model files",
            help=(f"write `{node.text}`",),
        )
    return const(node.value)


def _boolean(r: Reader, node: tree.Boolean) -> Value:
    truth = const(float(node.value))
    return build("eq", truth, const(1.0))


def _name(r: Reader, node: tree.Name) -> Value:
    if node.id in r.names:
        return r.names[node.id]
    if node.id in CONSTANTS:
        return build(node.id)
    if node.id in IDENTITIES:
        return operations.call(node.id, [], node.span)
    if node.id in r.bag or node.id in FUNCTIONS:
        fail(
            "E0304",
            f"`{node.id}` is a function",
            node.span,
            "expected a value here",
            help=(f"call it: `{node.id}(...)`",),
        )
    return Expr("symbol", (), node.id)


def _attribute(r: Reader, node: tree.Attribute) -> Value:
    path = _dotted(node)
    if path is not None and path[0] not in r.names:
        return r.names.get(".".join(path), Expr("symbol", (), ".".join(path)))
    owner = r.value(node.obj)
    if isinstance(owner, Quaternion):
        if node.name in QUATERNION_PARTS:
            return owner.entries[QUATERNION_PARTS[node.name]]
        if node.name == "vec":
            return owner.vec
    if isinstance(owner, Transform) and (found := part(owner, node.name)) is not None:
        return found
    at = VECTOR_PARTS.get(node.name)
    if isinstance(owner, Vector) and at is not None:
        if at < len(owner):
            return owner[at]
        has = ", ".join(list(VECTOR_PARTS)[: len(owner)])
        fail("E0305", f"{owner.type} has no `{node.name}`", node.name_span, f"it has {has}")
    help_: tuple[str, ...] = ()
    if node.name in METHODS:
        help_ = (f"`{node.name}` is a method: write `{node.name}()`",)
    elif isinstance(owner, Matrix):
        help_ = ("write `M[row, column]`, `M.row(i)` or `M.col(i)`",)
    fail(
        "E0204",
        f"{owner.type} has no part `{node.name}`",
        node.name_span,
        "unknown part",
        help=help_,
    )


def _dotted(node: tree.Expr) -> list[str] | None:
    parts: list[str] = []
    while isinstance(node, tree.Attribute):
        parts.append(node.name)
        node = node.obj
    return [node.id, *reversed(parts)] if isinstance(node, tree.Name) else None


def _index(r: Reader, node: tree.Index) -> Value:
    owner = r.value(node.obj)
    sizes: tuple[int, ...] = ()
    if isinstance(owner, Vector):
        sizes = (len(owner),)
    elif isinstance(owner, Matrix):
        sizes = owner.shape
    if not sizes:
        fail("E0305", f"{owner.type} cannot be indexed", node.span)
    if len(node.indices) != len(sizes):
        fail(
            "E0305",
            f"{owner.type} takes {len(sizes)} {'index' if len(sizes) == 1 else 'indices'}, "
            f"found {len(node.indices)}",
            node.span,
            help=("write `M[i, :]` for a whole row",) if len(sizes) == 2 else (),
        )
    taken = [
        _range(r, expr, size, str(owner.type))
        for expr, size in zip(node.indices, sizes, strict=True)
    ]
    kept = [isinstance(expr, tree.Slice) for expr in node.indices]
    rows, columns = (taken[0], taken[1]) if len(taken) == 2 else ([0], taken[0])
    table = [[owner.entries[i * sizes[-1] + j] for j in columns] for i in rows]
    if kept == [True, True]:
        return Matrix(table)
    entries = [entry for row in table for entry in row]
    return Vector(entries) if any(kept) else entries[0]


def _range(r: Reader, node: tree.Expr | tree.Slice, size: int, of: str) -> range:
    """Positions that an index or a slice takes."""
    if not isinstance(node, tree.Slice):
        at = _position(r, node, size, of)
        return range(at, at + 1)
    low = 0 if node.low is None else _position(r, node.low, size + 1, of)
    high = size if node.high is None else _position(r, node.high, size + 1, of)
    if low >= high:
        fail("E0305", f"the slice {low}:{high} is empty", node.span, "no elements")
    return range(low, high)


def _position(r: Reader, node: tree.Expr, size: int, of: str) -> int:
    found = r.value(node)
    value = found.value if isinstance(found, Expr) else None
    if value is None or not value.is_integer():
        fail("E0305", "an index is a whole number known in advance", node.span, "not whole")
    if not 0 <= value < size:
        fail(
            "E0305",
            f"index {int(value)} is outside of {of}",
            node.span,
            f"expected 0 to {size - 1}",
        )
    return int(value)


# --- operators ------------------------------------------------------------------------------------


def _unary(r: Reader, node: tree.Unary) -> Value:
    if node.op == "not":
        return operations.logic("not", r.condition(node.operand))
    value = operations.number(r.value(node.operand), node.operand.span)
    return value if node.op == "+" else operations.negative(value, node.span)


def _binary(r: Reader, node: tree.Binary) -> Value:
    """Read a chain ``a + b - c``, which leans to the left, step by step."""
    chain = [node]
    while isinstance(chain[-1].left, tree.Binary):
        chain.append(chain[-1].left)
    first = chain[-1].left
    at = first.span
    left: Value | None = None
    for step in reversed(chain):
        if step.op in ("and", "or"):
            a = r.condition(first) if left is None else _as_condition(left, at)
            left = operations.logic(step.op, a, r.condition(step.right))
        else:
            value = r.value(first) if left is None else left
            left = operations.operate(step.op, (value, at), r.operand(step.right), step.span)
        at = step.span
    assert left is not None
    return left


def _as_condition(value: Value, at: Span) -> Expr:
    if isinstance(value, Expr) and value.type == BOOL:
        return value
    fail("E0307", "expected a condition here", at, f"this is {value.type}")


def _transpose(r: Reader, node: tree.Transpose) -> Value:
    return operations.transposed(r.value(node.operand), node.span)


def _conditional(r: Reader, node: tree.Conditional) -> Value:
    condition = r.condition(node.cond)
    then, otherwise = r.value(node.then), r.value(node.otherwise)
    if then.type != otherwise.type:
        fail(
            "E0306",
            f"the two arms of `if` differ: {then.type} and {otherwise.type}",
            node.span,
            labels=(
                Label(node.then.span, f"this is {then.type}"),
                Label(node.otherwise.span, f"this is {otherwise.type}"),
            ),
        )
    pairs = zip(then.entries, otherwise.entries, strict=True)
    return composite(then.type, tuple(build("select", condition, a, b) for a, b in pairs))


def _list(r: Reader, node: tree.ListExpr) -> Value:
    if node.items and all(isinstance(item, tree.ListExpr) for item in node.items):
        rows = [r.value(item).entries for item in node.items]
        for row, item in zip(rows, node.items, strict=True):
            if len(row) != len(rows[0]):
                fail("E0312", "the rows of a matrix have one length", item.span)
        return Matrix(rows)
    entries: list[Expr] = []
    for item in node.items:
        value = operations.number(r.value(item), item.span)
        if not isinstance(value.type, (ScalarType, VectorType)):
            fail("E0312", f"a list holds scalars and vectors, found {value.type}", item.span)
        entries.extend(value.entries)
    if not entries:
        fail("E0312", "an empty list has no value", node.span, "put numbers in it")
    return Vector(entries)


def _string(r: Reader, node: tree.String) -> Value:
    fail("E0304", "text cannot be computed with", node.span, "this is a string")


def _lambda(r: Reader, node: tree.Lambda) -> Value:
    fail("E0304", "expected a value here", node.span, "`|s| ...` belongs behind `loss`")


# --- calls ----------------------------------------------------------------------------------------


def _call(r: Reader, node: tree.Call) -> Value:
    func = node.func
    if isinstance(func, tree.Attribute):
        return _method(r, node, func)
    if not isinstance(func, tree.Name):
        fail("E0205", "expected the name of a function", func.span, "cannot be called")
    if func.id in r.bag:
        return r.apply(r.bag[func.id], [r.operand(a) for a in node.args], node.span)
    if func.id in r.special:
        return r.special[func.id](r, node)
    if func.id in FUNCTIONS or func.id in IDENTITIES:
        return operations.call(func.id, [r.operand(a) for a in node.args], node.span)
    known = [*r.bag, *r.special, *FUNCTIONS, *IDENTITIES]
    help_ = tuple(did_you_mean(func.id, known))
    if func.id in ROW_METHODS:
        help_ = (f"write `M.{func.id}(i)`",)
    elif func.id in r.names:
        help_ = (f"`{func.id}` is a value; write `{func.id} * (...)` to multiply",)
    fail("E0205", f"unknown function `{func.id}`", func.span, "not found", help=help_)


def _method(r: Reader, node: tree.Call, func: tree.Attribute) -> Value:
    if func.name not in METHODS:
        fail(
            "E0205",
            f"a value has no method `{func.name}`",
            func.name_span,
            "unknown method",
            help=tuple(did_you_mean(func.name, sorted(METHODS))),
        )
    owner = r.operand(func.obj)
    if func.name not in ROW_METHODS:
        return operations.call(func.name, [owner, *map(r.operand, node.args)], node.span)
    matrix = owner[0]
    if not isinstance(matrix, Matrix):
        fail("E0302", f"`{func.name}` is of a matrix, found {matrix.type}", func.obj.span)
    if len(node.args) != 1:
        fail("E0303", f"`{func.name}` takes 1 argument, found {len(node.args)}", node.span)
    by_row = func.name == "row"
    at = _position(r, node.args[0], matrix.shape[not by_row], str(matrix.type))
    return matrix.row(at) if by_row else matrix.col(at)


_READERS: dict[type, Callable[..., Value]] = {
    tree.Number: _number,
    tree.Boolean: _boolean,
    tree.String: _string,
    tree.Name: _name,
    tree.Attribute: _attribute,
    tree.Index: _index,
    tree.Call: _call,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.Transpose: _transpose,
    tree.Conditional: _conditional,
    tree.ListExpr: _list,
    tree.Lambda: _lambda,
}
