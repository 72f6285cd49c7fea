"""Exported functions, compiled and called through ctypes; programs on Python's numbers."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from arael.exporting.c_functions import ConstraintFunction
from arael.exporting.exporter import Export
from arael.operations import OPERATIONS
from arael.runtime.machine.tape import Tape

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
EXACT = ["-O1", "-ffp-contract=off"]


def compiler() -> str:
    """The C compiler, or skip the test."""
    found = shutil.which("cc") or shutil.which("gcc")
    if found is None:
        pytest.skip("no C compiler")
    return found


class Library:
    """An exported project as a shared library."""

    def __init__(self, project: Export, folder: Path, *flags: str) -> None:
        self.project = project
        project.write(folder)
        stem = project.functions.prefix.removesuffix("_")
        target = folder / "functions.so"
        subprocess.run(
            [
                compiler(),
                *STRICT,
                *EXACT,
                *flags,
                "-shared",
                "-fPIC",
                f"{stem}.c",
                "-o",
                target,
                "-lm",
            ],
            cwd=folder,
            check=True,
        )
        self.library = ctypes.CDLL(str(target))
        self.real = ctypes.c_float if project.functions.real == "float" else ctypes.c_double
        self.dtype = np.float32 if self.real is ctypes.c_float else np.float64

    def call(self, name: str, *arrays: np.ndarray | None) -> int:
        """Call a function of arrays; None is NULL."""
        for one in arrays:
            assert one is None or (one.dtype == self.dtype and one.flags.c_contiguous)
        return getattr(self.library, name)(
            *(None if one is None else ctypes.c_void_p(one.ctypes.data) for one in arrays)
        )

    def evaluate(
        self, function: ConstraintFunction, states: list[np.ndarray], data: list[np.ndarray]
    ) -> tuple[int, np.ndarray, list[np.ndarray]]:
        """Return value, residual, blocks of the Jacobian."""
        r = function.group.residuals
        residual = np.full(r, np.nan, dtype=self.dtype)
        blocks = [np.full((r, one.entity.tangent), np.nan, self.dtype) for one in function.sets]
        arguments = [np.array(one, dtype=self.dtype) for one in (*states, *data)]
        active = self.call(function.name, *arguments, residual, *blocks)
        alone = np.full(r, np.nan, dtype=self.dtype)
        assert active == self.call(function.name, *arguments, alone, *[None] * len(blocks))
        np.testing.assert_array_equal(alone, residual)
        return active, residual, blocks


def on_numbers(tape: Tape, inputs: list[float]) -> list[float]:
    """Results of a program, each operation as Python's `math` has it."""
    values: list[float] = []
    for op, args in zip(tape.ops, tape.args, strict=True):
        if op == "input":
            values.append(inputs[args[0]])
        elif op == "const":
            values.append(tape.constants[args[0]])
        else:
            values.append(OPERATIONS[op].on_numbers(*(values[a] for a in args)))
    return [values[k] for k in tape.outputs]
