"""The files of an exported solver, with a main program that solves the problem of a data file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.project import cmake, head
from arael.exporting.solver import Solver
from arael.model import Model
from arael.runtime.evaluation.states import stored_scalars
from arael.runtime.layout import Raw, Slot
from arael.runtime.store.access import gather
from arael.solving import problem_of
from arael.symbolic.c import c_literal


def solver_files(solver: Solver, text: str, model: Model | None) -> dict[str, str]:
    """Text of each file by its name; `main.c` solves the problem of `model`, if there is one."""
    p = solver.prefix
    files = {
        f"{p}_solver.h": solver.header(head(solver.functions, text)),
        f"{p}_solver.c": solver.source(),
        "CMakeLists.txt": cmake(p, f"{p}.c", f"{p}_solver.c"),
    }
    if model is not None:
        files["main.c"] = _main(solver, problem_values(solver, model))
    return files


def problem_values(solver: Solver, model: Model) -> dict[str, np.ndarray[Any, Any]]:
    """Values of the members of the data struct, by their path in C.

    Raises
    ------
    AraelError
        E1503: a collection of the model has more rows than the solver.
    """
    functions, plan, store = solver.functions, solver.plan, model._store
    values: dict[str, np.ndarray[Any, Any]] = {}
    system = problem_of(model).structure.system
    for path, most in plan.rows.items():
        if path and store.tables[path].size > most:
            raise AraelError(
                Diagnostic(
                    "E1503",
                    f"`{path}` has {store.tables[path].size} rows, and the solver at most {most}",
                    help=(f"write --size {path}={store.tables[path].size}",),
                )
            )
    for one in functions.used:
        name = one.stored.name
        values[f"parameters.{name}"] = stored_scalars(store, one.entity, np.dtype(np.float64))
        values[f"{name}_fixed"] = (~system.blocks[one.number].free).astype(int)
    for path in plan.rows:
        table = store.tables[path]
        rows = np.arange(table.size)
        if path:
            values[f"{solver.row_names[path]}_count"] = np.array(table.size)
        for (owner, step), name in solver.ref_names.items():
            if owner == path:
                found = (
                    table.parent_rows() if step.kind == "parent" else table.target_rows(step.ref)
                )
                values[name] = np.asarray(found).astype(int)
        array = functions.arrays.data.get(path)
        if array is None:
            continue
        slots = (Slot((), path),)
        columns = []
        for part in array.parts:
            for k in range(part.count):
                column = gather(store, slots, [rows], Raw(0, part.name, k))
                columns.append(np.broadcast_to(column, table.size))
        values[array.name] = np.stack(columns, axis=1)
    return values


def _main(solver: Solver, values: dict[str, np.ndarray[Any, Any]]) -> str:
    p, upper = solver.prefix, solver.prefix.upper()
    lines = [
        "/* Solves the problem of the data file, and prints the solution. */",
        "#include <stdio.h>",
        "",
        f'#include "{p}_solver.h"',
        "",
        f"static {p}_data data = {{",
    ]
    for name, value in values.items():
        if value.size:
            lines += _member(name, value, solver.real)
    lines += [
        "};",
        f"static {p}_state state;",
        "",
        "int main(void)",
        "{",
        f"    const {p}_options options = {p}_default_options();",
        f"    const {p}_result result = {p}_solve(&state, &data, &options);",
        '    printf("status %d, cost %.17g -> %.17g, %d attempts, %d accepted\\n",',
        "           (int)result.status, result.start_cost, result.cost, result.iterations,",
        "           result.accepted);",
    ]
    for one in solver.functions.used:
        name, size = one.stored.name, solver.functions.macro(one.stored)
        path = one.entity.table
        rows = f"data.{solver.row_names[path]}_count" if path else "1"
        lines += [
            f"    for (int row = 0; row < {rows}; row++) {{",
            f'        printf("{name} %d", row);',
            f"        for (int k = 0; k < {size}; k++)",
            f'            printf(" %.17g", (double)data.parameters.{name}[row][k]);',
            '        printf("\\n");',
            "    }",
        ]
    return "\n".join([*lines, f"    return result.status != {upper}_CONVERGED;", "}"]) + "\n"


def _member(name: str, value: np.ndarray[Any, Any], real: str) -> Sequence[str]:
    text = str if value.dtype.kind == "i" else (lambda v: c_literal(v, real))
    if value.ndim == 0:
        return [f"    .{name} = {text(value.item())},"]
    if value.ndim == 1:
        return _folded(f"    .{name} = {{", [text(v) for v in value.tolist()])
    lines = [f"    .{name} = {{"]
    for row in value.tolist():
        lines += _folded("        {", [text(v) for v in row])
    return [*lines, "    },"]


def _folded(head: str, texts: Sequence[str]) -> list[str]:
    lines, current = [], head
    for text in texts:
        if len(current) + len(text) > 94:
            lines.append(current.rstrip())
            current = "            "
        current += f"{text}, "
    return [*lines, f"{current.rstrip().removesuffix(',')}}},"]
