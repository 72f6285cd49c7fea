"""A long straight-line program split into parts, each printed as a separate function.

The time that a C compiler takes for one function grows faster than its length, so a long program is
compiled as several. The parts share a *workspace*: columns of W lanes for the inputs from states,
for the results, and for values that one part computes and another reads. A column of the last kind
is used again once its value is no longer needed.

The operations of the residuals come first, so a cost evaluates only the leading parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from arael.compiler.runs import FREE, Run, find_runs, needed, run_of
from arael.runtime.machine.tape import Tape

PART = 200
"""Statements of a part. GCC 12 takes least time per statement between 100 and 400."""


@dataclass(frozen=True)
class Part:
    """A stretch of a program.

    Attributes
    ----------
    nodes : nodes computed here, in order
    stores : (column, node) of results that are stored here because their node is no operation
    runs : results that are written as loops
    """

    nodes: tuple[int, ...]
    stores: tuple[tuple[int, int], ...] = ()
    runs: tuple[Run, ...] = ()


@dataclass(frozen=True)
class Parts:
    """A program in parts.

    Attributes
    ----------
    parts : in order of evaluation
    leading : how many parts give the leading results
    columns : by node, the columns of the workspace that it is stored to
    first : column of the first result
    width : columns of the workspace
    """

    parts: tuple[Part, ...]
    leading: int
    columns: dict[int, list[int]]
    first: int
    width: int


def cut(tape: Tape, leading: int, first_column: int, limit: int | None = None) -> Parts:
    """Cut a program into parts of at most `limit` operations, by default `PART`.

    Parameters
    ----------
    tape : the program
    leading : number of leading results, which the first parts compute alone
    first_column : column of the workspace for the first result; result k is in the k-th after it
    """
    phases = (range(leading), range(leading, len(tape.outputs)))
    runs = [find_runs(tape, results) for results in phases]
    in_runs = run_of([*runs[0], *runs[1]])
    columns: dict[int, list[int]] = {}
    parts: list[Part] = []
    ends = []
    done: set[int] = set()
    for results, own_runs in zip(phases, runs, strict=True):
        single = [k for k in results if k not in in_runs]
        late = []
        for k in single:
            node = tape.outputs[k]
            if tape.ops[node] in (*FREE, "neg"):
                late.append((first_column + k, node))
            else:
                columns.setdefault(node, []).append(first_column + k)
        nodes = sorted(needed(tape, [tape.outputs[k] for k in single]) - done)
        done.update(nodes)
        parts += _chunks(
            [n for n in nodes if tape.ops[n] not in (*FREE, "neg")], late, limit or PART
        )
        if own_runs:
            parts.append(Part((), (), tuple(own_runs)))
        ends.append(len(parts))
    width = _carry(tape, parts, columns, first_column + len(tape.outputs))
    return Parts(tuple(parts), ends[0], columns, first_column, width)


def _chunks(nodes: Sequence[int], stores: Sequence[tuple[int, int]], limit: int) -> list[Part]:
    chunks = [Part(tuple(nodes[k : k + limit])) for k in range(0, len(nodes), limit)]
    return chunks + [Part((), tuple(stores[k : k + limit])) for k in range(0, len(stores), limit)]


def base(tape: Tape, node: int) -> int:
    """The node itself; of a negation, which is written where it is read, what it negates."""
    while tape.ops[node] == "neg":
        node = tape.args[node][0]
    return node


def _carry(tape: Tape, parts: Sequence[Part], columns: dict[int, list[int]], width: int) -> int:
    """Give a column to each value that a later part reads and no result has; return their end."""
    made: dict[int, int] = {}
    last: dict[int, int] = {}
    for number, part in enumerate(parts):
        reads = [a for n in part.nodes for a in tape.args[n]] + [n for _, n in part.stores]
        made.update(dict.fromkeys(part.nodes, number))
        for node in {base(tape, n) for n in reads}:
            if tape.ops[node] not in FREE:
                last[node] = number
    free: list[int] = []
    held: dict[int, list[int]] = {}
    for number, part in enumerate(parts):
        free += held.pop(number, [])
        for node in part.nodes:
            end = last.get(node, -1)
            if end <= number or node in columns:
                continue
            if free:
                column = free.pop()
            else:
                column, width = width, width + 1
            columns[node] = [column]
            held.setdefault(end + 1, []).append(column)
    return width
