"""From a graph to a tape: what is needed, numbered densely, without what only derivation needed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING

from arael.runtime.machine.tape import Tape

if TYPE_CHECKING:
    from arael.symbolic.graph import Graph


def write_tape(
    g: Graph, tape: Graph, outputs: Sequence[int], inputs: Sequence[Hashable] | None = None
) -> Tape:
    """Make the tape that `Graph.tape` documents, by way of the empty graph `tape`.

    Nodes that differ only in prescribed derivatives are one node there.
    """
    numbers = {key: i for i, key in enumerate(g.inputs if inputs is None else inputs)}
    live = g.live(outputs)
    turned = _turned(g, live, outputs)
    dropped = {g.args[node][0] for node in turned}
    written: dict[int, int] = {}
    for node in live:
        name, args, tape.place = g.ops[node], g.args[node], g.places[node]
        if node in dropped:
            continue
        if name == "input":
            key = g.inputs[args[0]]
            if key not in numbers:
                raise ValueError(f"the program needs input {key!r}, which it is not given")
            written[node] = tape.intern(name, (numbers[key],))
        elif name == "const":
            written[node] = tape.const(g.constants[args[0]])
        elif g.is_free(node):
            written[node] = written[args[0]]
        elif node in turned:
            tape.place, (name, *operands) = g.places[args[0]], turned[node]
            terms = (tape.const(a) if isinstance(a, float) else written[a] for a in operands)
            written[node] = tape.intern(name, tuple(terms))
        else:
            written[node] = tape.intern(name, tuple(written[a] for a in args))
    return Tape(
        ops=tuple(tape.ops),
        args=tuple(tape.args),
        constants=tuple(tape.constants),
        outputs=tuple(written[node] for node in outputs),
        places=tuple(tape.places),
    )


def _turned(
    g: Graph, live: Sequence[int], outputs: Sequence[int]
) -> Mapping[int, tuple[str, int | float, int | float]]:
    """Negations that cost nothing, since their operand serves nothing else, and what they are.

    A difference is turned round; of a sum, product or quotient with a constant, the constant
    changes its sign. Operands are nodes and, as floats, constants.
    """
    uses = Counter(outputs)
    for node in live:
        uses.update(g.operands(node))
    found: dict[int, tuple[str, int | float, int | float]] = {}
    for node in (n for n in live if g.ops[n] == "neg" and uses[g.args[n][0]] == 1):
        inner = g.args[node][0]
        name = g.ops[inner]
        if name not in ("add", "sub", "mul", "div"):
            continue
        (a, b), values = g.args[inner], [g.value(operand) for operand in g.args[inner]]
        if name == "sub":
            found[node] = name, b, a
        elif values.count(None) == 1:
            changed = [-v if v is not None else n for n, v in zip((a, b), values, strict=True)]
            if name == "add":  # -(x + c) = -c - x
                name, changed = "sub", sorted(changed, key=lambda x: not isinstance(x, float))
            found[node] = name, changed[0], changed[1]
    return found
