"""A solver as a WebAssembly module: the C of `solver.py` behind functions that JavaScript calls."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.solver import Solver
from arael.exporting.solver_project import initialiser

CLANG = ("clang", "clang-19", "clang-18", "clang-17", "clang-16", "clang-15", "clang-14")
"""Names of the compiler, the first that is installed."""

FLAGS = (
    "--target=wasm32-wasi",
    "-mexec-model=reactor",
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-Wl,--strip-all",
)

TIME_LIMIT = 300  # seconds that the compiler may take


class Member(NamedTuple):
    """A member of the data struct, as JavaScript sees it."""

    name: str
    path: str  # in C
    kind: str  # of the typed array
    shape: tuple[int, ...]
    comment: str


def members_of(solver: Solver) -> list[Member]:
    """The members of the data struct."""
    functions, plan = solver.functions, solver.plan
    floats = "Float32Array" if solver.real == "float" else "Float64Array"
    found = []
    for one in functions.used:
        rows, name = plan.rows[one.entity.table], one.stored.name
        shape = (rows, one.entity.stored)
        found.append(Member(name, f"parameters.{name}", floats, shape, one.stored.title))
        if one.entity.tangent:
            shape = (rows, one.entity.tangent)
            found.append(Member(f"{name}_fixed", f"{name}_fixed", "Uint8Array", shape, "1: fixed"))
    for path, rows in plan.rows.items():
        if path:
            name = f"{solver.rows.names[path]}_count"
            found.append(Member(name, name, "Int32Array", (), f"rows of {path} in use"))
        for (table, step), name in solver.rows.refs.items():
            if table == path:
                shown = "its owner" if step.kind == "parent" else step.ref
                found.append(Member(name, name, "Int32Array", (rows,), f"row of {shown}"))
        array = functions.arrays.data.get(path)
        if array is not None:
            shape = (rows, array.size)
            found.append(Member(array.name, array.name, floats, shape, array.title))
    return found


def wasm_files(
    solver: Solver, sources: Mapping[str, str], values: Mapping[str, np.ndarray[Any, Any]]
) -> dict[str, str | bytes]:
    """Files of the project: the module, its loader, its types, a page, and its C.

    Raises
    ------
    AraelError
        E1505: there is no clang with a WebAssembly target and library, or it fails.
    """
    p = solver.prefix
    members = members_of(solver)
    found: dict[str, str | bytes] = {
        name: sources[name] for name in (f"{p}.h", f"{p}.c", f"{p}_solver.h", f"{p}_solver.c")
    }
    found[f"{p}_wasm.c"] = _glue(solver, members, values)
    found[f"{p}.wasm"] = compile_module(p, {n: t for n, t in found.items() if isinstance(t, str)})
    found[f"{p}.mjs"] = _filled("wasm.mjs.in", solver, MEMBERS=_table(members))
    found[f"{p}.d.mts"] = _filled("wasm.d.mts.in", solver, MEMBERS=_types(solver, members))
    found["index.html"] = _filled("wasm.html.in", solver)
    return found


def compile_module(name: str, sources: Mapping[str, str]) -> bytes:
    """Compile the C sources of `name` to a module."""
    compiler = next(filter(None, map(shutil.which, CLANG)), None)
    remedy = "on Debian and Ubuntu: apt install clang lld wasi-libc libclang-rt-14-dev-wasm32"
    if compiler is None:
        raise AraelError(
            Diagnostic("E1505", "no clang was found, which compiles WebAssembly", help=(remedy,))
        )
    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        for file, text in sources.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        units = [file for file in sources if file.endswith(".c")]
        command = [compiler, *FLAGS, *units, "-o", f"{name}.wasm", "-lm"]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
            )
        except subprocess.TimeoutExpired:
            raise AraelError(
                Diagnostic(
                    "E1505", f"clang took more than {TIME_LIMIT} s", help=("a smaller --size",)
                )
            ) from None
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "error" in line][:3]
            raise AraelError(
                Diagnostic(
                    "E1505",
                    "clang cannot compile or link WebAssembly",
                    notes=tuple(line.strip() for line in lines),
                    help=(remedy,),
                )
            )
        return Path(folder, f"{name}.wasm").read_bytes()


def _glue(solver: Solver, members: list[Member], values: Mapping[str, np.ndarray[Any, Any]]) -> str:
    """Functions that JavaScript calls, on one problem and one workspace."""
    p = solver.prefix
    largest = max(one.entity.tangent for one in solver.functions.used)
    lines = [
        f"/* What JavaScript calls: one problem, one workspace, the solver of {p}_solver.h. */",
        f'#include "{p}_solver.h"',
        "",
        "#define EXPORT(name) __attribute__((export_name(name)))",
        "",
        f"static {p}_data data{' = {' if values else ';'}",
    ]
    for name, value in values.items():
        if value.size:
            lines += initialiser(name, value, solver.real)
    lines += [
        *["};"] * bool(values),
        f"static {p}_state state;",
        f"static {p}_result result;",
        f"static {solver.real} block[{largest * largest}];",
        "",
        'EXPORT("address") void *address(int member)',
        "{",
        "    switch (member) {",
    ]
    for number, one in enumerate(members):
        lines.append(f"    case {number}: return &data.{one.path};")
    lines += [
        "    default: return 0;",
        "    }",
        "}",
        "",
        'EXPORT("solve") int solve(int iterations, double precision, int strategy, double damping)',
        "{",
        f"    {p}_options options = {p}_default_options();",
        "    if (iterations > 0) options.max_iterations = iterations;",
        "    if (precision > 0.0) options.relative_precision = precision;",
        "    if (damping > 0.0) options.initial_damping = damping;",
        f"    options.strategy = ({p}_strategy)strategy;",
        f"    result = {p}_solve(&state, &data, &options);",
        "    return (int)result.status;",
        "}",
        "",
        'EXPORT("start_cost") double start_cost(void) { return result.start_cost; }',
        'EXPORT("cost") double cost(void) { return result.cost; }',
        'EXPORT("iterations") int iterations(void) { return result.iterations; }',
        'EXPORT("accepted") int accepted(void) { return result.accepted; }',
    ]
    for entity in solver.functions.used:
        name = f"covariance_{entity.stored.name}"
        lines += [
            f'EXPORT("{name}") void *{name}(int row)',
            "{",
            f"    return {p}_{name}(&state, &data, row, block) ? block : 0;",
            "}",
        ]
    return "\n".join(lines) + "\n"


def _filled(template: str, solver: Solver, **texts: str) -> str:
    entities = [
        f'["{one.stored.name}", {one.entity.tangent}, {one.entity.stored}]'
        for one in solver.functions.used
    ]
    marks = {
        **texts,
        "P": solver.prefix,
        "NAME": "".join(word.capitalize() for word in solver.prefix.split("_")),
        "FLOATS": "Float32Array" if solver.real == "float" else "Float64Array",
        "ENTITIES": ", ".join(entities),
        "COVARIANCES": "\n".join(
            f"  covariance_{one.stored.name}(row: number): {_floats(solver)} | null;"
            for one in solver.functions.used
        ),
    }
    text = files("arael.exporting").joinpath(template).read_text(encoding="utf-8")
    for mark, value in marks.items():
        text = text.replace(f"@{mark}@", value)
    return text


def _floats(solver: Solver) -> str:
    return "Float32Array" if solver.real == "float" else "Float64Array"


def _table(members: list[Member]) -> str:
    """The members as an array of JavaScript."""
    return "\n".join(
        f'  ["{one.name}", {one.kind}, {int(np.prod(one.shape, dtype=int))}, {len(one.shape)}],'
        for one in members
    )


def _types(solver: Solver, members: list[Member]) -> str:
    """The members as declarations of TypeScript."""
    lines = []
    for one in members:
        shape = " x ".join(map(str, one.shape))
        text = f"{one.comment}{f'; {shape}, row by row' if shape else ''}"
        kind = f"readonly {one.name}: {one.kind}" if one.shape else f"{one.name}: number"
        lines += [f"  /** {text.replace('*/', '* /')} */", f"  {kind};"]
    return "\n".join(lines)
