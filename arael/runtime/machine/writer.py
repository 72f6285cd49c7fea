"""Tapes put together from other tapes, without a graph and its rules."""

from __future__ import annotations

from collections.abc import Sequence

from arael.runtime.machine.tape import Tape


class TapeWriter:
    """A tape in the making, to which others are added; equal operations are one node."""

    def __init__(self) -> None:
        self._ops: list[str] = []
        self._args: list[tuple[int, ...]] = []
        self._places: list[int] = []
        self._constants: dict[float, int] = {}
        self._known: dict[tuple[str, tuple[int, ...]], int] = {}

    def input(self, number: int) -> int:
        """Node of an input."""
        return self.op("input", number)

    def const(self, value: float) -> int:
        """Node of a literal value."""
        return self.op("const", self._constants.setdefault(value, len(self._constants)))

    def op(self, name: str, *args: int, place: int = -1) -> int:
        """Node of an operation."""
        node = self._known.setdefault((name, args), len(self._ops))
        if node == len(self._ops):
            self._ops.append(name)
            self._args.append(args)
            self._places.append(place)
        return node

    def add(self, other: Tape, inputs: Sequence[int]) -> list[int]:
        """Nodes of the outputs of another tape for given nodes as its inputs."""
        nodes: list[int] = []
        places = other.places or (-1,) * len(other.ops)
        for name, args, place in zip(other.ops, other.args, places, strict=True):
            if name == "input":
                nodes.append(inputs[args[0]])
            elif name == "const":
                nodes.append(self.const(other.constants[args[0]]))
            else:
                nodes.append(self.op(name, *(nodes[a] for a in args), place=place))
        return [nodes[k] for k in other.outputs]

    def tape(self, outputs: Sequence[int]) -> Tape:
        """The tape with these outputs; what none of them needs is left out."""
        needed = set(outputs)
        for node in range(len(self._ops) - 1, -1, -1):
            if node in needed and self._ops[node] not in ("input", "const"):
                needed.update(self._args[node])
        order = sorted(needed)
        at = {node: k for k, node in enumerate(order)}
        return Tape(
            ops=tuple(self._ops[n] for n in order),
            args=tuple(
                self._args[n]
                if self._ops[n] in ("input", "const")
                else tuple(at[a] for a in self._args[n])
                for n in order
            ),
            constants=tuple(self._constants),
            outputs=tuple(at[n] for n in outputs),
            places=tuple(self._places[n] for n in order),
        )
