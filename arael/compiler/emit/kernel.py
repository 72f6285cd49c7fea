"""Kernels of one constraint: cost, and linearisation with its products, on lanes of W instances.

A block of W instances is gathered into arrays of W-wide columns, all arithmetic runs in one loop
over the lanes that touches only such arrays (so the C compiler can vectorise it), and the results
are added to gradient and Hessian blocks as `scatter` has planned.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.compiler.emit import accumulate
from arael.compiler.emit.large import emit_large
from arael.compiler.emit.scatter import make_plan
from arael.compiler.emit.writer import Writer, comment, statements
from arael.compiler.groups import Kernel
from arael.runtime.layout import Entity, pair_count
from arael.runtime.tape import Tape


def emit_constraint(
    w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity], ordered: bool = True
) -> None:
    """Write the functions ``cost_N``, ``linearise_N``, ``rows_N`` and, if needed, ``guard_N``.

    `ordered` says whether the systems that these are for have entities in the order of `entities`.
    """
    group = kernel.group
    w.line()
    w.line("# " + "-" * 96)
    where = comment(group.where.rpartition("/")[2])  # generated source names no folder
    w.line(f"# {group.label} over {group.table or 'the root'}, {where}")
    w.line(
        f"# {group.residuals} residuals, {len(group.jacobian)} Jacobian entries; operations "
        f"{group.operations_before} before and {group.operations_after} after sharing"
    )
    if kernel.parts is not None:
        emit_large(w, number, kernel, entities)
        return
    _emit_cost(w, number, kernel, entities)
    _emit_both(w, number, kernel, entities, ordered)
    if group.moving_guard is not None:
        _emit_guard(w, number, kernel, group.moving_guard, entities)


def _inputs(kernel: Kernel) -> list[str]:
    """Names of the inputs of the kernel's tapes inside the loop over lanes."""
    group = kernel.group
    return [
        *(f"x[{k}][w]" for k in range(len(group.states))),
        *(f"d[{k} * W + w]" for k in range(group.data_count)),
        *(f"u{k}" for k in range(group.uniform_count)),
    ]


def _read(tape: Tape) -> set[int]:
    return {args[0] for op, args in zip(tape.ops, tape.args, strict=True) if op == "input"}


def _head(w: Writer, kernel: Kernel, tape: Tape) -> None:
    """Declare what both kernels need."""
    group = kernel.group
    w.line("cdef Py_ssize_t n = lanes.n, block, w, count")
    w.line("cdef const real* d = <const real*>lanes.data")
    w.line("cdef const int32_t* row = lanes.row")
    if group.states:
        w.line(f"cdef real x[{len(group.states)}][W]")
    first_uniform = len(group.states) + group.data_count
    for k in range(group.uniform_count):
        if first_uniform + k in _read(tape):
            name = comment(kernel.uniform_names[k])
            w.line(f"cdef real u{k} = (<const real*>lanes.uniform)[{k}]  # {name}")


def _gather(w: Writer, kernel: Kernel, tape: Tape, entities: Sequence[Entity]) -> None:
    """Read the states of the entities into lanes."""
    group = kernel.group
    read = _read(tape)
    for use_number, use in enumerate(group.uses):
        wanted = [
            (k, offset)
            for k, (u, offset) in enumerate(group.states)
            if u == use_number and k in read
        ]
        if not wanted:
            continue
        stride = entities[use.entity].state
        start = f"s = <const real*>lanes.state[{use_number}] + <Py_ssize_t>row[{use_number} * W"
        moves = [
            f"x[{k}][w] = s[{offset}]  # {comment(kernel.state_names[k])}" for k, offset in wanted
        ]
        if use_number in group.lead:
            with w.block("if lanes.run[block]:"):
                w.line(f"{start}] * {stride}")
                with w.block("for w in range(W):"):
                    w.lines_of(moves)
            with w.block("else:"), w.block("for w in range(W):"):
                w.line(f"{start} + w] * {stride}")
                w.lines_of(move.partition("  #")[0] for move in moves)
            continue
        with w.block("for w in range(W):"):
            w.line(f"{start} + w] * {stride}")
            w.lines_of(moves)


def _data_legend(w: Writer, kernel: Kernel, tape: Tape) -> None:
    group = kernel.group
    read = _read(tape)
    for k in range(group.data_count):
        if len(group.states) + k in read:
            w.line(f"# d[{k}]: {comment(kernel.data_names[k])}")


def _declare_temporaries(w: Writer, at: int, count: int) -> None:
    """Insert the declarations of ``t0...`` that the statements turned out to need."""
    lines = []
    for start in range(0, count, 12):
        names = ", ".join(f"t{i}" for i in range(start, min(start + 12, count)))
        lines.append("    cdef real " + names)
    w.lines[at:at] = lines


def _emit_cost(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    group, tape = kernel.group, kernel.cost
    r = group.residuals
    with w.block(f"cdef double cost_{number}(const Lanes* lanes) noexcept nogil:"):
        _head(w, kernel, tape)
        w.line("cdef const real* s")
        w.line(f"cdef real r[{r}][W]")
        w.line("cdef double total[W]")
        w.line("cdef double cost = 0")
        declared = len(w.lines)
        _data_legend(w, kernel, tape)
        w.line("memset(total, 0, sizeof(total))")
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, kernel, tape, entities)
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: [f"r[{i}][w]"], group.places)
            w.line("count = min(n - block * W, W)")
            _add_squares(w, [f"r[{k}][w]" for k in range(r)])
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {len(group.uses)} * W")
        with w.block("for w in range(W):"):
            w.line("cost += total[w]")
        w.line("return cost")
    _declare_temporaries(w, declared, used)
    w.line()


def _add_squares(w: Writer, residuals: list[str]) -> None:
    squares = " + ".join(f"<double>{r} * <double>{r}" for r in residuals)
    with w.block("for w in range(count):"):
        w.line(f"total[w] += {squares}")


def _emit_guard(
    w: Writer, number: int, kernel: Kernel, tape: Tape, entities: Sequence[Entity]
) -> None:
    group = kernel.group
    with w.block(f"cdef void guard_{number}(const Lanes* lanes) noexcept nogil:"):
        _head(w, kernel, tape)
        w.line("cdef const real* s")
        w.line("cdef real* acts = <real*>lanes.data")
        declared = len(w.lines)
        _data_legend(w, kernel, tape)
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, kernel, tape, entities)
            at = f"acts[{group.data_count - 1} * W + w]"
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: [at], group.places)
            w.line(f"d += {group.data_count} * W")
            w.line(f"acts += {group.data_count} * W")
            w.line(f"row += {len(group.uses)} * W")
    _declare_temporaries(w, declared, used)
    w.line()


def _emit_both(
    w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity], ordered: bool
) -> None:
    """Write ``evaluate_N``, which accumulates or writes rows, and the two faces of it."""
    group, tape = kernel.group, kernel.linearise
    r, entries = group.residuals, len(group.jacobian)
    plan = make_plan(kernel, entities, ordered)
    accumulate.emit_settle(w, number, plan)
    with w.block(
        f"cdef double evaluate_{number}(const Lanes* lanes, real* gradient, real* values, "
        "real* residuals, real* entries) noexcept nogil:"
    ):
        _head(w, kernel, tape)
        w.line("cdef const real* s")
        w.line("cdef const int32_t* gradient_at = lanes.gradient_at")
        w.line("cdef const int64_t* block_at = lanes.block_at")
        w.line("cdef const uint8_t* turn = lanes.turn")
        w.line("cdef const uint8_t* first = lanes.first")
        w.line("cdef real* h")
        if plan.shared:
            w.line(f"cdef real o[{plan.shared}][W]")
        accumulate.declare(w, plan)
        w.line("cdef double total[W]")
        w.line("cdef double cost = 0")
        declared = len(w.lines)
        _data_legend(w, kernel, tape)
        w.line("memset(total, 0, sizeof(total))")
        accumulate.emit_start(w, plan)
        with w.block("for block in range((n + W - 1) // W):"):
            accumulate.emit_fetch(w, plan)
            _gather(w, kernel, tape, entities)
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: plan.outputs[i], group.places)
            w.line("count = min(n - block * W, W)")
            with w.block("if entries != NULL:"), w.block("for w in range(count):"):
                for k in range(r):
                    w.line(f"residuals[{k}] = {plan.sources[k]}")
                for k in range(entries):
                    w.line(f"entries[{k}] = {plan.sources[r + k]}")
                w.line(f"residuals += {r}")
                w.line(f"entries += {entries}")
            with w.block("else:"):
                _add_squares(w, plan.sources[:r])
                accumulate.emit_block(w, number, plan)
            uses = len(group.uses)
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {uses} * W")
            w.line(f"gradient_at += {uses} * W")
            pairs = pair_count(uses)
            w.line(f"block_at += {pairs} * W")
            w.line(f"turn += {pairs} * W")
            w.line(f"first += {pairs}")
        accumulate.emit_end(w, number, plan)
        with w.block("for w in range(W):"):
            w.line("cost += total[w]")
        w.line("return cost")
    _declare_temporaries(w, declared, used)
    w.line()
    with w.block(
        f"cdef double linearise_{number}(const Lanes* lanes, void* gradient, void* values) "
        "noexcept nogil:"
    ):
        w.line(f"return evaluate_{number}(lanes, <real*>gradient, <real*>values, NULL, NULL)")
    w.line()
    with w.block(
        f"cdef void rows_{number}(const Lanes* lanes, void* residuals, void* entries) "
        "noexcept nogil:"
    ):
        w.line(f"evaluate_{number}(lanes, NULL, NULL, <real*>residuals, <real*>entries)")
    w.line()
