"""Kernels of one constraint that is too large for one function.

The arithmetic is in parts (`arael.compiler.parts`), each a function on columns of a workspace. The
functions in front of them are the same as those of other constraints; what would be a statement per
scalar there is a loop over a table here, and the products J'r and J'J are formed by the loops of
``add_products`` (``arael/runtime/lanes.h``) over the Jacobian as it is known to be filled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from arael.compiler.emit.names import emit_inputs, jacobian_names
from arael.compiler.emit.operators import expression, literal
from arael.compiler.emit.writer import Writer, comment, described
from arael.compiler.groups import Kernel
from arael.compiler.parts import Part, Parts, cut
from arael.compiler.runs import formula
from arael.runtime.layout import Entity, pair_count, pair_of
from arael.runtime.machine.tape import Tape


def emit_large(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    """Write ``cost_N``, ``linearise_N``, ``rows_N``, and what data is written by."""
    group = kernel.group
    parts = kernel.parts
    assert parts is not None
    emit_inputs(w, kernel, "v")
    notes = _legend(w, kernel, parts, entities)
    _tables(w, number, kernel, entities)
    _emit_parts(w, number, kernel, kernel.linearise, parts, ("residual", "jacobian"), notes)
    _evaluate(w, number, kernel, entities, parts)
    for name, tape, columns in group.written:
        written = cut(tape, len(columns), len(group.states))
        _emit_parts(w, number, kernel, tape, written, (name, name), {})
        _written(w, number, kernel, entities, written, name, columns)


def _legend(w: Writer, kernel: Kernel, parts: Parts, entities: Sequence[Entity]) -> dict[int, str]:
    """Write the contents of the workspace's columns; return the names of results by column."""
    group, first = kernel.group, parts.first
    middle, end = first + group.residuals, first + group.residuals + len(group.jacobian)
    w.line("# Columns of the workspace")
    for start, stop, text in (
        (first, middle, "residuals"),
        (middle, end, "Jacobian, by residual and parameter"),
        (end, parts.width, "values that a later part reads"),
    ):
        if stop > start:
            w.line(f"#     v[{start}] to v[{stop - 1}]  {text}")
    names = [*(f"r{k}" for k in range(group.residuals)), *jacobian_names(group, entities)]
    return {first + k: name for k, name in enumerate(names)}


def _tables(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    """Write which scalars of a state are read, and how the Jacobian is filled."""
    group = kernel.group
    uses = len(group.uses)
    runs, ends = jacobian_runs(group.jacobian, group.residuals)
    coupled = [0] * pair_count(uses)
    for k in range(group.residuals):
        found = {use for use, _, _, _ in runs[ends[k] : ends[k + 1]]}
        for a in found:
            for b in found:
                coupled[pair_of(a, b)] = 1
    tables = {
        "offsets": [offset for _, offset in group.states],
        "ends": ends,
        "widths": [entities[use.entity].tangent for use in group.uses],
        "leads": [int(use in group.lead) for use in range(uses)],
        "coupled": coupled,
    }
    with w.block("cdef extern from *:"):
        w.line('"""')
        for name, values in tables.items():
            listed = ", ".join(map(str, values)) or "0"
            w.line(f"static const int {name}_{number}[] = {{{listed}}};")
        listed = ", ".join(f"{{{', '.join(map(str, run))}}}" for run in runs) or "{0, 0, 0, 0}"
        w.line(f"static const int runs_{number}[][4] = {{{listed}}};")
        w.line(f"static const arael_jacobian filled_{number} = {{")
        w.line(
            f"    {group.residuals}, {len(group.jacobian)}, {uses}, runs_{number}, ends_{number}, "
            f"widths_{number}, leads_{number}, coupled_{number}}};"
        )
        w.line('"""')
        w.line(f"const int offsets_{number}[]")
        w.line(f"const arael_jacobian filled_{number}")
    w.line()


def jacobian_runs(
    jacobian: Sequence[tuple[int, int, int]], residuals: int
) -> tuple[list[tuple[int, int, int, int]], list[int]]:
    """Runs of consecutive entries, and where those of each residual end.

    Parameters
    ----------
    jacobian : (residual, use, tangent) of each entry, by residual, use and tangent

    Returns
    -------
    (use, first tangent, first entry, entries) of each run, and a list that begins with 0
    """
    runs: list[list[int]] = []
    ends = [0] * (residuals + 1)
    before: tuple[int, int, int] | None = None
    for entry, (residual, use, tangent) in enumerate(jacobian):
        if before == (residual, use, tangent - 1):
            runs[-1][3] += 1
        else:
            runs.append([use, tangent, entry, 1])
        before = residual, use, tangent
        ends[residual + 1] = len(runs)
    for k in range(residuals):
        ends[k + 1] = max(ends[k], ends[k + 1])
    return [(use, tangent, entry, count) for use, tangent, entry, count in runs], ends


def _emit_parts(
    w: Writer,
    number: int,
    kernel: Kernel,
    tape: Tape,
    parts: Parts,
    names: tuple[str, str],
    notes: Mapping[int, str],
) -> None:
    """Write the function of each part; the leading ones are called ``names[0]_N_k``.

    `notes` are the names of results by their column.
    """
    for k, part in enumerate(parts.parts):
        name, at = _part_name(parts, k, names)
        last = parts.leading if k < parts.leading else len(parts.parts) - parts.leading
        w.line(f"# {name}, part {at + 1} of {last}")
        with w.block(
            f"cdef arael_part {name}_{number}_{at}(const Lanes* lanes, arael_data d, "
            "arael_columns v) noexcept nogil:"
        ):
            _part(w, kernel, tape, parts, part, notes)
        w.line()


def _part_name(parts: Parts, k: int, names: tuple[str, str]) -> tuple[str, int]:
    return (names[0], k) if k < parts.leading else (names[1], k - parts.leading)


def _part(
    w: Writer, kernel: Kernel, tape: Tape, parts: Parts, part: Part, notes: Mapping[int, str]
) -> None:
    """Write the body of a part: local temporaries, columns for values that other parts read."""
    group = kernel.group
    states, data = len(group.states), group.data_count
    names = {node: f"t{k}" for k, node in enumerate(part.nodes)}
    uniforms: dict[int, str] = {}

    def name(node: int) -> str:
        op, args = tape.ops[node], tape.args[node]
        if op == "neg":
            return f"(-{name(args[0])})"
        if op == "const":
            return literal(tape.constants[args[0]])
        if op != "input":
            return names.get(node) or f"v[{parts.columns[node][0]} * W + w]"
        if args[0] < states:
            return f"v[{args[0]} * W + w]"
        if args[0] < states + data:
            return f"d[{args[0] - states} * W + w]"
        return uniforms.setdefault(args[0], f"u{args[0] - states - data}")

    def moving(number: int, step: str) -> str:
        if number < states:
            return f"v[({number}{step}) * W + w]"
        if number < states + data:
            return f"d[({number - states}{step}) * W + w]"
        return f"(<const real*>lanes.uniform)[{number - states - data}{step}]"

    def beside(column: int) -> str:
        return f"  # {comment(notes[column])}" if column in notes else ""

    body = Writer()
    body.depth = w.depth + 1
    written = -1
    for node in part.nodes:
        place = tape.places[node] if tape.places else -1
        if place >= 0 and place != written:
            body.line(f"# {described(group.places[place])}")
            written = place
        value = expression(tape.ops[node], [name(a) for a in tape.args[node]])
        body.line(f"{names[node]} = {value}")
        for column in parts.columns.get(node, ()):
            body.line(f"v[{column} * W + w] = {names[node]}{beside(column)}")
    for column, node in part.stores:
        body.line(f"v[{column} * W + w] = {name(node)}{beside(column)}")
    loops = [(run, formula(tape, run, moving)) for run in part.runs]
    w.line("cdef Py_ssize_t w, i" if loops else "cdef Py_ssize_t w")
    for number, text in uniforms.items():
        k = number - states - data
        legend = comment(kernel.uniform_names[k])
        w.line(f"cdef real {text} = (<const real*>lanes.uniform)[{k}]  # {legend}")
    w.lines_of(declarations(len(part.nodes)))
    for run, text in loops:
        column = parts.first + run.first
        ends = [notes[k] for k in (column, column + run.count - 1) if k in notes]
        if ends:
            w.line(f"# {comment(' to '.join(ends))}")
        with w.block(f"for i in range({run.count}):"), w.block("for w in range(W):"):
            w.line(f"v[({column} + i) * W + w] = {text}")
    if body.lines:
        with w.block("for w in range(W):"):
            w.lines.extend(body.lines)


def declarations(count: int) -> list[str]:
    """Lines that declare temporaries ``t0...``."""
    return [
        "cdef real " + ", ".join(f"t{i}" for i in range(start, min(start + 12, count)))
        for start in range(0, count, 12)
    ]


def _head(w: Writer, kernel: Kernel, width: int) -> None:
    w.line("cdef Py_ssize_t n = lanes.n, block, w, k, count")
    w.line("cdef const real* d = <const real*>lanes.data")
    w.line("cdef const int32_t* row = lanes.row")
    w.line("cdef const real* s")
    w.line(f"cdef real v[{width} * W]")


def _gather(w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity]) -> None:
    """Read the states of the entities into the workspace."""
    group = kernel.group
    for u, use in enumerate(group.uses):
        mine = [k for k, (owner, _) in enumerate(group.states) if owner == u]
        if not mine:
            continue
        stride = entities[use.entity].state
        start = f"s = <const real*>lanes.state[{u}] + <Py_ssize_t>row[{u} * W"
        each = f"for k in range({mine[0]}, {mine[-1] + 1}):"
        move = f"v[k * W + w] = s[offsets_{number}[k]]"
        if u in group.lead:
            with w.block("if lanes.run[block]:"):
                w.line(f"{start}] * {stride}")
                with w.block(each), w.block("for w in range(W):"):
                    w.line(move)
            with w.block("else:"), w.block("for w in range(W):"):
                w.line(f"{start} + w] * {stride}")
                with w.block(each):
                    w.line(move)
        else:
            with w.block("for w in range(W):"):
                w.line(f"{start} + w] * {stride}")
                with w.block(each):
                    w.line(move)


def _calls(w: Writer, number: int, parts: Parts, names: tuple[str, str], which: range) -> None:
    for k in which:
        name, at = _part_name(parts, k, names)
        w.line(f"{name}_{number}_{at}(lanes, d, v)")


def _evaluate(
    w: Writer, number: int, kernel: Kernel, entities: Sequence[Entity], parts: Parts
) -> None:
    group = kernel.group
    r, entries, uses = group.residuals, len(group.jacobian), len(group.uses)
    first = len(group.states)
    names = ("residual", "jacobian")
    with w.block(
        f"cdef double evaluate_{number}(const Lanes* lanes, bint derive, real* gradient, "
        "real* values, real* residuals, real* entries, double* costs) noexcept nogil:"
    ):
        _head(w, kernel, parts.width)
        w.line(f"cdef real jacobian[{max(entries, 1)} * W]")
        w.line("cdef const int32_t* gradient_at = lanes.gradient_at")
        w.line("cdef const int64_t* block_at = lanes.block_at")
        w.line("cdef const uint8_t* turn = lanes.turn")
        w.line("cdef const uint8_t* first = lanes.first")
        w.line("cdef double total[W]")
        w.line("cdef double cost = 0")
        w.line("memset(total, 0, sizeof(total))")
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, number, kernel, entities)
            _calls(w, number, parts, names, range(parts.leading))
            w.line("count = min(n - block * W, W)")
            with w.block("if costs == NULL:"):
                _squares(w, range(first, first + r), "total")
            with w.block("else:"):
                w.line("memset(costs, 0, count * sizeof(double))")
                _squares(w, range(first, first + r), "costs")
                w.line("costs = &costs[W]")
            with w.block("if derive:"):
                _calls(w, number, parts, names, range(parts.leading, len(parts.parts)))
                with w.block("if entries != NULL:"), w.block("for w in range(count):"):
                    with w.block(f"for k in range({r}):"):
                        w.line(f"residuals[k] = v[({first} + k) * W + w]")
                    with w.block(f"for k in range({entries}):"):
                        w.line(f"entries[k] = v[({first + r} + k) * W + w]")
                    w.line(f"residuals += {r}")
                    w.line(f"entries += {entries}")
                with w.block("else:"):
                    w.line(
                        f"add_products(&filled_{number}, v + {first} * W, jacobian, count, "
                        "lanes.run[block],"
                    )
                    w.line("             gradient, values, gradient_at, block_at, turn, first)")
                w.line(f"gradient_at += {uses} * W")
                pairs = pair_count(uses)
                w.line(f"block_at += {pairs} * W")
                w.line(f"turn += {pairs} * W")
                w.line(f"first += {pairs}")
            w.line(f"d += {group.data_count} * W")
            w.line(f"row += {uses} * W")
        with w.block("for w in range(W):"):
            w.line("cost += total[w]")
        w.line("return cost")
    w.line()
    with w.block(f"cdef double cost_{number}(const Lanes* lanes, double* costs) noexcept nogil:"):
        w.line(f"return evaluate_{number}(lanes, False, NULL, NULL, NULL, NULL, costs)")
    w.line()
    with w.block(
        f"cdef double linearise_{number}(const Lanes* lanes, void* gradient, void* values) "
        "noexcept nogil:"
    ):
        w.line(f"return evaluate_{number}(")
        w.line("    lanes, True, <real*>gradient, <real*>values, NULL, NULL, NULL)")
    w.line()
    with w.block(
        f"cdef void rows_{number}(const Lanes* lanes, void* residuals, void* entries) "
        "noexcept nogil:"
    ):
        w.line(f"evaluate_{number}(")
        w.line("    lanes, True, NULL, NULL, <real*>residuals, <real*>entries, NULL)")
    w.line()


def _squares(w: Writer, columns: range, into: str) -> None:
    """Write the sum of the squares of residuals by lane."""
    each = w.block(f"for k in range({columns.start}, {columns.stop}):")
    with each, w.block("for w in range(count):"):
        w.line(f"{into}[w] += <double>v[k * W + w] * <double>v[k * W + w]")


def _written(
    w: Writer,
    number: int,
    kernel: Kernel,
    entities: Sequence[Entity],
    parts: Parts,
    name: str,
    columns: Sequence[int],
) -> None:
    """Write a function that stores the results of parts into columns of the data."""
    group = kernel.group
    with w.block(f"cdef void {name}_{number}(const Lanes* lanes) noexcept nogil:"):
        _head(w, kernel, parts.width)
        w.line("cdef real* acts = <real*>lanes.data")
        with w.block("for block in range((n + W - 1) // W):"):
            _gather(w, number, kernel, entities)
            _calls(w, number, parts, (name, name), range(len(parts.parts)))
            with w.block("for w in range(W):"):
                for k, column in enumerate(columns, len(group.states)):
                    w.line(f"acts[{column} * W + w] = v[{k} * W + w]")
            w.line(f"d += {group.data_count} * W")
            w.line(f"acts += {group.data_count} * W")
            w.line(f"row += {len(group.uses)} * W")
    w.line()
