"""The files of an exported project: header, source, main program, CMake, a page to read."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np

from arael.compiler.emit.writer import comment
from arael.exporting.c_functions import ConstraintFunction, Functions, header, source
from arael.exporting.sample import Samples
from arael.exporting.statements import c_comment
from arael.symbolic.c import c_literal
from arael.version import __version__

SHOWN = 3
"""Instances of each constraint that `main.c` evaluates."""

_TEXT_LINES, _TEXT_WIDTH = 400, 200
"""Most lines and columns of the model in the head."""


def head(functions: Functions, text: str) -> str:
    """Comment at the top of a file: the model, its hash, options, its text.

    Parameters
    ----------
    functions : of the model
    text : of the model
    """
    layout = functions.layout
    lines = text.splitlines()
    shown = [f"     {c_comment(line, _TEXT_WIDTH)}" for line in lines[:_TEXT_LINES]]
    if len(lines) > _TEXT_LINES:
        shown.append(f"     and {len(lines) - _TEXT_LINES} more lines")
    digest = hashlib.sha256(text.encode()).hexdigest()
    name = layout.source.replace("\\", "/").rpartition("/")[2]
    top = [
        f"/* Functions of the model {c_comment(layout.name)}, written by arael {__version__}.",
        "",
        f"   Model       {c_comment(name)}, SHA-256 {digest}",
        f"   Precision   {layout.precision}",
        f"   Constraints {len(functions.constraints)}",
    ]
    if "starship" in text:
        top += [
            "",
            "   `starship`, gamma * atan(r / gamma), is described by its authors as patented",
            "   (US 12,346,118); check for yourself whether you may use it.",
        ]
    return "\n".join([*top, "", *(line.rstrip() for line in shown), "*/"])


def files_of(functions: Functions, text: str, samples: Sequence[Samples] | None) -> dict[str, str]:
    """Text of each file by its name.

    Parameters
    ----------
    functions : what is exported
    text : of the model
    samples : arguments that `main.c` evaluates, by function; None: there is no data, and `main.c`
        evaluates all functions at zeros
    """
    stem = functions.prefix.removesuffix("_")
    return {
        f"{stem}.h": header(functions, head(functions, text)),
        f"{stem}.c": source(functions, f"/* Functions of {stem}.h, which has the model. */"),
        "main.c": _main(functions, samples),
        "CMakeLists.txt": cmake(stem, f"{stem}.c"),
    }


def cmake(stem: str, *sources: str) -> str:
    """Text of `CMakeLists.txt` for a library of `sources` and `main.c`."""
    return f"""cmake_minimum_required(VERSION 3.13)
project({stem} C)

add_library({stem} STATIC {" ".join(sources)})
target_include_directories({stem} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
set_target_properties({stem} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
if(NOT MSVC)
  # Without fused operations results have the same bits as those of arael on the same machine.
  target_compile_options({stem} PRIVATE -O2 -ffp-contract=off)
  target_link_libraries({stem} PUBLIC m)
endif()

add_executable({stem}_main main.c)
target_link_libraries({stem}_main PRIVATE {stem})
"""


def _main(functions: Functions, samples: Sequence[Samples] | None) -> str:
    stem, real = functions.prefix.removesuffix("_"), functions.real
    lines = [
        "/* Evaluates residuals and derivatives of the first rows of the data, and prints them. */",
        "#include <stdio.h>",
        "",
        f'#include "{stem}.h"',
        "",
        f"static void print(const char *name, int rows, int columns, const {real} *values)",
        "{",
        '    printf("  %s\\n", name);',
        "    for (int i = 0; i < rows; i++) {",
        '        printf("   ");',
        "        for (int k = 0; k < columns; k++)",
        '            printf(" %.17g", (double)values[i * columns + k]);',
        '        printf("\\n");',
        "    }",
        "}",
        "",
        "int main(void)",
        "{",
    ]
    for number, function in enumerate(functions.constraints):
        arguments = samples[number] if samples is not None else _zeros(function)
        for k, row in enumerate(arguments.rows[:SHOWN]):
            values = [*(a[k] for a in arguments.states), *(a[k] for a in arguments.data)]
            lines += _call(functions, function, int(row), values)
    return "\n".join([*lines, "    return 0;", "}"]) + "\n"


def _zeros(function: ConstraintFunction) -> Samples:
    """Arguments without data: neutral parameters, zeros for data."""
    states = []
    for one in function.sets:
        values = np.zeros((1, one.entity.stored))
        for part in one.stored.parts:
            for k, suffix in enumerate(part.suffixes):
                values[0, part.first + k] = suffix in (".w", ".rotation.w", ".scale")
        states.append(values)
    data = tuple(np.zeros((1, one.array.size)) for one in function.data)
    return Samples(np.zeros(1, dtype=np.int64), tuple(states), data)


def _call(
    functions: Functions, function: ConstraintFunction, row: int, values: Sequence[np.ndarray]
) -> list[str]:
    group, real = function.group, functions.real
    lines = ["    {"]
    for one, numbers in zip((*function.states, *function.data), values, strict=True):
        texts = ", ".join(c_literal(v, real) for v in numbers)
        lines += _folded(f"const {real} {one.name}[] = {{{texts}}};")
    lines.append(f"        {real} residual[{group.residuals}];")
    for name, solved in zip(function.jacobians, function.sets, strict=True):
        lines.append(f"        {real} {name}[{group.residuals * max(solved.entity.tangent, 1)}];")
    arguments = [one.name for one in (*function.states, *function.data)]
    arguments += ["residual", *function.jacobians]
    lines += _folded(f"int active = {function.name}({', '.join(arguments)});")
    label = comment(f"{group.label}[{row}]")
    lines.append(f'        printf("{label}%s\\n", active ? "" : ": inactive");')
    lines.append(f'        print("residual", 1, {group.residuals}, residual);')
    for name, solved in zip(function.jacobians, function.sets, strict=True):
        lines.append(
            f'        print("{name}", {group.residuals}, {solved.entity.tangent}, {name});'
        )
    return [*lines, "    }"]


def _folded(text: str) -> list[str]:
    """A statement over several lines, cut at blanks."""
    lines, current = [], "       "
    for word in text.split(" "):
        if len(current) + 1 + len(word) > 96 and current.strip():
            lines.append(current)
            current = "           "
        current += f" {word}"
    return [*lines, current]
