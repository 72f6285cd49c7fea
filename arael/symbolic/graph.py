"""The graph of a formula: scalar operations, each kept once.

Nodes are integers in order of creation, which is an order of evaluation. A node is identified by
its operation and operands, so equal expressions are one node: value numbering, which is
deterministic elimination of common subexpressions, happens as the graph is built.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from arael.runtime.machine.tape import NATIVE, PRIMITIVES, Tape
from arael.symbolic.simplify import RULES, fold
from arael.symbolic.taping import write_tape

NO_PLACE = -1


def closure(start: Iterable[int], below: Callable[[int], Iterable[int]]) -> list[int]:
    """Nodes of `start`, those `below` them, and so on, in order of evaluation."""
    found = set(start)
    stack = list(found)
    while stack:
        new = [node for node in below(stack.pop()) if node not in found]
        found.update(new)
        stack += new
    return sorted(found)


@dataclass(frozen=True)
class Prescribed:
    """A function of scalars with partial derivatives of its own.

    The partials are made when a call is differentiated and not before, so functions may name each
    other and themselves in them: ``exp`` is its own derivative.

    Attributes
    ----------
    name : as the model spells it
    native : whether its value is known to native code only; else calls have a node of their value
    partials : makes the partial derivatives, one per argument, from a graph and the arguments; None
        of a function of `arael.symbolic.derivatives`, which SymPy differentiates
    """

    name: str
    native: bool
    partials: Callable[[Graph, Sequence[int]], Sequence[int]] | None = None

    @property
    def operation(self) -> str:
        """Name of the operation in graphs, and of a native one in tapes too."""
        return f"{NATIVE}{self.name}" if self.native else f"derived:{self.name}"

    def arguments(self, operands: tuple[int, ...]) -> tuple[int, ...]:
        """Arguments among the operands of a call."""
        return operands if self.native else operands[1:]


class Graph:
    """Hash-consed scalar operations.

    Attributes
    ----------
    ops : name of the operation, one per node: those of `arael.runtime.machine.tape.PRIMITIVES`;
        ``custom``, a value whose derivative is prescribed (see `custom`); and the operations of
        `functions`
    args : operands, one tuple per node. Of an ``input``: its number, an index into `inputs`;
        of a ``const``: index into `constants`; else earlier nodes.
    constants : literal values
    inputs : keys of the inputs, in order of creation
    functions : functions with derivatives of their own that were called, by their operation
    places : per node, the place that was current when it was first made, or -1
    place : current place: an index into the caller's table of source places, or None. New nodes
        remember it.
    """

    def __init__(self, *, simplify: bool = True) -> None:
        self.ops: list[str] = []
        self.args: list[tuple[int, ...]] = []
        self.constants: list[float] = []
        self.inputs: list[Hashable] = []
        self.functions: dict[str, Prescribed] = {}
        self.places: list[int] = []
        self.place: int | None = None
        self.simplify = simplify
        self._nodes: dict[tuple[str, tuple[int, ...]], int] = {}
        self._constants: dict[float, int] = {}
        self._inputs: dict[Hashable, int] = {}

    def __len__(self) -> int:
        """Count the nodes."""
        return len(self.ops)

    def const(self, value: float) -> int:
        """Node of a literal value. Negative zero becomes zero."""
        value = float(value) + 0.0
        if math.isnan(value):
            value = math.nan  # one object, which a dict finds by identity
        node = self._constants.get(value)
        if node is None:
            node = self._constants[value] = self._append("const", (len(self.constants),))
            self.constants.append(value)
        return node

    def input(self, key: Hashable) -> int:
        """Node of the input known as `key`; the same node for the same key."""
        node = self._inputs.get(key)
        if node is None:
            node = self._inputs[key] = self._append("input", (len(self.inputs),))
            self.inputs.append(key)
        return node

    def op(self, name: str, *args: int) -> int:
        """Node for operation `name` of `args`, simplified; an existing one where it is the same.

        Raises
        ------
        ValueError
            If there is no such operation, or it takes another number of operands.
        """
        primitive = PRIMITIVES.get(name)
        if primitive is None or primitive[1] is None or primitive[0] != len(args):
            raise ValueError(f"no operation {name!r} of {len(args)} operands")
        if not self.simplify:
            return self.intern(name, args)
        values = [self.value(a) for a in args]
        if name != "identity" and None not in values:
            folded = fold(name, *(v for v in values if v is not None))
            if folded is not None:
                return self.const(folded)
        rule = RULES.get(name)
        return rule(self, *args) if rule is not None else self.intern(name, args)

    def custom(self, value: int, partials: Iterable[tuple[int, int]]) -> int:
        """Make a node with the value of `value` and a prescribed derivative.

        `partials` are pairs of an argument and the derivative by it, both nodes; differentiation
        goes through these and never into `value`. The node has operation ``custom`` and operands
        ``value, argument, partial, argument, ...``. A tape has `value` in its place.
        """
        flat = tuple(node for pair in partials for node in pair)
        return self.intern("custom", (value, *flat))

    def call(self, function: Prescribed, args: Sequence[int], value: int | None = None) -> int:
        """Make a node for a call of a function whose derivatives are prescribed.

        A tape has the node `value` in its place; without one it is known only to native code.
        """
        self.functions[function.operation] = function
        operands = args if value is None else (value, *args)
        return self.intern(function.operation, tuple(operands))

    def is_free(self, node: int) -> bool:
        """Whether a node is only another name of its first operand's value."""
        function = self.functions.get(self.ops[node])
        return self.ops[node] == "custom" or (function is not None and not function.native)

    def intern(self, name: str, args: tuple[int, ...]) -> int:
        """Node of exactly this operation and operands, without simplification."""
        key = (name, args)
        node = self._nodes.get(key)
        if node is None:
            node = self._nodes[key] = self._append(name, args)
        return node

    def _append(self, name: str, args: tuple[int, ...]) -> int:
        self.ops.append(name)
        self.args.append(args)
        self.places.append(NO_PLACE if self.place is None else self.place)
        return len(self.ops) - 1

    def place_of(self, node: int, default: int | None = None) -> int | None:
        """Return the place of `node`, or `default` if it has none."""
        place = self.places[node]
        return default if place == NO_PLACE else place

    def rollback(self, length: int) -> None:
        """Forget all nodes made since the graph had `length` nodes."""
        while len(self.ops) > length:
            name, args = self.ops.pop(), self.args.pop()
            self.places.pop()
            if name == "const":
                del self._constants[self.constants.pop()]
            elif name == "input":
                del self._inputs[self.inputs.pop()]
            else:
                del self._nodes[(name, args)]

    def reserve(self, operations: int) -> None:
        """Learn that about so many operations are going to be made; a bounded graph may refuse."""

    def exists(self, name: str, args: tuple[int, ...]) -> bool:
        """Whether a node of exactly this operation and operands has been made."""
        return (name, args) in self._nodes

    def value(self, node: int) -> float | None:
        """Value of a constant node, None of any other."""
        return self.constants[self.args[node][0]] if self.ops[node] == "const" else None

    def key(self, node: int) -> Hashable:
        """Key of an input node."""
        if self.ops[node] != "input":
            raise ValueError(f"node {node} is no input but {self.ops[node]}")
        return self.inputs[self.args[node][0]]

    def operands(self, node: int) -> tuple[int, ...]:
        """Nodes that the value of `node` is computed from: none of inputs and constants."""
        if self.ops[node] in ("input", "const"):
            return ()
        return self.args[node][:1] if self.is_free(node) else self.args[node]

    def live(self, outputs: Iterable[int]) -> list[int]:
        """Nodes that `outputs` are computed from, themselves included, in order of evaluation."""
        return closure(outputs, self.operands)

    def depends(self, on: Iterable[int]) -> set[int]:
        """Nodes of the graph whose value is computed from one of `on`, and those themselves."""
        found = set(on)
        for node in range(min(found, default=len(self.ops)), len(self.ops)):
            if not found.isdisjoint(self.operands(node)):
                found.add(node)
        return found

    def operations(self, outputs: Iterable[int]) -> int:
        """Count the distinct arithmetic operations that `outputs` take."""
        return sum(self._is_operation(n) for n in self.live(outputs))

    def tree_operations(self, outputs: Iterable[int]) -> int:
        """Count the operations of the expressions written out in full, nothing shared."""
        outputs = list(outputs)
        size: dict[int, int] = {}
        for node in self.live(outputs):
            size[node] = self._is_operation(node) + sum(size[a] for a in self.operands(node))
        return sum(size[node] for node in outputs)

    def _is_operation(self, node: int) -> bool:
        return self.ops[node] not in ("input", "const") and not self.is_free(node)

    def copy(
        self, outputs: Iterable[int], target: Graph, replacement: Mapping[int, int] | None = None
    ) -> list[int]:
        """Build `outputs` again in `target`, where nodes of `replacement` become its nodes.

        Replacements are not themselves rewritten; prescribed derivatives follow their values.
        Inputs keep their keys, and nodes their places when `target` is another graph.
        """
        outputs = list(outputs)
        new: dict[int, int] = dict(replacement or {})
        saved = target.place
        leaves = set(new)

        def needed(node: int) -> Iterable[int]:
            leaf = node in leaves or self.ops[node] in ("input", "const")
            return () if leaf else self.args[node]

        for node in closure(outputs, needed):
            if node in leaves:
                continue
            name, args = self.ops[node], self.args[node]
            target.place = self.place_of(node, saved)
            if name == "const":
                new[node] = target.const(self.constants[args[0]])
            elif name == "input":
                new[node] = target.input(self.inputs[args[0]])
            elif name == "custom" or name in self.functions:
                new[node] = target.intern(name, tuple(new[a] for a in args))
                if name in self.functions:
                    target.functions[name] = self.functions[name]
            else:
                new[node] = target.op(name, *(new[a] for a in args))
        target.place = saved
        return [new[node] for node in outputs]

    def tape(self, outputs: Iterable[int], inputs: Sequence[Hashable] | None = None) -> Tape:
        """Make the straight-line program of `outputs`, which are its results in that order.

        `inputs` are the keys of its inputs in order, by default all those of the graph; ValueError
        if an output needs another one.
        """
        return write_tape(self, Graph(), list(outputs), inputs)
