"""Refresh kernels: the state of each row of an entity from its stored scalars and a step."""

from __future__ import annotations

from collections.abc import Callable

from arael.compiler.emit.writer import Writer, comment, statements
from arael.compiler.runs import find_runs, formula, without
from arael.runtime.layout import Entity


def emit_refresh(w: Writer, number: int, entity: Entity) -> None:
    """Write ``refresh_N``."""
    where = f"{entity.table or 'the root'}{' ' + entity.prefix if entity.prefix else ''}"
    w.line()
    w.line(f"# State of {entity.struct} over {comment(where)}: {entity.state} scalars a row.")
    with w.block(
        f"cdef void refresh_{number}(Py_ssize_t rows, const void* state, const void* delta, "
        "const int32_t* delta_at, void* moved) noexcept nogil:"
    ):
        w.line("cdef Py_ssize_t i, k")
        w.line("cdef const real* s = <const real*>state")
        w.line("cdef real* m = <real*>moved")
        w.line(f"cdef real v[{entity.stored}]")
        w.line(f"cdef real e[{max(entity.tangent, 1)}]")
        declared = len(w.lines)
        with w.block("for i in range(rows):"):
            with w.block(f"for k in range({entity.stored}):"):
                w.line("v[k] = s[k]")
            with w.block(f"for k in range({entity.tangent}):"):
                w.line(
                    "e[k] = (<const real*>delta)[delta_at[i] + k] if delta_at[i] >= 0 else <real>0"
                )
            inputs = [
                *(f"v[{k}]" for k in range(entity.stored)),
                *(f"e[{k}]" for k in range(entity.tangent)),
            ]
            tape = entity.refresh
            runs = find_runs(tape, range(len(tape.outputs)))
            for run in runs:
                with w.block(f"for k in range({run.count}):"):
                    value = formula(tape, run, _moving(entity.stored))
                    w.line(f"m[{run.first} + k] = {value}")
            rest, remaining = without(tape, runs)
            used = statements(w, rest, inputs, lambda i: [f"m[{remaining[i]}]"])
            w.line(f"s += {entity.state}")
            w.line(f"m += {entity.state}")
    lines = []
    for start in range(0, used, 12):
        names = ", ".join(f"t{i}" for i in range(start, min(start + 12, used)))
        lines.append("    cdef real " + names)
    w.lines[declared:declared] = lines
    w.line()


def _moving(stored: int) -> Callable[[int, str], str]:
    """Texts of stored scalars and steps in a loop over `k`."""

    def name(number: int, step: str) -> str:
        array, at = ("v", number) if number < stored else ("e", number - stored)
        return f"{array}[{at} + k]" if step else f"{array}[{at}]"

    return name
