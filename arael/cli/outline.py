"""Trees of dataclasses as indented text, for the early stages in `arael emit`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import Source, Span
from arael.runtime.layout import Group, Layout, RowSums, Use
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
    names = [*kernel.state_names, *kernel.data_names, *kernel.uniform_names]
    lines += [f"  {line}" for line in _tape(group.tape, names)]
    if group.row_sums is not None:
        lines += ["  for lists without rows", *_pieces(group, group.row_sums, layout)]
    outputs = group.tape.outputs
    lines += [f"  r{i} = t{node}" for i, node in enumerate(outputs[: group.residuals])]
    for node, (row, use, k) in zip(outputs[group.residuals :], group.jacobian, strict=True):
        lines.append(f"  d r{row} / d {_tangent(group, group.uses[use], k, layout)} = t{node}")
    return "\n".join(lines)


def _pieces(group: Group, sums: RowSums, layout: Layout) -> Iterator[str]:
    """Programs for lists with rows, behind that for lists without."""
    titles = ["residuals, which read the sums"]
    for number, _ in sums.sums:
        table = layout.table(sums.slots[sums.lists[number][1]].table)
        titles.append(f"term of the sum over {table.field}")
    pieces = [sums.main, *(piece for _, piece in sums.sums)]
    for title, piece in zip(titles, pieces, strict=True):
        yield f"  {title}"
        names = []
        for kind, a, b in piece.inputs:
            if kind == "state":
                use = sums.uses[a]
                names.append(f"{_way(sums, use)}state[{b}] of {layout.entities[use.entity].struct}")
            else:
                names.append(f"sum{a + 1}[{b}]" if kind == "sum" else f"{kind}[{a}]")
        yield from (f"    {line}" for line in _tape(piece.tape, names))
        for k, node in enumerate(piece.tape.outputs[: piece.values]):
            yield f"    v{k} = t{node}"
        ends = piece.tape.outputs[piece.values :]
        for node, (value, number, k) in zip(ends, piece.entries, strict=True):
            by = f"sum{-number}[{k}]"
            if number >= 0:
                by = _tangent(sums, sums.uses[number], k, layout)
            yield f"    d v{value} / d {by} = t{node}"


def _tape(tape: Tape, names: list[str]) -> Iterator[str]:
    for number, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if op == "input":
            yield f"t{number} = {names[args[0]] if args[0] < len(names) else f'input {args[0]}'}"
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
