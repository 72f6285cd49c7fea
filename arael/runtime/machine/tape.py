"""Straight-line programs over scalars: the form in which formulas reach the runtime.

A tape is what the compiler prints as C and what the expression machine runs. It knows nothing of
the language; its nodes are numbered in order of evaluation and refer only to earlier ones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import msgspec
from numpy.typing import NDArray

from arael.operations import OPERATIONS

Array = NDArray[Any]


# Name -> (number of arguments, NumPy implementation). "input" and "const" have no implementation.
# The others are those of `arael.operations`. A comparison yields 1.0 or 0.0.
PRIMITIVES: dict[str, tuple[int, Callable[..., Array] | None]] = {
    "input": (0, None),
    "const": (0, None),
    **{one.name: (one.arity, one.numpy) for one in OPERATIONS.values() if one.primitive},
}


NATIVE = "extern:"
"""Before the name of a native function where it is an operation of a tape."""


class Tape(msgspec.Struct, frozen=True, dict=True):
    """A straight-line program.

    Attributes
    ----------
    ops : names of `PRIMITIVES`, one per node; or ``extern:NAME``, the native function of that name
    args : one tuple per node. Of an ``input``: its number; of a ``const``: index into `constants`;
        else the numbers of earlier nodes.
    constants : literal values
    outputs : nodes that are the results
    places : per node, index into the table of source places kept beside the tape, or -1
    """

    ops: tuple[str, ...]
    args: tuple[tuple[int, ...], ...]
    constants: tuple[float, ...]
    outputs: tuple[int, ...]
    places: tuple[int, ...] = ()

    @cached_property
    def natives(self) -> frozenset[str]:
        """Names of the native functions that the tape calls."""
        return frozenset(op.removeprefix(NATIVE) for op in self.ops if op.startswith(NATIVE))

    @property
    def operations(self) -> int:
        """Number of arithmetic operations of one evaluation."""
        return sum(op not in ("input", "const") for op in self.ops)
