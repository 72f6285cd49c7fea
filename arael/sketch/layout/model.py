"""The shipped model of all sketches, compiled once per process."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from arael.runtime.machine.tape import Tape


@cache
def compiled() -> Any:
    """The compiled model ``sketch``."""
    return load_compiled("sketch")


def rows() -> KernelRows:
    """Rows of a sketch without any."""
    model = compiled()
    return KernelRows(model.layout, model.kernels)


@lru_cache(maxsize=64)
def linear(count: int) -> Tape:
    """The sum of so many inputs, each multiplied by one of as many numbers that follow."""
    ops = ["input"] * (2 * count)
    args: list[tuple[int, ...]] = [(k,) for k in range(2 * count)]
    total = -1
    for k in range(count):
        ops.append("mul")
        args.append((k, count + k))
        if total >= 0:
            ops.append("add")
            args.append((total, len(ops) - 2))
        total = len(ops) - 1
    outputs = (total, *range(count, 2 * count))
    return Tape(tuple(ops), tuple(args), (), outputs)
