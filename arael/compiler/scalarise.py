"""From typed expressions to scalars of a graph.

Every value becomes a flat list of nodes: a vector its components, a matrix row by row, a quaternion
w, x, y, z, a transform its translation, its quaternion and its scale. Reads become inputs of the
graph, keyed by what they read:

- `StateInput`: a scalar of the state of a used entity,
- `RawInput`: data, the stored value of a parameter, or (``path?``) whether an optional is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, Protocol

from arael.check.typed import (
    Apply,
    Component,
    Formal,
    Formula,
    Invoke,
    Literal_,
    LookUp,
    MatrixType,
    Pack,
    Present,
    QuaternionType,
    Read,
    ScalarType,
    Select,
    Total,
    TransformType,
    Typed,
    ValueType,
    VectorType,
)
from arael.check.walk import operands
from arael.compiler.rigid import Transforms
from arael.diagnostics.records import Span
from arael.manifolds import inverse, linear, quaternion, rigid, rotation, sphere
from arael.runtime.layout import Place
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.scalars import SCALARS

Nodes = list[int]


class StateInput(NamedTuple):
    """A scalar of the state of an entity: number of its use, offset in the state."""

    use: int
    offset: int


class RawInput(NamedTuple):
    """A scalar of a column reached through a slot."""

    slot: int
    column: str
    component: int


class Uses(Protocol):
    """Where trial values come from: the state of entities."""

    def stored(self, slot: int, column: str) -> Sequence[tuple[int, int]]:
        """(use, offset) of the stored scalars of a parameter."""
        ...

    def cached(self, slot: int, column: str, cache: str) -> Sequence[tuple[int, int]]:
        """(use, offset) of the scalars of one of its caches."""
        ...

    def formula(self, slot: int, column: str) -> Sequence[tuple[int, int]] | None:
        """(use, offset) of the scalars of a formula of a component; None if they are not kept."""
        ...


def width(type_: ValueType) -> int:
    """Count the scalars of a value."""
    if isinstance(type_, VectorType):
        return type_.n
    if isinstance(type_, MatrixType):
        return type_.rows * type_.columns
    if isinstance(type_, TransformType):
        return 8 if type_.scaled else 7
    return 4 if isinstance(type_, QuaternionType) else 1


class Calls(Protocol):
    """Functions with prescribed derivatives, by name."""

    def __getitem__(self, name: str) -> Prescribed:
        """Return the function of that name."""
        ...


class Totals(Protocol):
    """Where sums over collections come from."""

    def of(self, total: Total, terms: Nodes) -> Nodes:
        """Scalars of a sum, from those of its term."""
        ...


class LookUps(Protocol):
    """Where the values of look-ups come from."""

    def of(self, e: LookUp, argument: int, rows: Sequence[Nodes]) -> Nodes:
        """Scalars of a look-up, from the node of its argument and the scalars of its rows."""
        ...


class Scalariser:
    """Scalarises expressions of one constraint into one graph.

    Parameters
    ----------
    factored : whether a product of matrices that is applied to a vector is applied factor by
        factor, ``A (B v)`` for ``(A B) v``

    Attributes
    ----------
    chains : number of products that were applied factor by factor
    """

    def __init__(self, graph: Graph, uses: Uses, functions: Calls, factored: bool = False) -> None:
        self.graph = graph
        self.factored = factored
        self.chains = 0
        self.uses = uses
        self.functions = functions
        # Of a constraint; formulas of entities have none.
        self.totals: Totals | None = None
        self.look_ups: LookUps | None = None
        self.places: list[Place] = []
        self._done: dict[Typed, Nodes] = {}
        self._place_of: dict[tuple[str, str], int] = {}
        self._transforms = Transforms(graph, self.nodes, lambda read: self._state(read, "R"))

    def nodes(self, expression: Typed) -> Nodes:
        """Scalars of `expression`; the same list for the same expression."""
        done = self._done
        # With an explicit stack, because sums may have thousands of terms, each nested in the next.
        waiting = [expression]
        while waiting:
            e = waiting[-1]
            missing = [] if e in done else [o for o in self._needs(e) if o not in done]
            if missing:
                waiting += reversed(missing)
                continue
            waiting.pop()
            if e not in done:
                done[e] = self._scalarise(e)
        return done[expression]

    def _needs(self, e: Typed) -> tuple[Typed, ...]:
        """Operands whose scalars `e` is computed from, in the order of computation."""
        if isinstance(e, Formula):
            return () if self.uses.formula(e.slot, e.column) is not None else (e.of,)
        if not isinstance(e, Apply):
            return operands(e)
        if self._cached(e) is not None:
            return ()
        if e.args and isinstance(e.args[0].type, TransformType):
            return self._transforms.needs(e)
        if self.factored and is_applied(e):
            matrix, vector = e.args if isinstance(e.args[1].type, VectorType) else e.args[::-1]
            return (vector, *(factor for factor, _ in factors(matrix)))
        return e.args

    def assume(self, expression: Typed, nodes: Nodes) -> None:
        """Let `expression` have these scalars."""
        self._done[expression] = nodes

    @contextmanager
    def at(self, span: Span) -> Iterator[None]:
        """Let nodes made within remember the expression at `span`."""
        with _at(self.graph, self._place(span)):
            yield

    def _scalarise(self, e: Typed) -> Nodes:
        g = self.graph
        if isinstance(e, Literal_):
            return [g.const(e.value)]
        if isinstance(e, Read):
            return self._read(e)
        if isinstance(e, Present):
            return [g.input(RawInput(e.slot, f"{e.column}?", 0))]
        if isinstance(e, Component):
            return [self.nodes(e.of)[e.index]]
        if isinstance(e, Formula):
            return self._formula(e)
        if isinstance(e, Pack):
            return [n for item in e.items for n in self.nodes(item)]
        if isinstance(e, Select):
            cond = self.nodes(e.cond)[0]
            arms = zip(self.nodes(e.then), self.nodes(e.otherwise), strict=True)
            with _at(g, self._place(e.span)):
                return [g.op("select", cond, a, b) for a, b in arms]
        if isinstance(e, Total):
            assert self.totals is not None
            with _at(g, self._place(e.span)):
                return self.totals.of(e, self.nodes(e.of))
        if isinstance(e, LookUp):
            assert self.look_ups is not None
            with _at(g, self._place(e.span)):
                return self.look_ups.of(e, self.nodes(e.of)[0], [self.nodes(r) for r in e.rows])
        if isinstance(e, Invoke):
            arguments = [self.nodes(a)[0] for a in e.args]
            value = None if e.value is None else self.nodes(e.value)[0]
            with _at(g, self._place(e.span)):
                return [g.call(self.functions[e.function], arguments, value)]
        assert isinstance(e, Apply), type(e)
        cached = self._cached(e)
        if cached is not None:
            return cached
        if e.args and isinstance(e.args[0].type, TransformType):
            with _at(g, self._place(e.span)):
                return self._transforms.apply(e)
        if self.factored and is_applied(e):
            with _at(g, self._place(e.span)):
                return self._factor_by_factor(e)
        args = [self.nodes(a) for a in e.args]
        with _at(g, self._place(e.span)):
            return apply(g, e.name, [a.type for a in e.args], args)

    def _factor_by_factor(self, e: Apply) -> Nodes:
        """Apply the factors of a product to a vector, the nearest first."""
        left, right = e.args
        behind = isinstance(right.type, VectorType)  # otherwise v' M, which is M' v
        chain = factors(left) if behind else factors(right, transposed=True)
        result = self.nodes(right if behind else left)
        for factor, transposed in reversed(chain):
            grid = _grid(factor.type, self.nodes(factor))
            result = linear.matvec(
                self.graph, linear.transpose(grid) if transposed else grid, result
            )
        self.chains += 1
        return list(result)

    def _read(self, e: Read) -> Nodes:
        if e.version in ("trial", "computed"):
            offsets = self.uses.stored(e.slot, e.column)
            return [self.graph.input(StateInput(use, offset)) for use, offset in offsets]
        return [self.graph.input(RawInput(e.slot, e.column, k)) for k in range(width(e.type))]

    def _formula(self, e: Formula) -> Nodes:
        node = self.uses.formula(e.slot, e.column)
        if node is None:
            return self.nodes(e.of)
        return [self.graph.input(StateInput(use, offset)) for use, offset in node]

    def _cached(self, e: Apply) -> Nodes | None:
        """Find what the state of an entity holds: its rotation matrix, sines and cosines."""
        if len(e.args) != 1:
            return None
        (arg,) = e.args
        component = 0
        if e.name in ("sin", "cos"):
            if isinstance(arg, Component):
                component, arg = arg.index, arg.of
            if not (isinstance(arg, Read) and arg.parameter in ("euler", "angle")):
                return None
            cache = e.name
        elif e.name == "rotation_matrix":
            cache = "R"
        else:
            return None
        if not (isinstance(arg, Read) and arg.version == "trial" and arg.parameter):
            return None
        if arg.parameter not in ("euler", "angle", "rotation", "quaternion"):
            return None
        if cache == "R":
            return self._state(arg, cache)
        if not isinstance(e.args[0].type, ScalarType):
            return None
        return [self._state(arg, cache)[component]]

    def _state(self, read: Read, cache: str) -> Nodes:
        """Scalars of a cache of the parameter that `read` reads."""
        node = self.uses.cached(read.slot, read.column, cache)
        return [self.graph.input(StateInput(use, offset)) for use, offset in node]

    def _place(self, span: Span) -> int | None:
        key = (str(span), span.text)
        if key not in self._place_of:
            self._place_of[key] = len(self.places)
            self.places.append(Place(where=key[0], text=" ".join(key[1].split())[:200]))
        return self._place_of[key]


def is_applied(e: Apply) -> bool:
    """Whether `e` applies a product of matrices, or its transpose, to a vector."""
    if e.name != "mul":
        return False
    left, right = (a.type for a in e.args)
    if isinstance(left, MatrixType) and isinstance(right, VectorType):
        return len(factors(e.args[0])) > 1
    if isinstance(left, VectorType) and isinstance(right, MatrixType):
        return len(factors(e.args[1])) > 1
    return False


def factors(e: Typed, transposed: bool = False) -> list[tuple[Typed, bool]]:
    """Factors of a product of matrices from the left, and whether each is to be transposed."""
    factor_list: list[tuple[Typed, bool]] = []
    waiting = [(e, transposed)]
    while waiting:
        factor, turned = waiting.pop()
        if isinstance(factor, Apply) and factor.name == "transpose":
            waiting.append((factor.args[0], not turned))
        elif (
            isinstance(factor, Apply)
            and factor.name == "mul"
            and all(isinstance(a.type, MatrixType) for a in factor.args)
        ):
            left, right = factor.args
            # The last one is looked at first: (A B)' = B' A'.
            waiting += [(left, True), (right, True)] if turned else [(right, False), (left, False)]
        else:
            factor_list.append((factor, turned))
    return factor_list


class NoUses:
    """The entities of what reads none: of a function, of a row by itself."""

    def stored(self, slot: int, column: str) -> Sequence[tuple[int, int]]:
        """No entity has anything to read."""
        raise AssertionError(f"there is no entity to read {column} of")

    def cached(self, slot: int, column: str, cache: str) -> Sequence[tuple[int, int]]:
        """No entity has anything to read."""
        raise AssertionError(f"there is no entity to read {column} of")

    def formula(self, slot: int, column: str) -> None:
        """No formula is kept."""
        return None


class FormulaScalariser(Scalariser):
    """Scalarises formulas of a function for given arguments.

    What it makes belongs to the place that is current, that of the call.
    """

    def __init__(self, graph: Graph, arguments: Sequence[int], functions: Calls) -> None:
        super().__init__(graph, NoUses(), functions)
        self.arguments = arguments

    def _scalarise(self, e: Typed) -> Nodes:
        return [self.arguments[e.index]] if isinstance(e, Formal) else super()._scalarise(e)

    def _place(self, span: Span) -> int | None:
        return self.graph.place


@contextmanager
def _at(graph: Graph, place: int | None) -> Iterator[None]:
    """Let new nodes remember `place`."""
    saved, graph.place = graph.place, place
    yield
    graph.place = saved


def apply(g: Graph, name: str, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    """Apply an operator or function whose argument types have been checked."""
    special = _OPERATIONS.get(name)
    if special is not None:
        return special(g, types, args)
    return _elementwise(g, name, args)


def _elementwise(g: Graph, name: str, args: Sequence[Nodes]) -> Nodes:
    """Apply a scalar function to each component of its first argument; others may be scalars."""
    n = max(len(a) for a in args)
    columns = [a if len(a) == n else list(a) * n for a in args]
    return [SCALARS[name](g, *scalar_args) for scalar_args in zip(*columns, strict=True)]


def _op(name: str) -> Callable[[Graph, Sequence[ValueType], Sequence[Nodes]], Nodes]:
    def build(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
        n = max(len(a) for a in args)
        columns = [a if len(a) == n else list(a) * n for a in args]
        return [g.op(name, *scalar_args) for scalar_args in zip(*columns, strict=True)]

    return build


def _swapped(name: str) -> Callable[[Graph, Sequence[ValueType], Sequence[Nodes]], Nodes]:
    return lambda g, t, a: _op(name)(g, t, (a[1], a[0]))


def _grid(type_: ValueType, nodes: Nodes) -> list[Nodes]:
    assert isinstance(type_, MatrixType)
    c = type_.columns
    return [nodes[r * c : (r + 1) * c] for r in range(type_.rows)]


def _mul(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    (left, right), (a, b) = types, args
    if isinstance(left, ScalarType) or isinstance(right, ScalarType):
        return _op("mul")(g, types, args)
    if isinstance(left, QuaternionType):
        return list(quaternion.product(g, a, b))
    if isinstance(left, MatrixType) and isinstance(right, VectorType):
        return list(linear.matvec(g, _grid(left, a), b))
    if isinstance(left, VectorType):
        return list(linear.matvec(g, linear.transpose(_grid(right, b)), a))
    return linear.flatten(linear.matmul(g, _grid(left, a), _grid(right, b)))


def _matrix(
    f: Callable[[Graph, list[Nodes]], list[Nodes]],
) -> Callable[[Graph, Sequence[ValueType], Sequence[Nodes]], Nodes]:
    return lambda g, t, a: linear.flatten(f(g, _grid(t[0], a[0])))


def _inverse(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    if isinstance(types[0], QuaternionType):
        return quaternion.inverse(g, args[0])
    return linear.flatten(inverse.inverse(g, _grid(types[0], args[0])))


def _index(g: Graph, node: int) -> int:
    value = g.value(node)
    assert value is not None
    return int(value)


def _rotation_matrix(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    if isinstance(types[0], QuaternionType):
        return linear.flatten(quaternion.rotation_matrix(g, args[0]))
    if isinstance(types[0], ScalarType):
        return linear.flatten(rotation.rotation_matrix2(g, args[0][0]))
    return linear.flatten(rotation.rotation_matrix(g, args[0]))


def _euler_angles(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    if isinstance(types[0], QuaternionType):
        return list(rotation.euler_angles(g, quaternion.rotation_matrix(g, args[0])))
    return list(rotation.euler_angles(g, _grid(types[0], args[0])))


def _quaternion_of(g: Graph, type_: ValueType, nodes: Nodes) -> Nodes:
    """Quaternion of a rotation that may be a matrix."""
    if isinstance(type_, MatrixType):
        return list(quaternion.from_rotation_matrix(g, _grid(type_, nodes)))
    return nodes


def _rigid(g: Graph, types: Sequence[ValueType], args: Sequence[Nodes]) -> Nodes:
    """Transform of a matrix, or of a translation and a rotation, with a scale if there is one."""
    if len(args) == 1:
        rows = _grid(types[0], args[0])
        turn = quaternion.from_rotation_matrix(g, [row[:3] for row in rows[:3]])
        return [*(row[3] for row in rows[:3]), *turn]
    at = 0 if isinstance(types[0], VectorType) else 1
    turn = _quaternion_of(g, types[1 - at], args[1 - at])
    return [*args[at], *turn, *(n for a in args[2:] for n in a)]


_OPERATIONS: dict[str, Callable[[Graph, Sequence[ValueType], Sequence[Nodes]], Nodes]] = {
    **{name: _op(name) for name in ("neg", "add", "sub", "div", "pow", "and", "or", "not")},
    **{name: _op(name) for name in ("lt", "le", "eq", "ne")},
    "gt": _swapped("lt"),
    "ge": _swapped("le"),
    "emul": _op("mul"),
    "ediv": _op("div"),
    "mul": _mul,
    "transpose": lambda g, t, a: linear.flatten(linear.transpose(_grid(t[0], a[0]))),
    "inverse": _inverse,
    "row": lambda g, t, a: _grid(t[0], a[0])[_index(g, a[1][0])],
    "column": lambda g, t, a: [r[_index(g, a[1][0])] for r in _grid(t[0], a[0])],
    "quat_vec": lambda g, t, a: a[0][1:],
    "rotation_matrix": _rotation_matrix,
    "euler_angles": _euler_angles,
    "rotation_vector": lambda g, t, a: list(rotation.rotation_vector(g, _grid(t[0], a[0]))),
    "dot": lambda g, t, a: [linear.dot(g, a[0], a[1])],
    "cross": lambda g, t, a: list(linear.cross(g, a[0], a[1])),
    "norm": lambda g, t, a: [linear.norm(g, a[0])],
    "norm2": lambda g, t, a: [linear.norm2(g, a[0])],
    "unit": lambda g, t, a: list(linear.unit(g, a[0])),
    "perp": lambda g, t, a: list(linear.perp(g, a[0])),
    "det": lambda g, t, a: [inverse.det(g, _grid(t[0], a[0]))],
    "trace": lambda g, t, a: [linear.trace(g, _grid(t[0], a[0]))],
    "skew": lambda g, t, a: linear.flatten(linear.skew(g, a[0])),
    "vee": lambda g, t, a: list(linear.vee(g, _grid(t[0], a[0]))),
    "identity2": lambda g, t, a: linear.flatten(linear.identity(g, 2)),
    "identity3": lambda g, t, a: linear.flatten(linear.identity(g, 3)),
    "conj": lambda g, t, a: list(quaternion.conj(g, a[0])),
    "rotate": lambda g, t, a: list(quaternion.rotate(g, a[0], a[1])),
    "quat_log": lambda g, t, a: list(quaternion.log(g, a[0])),
    "quat_exp": lambda g, t, a: list(quaternion.exp(g, a[0])),
    "tf_exp": lambda g, t, a: rigid.exp(g, a[0]),
    "direction_log": lambda g, t, a: list(sphere.log(g, a[0], a[1])),
    "quaternion": lambda g, t, a: _quaternion_of(g, t[0], a[0]),
    "transform": _rigid,
    "similarity": _rigid,
}
