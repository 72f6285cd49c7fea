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

from arael.runtime.machine.library import FUNCTIONS

Array = NDArray[Any]


def _sign(x: Array) -> Array:
    return np.sign(x)


def _heaviside(x: Array) -> Array:
    """Step from 0 to 1, one half at 0."""
    return np.heaviside(x, 0.5)


def _round_half_away(x: Array) -> Array:
    """Round as C does: halves go away from zero, unlike NumPy's."""
    return np.copysign(np.floor(np.abs(x) + 0.5), x)


def _where(condition: Array, taken: Array, otherwise: Array) -> Array:
    return np.where(condition != 0, taken, otherwise)


def _as_number(compare: Callable[..., Array]) -> Callable[..., Array]:
    return lambda *a: compare(*a).astype(np.result_type(*a, np.float32))


# Name -> (number of arguments, NumPy implementation). "input" and "const" have no implementation.
# Functions of the C library are those of `arael.runtime.machine.library`.
# A comparison yields 1.0 or 0.0.
PRIMITIVES: dict[str, tuple[int, Callable[..., Array] | None]] = {
    "input": (0, None),
    "const": (0, None),
    "add": (2, np.add),
    "sub": (2, np.subtract),
    "mul": (2, np.multiply),
    "div": (2, np.divide),
    "neg": (1, np.negative),
    **{f.name: (f.arity, f.numpy) for f in FUNCTIONS if f.opcode},
    "abs": (1, np.abs),
    "sign": (1, _sign),
    "heaviside": (1, _heaviside),
    "floor": (1, np.floor),
    "ceil": (1, np.ceil),
    "round": (1, _round_half_away),
    "min": (2, np.minimum),
    "max": (2, np.maximum),
    "identity": (1, np.positive),
    "lt": (2, _as_number(np.less)),
    "le": (2, _as_number(np.less_equal)),
    "eq": (2, _as_number(np.equal)),
    "ne": (2, _as_number(np.not_equal)),
    "and": (2, _as_number(np.logical_and)),
    "or": (2, _as_number(np.logical_or)),
    "not": (1, _as_number(np.logical_not)),
    "select": (3, _where),
    **{f.name: (f.arity, f.numpy) for f in FUNCTIONS if not f.opcode},
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
