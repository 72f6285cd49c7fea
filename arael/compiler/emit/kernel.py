"""Kernels of one constraint: cost, and linearisation with its products, on lanes of W instances.

A block of W instances is gathered into arrays of W-wide columns, all arithmetic runs in one loop
over the lanes that touches only such arrays (so the C compiler can vectorise it), and the results
are scattered into gradient and Hessian blocks.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.compiler.emit.writer import Writer, comment, statements
from arael.compiler.groups import Kernel
from arael.runtime.layout import Entity
from arael.runtime.tape import Tape


def emit_constraint(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    """Write the functions ``cost_N``, ``linearise_N``, ``rows_N`` and, if needed, ``guard_N``."""
    group = kernel.group
    w.line()
    w.line("# " + "-" * 96)
    w.line(f"# {group.label} over {group.table or 'the root'}, {comment(group.where)}")
    w.line(
        f"# {group.residuals} residuals, {len(group.jacobian)} Jacobian entries; operations "
        f"{group.operations_before} before and {group.operations_after} after sharing"
    )
    _emit_cost(w, number, kernel, entities)
    _emit_both(w, number, kernel, entities)
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
        with w.block("for w in range(W):"):
            w.line(
                f"s = <const real*>lanes.state[{use_number}] "
                f"+ <Py_ssize_t>row[{use_number} * W + w] * {stride}"
            )
            for k, offset in wanted:
                w.line(f"x[{k}][w] = s[{offset}]  # {comment(kernel.state_names[k])}")


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
        with w.block("for w in range(W):"):
            w.line("total[w] = 0")
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, kernel, tape, entities)
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: [f"r[{i}][w]"], group.places)
            squares = " + ".join(f"<double>r[{k}][w] * <double>r[{k}][w]" for k in range(r))
            w.line("count = min(n - block * W, W)")
            with w.block("for w in range(count):"):
                w.line(f"total[w] += {squares}")
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {len(group.uses)} * W")
        with w.block("for w in range(W):"):
            w.line("cost += total[w]")
        w.line("return cost")
    _declare_temporaries(w, declared, used)
    w.line()


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


def _emit_both(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    """Write ``evaluate_N``, which accumulates or writes rows, and the two faces of it."""
    group, tape = kernel.group, kernel.linearise
    r, entries = group.residuals, len(group.jacobian)
    targets, sources, count = _targets(kernel)
    with w.block(
        f"cdef double evaluate_{number}(const Lanes* lanes, real* gradient, real* values, "
        "real* residuals, real* entries) noexcept nogil:"
    ):
        _head(w, kernel, tape)
        w.line("cdef const real* s")
        w.line("cdef const int32_t* gradient_at = lanes.gradient_at")
        w.line("cdef const int64_t* block_at = lanes.block_at")
        w.line("cdef const uint8_t* turn = lanes.turn")
        w.line("cdef real* g")
        w.line("cdef real* h")
        w.line(f"cdef real o[{max(count, 1)}][W]")
        if kernel.rolled:
            _declare_rolled(w, kernel, entities)
        w.line("cdef double cost = 0")
        declared = len(w.lines)
        _data_legend(w, kernel, tape)
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, kernel, tape, entities)
            with w.block("for w in range(W):"):
                used = statements(w, tape, _inputs(kernel), lambda i: targets[i], group.places)
            w.line("count = min(n - block * W, W)")
            with w.block("if entries != NULL:"), w.block("for w in range(count):"):
                for k in range(r):
                    w.line(f"residuals[{k}] = {sources[k]}")
                for k in range(entries):
                    w.line(f"entries[{k}] = {sources[r + k]}")
                w.line(f"residuals += {r}")
                w.line(f"entries += {entries}")
            with w.block("else:"):
                if kernel.rolled:
                    _rolled_products(w, kernel, entities, sources)
                with w.block("for w in range(count):"):
                    squares = " + ".join(
                        f"<double>{sources[k]} * <double>{sources[k]}" for k in range(r)
                    )
                    w.line(f"cost += {squares}")
                    _scatter(w, kernel, entities, sources)
            uses = len(group.uses)
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {uses} * W")
            w.line(f"gradient_at += {uses} * W")
            w.line(f"block_at += {uses * (uses + 1) // 2} * W")
            w.line(f"turn += {uses * (uses + 1) // 2} * W")
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


def _targets(kernel: Kernel) -> tuple[dict[int, list[str]], list[str], int]:
    """Where each output of the linearisation is kept, and from where it is read.

    Outputs that are the same node share one column of ``o``; one that is the negative of another is
    read with a minus sign; constants are written in place.
    """
    tape = kernel.linearise
    column: dict[int, str] = {}
    targets: dict[int, list[str]] = {i: [] for i in range(len(tape.outputs))}
    sources: list[str] = []
    count = 0
    for i, node in enumerate(tape.outputs):
        sign = ""
        base = node
        if tape.ops[node] == "neg" and tape.args[node][0] in column:
            sign, base = "-", tape.args[node][0]
        if base not in column:
            column[base] = f"o[{count}][w]"
            targets[i].append(column[base])
            count += 1
        sources.append(sign + column[base])
    return targets, sources, count


def _tangents(kernel: Kernel, entities: Sequence[Entity]) -> list[int]:
    return [entities[use.entity].tangent for use in kernel.group.uses]


def _scatter(w: Writer, kernel: Kernel, entities: Sequence[Entity], sources: list[str]) -> None:
    """Add one lane's gradient and products to where they belong."""
    group = kernel.group
    tangent = _tangents(kernel, entities)
    if kernel.rolled:
        gradient = {
            (u, i): f"gr[{_start(tangent, u) + i}][w]"
            for u in range(len(tangent))
            for i in range(tangent[u])
        }
        products = {
            (a, b, i, j): f"hr[{_start(tangent, a) + i}][{_start(tangent, b) + j}][w]"
            for a in range(len(tangent))
            for b in range(a + 1)
            for i in range(tangent[a])
            for j in range(tangent[b] if a != b else i + 1)
        }
    else:
        first = group.residuals + len(group.jacobian)
        gradient = dict(zip(kernel.gradient, sources[first:], strict=False))
        products = dict(zip(kernel.products, sources[first + len(gradient) :], strict=True))
    for u in range(len(group.uses)):
        w.line(f"g = gradient + gradient_at[{u} * W + w]")
        for (use, i), source in gradient.items():
            if use == u:
                w.line(f"g[{i}] += {source}")
    for a in range(len(group.uses)):
        for b in range(a + 1):
            here = {(i, j): s for (x, y, i, j), s in products.items() if (x, y) == (a, b)}
            if not here:
                continue
            pair = a * (a + 1) // 2 + b
            w.line(f"h = values + block_at[{pair} * W + w]")
            if a == b:
                for (i, j), source in here.items():
                    w.line(f"h[{i * tangent[a] + j}] += {source}")
                continue
            with w.block(f"if turn[{pair} * W + w] == 0:"):
                for (i, j), source in here.items():
                    w.line(f"h[{i * tangent[b] + j}] += {source}")
            with w.block(f"elif turn[{pair} * W + w] == 1:"):
                for (i, j), source in here.items():
                    w.line(f"h[{j * tangent[a] + i}] += {source}")
            if group.uses[a].entity == group.uses[b].entity:
                with w.block("else:"):
                    for (i, j), source in here.items():
                        w.line(f"h[{max(i, j) * tangent[a] + min(i, j)}] += {source}")
                        if i == j:
                            w.line(f"h[{i * tangent[a] + j}] += {source}")


def _start(tangent: list[int], use: int) -> int:
    return sum(tangent[:use])


def _declare_rolled(w: Writer, kernel: Kernel, entities: Sequence[Entity]) -> None:
    total = sum(_tangents(kernel, entities))
    r = kernel.group.residuals
    w.line("cdef Py_ssize_t k, i, j")
    w.line(f"cdef real jr[{r}][{total}][W]")
    w.line(f"cdef real gr[{total}][W]")
    w.line(f"cdef real hr[{total}][{total}][W]")


def _rolled_products(
    w: Writer, kernel: Kernel, entities: Sequence[Entity], sources: list[str]
) -> None:
    """J'r and J'J by loops over a dense Jacobian, for constraints too large to spell out."""
    group = kernel.group
    tangent = _tangents(kernel, entities)
    total, r = sum(tangent), group.residuals
    known = {
        (k, _start(tangent, use) + i): sources[r + e]
        for e, (k, use, i) in enumerate(group.jacobian)
    }
    with w.block("for w in range(W):"):
        for k in range(r):
            for i in range(total):
                w.line(f"jr[{k}][{i}][w] = {known.get((k, i), '0')}")
    with w.block(f"for i in range({total}):"):
        with w.block("for w in range(W):"):
            w.line("gr[i][w] = 0")
        with w.block("for j in range(i + 1):"), w.block("for w in range(W):"):
            w.line("hr[i][j][w] = 0")
    for k in range(r):
        with w.block(f"for i in range({total}):"):
            with w.block("for w in range(W):"):
                w.line(f"gr[i][w] += jr[{k}][i][w] * {sources[k]}")
            with w.block("for j in range(i + 1):"), w.block("for w in range(W):"):
                w.line(f"hr[i][j][w] += jr[{k}][i][w] * jr[{k}][j][w]")
