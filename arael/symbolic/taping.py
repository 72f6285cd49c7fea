"""From a graph to a tape: what is needed, numbered densely, without what only derivation needed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING

from arael.runtime.machine.tape import Tape

if TYPE_CHECKING:
    from arael.symbolic.graph import Graph


class _Writer:
    """A tape in the making; nodes that differ only in prescribed derivatives meet again here."""

    def __init__(self) -> None:
        self.entries: dict[tuple[str, tuple[int, ...]], int] = {}
        self.constants: dict[float, int] = {}
        self.places: list[int] = []

    def append(self, name: str, args: tuple[int, ...], place: int) -> int:
        known = self.entries.get((name, args))
        if known is None:
            known = self.entries[(name, args)] = len(self.places)
            self.places.append(place)
        return known

    def constant(self, value: float, place: int) -> int:
        index = self.constants.setdefault(value, len(self.constants))
        return self.append("const", (index,), place)


def write_tape(g: Graph, outputs: Sequence[int], inputs: Sequence[Hashable] | None = None) -> Tape:
    """Make the tape that `Graph.tape` documents."""
    numbers = {key: i for i, key in enumerate(g.inputs if inputs is None else inputs)}
    live = g.live(outputs)
    absorbed = _absorbed_negations(g, live, outputs)
    dropped = {operand for operand, _ in absorbed.values()}
    tape = _Writer()
    written: dict[int, int] = {}
    for node in live:
        if node in dropped:
            continue
        name, args, place = g.ops[node], g.args[node], g.places[node]
        if name == "input":
            key = g.inputs[args[0]]
            if key not in numbers:
                raise ValueError(f"the program needs input {key!r}, which it is not given")
            written[node] = tape.append(name, (numbers[key],), place)
        elif name == "const":
            written[node] = tape.constant(g.constants[args[0]], place)
        elif g.is_free(node):
            written[node] = written[args[0]]
        elif node in absorbed:
            operand, factor = absorbed[node]
            inner, (a, b), place = g.ops[operand], g.args[operand], g.places[operand]
            if factor is None:  # -(a - b) = b - a
                written[node] = tape.append(inner, (written[b], written[a]), place)
                continue
            constant = tape.constant(-factor, place)
            first = g.value(a) is not None
            if inner == "add":  # -(a + c) = -c - a
                written[node] = tape.append("sub", (constant, written[b if first else a]), place)
            else:
                pair = (constant, written[b]) if first else (written[a], constant)
                written[node] = tape.append(inner, pair, place)
        else:
            written[node] = tape.append(name, tuple(written[a] for a in args), place)
    return Tape(
        ops=tuple(name for name, _ in tape.entries),
        args=tuple(args for _, args in tape.entries),
        constants=tuple(tape.constants),
        outputs=tuple(written[node] for node in outputs),
        places=tuple(tape.places),
    )


def _absorbed_negations(
    g: Graph, live: Sequence[int], outputs: Sequence[int]
) -> Mapping[int, tuple[int, float | None]]:
    """Negations that cost nothing, since their operand serves nothing else.

    Those of a difference, which is turned round, and those of a sum, product or quotient with a
    constant, whose sign is changed. By negation: its operand, and the constant or None.
    """
    uses = Counter(outputs)
    for node in live:
        uses.update(g.operands(node))
    found: dict[int, tuple[int, float | None]] = {}
    for node in live:
        if g.ops[node] != "neg":
            continue
        operand = g.args[node][0]
        if uses[operand] > 1:
            continue
        if g.ops[operand] == "sub":
            found[node] = operand, None
        elif g.ops[operand] in ("add", "mul", "div"):
            factors = [v for v in map(g.value, g.args[operand]) if v is not None]
            if len(factors) == 1:
                found[node] = operand, factors[0]
    return found
