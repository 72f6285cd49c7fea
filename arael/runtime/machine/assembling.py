"""From the tape of a group to instructions on registers, which the expression machine runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from arael.runtime.layout import Entity, Group, pair_of
from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import NATIVE, PRIMITIVES, Tape

# Functions of the C library that the machine calls by address.
LIBRARY = tuple(f for f in FUNCTIONS if not f.opcode)
_AT = {f.name: k for k, f in enumerate(LIBRARY)}

# In the order of `Operation` in machine.pyx.
OPERATIONS = tuple(name for name in PRIMITIVES if name not in ("input", "const", *_AT))
_NUMBER = {name: k for k, name in enumerate(OPERATIONS)}
_CALL = len(OPERATIONS)
_LIBRARY = _CALL + 1

Word = tuple[int, int, int, int, int]


@dataclass(frozen=True)
class Parts:
    """What a program consists of; the words of each list are described in machine.pxd.

    `results` and `entries` are registers of the linearisation; the cost leaves its residuals in the
    same registers. `operands` are those of calls of native functions, which may have many.
    """

    cost: list[Word]
    full: list[Word]
    states: list[tuple[int, int, int]]
    constants: tuple[float, ...]
    registers: int
    results: list[int]
    entries: list[tuple[int, int, int]]
    products: list[tuple[int, int, int, int, int, int, int]]
    operands: list[int]
    arguments: int  # of the call that has most


def assemble(group: Group, entities: Sequence[Entity], natives: Sequence[str] = ()) -> Parts:
    """Assign a register to every node of the group's tape and list the operations.

    `natives` are the names of the native functions in the order in which they are numbered.
    """
    tape = group.tape
    inputs = len(group.states) + group.data_count + group.uniform_count
    register, count = _registers(tape, inputs)
    outputs = [register[node] for node in tape.outputs]
    results, derivatives = outputs[: group.residuals], outputs[group.residuals :]
    entries = [
        (at, residual, use | tangent << 16)
        for at, (residual, use, tangent) in zip(derivatives, group.jacobian, strict=True)
    ]
    calls = [k for k, op in enumerate(tape.ops) if op.startswith(NATIVE)]
    sizes = [len(tape.args[k]) for k in calls]
    called = {
        node: (natives.index(tape.ops[node].removeprefix(NATIVE)), sum(sizes[:k]))
        for k, node in enumerate(calls)
    }
    return Parts(
        cost=_words(tape, register, _needed(tape, tape.outputs[: group.residuals]), called),
        full=_words(tape, register, range(len(tape.ops)), called),
        states=[(u, o, entities[group.uses[u].entity].state) for u, o in group.states],
        constants=tape.constants,
        registers=max(count, 1),
        results=results,
        entries=entries,
        products=_products(group, entities, derivatives),
        operands=[register[x] for node in calls for x in tape.args[node]],
        arguments=max(sizes, default=0),
    )


def _registers(tape: Tape, inputs: int) -> tuple[list[int], int]:
    """Register of every node, and how many there are; one that is not read any more is free."""
    last = list(range(len(tape.ops)))
    for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op not in ("input", "const"):
            for arg in args:
                last[arg] = node
    for node in tape.outputs:
        last[node] = len(tape.ops)
    fixed = inputs + len(tape.constants)
    count, spare, register = fixed, list[int](), list[int]()
    for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op == "input":
            register.append(args[0])
            continue
        if op == "const":
            register.append(inputs + args[0])
            continue
        # An operand read here for the last time may become the target: lanes do not mix.
        spare += {register[a] for a in args if last[a] == node and register[a] >= fixed}
        if not spare:
            spare.append(count)
            count += 1
        register.append(spare.pop())
        last_use = last[node]
        if last_use == node:  # its value is never read
            spare.append(register[node])
    return register, count


def _needed(tape: Tape, outputs: Sequence[int]) -> list[int]:
    needed = set(outputs)
    for node in range(len(tape.ops) - 1, -1, -1):
        if node in needed and tape.ops[node] not in ("input", "const"):
            needed.update(tape.args[node])
    return sorted(needed)


def _words(
    tape: Tape, register: list[int], nodes: Sequence[int], called: dict[int, tuple[int, int]]
) -> list[Word]:
    """Instructions of some nodes; `called`: number of the native function, place of operands."""
    words: list[Word] = []
    for node in nodes:
        op = tape.ops[node]
        if op in ("input", "const"):
            continue
        if node in called:
            words.append((_CALL, register[node], *called[node], 0))
            continue
        if op in _AT:
            words.append((_LIBRARY, register[node], register[tape.args[node][0]], 0, _AT[op]))
            continue
        a, b, c = (*(register[x] for x in tape.args[node]), 0, 0)[:3]
        words.append((_NUMBER[op], register[node], a, b, c))
    return words


def _products(
    group: Group, entities: Sequence[Entity], derivatives: list[int]
) -> list[tuple[int, int, int, int, int, int, int]]:
    """Products of derivatives of the same residual, by the pair of uses that they belong to."""
    rows: dict[int, list[tuple[int, int, int]]] = {}
    for at, (residual, use, tangent) in zip(derivatives, group.jacobian, strict=True):
        rows.setdefault(residual, []).append((use, tangent, at))
    found = []
    for row in rows.values():
        for a, i, left in row:
            for b, j, right in row:
                if (a, i) < (b, j):
                    continue
                height = entities[group.uses[a].entity].tangent
                width = entities[group.uses[b].entity].tangent
                offsets = i * width + j, j * height + i, max(i, j) * width + min(i, j)
                factor = 2 if i == j else 1
                found.append((left, right, pair_of(a, b), *offsets, factor))
    return found
