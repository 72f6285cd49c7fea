"""Hand-built layouts for tests of the solver: formulas written in Python, differentiated forward.

Not the compiler: tapes come out as written, so that a failing test here speaks of the runtime.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from arael.runtime.layout import (
    Column,
    Entity,
    Group,
    Layout,
    LayoutPass,
    Param,
    ParamUse,
    Place,
    Raw,
    Slot,
    Step,
    Table,
    Target,
    Use,
)
from arael.runtime.machine.tape import Tape

ROOT = Slot((Step("root"),), "")


class Graph:
    """Builds one tape."""

    def __init__(self) -> None:
        self.ops: list[str] = []
        self.args: list[tuple[int, ...]] = []
        self.constants: list[float] = []
        self.places: list[int] = []
        self.known: dict[tuple, int] = {}

    def node(self, op: str, *args: int) -> Num:
        key = (op, *args)
        if key not in self.known:
            self.known[key] = len(self.ops)
            self.ops.append(op)
            self.args.append(args)
            self.places.append(0)
        return Num(self, self.known[key])

    def input(self, number: int) -> Num:
        return self.node("input", number)

    def const(self, value: float) -> Num:
        if value not in self.constants:
            self.constants.append(value)
        return self.node("const", self.constants.index(value))

    def lift(self, x: Num | float) -> Num:
        return x if isinstance(x, Num) else self.const(float(x))

    def call(self, op: str, *args: Num | float) -> Num:
        return self.node(op, *(self.lift(a).index for a in args))

    def is_const(self, x: Num, value: float) -> bool:
        return self.ops[x.index] == "const" and self.constants[self.args[x.index][0]] == value

    def derivative(self, y: Num, by: int, memo: dict[int, Num] | None = None) -> Num:
        """Derivative of a node by input number `by`."""
        memo = {} if memo is None else memo
        if y.index in memo:
            return memo[y.index]
        op, args = self.ops[y.index], self.args[y.index]
        if op == "const":
            found = self.const(0.0)
        elif op == "input":
            found = self.const(1.0 if args[0] == by else 0.0)
        else:
            x = [Num(self, a) for a in args]
            d = [self.derivative(a, by, memo) for a in x]
            found = RULES[op](self, y, x, d)
        memo[y.index] = found
        return found

    def tape(self, outputs: Sequence[Num]) -> Tape:
        return Tape(
            tuple(self.ops),
            tuple(self.args),
            tuple(self.constants),
            tuple(o.index for o in outputs),
            tuple(self.places),
        )


class Num:
    """A node with arithmetic."""

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph, self.index = graph, index

    def __add__(self, other):
        g, other = self.graph, self.graph.lift(other)
        if g.is_const(self, 0):
            return other
        return self if g.is_const(other, 0) else g.call("add", self, other)

    def __sub__(self, other):
        g, other = self.graph, self.graph.lift(other)
        return self if g.is_const(other, 0) else g.call("sub", self, other)

    def __mul__(self, other):
        g, other = self.graph, self.graph.lift(other)
        if g.is_const(self, 0) or g.is_const(other, 1):
            return self
        if g.is_const(other, 0) or g.is_const(self, 1):
            return other
        return g.call("mul", self, other)

    def __truediv__(self, other):
        return self.graph.call("div", self, other)

    def __neg__(self):
        return self * -1.0

    def __radd__(self, other):
        return self.graph.lift(other) + self

    def __rsub__(self, other):
        return self.graph.lift(other) - self

    def __rmul__(self, other):
        return self.graph.lift(other) * self

    def __rtruediv__(self, other):
        return self.graph.lift(other) / self


def sqrt(x):
    return x.graph.call("sqrt", x)


def sin(x):
    return x.graph.call("sin", x)


def cos(x):
    return x.graph.call("cos", x)


def atan2(y, x):
    return y.graph.call("atan2", y, x)


def where_at_most(x, bound, taken, otherwise):
    return x.graph.call("select", x.graph.call("le", x, bound), taken, otherwise)


RULES: dict[str, Callable] = {
    "add": lambda g, y, x, d: d[0] + d[1],
    "sub": lambda g, y, x, d: d[0] - d[1],
    "mul": lambda g, y, x, d: d[0] * x[1] + x[0] * d[1],
    "div": lambda g, y, x, d: (d[0] - y * d[1]) / x[1],
    "sqrt": lambda g, y, x, d: d[0] * 0.5 / y,
    "sin": lambda g, y, x, d: d[0] * cos(x[0]),
    "cos": lambda g, y, x, d: d[0] * -1.0 * sin(x[0]),
    "select": lambda g, y, x, d: g.call("select", x[0], d[1], d[2]),
    "le": lambda g, y, x, d: g.const(0.0),
    "exp": lambda g, y, x, d: d[0] * y,
    "atan2": lambda g, y, x, d: (d[0] * x[1] - x[0] * d[1]) / (x[0] * x[0] + x[1] * x[1]),
}


def param(path: str, size: int = 1, low=(), high=(), kind: str = "") -> Column:
    kind = kind or ("real" if size == 1 else "vec")
    stored, tangent, shape = size, size, () if size == 1 else (size,)
    if kind == "quaternion":
        stored, tangent, shape = 4, 3, (4,)
    if kind == "angle":
        stored, tangent, shape = 1, 1, ()
    return Column(
        path,
        "real",
        shape,
        "param",
        kind,
        "toy:1:1",
        default=(0.0,) * stored,
        param=Param(kind, stored, tangent, tuple(low), tuple(high)),
    )


def data(path: str, shape: tuple[int, ...] = (), default: float | None = None) -> Column:
    size = 1
    for s in shape:
        size *= s
    given = None if default is None else (default,) * size
    return Column(path, "real", shape, "data", "real", "toy:2:1", default=given)


def ref(path: str, table: str) -> Column:
    return Column(
        path,
        "int",
        (),
        "ref",
        f"ref into {table}",
        "toy:3:1",
        target=Target(table, table, (Step("root"),), f"root.{table}"),
    )


def table(path: str, *columns: Column, **settings) -> Table:
    if not path:
        return Table("", "Toy", "root", "", "", "toy:4:1", columns, **settings)
    return Table(path, path.capitalize(), "list", "", path, "toy:5:1", columns, **settings)


def entity(
    layout_table: Table, refresh=None, names: Sequence[str] = (), prefix: str = ""
) -> Entity:
    """All param columns of a table; `refresh(graph, stored, step)` gives the whole state."""
    uses, stored, tangent, made = [], 0, 0, []
    for column in layout_table.columns:
        if column.param is None:
            continue
        p = column.param
        uses.append(ParamUse(column.path, p.kind, stored, p.stored, tangent, p.tangent))
        stored, tangent = stored + p.stored, tangent + p.tangent
        axes = "xyzwvu"
        made += (
            [column.path]
            if p.tangent == 1
            else [f"{column.path}.{axes[k]}" for k in range(p.tangent)]
        )
    g = Graph()
    old = [g.input(k) for k in range(stored)]
    step = [g.input(stored + k) for k in range(tangent)]
    outputs = (
        [a + b for a, b in zip(old, step, strict=True)]
        if refresh is None
        else refresh(g, old, step)
    )
    return Entity(
        layout_table.struct,
        layout_table.path,
        prefix,
        tuple(uses),
        stored,
        tangent,
        len(outputs),
        g.tape(outputs),
        tuple(names) or tuple(made),
    )


def group(
    label: str,
    at: str,
    slots: Sequence[Slot],
    uses: Sequence[tuple[int, int]],
    entities: Sequence[Entity],
    formula: Callable,
    raw: Sequence[Raw] = (),
    uniform: Sequence[Raw] = (),
    chain: dict[int, Callable] | None = None,
    guard: tuple[Sequence[Raw], Callable] | None = None,
    index_column: str = "",
    places: Sequence[Place] = (),
) -> Group:
    """A constraint; `formula(states per use, data, uniforms)` gives the residuals.

    `chain[use](state)` gives, per tangent scalar, the derivative of each state scalar; without it
    tangent scalars are the first state scalars.
    """
    g = Graph()
    states: list[tuple[int, int]] = []
    moving: list[list[Num]] = []
    for u, (_, e) in enumerate(uses):
        moving.append([])
        for offset in range(entities[e].state):
            moving[u].append(g.input(len(states)))
            states.append((u, offset))
    first = len(states)
    lanes = [g.input(first + k) for k in range(len(raw))]
    same = [g.input(first + len(raw) + k) for k in range(len(uniform))]
    residuals = [g.lift(r) for r in formula(moving, lanes, same)]
    outputs, jacobian = list(residuals), []
    for r, residual in enumerate(residuals):
        for u, (_, e) in enumerate(uses):
            by_state = [g.derivative(residual, g.args[s.index][0]) for s in moving[u]]
            if chain and u in chain:
                rows = chain[u](moving[u])
            else:
                rows = [
                    [1.0 if k == t else 0.0 for k in range(entities[e].state)]
                    for t in range(entities[e].tangent)
                ]
            for t, row in enumerate(rows):
                total = g.const(0.0)
                for d, c in zip(by_state, row, strict=True):
                    total = total + d * c
                if not g.is_const(total, 0):
                    outputs.append(total)
                    jacobian.append((r, u, t))
    prepare = Graph()
    everything = [*raw, *uniform]
    guard_tape, guard_raw = None, ()
    if guard is not None:
        guard_raw = tuple(guard[0])
        gg = Graph()
        guard_tape = gg.tape([guard[1](gg, [gg.input(k) for k in range(len(guard_raw))])])
    struct, _, name = label.partition(".")
    return Group(
        label,
        struct,
        name,
        "toy:7:5",
        at,
        "",
        len(residuals),
        tuple(slots),
        tuple(Use(s, e) for s, e in uses),
        tuple(everything),
        prepare.tape([prepare.input(k) for k in range(len(everything))]),
        len(raw),
        len(uniform),
        tuple(states),
        g.tape(outputs),
        tuple(jacobian),
        tuple(places) or (Place("toy:7:9", "the residual"),),
        guard=guard_tape,
        guard_raw=guard_raw,
        guard_text="guard" if guard else "",
        index_column=index_column,
    )


def layout(
    tables: Sequence[Table],
    entities: Sequence[Entity],
    groups: Sequence[Group],
    precision: str = "f64",
    passes: Sequence[LayoutPass] = (),
) -> Layout:
    return Layout(
        1,
        "toy",
        "Toy",
        precision,
        "toy.arael",
        tuple(tables),
        tuple(entities),
        tuple(groups),
        tuple(passes),
    )
