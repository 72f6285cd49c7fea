"""Trees of dataclasses as indented text, for the early stages in `arael emit`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import Source, Span
from arael.runtime.layout import Group, Layout, Raw, RowSums, Use
from arael.runtime.machine.tape import Tape

if TYPE_CHECKING:
    from arael.compiler.compiler import Program
    from arael.compiler.groups import Kernel


_MAX_INDENT = 200
_MAX_LINES = 100_000


def outline(node: Any) -> str:
    """Text of a tree of dataclasses, one line per node, without spans.

    Below 100 levels, and after `_MAX_LINES` lines, ``...`` stands for the rest: a long sum is a
    left-deep tree, and shared nodes are printed at each use.
    """
    lines = list(islice(_lines(node, "", ""), _MAX_LINES + 1))
    if len(lines) > _MAX_LINES:
        lines[-1] = "..."
    return "\n".join(lines)


def _lines(node: Any, label: str, indent: str) -> Iterator[str]:
    head = f"{indent}{label}"
    if len(indent) > _MAX_INDENT:
        yield f"{indent}..."
    elif _is_plain(node):
        yield f"{head}{node!r}"
    elif isinstance(node, (tuple, list)):
        if not node:
            yield f"{head}[]"
        elif all(_is_plain(item) for item in node):
            yield f"{head}[{', '.join(map(repr, node))}]"
        else:
            yield head.rstrip()
            for item in node:
                yield from _lines(item, "- ", indent + "  ")
    elif isinstance(node, dict):
        yield f"{head}{node!r}"
    else:
        names = _field_names(node)
        values = {name: getattr(node, name) for name in names}
        plain = {k: v for k, v in values.items() if _is_plain(v) and v not in ("", None)}
        shown = " ".join(f"{name}={value!r}" for name, value in plain.items())
        yield f"{head}{type(node).__name__} {shown}".rstrip()
        for name, value in values.items():
            if not _is_plain(value) and not isinstance(value, (Span, Source)) and value != ():
                yield from _lines(value, f"{name}: ", indent + "  ")


def _is_plain(value: Any) -> bool:
    return value is None or isinstance(value, (str, int, float, bool))


def _field_names(node: Any) -> list[str]:
    if is_dataclass(node):
        return [f.name for f in fields(node) if f.name not in ("span", "name_span")]
    return list(getattr(node, "__struct_fields__", ()))


def programs(program: Program) -> str:
    """Print the IR: every constraint as a straight-line program with its derivatives."""
    layout = program.layout
    parts = [f"model {layout.name}, root {layout.root}, {layout.precision}"]
    parts += [_constraint(kernel, layout) for kernel in program.kernels]
    return "\n\n".join(parts)


def _constraint(kernel: Kernel, layout: Layout) -> str:
    group = kernel.group
    lines = [
        f"constraint {group.label} at {group.table or 'root'}  ({group.where})",
        f"  {group.residuals} residuals, {len(group.jacobian)} derivatives, "
        f"{group.operations_before} operations before and {group.operations_after} after "
        "common subexpressions",
    ]
    if group.guard_text:
        lines.append(f"  when {group.guard_text}")
    if group.loss_text:
        lines.append(f"  loss {group.loss_text}")
    data, prepared = _prepared(group, group.raw, group.prepare, "p")
    lines += _titled("prepared once per solve", prepared)
    if group.moving_guard is not None:
        data[group.data_count - 1] = "guard"
    names = [*kernel.state_names, *data]
    if group.moving_guard is not None:
        holds = f"guard = t{group.moving_guard.outputs[0]}"
        lines += _titled("guard, at each linearisation", [*_tape(group.moving_guard, names), holds])
    if group.row_sums is not None:
        lines.append("  where all lists are empty")
    lines += [f"  {line}" for line in _tape(group.tape, names)]
    outputs = group.tape.outputs
    lines += [f"  r{i} = t{node}" for i, node in enumerate(outputs[: group.residuals])]
    for node, (row, use, k) in zip(outputs[group.residuals :], group.jacobian, strict=True):
        lines.append(f"  d r{row} / d {_tangent(group, group.uses[use], k, layout)} = t{node}")
    if group.row_sums is not None:
        lines += ["  where lists have rows", *_pieces(group.row_sums, layout)]
    return "\n".join(lines)


def _titled(title: str, lines: Iterable[str]) -> Iterator[str]:
    """Lines below a title; nothing if there are none."""
    for number, line in enumerate(lines):
        if not number:
            yield f"  {title}"
        yield f"    {line}"


def _prepared(
    of: Group | RowSums, raw: Sequence[Raw], tape: Tape, letter: str
) -> tuple[list[str], list[str]]:
    """What the outputs of a program over data are called, and its lines."""

    def name(node: int) -> str:
        number = tape.args[node]
        if tape.ops[node] == "const":
            return repr(tape.constants[number[0]])
        if tape.ops[node] != "input":
            return f"{letter}{node}"
        read = raw[number[0]]
        way = "".join(f"{step.shown}." for step in of.slots[read.slot].steps)
        if "#" in read.column:
            return f"sum {read.component + 1} over {way}{read.column.partition('#')[0]}"
        return f"{way}{read.column}[{read.component}]"

    lines = [
        f"{name(node)} = {op} {' '.join(map(name, args))}"
        for node, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True))
        if op not in ("input", "const")
    ]
    return [name(node) for node in tape.outputs], lines


def _pieces(sums: RowSums, layout: Layout) -> Iterator[str]:
    """Programs for lists with rows, each after those that it reads."""
    own, prepared = _prepared(sums, sums.raw, sums.prepare, "p")
    yield from _titled("prepared once per solve", prepared)
    of_rows = []
    for number, (raw, program) in enumerate(zip(sums.row_raw, sums.row_prepare, strict=True)):
        names, prepared = _prepared(sums, raw, program, f"p{number + 1}_")
        of_rows.append(names)
        field = layout.table(sums.slots[sums.lists[number][1]].table).field
        yield from _titled(f"prepared once per solve, for each row of {field}", prepared)
    first = len(own) - sums.uniforms

    def name(kind: str, a: int, b: int, of_list: int) -> str:
        if kind == "state":
            use = sums.uses[a]
            entity = layout.entities[use.entity]
            return f"{_way(sums, use)}state[{b}] of {entity.struct}"
        if kind == "sum":
            return f"sum{a + 1}[{b}]"
        if kind == "guard":
            return "guard"
        return of_rows[of_list][a] if kind == "row" else own[a + first * (kind == "uniform")]

    pieces = []
    for k, (number, piece) in enumerate(sums.sums):
        field = layout.table(sums.slots[sums.lists[number][1]].table).field
        pieces.append((f"term of sum{k + 1}, over {field}", number, piece))
    if sums.guard is not None:
        pieces.append(("guard, at each linearisation", -1, sums.guard))
    pieces.append(("residuals, which read the sums", -1, sums.main))
    for title, number, piece in pieces:
        yield f"  {title}"
        letter = "r" if piece is sums.main else "v"
        names = [name(kind, a, b, number) for kind, a, b in piece.inputs]
        yield from (f"    {line}" for line in _tape(piece.tape, names))
        for k, node in enumerate(piece.tape.outputs[: piece.values]):
            yield f"    {'guard' if piece is sums.guard else f'{letter}{k}'} = t{node}"
        ends = piece.tape.outputs[piece.values :]
        for node, (value, use, k) in zip(ends, piece.entries, strict=True):
            by = f"sum{-use}[{k}]"
            if use >= 0:
                by = _tangent(sums, sums.uses[use], k, layout)
            yield f"    d {letter}{value} / d {by} = t{node}"


def _tape(tape: Tape, names: Sequence[str]) -> Iterator[str]:
    for number, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op == "input":
            yield f"t{number} = {names[args[0]]}"
        elif op == "const":
            yield f"t{number} = {tape.constants[args[0]]!r}"
        else:
            yield f"t{number} = {op} {' '.join(f't{a}' for a in args)}"


def _tangent(group: Group | RowSums, use: Use, index: int, layout: Layout) -> str:
    entity = layout.entities[use.entity]
    return f"{_way(group, use)}{entity.prefix}{entity.tangent_names[index]}"


def _way(group: Group | RowSums, use: Use) -> str:
    """Text of the path to an entity, with a dot at its end: ``pose.``, ``parent.``, ``root.``."""
    steps = group.slots[use.slot].steps
    return "".join(f"{step.shown}." for step in steps)
