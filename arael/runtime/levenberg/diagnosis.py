"""Explanation of failures of a solve, with the names of the model."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.operations.numbers import outside_domain
from arael.runtime.failures import SolveError, listed
from arael.runtime.layout import Group, Place
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.machine.programs import evaluate
from arael.runtime.machine.tape import NATIVE, Tape
from arael.runtime.problem import Problem
from arael.runtime.store.access import Array, gather
from arael.runtime.system import row_name


def check_linearisation(problem: Problem, cost: float, gradient: Array, diagonal: Array) -> None:
    """Raise SolveError if a solve cannot start here.

    Raises
    ------
    SolveError
        E1001 a residual is not finite, E1002 a derivative is not finite, E1003 no constraint reads
        a parameter, E1004 all derivatives with respect to a parameter are zero, or their squares
        are.
    """
    # Sums are finite where all is, but for overflow, which the checks below judge.
    if (
        len(diagonal)
        and diagonal.min() > 0
        and math.isfinite(cost + float(diagonal.sum()) + float(gradient.sum()))
    ):
        return
    if not np.isfinite(cost):
        raise SolveError(non_finite(problem, derivatives=False))
    if not (np.isfinite(gradient).all() and np.isfinite(diagonal).all()):
        raise SolveError(non_finite(problem, derivatives=True))
    free = np.ones(problem.size, dtype=bool)
    free[problem.structure.system.held] = False
    loose = np.flatnonzero(free & (diagonal == 0))
    if len(loose):
        raise SolveError(_unconstrained(problem, loose))


def _unconstrained(problem: Problem, loose: Array) -> Diagnostic:
    name_of = problem.structure.system.name_of
    untouched = loose[~problem.touched()[loose]]
    if len(untouched):
        names = [name_of(int(i)) for i in untouched]
        return Diagnostic(
            "E1003",
            f"no constraint reads {listed(names)}",
            origin=problem.layout.name,
            notes=(f"{len(names)} of {problem.size} scalars are unconstrained",)
            if len(names) > 1
            else (),
            help=(
                "is the guard of the intended constraint false, or is its list empty?",
                "otherwise freeze the parameter, or add a prior",
            ),
        )
    names = [name_of(int(i)) for i in loose]
    largest = _largest_derivative(problem, loose)
    if largest > 0:
        return Diagnostic(
            "E1004",
            f"derivatives with respect to {listed(names)} are too small at the start: none is "
            f"larger than {largest:.3g}, and its square underflows to zero",
            origin=problem.layout.name,
            help=(
                "use another unit for the parameter, or divide the residuals by smaller sigmas",
                "otherwise start elsewhere, or freeze it; a `min_diagonal` above 0 leaves it as is",
            ),
        )
    return Diagnostic(
        "E1004",
        f"no residual changes with {listed(names)} at the start: every derivative is zero there",
        origin=problem.layout.name,
        help=("start it elsewhere, or freeze it; `min_diagonal` above 0 leaves it unchanged",),
    )


def _largest_derivative(problem: Problem, scalars: Array) -> float:
    """Largest absolute derivative of any residual by one of `scalars`."""
    wanted = np.zeros(problem.size + problem.structure.trash, dtype=bool)
    wanted[scalars] = True
    largest = 0.0
    for number, group in enumerate(problem.layout.groups):
        entries = problem.evaluation.group_rows(number)[1]
        placement = problem.structure.placements[number]
        for column, (_, use, tangent) in enumerate(group.jacobian):
            mine = entries[wanted[placement.gradient_at[:, use] + tangent], column]
            largest = max(largest, float(np.abs(mine).max(initial=0.0)))
    return largest


def non_finite(problem: Problem, derivatives: bool) -> Diagnostic:
    """Report the first instance with a non-finite residual (or derivative), and the reason."""
    found = find_non_finite(problem, derivatives)
    if found is None:
        return Diagnostic(
            "E1002" if derivatives else "E1001",
            "the sum of squares overflows" if not derivatives else "J'J overflows",
            origin=problem.layout.name,
            help=("scale the residuals: each should be of the order of one sigma",),
        )
    number, instance, column = found
    group = problem.layout.groups[number]
    what = (
        f"a derivative of residual {group.jacobian[column][0]}"
        if derivatives
        else f"residual {column}"
    )
    value = problem.evaluation.group_rows(number)[int(derivatives)][instance, column]
    output = group.residuals + column if derivatives else column
    notes = [f"it acts on `{problem.instance_place(number, instance)}`"]
    notes += _cause(problem, number, instance, output)
    return Diagnostic(
        "E1002" if derivatives else "E1001",
        f"`{problem.instance_name(number, instance)}`: {what} is {_shown(value)} at the start",
        origin=group.where,
        notes=tuple(notes),
        help=(
            "correct the data, or write the residual so that it stays finite there "
            "(`safe_sqrt`, `safe_acos`, `safe_atan2`)",
        ),
    )


def find_non_finite(problem: Problem, derivatives: bool) -> tuple[int, int, int] | None:
    """Group, instance and column of the first residual (or Jacobian entry) that is not finite."""
    for number in range(len(problem.layout.groups)):
        if not len(problem.structure.active[number]):
            continue
        values = problem.evaluation.group_rows(number)[int(derivatives)]
        bad = ~np.isfinite(values)
        if bad.any():
            instance, column = np.argwhere(bad)[0]
            return number, int(instance), int(column)
    return None


def offenders(problem: Problem, gradient: Array, diagonal: Array, pivot: int) -> list[str]:
    """The cause of a failed factorisation, as lines for the trace."""
    name_of = problem.structure.system.name_of
    lines = []
    for derivatives in (False, True):
        found = find_non_finite(problem, derivatives)
        if found is not None:
            what = "derivative" if derivatives else "residual"
            lines.append(f"non-finite {what} in {problem.instance_name(found[0], found[1])}")
    for text, bad in (
        ("non-finite gradient of", ~np.isfinite(gradient)),
        ("non-finite diagonal of", ~np.isfinite(diagonal)),
        ("diagonal <= 0 of", diagonal <= 0),
    ):
        names = [name_of(int(i)) for i in np.flatnonzero(bad)]
        if names:
            lines.append(f"{text} {listed(names)}")
    if not lines and pivot >= 0:
        lines.append(f"pivot not positive at `{name_of(pivot)}`")
    return lines


def _cause(problem: Problem, number: int, instance: int, output: int) -> list[str]:
    """The place in the model and the operands of a non-finite result."""
    group = problem.layout.groups[number]
    inputs = [_one(a, instance) for a in problem.group_inputs(number, problem.states)]
    found = _first_bad(
        group.tape, group.tape.outputs[output], inputs, group.places, problem.natives
    )
    if found is None:
        return []
    lines, bad_input, reads = found
    first_lane = len(group.states)
    if bad_input is None or bad_input < first_lane:
        if bad_input is not None:
            use, offset = group.states[bad_input]
            lines.append(f"a parameter of it is not finite (state {offset} of use {use})")
        return lines + _summed_row(problem, number, instance, _slots_read(group, reads))
    rows = problem.structure.slot_rows[number]
    raw = [_one(gather(problem.store, group.slots, rows, r), instance) for r in group.raw]
    prepared = _first_bad(
        group.prepare,
        group.prepare.outputs[bad_input - first_lane],
        raw,
        group.places,
        problem.natives,
    )
    if prepared is None:
        return lines
    more, bad_raw, reads = prepared
    if bad_raw is not None:
        more.append(
            f"`{_raw_name(problem, group, rows, instance, bad_raw)}` is {_shown(raw[bad_raw])}"
        )
    slots = [group.raw[k].slot for k in reads]
    return lines + more + _summed_row(problem, number, instance, slots)


def _slots_read(group: Group, inputs: Sequence[int]) -> list[int]:
    """Slots that inputs of the tape of a group come from."""
    found: list[int] = []
    for k in inputs:
        if k < len(group.states):
            found.append(group.uses[group.states[k][0]].slot)
        else:
            node = group.prepare.outputs[k - len(group.states)]
            found += [group.raw[i].slot for i in _inputs_of(group.prepare, node)]
    return found


def _summed_row(problem: Problem, number: int, instance: int, slots: Sequence[int]) -> list[str]:
    """The row of a sum over rows that a value was computed from, if it is one row."""
    group = problem.layout.groups[number]
    ways = set()
    for slot in slots:
        steps = group.slots[slot].steps
        ways |= {steps[: k + 1] for k, step in enumerate(steps) if step.kind == "row"}
    if len(ways) != 1:
        return []
    (way,) = ways
    at = next(k for k, slot in enumerate(group.slots) if slot.steps == way)
    row = int(problem.structure.slot_rows[number][at][instance])
    return [f"in the term of `{row_name(problem.store, group.slots[at].table, row)}`"]


def _first_bad(
    tape: Tape,
    output: int,
    inputs: Sequence[Array],
    places: tuple[Place, ...],
    natives: NativeTable,
) -> tuple[list[str], int | None, list[int]] | None:
    """The first node among the operands of `output` whose value is not finite for finite operands.

    Returns lines that describe it, the number of the input if it is one, and the numbers of the
    inputs that it is computed from.
    """
    every = tuple(range(len(tape.ops)))
    values = evaluate(msgspec.structs.replace(tape, outputs=every), inputs, natives=natives)
    node = output
    if np.isfinite(values[node]):
        return None
    while tape.ops[node] not in ("input", "const"):
        worse = [a for a in _read(tape, node, values) if not np.isfinite(values[a])]
        if not worse:
            break
        node = worse[0]
    if tape.ops[node] == "input":
        return [], tape.args[node][0], [tape.args[node][0]]
    operands = ", ".join(_shown(values[a]) for a in tape.args[node])
    lines = []
    place = tape.places[node] if tape.places else -1
    if 0 <= place < len(places):
        lines.append(f"in `{places[place].text}` at {places[place].where}")
    name = tape.ops[node].removeprefix(NATIVE)
    lines.append(f"`{name}` of ({operands}) is {_shown(values[node])}")
    taken = outside_domain(tape.ops[node], *(float(values[a]) for a in tape.args[node]))
    if taken:
        lines.append(taken)
    return lines, None, _inputs_of(tape, node)


def _inputs_of(tape: Tape, node: int) -> list[int]:
    """Numbers of the inputs that a node is computed from."""
    needed = {node}
    for k in range(node, -1, -1):
        if k in needed and tape.ops[k] not in ("input", "const"):
            needed.update(tape.args[k])
    return [tape.args[k][0] for k in sorted(needed) if tape.ops[k] == "input"]


def _read(tape: Tape, node: int, values: Sequence[Array]) -> tuple[int, ...]:
    """Relevant operands: of a select, the condition and the selected branch."""
    args = tape.args[node]
    if tape.ops[node] == "select":
        return (args[0], args[1] if values[args[0]] != 0 else args[2])
    return args


def _raw_name(problem: Problem, group: Group, rows: list[Array], instance: int, number: int) -> str:
    raw = group.raw[number]
    table = group.slots[raw.slot].table
    if "#" in raw.column:
        owner = row_name(problem.store, table, int(rows[raw.slot][instance]))
        return f"the sum over {owner}.{raw.column.partition('#')[0]}".replace(" .", " ")
    column = problem.layout.table(table).column(raw.column.removesuffix("?"))
    place = row_name(problem.store, table, int(rows[raw.slot][instance]))
    component = f"[{raw.component}]" if column.shape and raw.column[-1] != "?" else ""
    return f"{place}.{raw.column}{component}" if place else f"{raw.column}{component}"


def _one(values: Array, instance: int) -> Array:
    return values if values.ndim == 0 else values[instance]


def _shown(value: Array | float) -> str:
    return f"{float(value):.6g}"
