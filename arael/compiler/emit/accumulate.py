"""Code that adds a block of lanes to gradient and Hessian, by the three methods of `scatter`."""

from __future__ import annotations

from arael.compiler.emit.scatter import Plan, Target
from arael.compiler.emit.writer import Writer

# Columns that `add_rows` may read behind the last one: a tile of f32 has 8.
PADDING = 7

# Scalars of a cache line, of doubles.
LINE = 8


def _columns(plan: Plan) -> list[str]:
    """Distinct columns that are accumulated, without their signs."""
    columns = [plan.sources[at] for target in plan.accumulated for at in target.entries.values()]
    return list(dict.fromkeys(source.removeprefix("-") for source in columns))


def _pointer(target: Target) -> str:
    """Name of the pointer to an accumulated target."""
    return f"lead_g{target.a}" if target.b is None else f"lead_h{target.pair}"


def emit_settle(w: Writer, number: int, plan: Plan) -> None:
    """Write ``settle_N``: add the sums over lanes to the arrays and reset them to zero."""
    columns = _columns(plan)
    if not columns:
        return
    count = len(columns)
    pointers = "".join(f", real* {_pointer(t)}" for t in plan.accumulated)
    with w.block(f"cdef void settle_{number}(real* sums{pointers}) noexcept nogil:"):
        w.line("cdef Py_ssize_t k, w")
        w.line(f"cdef real o[{count}]")
        with w.block(f"for k in range({count}):"):
            w.line("o[k] = 0")
            with w.block("for w in range(W):"):
                w.line("o[k] += sums[k * W + w]")
                w.line("sums[k * W + w] = 0")
        for target in plan.accumulated:
            for (i, j), at in target.entries.items():
                source = plan.sources[at]
                sign = "-" if source.startswith("-") else "+"
                k = columns.index(source.removeprefix("-"))
                w.line(f"{_pointer(target)}[{i * target.width + j}] {sign}= o[{k}]")
    w.line()


def declare(w: Writer, plan: Plan) -> None:
    """Declare sums, columns and rows."""
    columns = _columns(plan)
    if columns:
        w.line("cdef int32_t held = -1")
        w.line(f"cdef real sums[{len(columns)} * W]")
        for target in plan.accumulated:
            w.line(f"cdef real* {_pointer(target)} = NULL")
    if plan.columns:
        w.line(f"cdef real q[{plan.columns + PADDING}][W]")
        w.line(f"cdef real spare[{max(t.size for t, _ in plan.whole)}]")
        w.line("cdef real* at[W]")


def emit_start(w: Writer, plan: Plan) -> None:
    """Write the code before the loop over blocks."""
    if not _columns(plan) and not plan.columns:
        return
    with w.block("if derive:"):
        if _columns(plan):
            w.line("memset(sums, 0, sizeof(sums))")
        if plan.columns:
            w.line("memset(q, 0, sizeof(q))")
            w.line("memset(spare, 0, sizeof(spare))")


def emit_fetch(w: Writer, plan: Plan) -> None:
    """Write the prefetching of blocks during the arithmetic.

    Instances are sorted by the lead, so the other blocks are accessed in scattered order.
    """
    targets = [t for t, _ in plan.whole if t.b is not None and t.a != t.b]
    if not targets or not _columns(plan):
        return
    with w.block("if derive and values != NULL:"), w.block("for w in range(W):"):
        for target in targets:
            w.line(f"h = {_place(target)}")
            last = target.size - 1
            for k in (*range(0, last, LINE), last):
                w.line(f"fetch(h + {k})")


def emit_block(w: Writer, number: int, plan: Plan) -> None:
    """Write the addition of one block of lanes."""
    columns = _columns(plan)
    if columns:
        lead = plan.lead
        with w.block("if lanes.run[block]:"):
            with w.block(f"if gradient_at[{lead} * W] != held:"):
                _settle(w, number, plan)
                w.line(f"held = gradient_at[{lead} * W]")
                for target in plan.accumulated:
                    w.line(f"{_pointer(target)} = {_place(target, lane='')}")
            with w.block("for w in range(W):"):
                for k, column in enumerate(columns):
                    w.line(f"sums[{k} * W + w] += {column}")
        with w.block("else:"), w.block("for w in range(count):"):
            for target in plan.accumulated:
                _add_scalars(w, target, plan)
    for target, first in plan.whole:
        _add_whole(w, target, first, plan)
    if plan.single:
        with w.block("for w in range(count):"):
            for target in plan.single:
                _add_scalars(w, target, plan)


def emit_end(w: Writer, number: int, plan: Plan) -> None:
    """Write the code after the loop over blocks."""
    if _columns(plan):
        with w.block("if derive:"):
            _settle(w, number, plan)


def _settle(w: Writer, number: int, plan: Plan) -> None:
    pointers = "".join(f", {_pointer(t)}" for t in plan.accumulated)
    with w.block("if held >= 0:"):
        w.line(f"settle_{number}(sums{pointers})")


def _place(target: Target, lane: str = " + w") -> str:
    if target.b is None:
        return f"gradient + gradient_at[{target.a} * W{lane}]"
    return f"values + block_at[{target.pair} * W{lane}]"


def _add_whole(w: Writer, target: Target, first: int, plan: Plan) -> None:
    """Add rows to the target of each lane; padding lanes add to unused cells."""
    straight = f" and turn[{target.pair} * W + w] == 0" if target.varies else ""
    with w.block("for w in range(W):"):
        w.line(f"at[w] = {_place(target)} if w < count{straight} else spare")
    if target.is_crossed:
        with w.block(f"if first[{target.pair}]:"):
            w.line(f"put_rows({target.size}, q[{first}], at)")
        with w.block("else:"):
            w.line(f"add_rows({target.size}, q[{first}], at)")
    else:
        w.line(f"add_rows({target.size}, q[{first}], at)")
    if target.varies:
        with w.block("for w in range(count):"), w.block(f"if turn[{target.pair} * W + w] != 0:"):
            w.line(f"h = {_place(target)}")
            _empty(w, target)
            _add_turned(w, target, {p: plan.sources[o] for p, o in target.entries.items()})


def _add_scalars(w: Writer, target: Target, plan: Plan) -> None:
    w.line(f"h = {_place(target)}")
    sources = {place: plan.sources[at] for place, at in target.entries.items()}
    lines = [f"h[{i * target.width + j}] += {s}" for (i, j), s in sources.items()]
    if not target.varies:
        if target.is_crossed and len(sources) == target.size:
            with w.block(f"if first[{target.pair}]:"):
                w.lines_of(line.replace("+=", "=") for line in lines)
            with w.block("else:"):
                w.lines_of(lines)
            return
        _empty(w, target)
        w.lines_of(lines)
        return
    _empty(w, target)
    with w.block(f"if turn[{target.pair} * W + w] == 0:"):
        w.lines_of(lines)
    with w.block("else:"):
        _add_turned(w, target, sources)


def _empty(w: Writer, target: Target) -> None:
    """Write the zeroing of a block before its first writer adds to it."""
    if target.is_crossed:
        with w.block(f"if first[{target.pair}]:"):
            w.line(f"memset(h, 0, {target.size} * sizeof(real))")


def _add_turned(w: Writer, target: Target, sources: dict[tuple[int, int], str]) -> None:
    """Add to a block that is stored transposed, or on the diagonal."""
    with w.block(f"if turn[{target.pair} * W + w] == 1:"):
        w.lines_of(f"h[{j * target.height + i}] += {s}" for (i, j), s in sources.items())
    with w.block("else:"):
        for (i, j), source in sources.items():
            w.line(f"h[{max(i, j) * target.width + min(i, j)}] += {source}")
            if i == j:
                w.line(f"h[{i * target.width + j}] += {source}")
