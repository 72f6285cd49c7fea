"""The files of an exported solver, with a main program that solves the problem of a data file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.project import cmake, head
from arael.exporting.sample import model_values
from arael.exporting.solver import Solver
from arael.model import Model
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
        files["main.c"] = _main(solver, checked_values(solver, model))
    return files


def checked_values(solver: Solver, model: Model) -> dict[str, np.ndarray[Any, Any]]:
    """Values of the data struct's members; E1503 if there are more rows than the solver has."""
    for path, most in solver.plan.rows.items():
        found = model._store.tables[path].size
        if path and found > most:
            raise AraelError(
                Diagnostic(
                    "E1503",
                    f"`{path}` has {found} rows, and the solver at most {most}",
                    help=(f"write --size {path}={found}",),
                )
            )
    values = model_values(solver.functions, solver.rows, model)
    stored = {one.stored.name for one in solver.functions.used}
    return {f"parameters.{n}" if n in stored else n: v for n, v in values.items()}


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
            lines += initialiser(name, value, solver.real)
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
        rows = f"data.{solver.rows.names[path]}_count" if path else "1"
        lines += [
            f"    for (int row = 0; row < {rows}; row++) {{",
            f'        printf("{name} %d", row);',
            f"        for (int k = 0; k < {size}; k++)",
            f'            printf(" %.17g", (double)data.parameters.{name}[row][k]);',
            '        printf("\\n");',
            "    }",
        ]
    return "\n".join([*lines, f"    return result.status != {upper}_CONVERGED;", "}"]) + "\n"


def initialiser(name: str, value: np.ndarray[Any, Any], real: str) -> Sequence[str]:
    """Lines of the designated initialiser of one member."""
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
