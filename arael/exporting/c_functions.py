"""The header and the source of exported functions, in C99."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from arael.compiler.groups import Kernel
from arael.compiler.runs import needed
from arael.exporting.arrays import Array, Arrays, ParameterSet, arrays_of, refuse_rows
from arael.exporting.identifiers import Names, identifier, project_name
from arael.exporting.program import (
    ConstraintProgram,
    constraint_program,
    local_coordinates,
    retraction,
)
from arael.exporting.statements import Statements, c_comment
from arael.runtime.layout import Group, Layout
from arael.runtime.machine.tape import Tape
from arael.symbolic.c import c_prelude

_WIDTH = 96


@dataclass(frozen=True)
class Parameter:
    """A pointer that an exported function takes.

    Attributes
    ----------
    name : in C
    array : what it points to
    use : number of the use of the group; -1 for data
    slot : number of the slot of the group
    """

    name: str
    array: Array
    use: int
    slot: int


@dataclass(frozen=True)
class ConstraintFunction:
    """A constraint as a C function.

    Attributes
    ----------
    name : of the function
    program : what it computes
    states, data : pointers that it reads
    jacobians : names of the pointers to the blocks of the Jacobian, one per state
    sets : parameter sets of `states`
    """

    name: str
    program: ConstraintProgram
    states: tuple[Parameter, ...]
    data: tuple[Parameter, ...]
    jacobians: tuple[str, ...]
    sets: tuple[ParameterSet, ...]

    @property
    def group(self) -> Group:
        """Of the layout."""
        return self.program.group


@dataclass(frozen=True)
class Functions:
    """The functions of a model.

    Attributes
    ----------
    layout : the model
    prefix : what their names begin with, an underscore at its end
    real : C type of all scalars
    arrays : what they read
    constraints : one function each
    """

    layout: Layout
    prefix: str
    real: str
    arrays: Arrays
    constraints: tuple[ConstraintFunction, ...]

    def macro(self, array: Array, suffix: str = "SIZE") -> str:
        """Name of the macro for the size of an array."""
        return f"{self.prefix}{array.name}_{suffix}".upper()

    @property
    def used(self) -> tuple[ParameterSet, ...]:
        """Parameter sets that the constraints read."""
        numbers = {one.number for function in self.constraints for one in function.sets}
        return tuple(one for one in self.arrays.parameters if one.number in numbers)


def functions_of(layout: Layout, kernels: tuple[Kernel, ...]) -> Functions:
    """Plan the functions of the constraints `kernels` of a model."""
    refuse_rows(kernels)
    arrays = arrays_of(layout, kernels)
    prefix = f"{project_name(layout.name)}_"
    taken = [f"{one.stored.name}_{way}" for one in arrays.parameters for way in _WAYS]
    taken += [f"covariance_{one.stored.name}" for one in arrays.parameters]
    names = Names((*taken, *_OF_SOLVER))
    constraints = []
    for kernel in kernels:
        group = kernel.group
        name = names.take(f"{identifier(group.struct)}_{identifier(group.constraint)}")
        constraints.append(_constraint(f"{prefix}{name}", kernel, layout, arrays))
    real = "float" if layout.precision == "f32" else "double"
    return Functions(layout, prefix, real, arrays, tuple(constraints))


_WAYS = ("retract", "local")

_OF_SOLVER = ("data", "default_options", "parameters", "solve", "state")
"""What an exported solver defines after the prefix, and what a constraint may be called."""


def _constraint(name: str, kernel: Kernel, layout: Layout, arrays: Arrays) -> ConstraintFunction:
    group = kernel.group
    program = constraint_program(kernel, layout)
    names = Names(("residual", "k"))
    sets = tuple(arrays.parameters[use.entity] for use in group.uses)
    states = []
    for number, (use, one) in enumerate(zip(group.uses, sets, strict=True)):
        way = _way(group, use.slot) + identifier(one.entity.prefix) * bool(one.entity.prefix)
        states.append(Parameter(names.take(identifier(way)), one.stored, number, use.slot))
    read = {group.raw[k].slot for kind, k in _keys(program) if kind == "raw"}
    read |= {group.guard_raw[k].slot for kind, k in _keys(program) if kind == "guard"}
    data = []
    for slot in sorted(read):
        array = arrays.data[group.slots[slot].table]
        data.append(Parameter(names.take(f"{identifier(_way(group, slot))}_data"), array, -1, slot))
    jacobians = tuple(names.take(f"jacobian_{one.name}") for one in states)
    return ConstraintFunction(name, program, tuple(states), tuple(data), jacobians, sets)


def _keys(program: ConstraintProgram) -> list[tuple[str, int]]:
    return [(key[0], key[-1]) for key in program.inputs if isinstance(key, tuple)]


def _way(group: Group, slot: int) -> str:
    """How the constraint names a row: ``pose``, ``parent``; its struct's name for its own."""
    steps = group.slots[slot].steps
    return "_".join(step.shown for step in steps) or identifier(group.struct)


def header(functions: Functions, head: str) -> str:
    """Text of the header.

    Parameters
    ----------
    functions : what is declared
    head : comment at the top
    """
    layout, guard = functions.layout, f"{functions.prefix.upper()}H"
    lines = [head, f"#ifndef {guard}", f"#define {guard}", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    for one in functions.used:
        lines += [*_array(functions, one.stored), *_array(functions, one.tangent)]
    for table in layout.tables:
        array = functions.arrays.data.get(table.path)
        if array is not None:
            lines += _array(functions, array, offsets=True)
    for one in functions.used:
        lines += _moves(functions, one)
    for function in functions.constraints:
        lines += [*_documentation(functions, function), f"{_signature(functions, function)};", ""]
    natives = sorted(set().union(*(f.program.tape.natives for f in functions.constraints)))
    if natives:
        lines += ["/* What the model declares as `extern fn`: to be defined by you. */"]
        for native in layout.functions:
            if native.name in natives:
                scalars = ", ".join(f"{functions.real} {identifier(p)}" for p in native.params)
                name = f"{functions.prefix}{identifier(native.name)}"
                lines += [f"{functions.real} {name}({scalars});"]
        lines += [""]
    lines += ["#ifdef __cplusplus", "}", "#endif", "", "#endif"]
    return "\n".join(lines) + "\n"


def source(functions: Functions, head: str) -> str:
    """Text of the source, which includes the header and `<math.h>` alone."""
    stem = functions.prefix.removesuffix("_")
    bodies: list[str] = []
    for one in functions.used:
        bodies += [*_retract(functions, one), *_local(functions, one)]
    for function in functions.constraints:
        bodies += _body(functions, function)
    lines = [head, f'#include "{stem}.h"', "", *_prelude(bodies, functions.real), "", *bodies]
    return "\n".join(lines).rstrip("\n") + "\n"


def _prelude(bodies: Sequence[str], real: str) -> list[str]:
    """What of the prelude the bodies call."""
    text = "\n".join(bodies)
    lines = c_prelude(real).splitlines()
    kept = [lines[0]]
    for line in lines[1:]:
        called = line.partition("(")[0].rpartition(" ")[2]
        if f"{called}(" in text:
            kept.append(line)
    return kept


def _array(functions: Functions, array: Array, *, offsets: bool = False) -> list[str]:
    """Comment and macros of an array."""
    lines = [f"/* {c_comment(array.title[:1].upper() + array.title[1:])}:"]
    for part in array.parts:
        last = part.first + part.count - 1
        at = f"{part.first}" if part.count == 1 else f"{part.first}-{last}"
        unit = f" [{part.unit}]" if part.unit else ""
        parts = f": {', '.join(s.lstrip('.') for s in part.suffixes)}" if part.count > 1 else ""
        row_major = part.count > 3 and part.suffixes[0].startswith("[")
        parts = "" if row_major else parts
        lines.append(f"     [{at}] {c_comment(f'{part.name} ({part.type}){unit}{parts}')}")
    lines[-1] += " */"
    lines.append(f"#define {functions.macro(array)} {array.size}")
    if offsets:
        names = Names(("SIZE",))
        for part in array.parts:
            name = names.take(identifier(part.name.replace("?", "_there")).upper())
            lines.append(f"#define {functions.macro(array, name)} {part.first}")
    return [*lines, ""]


def _retract_head(functions: Functions, one: ParameterSet, end: str) -> list[str]:
    """The head of a retraction; its names are none of the model."""
    real, size = functions.real, functions.macro(one.stored)
    step = functions.macro(one.tangent)
    return _wrapped(
        f"void {functions.prefix}{one.stored.name}_retract(",
        [f"const {real} x[{size}]", f"const {real} step[{step}]", f"{real} moved[{size}]"],
        end,
    )


def _local_head(functions: Functions, one: ParameterSet, end: str) -> list[str]:
    real, size = functions.real, functions.macro(one.stored)
    step = functions.macro(one.tangent)
    return _wrapped(
        f"void {functions.prefix}{one.stored.name}_local(",
        [f"const {real} x[{size}]", f"const {real} y[{size}]", f"{real} step[{step}]"],
        end,
    )


def _moves(functions: Functions, one: ParameterSet) -> list[str]:
    name = one.stored.name
    return [
        f"/* Moves the parameters x of {name} by a step; `moved` may be x itself. */",
        *_retract_head(functions, one, ");"),
        "",
        f"/* The step that leads from x to y, parameters of {name}, by the shortest rotation. */",
        *_local_head(functions, one, ");"),
        "",
    ]


def _documentation(functions: Functions, function: ConstraintFunction) -> list[str]:
    group = function.group
    where = group.where.rpartition("/")[2]
    lines = [f"/* {c_comment(f'{group.label}, {where}')}: {_count(group.residuals, 'residual')}."]
    if group.doc:
        lines += [f"   {c_comment(line)}" for line in group.doc.splitlines()]
    if group.loss_text:
        lines.append(f"   Robustified by {c_comment(group.loss_text)}.")
    if function.program.guards:
        lines.append(
            f"   When {c_comment(group.guard_text)}: else it returns 0, and all results are 0."
        )
    for one, blocks in zip(function.states, function.jacobians, strict=True):
        rows = f"{group.residuals} x {function.sets[one.use].entity.tangent}"
        lines.append(f"   {blocks}: {rows}, row by row, by a step of `{one.name}`; or NULL.")
    operations = f"{function.program.tape.operations} operations with all derivatives"
    lines.append(f"   Returns 1. {operations}. */")
    return lines


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"


def _signature(functions: Functions, function: ConstraintFunction) -> str:
    real = functions.real
    parameters = [
        f"const {real} {one.name}[{functions.macro(one.array)}]"
        for one in (*function.states, *function.data)
    ]
    parameters.append(f"{real} residual[{function.group.residuals}]")
    parameters += [f"{real} *{name}" for name in function.jacobians]
    return "\n".join(_wrapped(f"int {function.name}(", parameters, ")"))


def _wrapped(head: str, parameters: Sequence[str], end: str) -> list[str]:
    line = f"{head}{', '.join(parameters)}{end}"
    if len(line) <= _WIDTH:
        return [line]
    lines, current = [head], "   "
    for number, one in enumerate(parameters):
        text = f" {one}{',' if number + 1 < len(parameters) else end}"
        if len(current) + len(text) > _WIDTH:
            lines.append(current)
            current = "   "
        current += text
    return [*lines, current]


def _retract(functions: Functions, one: ParameterSet) -> list[str]:
    inputs = [f"x[{k}]" for k in range(one.entity.stored)]
    inputs += [f"step[{k}]" for k in range(one.entity.tangent)]
    head = _retract_head(functions, one, ")")
    return _simple(head, retraction(one.entity), inputs, "moved", functions.real)


def _local(functions: Functions, one: ParameterSet) -> list[str]:
    inputs = [f"x[{k}]" for k in range(one.entity.stored)]
    inputs += [f"y[{k}]" for k in range(one.entity.stored)]
    head = _local_head(functions, one, ")")
    return _simple(head, local_coordinates(one), inputs, "step", functions.real)


def _simple(
    head: list[str], tape: Tape, inputs: Sequence[str], target: str, real: str
) -> list[str]:
    """Write a function whose results go into one array, which may be one of its operands."""
    names = [f"x{k}" for k in range(len(inputs))]
    written = Statements(tape, inputs, names, real)
    written.write(range(len(tape.ops)))
    stores = [f"{target}[{k}] = {written.value(node)};" for k, node in enumerate(tape.outputs)]
    return [*head, "{", *_indented([*written.lines, *stores]), "}", ""]


def _body(functions: Functions, function: ConstraintFunction) -> list[str]:
    program, group = function.program, function.group
    tape, real = program.tape, functions.real
    inputs, names = _inputs(functions, function)
    written = Statements(tape, inputs, names, real, group.places, functions.prefix)
    lines: list[str] = []

    def write(nodes: Sequence[int]) -> None:
        needs = needed(tape, nodes)
        written.lines = []
        written.write(sorted(needs))
        lines.extend(written.lines)

    first, last = program.guards, program.guards + group.residuals
    guards, residuals = tape.outputs[:first], tape.outputs[first:last]
    entries = dict(zip(program.entries, tape.outputs[last:], strict=True))
    read = {name for name in inputs}
    unread = [one.name for one in (*function.states, *function.data) if not _reads(read, one.name)]
    lines += [f"(void){name};" for name in unread]
    if guards:
        write(guards)
        zero = "0.0f" if real == "float" else "0.0"
        tests = " && ".join(f"{written.value(node, 6)} != {zero}" for node in guards)
        lines += [f"if (!({tests})) {{", *_indented(_zeros(function, zero)), "    return 0;", "}"]
    write(residuals)
    lines += [f"residual[{k}] = {written.value(node)};" for k, node in enumerate(residuals)]
    if function.jacobians:
        absent = " && ".join(f"!{name}" for name in function.jacobians)
        lines += [f"if ({absent}) return 1;", ""]
        write(list(entries.values()))
        zero = "0.0f" if real == "float" else "0.0"
        for use, name in enumerate(function.jacobians):
            tangent = function.sets[use].entity.tangent
            block = []
            for row in range(group.residuals):
                for k in range(tangent):
                    node = entries.get((row, use, k))
                    value = zero if node is None else written.value(node)
                    block.append(f"{name}[{row * tangent + k}] = {value};")
            lines += [f"if ({name}) {{", *_indented(block), "}"]
    lines.append("return 1;")
    return [*_signature(functions, function).splitlines(), "{", *_indented(lines), "}", ""]


def _reads(inputs: set[str], pointer: str) -> bool:
    return any(text.startswith(f"{pointer}[") for text in inputs)


def _zeros(function: ConstraintFunction, zero: str) -> list[str]:
    """Set all results to zero."""
    lines = [f"for (int k = 0; k < {function.group.residuals}; k++) residual[k] = {zero};"]
    for use, name in enumerate(function.jacobians):
        size = function.group.residuals * function.sets[use].entity.tangent
        lines += [f"if ({name})", f"    for (int k = 0; k < {size}; k++) {name}[k] = {zero};"]
    return lines


def _inputs(functions: Functions, function: ConstraintFunction) -> tuple[list[str], list[str]]:
    """C expression and name of each input of the program."""
    group, arrays = function.group, functions.arrays
    taken = {one.name for one in (*function.states, *function.data)}
    names = Names((*taken, *function.jacobians, "residual", "k"))
    pointers = {one.slot: one for one in function.data}
    texts, called = [], []
    for key in function.program.inputs:
        assert isinstance(key, tuple)
        if key[0] == "stored":
            state, k = function.states[key[1]], key[2]
            texts.append(f"{state.name}[{k}]")
            called.append(names.take(identifier(f"{state.name}_{_name_of(state.array, k)}")))
            continue
        raw = (group.raw if key[0] == "raw" else group.guard_raw)[key[1]]
        pointer = pointers[raw.slot]
        at = arrays.offset(group.slots[raw.slot].table, raw.column, raw.component)
        texts.append(f"{pointer.name}[{at}]")
        short = pointer.name.removesuffix("_data")
        called.append(names.take(identifier(f"{short}_{_name_of(pointer.array, at)}")))
    return texts, called


def _name_of(array: Array, at: int) -> str:
    for part in array.parts:
        if part.first <= at < part.first + part.count:
            return f"{part.name}{part.suffixes[at - part.first]}"
    raise KeyError(at)


def _indented(lines: Sequence[str]) -> list[str]:
    return [f"    {line}" if line else "" for line in lines]
