"""Kernels of one constraint: cost, and linearisation with its products, on lanes of W instances.

A block of W instances is gathered into arrays of W-wide columns, all arithmetic runs in one loop
over the lanes that touches only such arrays (so the C compiler can vectorise it), and the results
are added to gradient and Hessian blocks as `scatter` has planned.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from arael.compiler.emit import accumulate
from arael.compiler.emit.large import emit_large
from arael.compiler.emit.names import emit_inputs, emit_title, output_notes
from arael.compiler.emit.scatter import make_plan
from arael.compiler.emit.writer import Statements, Writer, statements
from arael.compiler.groups import Kernel
from arael.compiler.runs import needed
from arael.runtime.layout import Entity, pair_count
from arael.runtime.machine.tape import Tape


def emit_constraint(
    w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity], ordered: bool = True
) -> None:
    """Write the functions ``cost_N``, ``linearise_N``, ``rows_N``, and what data is written by.

    That is ``guard_N`` for a guard over parameters and ``arguments_N`` for look-ups.

    `ordered`: whether the systems of these kernels have entities in the order of `entities`.
    """
    emit_title(w, kernel)
    if kernel.parts is not None:
        emit_large(w, number, kernel, entities)
        return
    emit_inputs(w, kernel)
    _emit_evaluate(w, number, kernel, entities, ordered)
    _emit_functions(w, number)
    for name, tape, columns in kernel.group.written:
        _emit_written(w, f"{name}_{number}", kernel, tape, columns, entities)


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
    """Declare what all kernels need."""
    group = kernel.group
    w.line("cdef Py_ssize_t n = lanes.n, block, w, count")
    w.line("cdef const real* d = <const real*>lanes.data")
    w.line("cdef const int32_t* row = lanes.row")
    if group.states:
        w.line(f"cdef real x[{len(group.states)}][W]")
    first_uniform = len(group.states) + group.data_count
    for k in range(group.uniform_count):
        if first_uniform + k in _read(tape):
            w.line(f"cdef real u{k} = (<const real*>lanes.uniform)[{k}]")


def _gather(w: Writer, kernel: Kernel, reads: Collection[int], entities: Sequence[Entity]) -> None:
    """Gather the states that are among the inputs `reads` into lanes."""
    group = kernel.group
    for use_number, use in enumerate(group.uses):
        wanted = [
            (k, offset)
            for k, (u, offset) in enumerate(group.states)
            if u == use_number and k in reads
        ]
        if not wanted:
            continue
        stride = entities[use.entity].state
        start = f"s = <const real*>lanes.state[{use_number}] + <Py_ssize_t>row[{use_number} * W"
        moves = [f"x[{k}][w] = s[{offset}]" for k, offset in wanted]
        if use_number in group.lead:
            with w.block("if lanes.run[block]:"):
                w.line(f"{start}] * {stride}")
                with w.block("for w in range(W):"):
                    w.lines_of(moves)
            with w.block("else:"), w.block("for w in range(W):"):
                w.line(f"{start} + w] * {stride}")
                w.lines_of(moves)
            continue
        with w.block("for w in range(W):"):
            w.line(f"{start} + w] * {stride}")
            w.lines_of(moves)


def _declare_temporaries(w: Writer, at: int, count: int) -> None:
    """Insert the declarations of ``t0...`` that the statements turned out to need."""
    lines = []
    for start in range(0, count, 12):
        names = ", ".join(f"t{i}" for i in range(start, min(start + 12, count)))
        lines.append("    cdef real " + names)
    w.lines[at:at] = lines


def emit_squares(w: Writer, residuals: list[str]) -> None:
    """Add up the costs of the instances of a block, or store each where `costs` is given."""
    with w.block("if costs == NULL:"):
        _emit_total(w, residuals)
    with w.block("else:"):
        with w.block("for w in range(count):"):
            w.line(f"costs[w] = {_squares(residuals)}")
        w.line("costs = &costs[W]")


def _emit_total(w: Writer, residuals: list[str]) -> None:
    with w.block("for w in range(count):"):
        w.line(f"total[w] += {_squares(residuals)}")


def _squares(residuals: list[str]) -> str:
    return " + ".join(f"<double>{r} * <double>{r}" for r in residuals)


def _emit_written(
    w: Writer,
    name: str,
    kernel: Kernel,
    tape: Tape,
    columns: Sequence[int],
    entities: Sequence[Entity],
) -> None:
    """Write a function that stores the results of a tape into columns of the data."""
    group = kernel.group
    with w.block(f"cdef void {name}(const Lanes* lanes) noexcept nogil:"):
        _head(w, kernel, tape)
        w.line("cdef const real* s")
        w.line("cdef real* acts = <real*>lanes.data")
        declared = len(w.lines)
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, kernel, _read(tape), entities)
            at = [[f"acts[{column} * W + w]"] for column in columns]
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: at[i], group.places)
            w.line(f"d += {group.data_count} * W")
            w.line(f"acts += {group.data_count} * W")
            w.line(f"row += {len(group.uses)} * W")
    _declare_temporaries(w, declared, used)
    w.line()


def _emit_evaluate(
    w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity], ordered: bool
) -> None:
    """Write ``evaluate_N``: the cost and, with `derive`, what is accumulated or rows.

    It is compiled twice, inlined with and without `derive`, so a cost computes
    nothing that only derivatives need.
    """
    group, tape = kernel.group, kernel.linearise
    r, entries = group.residuals, len(group.jacobian)
    plan = make_plan(kernel, entities, ordered)
    sections = _sections(tape, r, entries)
    first_reads = {
        tape.args[node][0]
        for name, nodes, _ in sections
        for node in nodes
        if name in _OF_COST and tape.ops[node] == "input"
    }
    accumulate.emit_settle(w, number, plan)
    with w.block(
        f"cdef arael_inlined evaluate_{number}(const Lanes* lanes, bint derive, real* gradient, "
        "real* values, real* residuals, real* entries, double* cost, double* costs) "
        "noexcept nogil:"
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
        declared = len(w.lines)
        w.line("memset(total, 0, sizeof(total))")
        accumulate.emit_start(w, plan)
        with w.block("for block in range((n + W - 1) // W):"):
            accumulate.emit_fetch(w, plan)
            _gather(w, kernel, first_reads, entities)
            late = _read(tape) - first_reads
            if late & set(range(len(group.states))):
                with w.block("if derive:"):
                    _gather(w, kernel, late, entities)
            with w.block("for w in range(W):"):
                notes = output_notes(kernel, plan, entities)
                written = Statements(
                    w, tape, _inputs(kernel), lambda i: plan.outputs[i], group.places, notes
                )
                _write_sections(w, written, [s for s in sections if s[0] in _OF_COST])
                with w.block("if derive:"):
                    _write_sections(w, written, [s for s in sections if s[0] not in _OF_COST])
            w.line("count = min(n - block * W, W)")
            # After the products of one residual: before them, the kernel of `linear` takes a tenth
            # more time (GCC 12, AVX-512). That of `bundle_adjustment`, with two, takes an eighth
            # more if they are added up after its products.
            last = r == 1
            if last:
                with w.block("if not derive:"):
                    emit_squares(w, plan.sources[:r])
            else:
                emit_squares(w, plan.sources[:r])
            with w.block("if derive:"):
                with w.block("if entries != NULL:"), w.block("for w in range(count):"):
                    for k in range(r):
                        w.line(f"residuals[{k}] = {plan.sources[k]}")
                    for k in range(entries):
                        w.line(f"entries[{k}] = {plan.sources[r + k]}")
                    w.line(f"residuals += {r}")
                    w.line(f"entries += {entries}")
                with w.block("else:"):
                    mark = len(w.lines)
                    accumulate.emit_block(w, number, plan)
                    if last:
                        _emit_total(w, plan.sources[:r])
                    if len(w.lines) == mark:
                        w.line("pass")
                uses = len(group.uses)
                w.line(f"gradient_at += {uses} * W")
                pairs = pair_count(uses)
                w.line(f"block_at += {pairs} * W")
                w.line(f"turn += {pairs} * W")
                w.line(f"first += {pairs}")
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {uses} * W")
        accumulate.emit_end(w, number, plan)
        with w.block("for w in range(W):"):
            w.line("cost[0] += total[w]")
    _declare_temporaries(w, declared, written.temporaries)
    w.line()


def _emit_functions(w: Writer, number: int) -> None:
    """Write the functions in the table of kernels, and what two of them share."""
    with w.block(f"cdef double cost_{number}(const Lanes* lanes, double* costs) noexcept nogil:"):
        w.line("cdef double cost = 0")
        w.line(f"evaluate_{number}(lanes, False, NULL, NULL, NULL, NULL, &cost, costs)")
        w.line("return cost")
    w.line()
    with w.block(
        f"cdef double derive_{number}(const Lanes* lanes, real* gradient, real* values, "
        "real* residuals, real* entries) noexcept nogil:"
    ):
        w.line("cdef double cost = 0")
        w.line(f"evaluate_{number}(lanes, True, gradient, values, residuals, entries, &cost, NULL)")
        w.line("return cost")
    w.line()
    with w.block(
        f"cdef double linearise_{number}(const Lanes* lanes, void* gradient, void* values) "
        "noexcept nogil:"
    ):
        w.line(f"return derive_{number}(lanes, <real*>gradient, <real*>values, NULL, NULL)")
    w.line()
    with w.block(
        f"cdef void rows_{number}(const Lanes* lanes, void* residuals, void* entries) "
        "noexcept nogil:"
    ):
        w.line(f"derive_{number}(lanes, NULL, NULL, <real*>residuals, <real*>entries)")
    w.line()


_OF_COST = ("shared", "residual")


def _sections(tape: Tape, residuals: int, entries: int) -> list[tuple[str, list[int], range]]:
    """Nodes and outputs of a linearisation by section.

    What residuals share with derivatives comes first, then the rest of the residuals, so that a
    cost is the first two sections. No
    section depends on later ones.
    """
    outputs = tape.outputs
    of_residuals = needed(tape, outputs[:residuals])
    of_jacobian = needed(tape, outputs[residuals : residuals + entries])
    shared, jacobian = of_residuals & of_jacobian, of_jacobian - of_residuals
    products = set(range(len(tape.ops))) - of_residuals - of_jacobian
    end = residuals + entries
    return [
        ("shared", sorted(shared), range(0)),
        ("residual", sorted(of_residuals - shared), range(residuals)),
        ("Jacobian", sorted(jacobian), range(residuals, end)),
        ("products", sorted(products), range(end, len(outputs))),
    ]


def _write_sections(
    w: Writer, written: Statements, sections: Sequence[tuple[str, list[int], range]]
) -> None:
    before = len(w.lines)
    for name, nodes, outputs in sections:
        mark = len(w.lines)
        written.write(nodes, outputs)
        if len(w.lines) > mark:
            w.lines.insert(mark, "    " * w.depth + f"# {name}")
    if len(w.lines) == before:
        w.line("pass")
