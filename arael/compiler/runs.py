"""Results that are one formula over consecutive inputs: a loop instead of a statement for each.

``p - z`` over vectors of a thousand scalars is a thousand results ``p[k] - z[k]``; the derivative
of each is the constant 1. Both are written as one loop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from arael.compiler.emit.operators import expression, literal
from arael.runtime.machine.tape import NATIVE, Tape

FREE = ("input", "const")
"""Operations that take no statement."""

LEAST = 16
"""Results that make a loop."""

# A formula of more operations is not searched for: what several results share is computed once.
_MOST_OPERATIONS = 4

Leaves = tuple[int, ...]


@dataclass(frozen=True)
class Run:
    """Consecutive results of one formula.

    Attributes
    ----------
    first, count : the results
    node : node of the first result
    steps : by input that the first result reads, in order of reading: what is added to its number
        from one result to the next, 0 or 1
    """

    first: int
    count: int
    node: int
    steps: tuple[int, ...]

    @property
    def end(self) -> int:
        """The result behind the last one."""
        return self.first + self.count


def find_runs(tape: Tape, results: range) -> list[Run]:
    """Find the runs among `results` of a program, from the first on."""
    forms = [_form(tape, tape.outputs[k]) for k in results]
    runs: list[Run] = []
    at = 0
    while at < len(forms):
        end, steps = _extent(forms, at)
        if end - at >= LEAST:
            runs.append(Run(results[at], end - at, tape.outputs[results[at]], steps))
        at = end
    return runs


def _extent(forms: Sequence[tuple[object, Leaves] | None], at: int) -> tuple[int, tuple[int, ...]]:
    """End of the run that begins with result `at`, and its steps."""
    first = forms[at]
    end = at + 1
    steps: tuple[int, ...] | None = None
    while first is not None and end < len(forms):
        before, here = forms[end - 1], forms[end]
        if before is None or here is None or here[0] != first[0]:
            break
        moved = tuple(b - a for a, b in zip(before[1], here[1], strict=True))
        if not set(moved) <= {0, 1} or steps not in (None, moved):
            break
        steps = moved
        end += 1
    return end, steps or ()


def _form(tape: Tape, node: int) -> tuple[object, Leaves] | None:
    """What the operations of a result are, and the inputs that it reads; None if they are many."""
    leaves: list[int] = []
    operations = 0

    def shape(node: int) -> object:
        nonlocal operations
        op, args = tape.ops[node], tape.args[node]
        if op == "input":
            leaves.append(args[0])
            return op
        if op == "const":
            return tape.constants[args[0]]
        operations += 1
        if operations > _MOST_OPERATIONS or op.startswith(NATIVE):
            raise OverflowError
        return (op, *(shape(a) for a in args))

    try:
        form = shape(node)
    except OverflowError:
        return None
    return form, tuple(leaves)


def formula(tape: Tape, run: Run, name: Callable[[int, str], str]) -> str:
    """Formula of a run as an expression.

    Parameters
    ----------
    name : text of an input by its number, and what a loop over `i` adds to it: ``""`` or
        ``" + i"``
    """
    steps = iter(run.steps)

    def text(node: int) -> str:
        op, args = tape.ops[node], tape.args[node]
        if op == "input":
            return name(args[0], " + i" if next(steps, 0) else "")
        if op == "const":
            return literal(tape.constants[args[0]])
        return f"({expression(op, [text(a) for a in args])})"

    whole = text(run.node)
    return whole[1:-1] if tape.ops[run.node] not in ("input", "const") else whole


def run_of(runs: Sequence[Run]) -> Mapping[int, Run]:
    """The run of each result that has one."""
    return {k: run for run in runs for k in range(run.first, run.end)}


def without(tape: Tape, runs: Sequence[Run]) -> tuple[Tape, list[int]]:
    """Take runs out of a program: what is left, and which results those of the rest are."""
    if not runs:
        return tape, list(range(len(tape.outputs)))
    gone = run_of(runs)
    outputs = [k for k in range(len(tape.outputs)) if k not in gone]
    live = sorted(needed(tape, [tape.outputs[k] for k in outputs]))
    number = {node: k for k, node in enumerate(live)}
    rest = Tape(
        ops=tuple(tape.ops[n] for n in live),
        args=tuple(
            tape.args[n] if tape.ops[n] in FREE else tuple(number[a] for a in tape.args[n])
            for n in live
        ),
        constants=tape.constants,
        outputs=tuple(number[tape.outputs[k]] for k in outputs),
        places=tuple(tape.places[n] for n in live) if tape.places else (),
    )
    return rest, outputs


def needed(tape: Tape, outputs: Iterable[int]) -> set[int]:
    """Nodes that `outputs` are computed from, themselves included."""
    nodes = set(outputs)
    waiting = list(nodes)
    while waiting:
        node = waiting.pop()
        if tape.ops[node] not in FREE:
            for operand in tape.args[node]:
                if operand not in nodes:
                    nodes.add(operand)
                    waiting.append(operand)
    return nodes
