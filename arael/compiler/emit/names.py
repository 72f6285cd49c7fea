"""What the arrays of a kernel hold, in the model's words: heads and comments of generated code."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from arael.compiler.emit.scatter import Plan
from arael.compiler.emit.writer import Writer, comment
from arael.compiler.groups import Kernel
from arael.runtime.layout import Entity, Group

# Inputs of which a list is shown; beyond, its beginning.
_SHOWN = 200


def emit_title(w: Writer, kernel: Kernel) -> None:
    """Write the heading of a constraint: what it is, where, its options, operation counts."""
    group = kernel.group
    where = comment(group.where.rpartition("/")[2])  # generated source names no folder
    w.line()
    w.line("# " + "-" * 96)
    w.line(f"# {group.label} over {group.table or 'the root'}, {where}")
    w.line(
        f"# {group.residuals} residuals, {len(group.jacobian)} Jacobian entries; operations "
        f"{group.operations_before} before and {group.operations_after} after sharing"
    )
    options = [
        *([f"guard {comment(group.guard_text)}"] if group.guard_text else []),
        *([f"loss {comment(group.loss_text)}"] if group.loss_text else []),
        *([f"lead {', '.join(_lead(group))}"] if group.lead else []),
        *([f"{len(kernel.parts.parts)} parts"] if kernel.parts is not None else []),
    ]
    if options:
        w.line(f"# {'; '.join(options)}")


def emit_inputs(w: Writer, kernel: Kernel, state: str = "x") -> None:
    """Write the list of inputs: states, data, and what all instances share."""
    w.line("#")
    w.line("# Inputs")
    lists = ((state, kernel.state_names), ("d", kernel.data_names), ("u", kernel.uniform_names))
    for array, names in lists:
        for k, name in enumerate(names[:_SHOWN]):
            at = f"u{k}" if array == "u" else f"{array}[{k}]"
            w.line(f"#     {at:<7} {comment(name)}")
        if len(names) > _SHOWN:
            w.line(f"#     and {len(names) - _SHOWN} more in {array}")


def jacobian_names(group: Group, entities: Sequence[Entity]) -> list[str]:
    """Names of the Jacobian's entries: ``d r0 / d pose.ea.x``."""
    return [f"d r{k} / d {_tangent(group, entities, use, i)}" for k, use, i in group.jacobian]


def output_notes(kernel: Kernel, plan: Plan, entities: Sequence[Entity]) -> dict[str, str]:
    """What each column that is stored to holds."""
    group = kernel.group
    names = [
        *(f"r{k}" for k in range(group.residuals)),
        *jacobian_names(group, entities),
        *(f"J'r of {_tangent(group, entities, *key)}" for key in kernel.gradient),
        *_products(kernel, entities),
    ]
    notes: dict[str, list[str]] = {}
    for i, name in enumerate(names):
        for column in [*plan.outputs[i]] or [plan.sources[i]]:
            sign = "-" if column.startswith("-") else ""
            notes.setdefault(column.removeprefix("-"), []).append(
                f"-({name})" if sign and " " in name else sign + name
            )
    return {column: ", ".join(found_names) for column, found_names in notes.items()}


def _products(kernel: Kernel, entities: Sequence[Entity]) -> Iterator[str]:
    group = kernel.group
    for a, b, i, j in kernel.products:
        left, right = _tangent(group, entities, a, i), _tangent(group, entities, b, j)
        yield f"J'J of {left}, {right}"


def _tangent(group: Group, entities: Sequence[Entity], use: int, index: int) -> str:
    """Name of a scalar that is solved for, as the constraint reaches it."""
    entity = entities[group.uses[use].entity]
    return f"{_way(group, use)}{entity.prefix}{entity.tangent_names[index]}"


def _lead(group: Group) -> list[str]:
    """The uses of the lead, as the constraint reaches them."""
    return [_way(group, use).removesuffix(".") or "self" for use in group.lead]


def _way(group: Group, use: int) -> str:
    steps = group.slots[group.uses[use].slot].steps
    return "".join(f"{step.shown}." for step in steps)
