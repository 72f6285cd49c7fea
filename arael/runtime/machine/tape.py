"""Straight-line programs over scalars: the form in which formulas reach the runtime.

A tape is what the compiler prints as C and what the NumPy interpreter runs. It knows nothing of the
language; its nodes are numbered in order of evaluation and refer only to earlier ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import msgspec
import numpy as np
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


class Natives(Protocol):
    """Native functions by name, on whole columns."""

    def __getitem__(self, name: str) -> Callable[..., Array]:
        """Return the function of that name: arrays or scalars to an array."""
        ...


class Tape(msgspec.Struct, frozen=True):
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

    @property
    def natives(self) -> set[str]:
        """Names of the native functions that the tape calls."""
        return {op.removeprefix(NATIVE) for op in self.ops if op.startswith(NATIVE)}

    @property
    def operations(self) -> int:
        """Number of arithmetic operations of one evaluation."""
        return sum(op not in ("input", "const") for op in self.ops)


def evaluate(
    tape: Tape,
    inputs: Sequence[Array],
    dtype: np.dtype[Any] | type = np.float64,
    natives: Natives | None = None,
) -> list[Array]:
    """Compute every node, for a whole column of instances at once.

    Parameters
    ----------
    tape : the program
    inputs : one array (or scalar) per input number, broadcastable against each other
    dtype : precision of the constants (and so of the evaluation, if the inputs have it too)
    natives : the native functions that the tape calls

    Returns
    -------
    One array per node of the tape; take those of ``tape.outputs`` for the results. Invalid
    operations give NaN or infinity silently, as the compiled kernel does.
    """
    values: list[Array] = []
    with np.errstate(all="ignore"):
        for op, args in zip(tape.ops, tape.args, strict=True):
            if op == "input":
                values.append(np.asarray(inputs[args[0]]))
            elif op == "const":
                values.append(np.asarray(tape.constants[args[0]], dtype=dtype))
            elif op.startswith(NATIVE):
                assert natives is not None, op
                values.append(natives[op.removeprefix(NATIVE)](*(values[a] for a in args)))
            else:
                function = PRIMITIVES[op][1]
                assert function is not None
                values.append(function(*(values[a] for a in args)))
    return values
