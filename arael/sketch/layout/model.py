"""The model of all sketches, loaded once per process."""

from __future__ import annotations

from functools import cache, lru_cache

from arael.compiled_model import CompiledModel
from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from arael.runtime.machine.tape import Tape


@cache
def _loaded() -> list[CompiledModel]:
    return [load_compiled("sketch", interpret="meanwhile")]


def compiled() -> CompiledModel:
    """The model ``sketch``; without its kernels while they are compiled, which takes some seconds.

    They are in a wheel; a build from source leaves them to the first sketch.
    """
    held = _loaded()
    held[0] = held[0].current(level=2)
    return held[0]


def rows() -> KernelRows:
    """Rows of a sketch without any: on kernels, or on the expression machine without them."""
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
