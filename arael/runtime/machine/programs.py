"""Programs of the expression machine: of groups, of entities, and of tapes on arrays.

Each is assembled when it is first needed, and kept with the group, entity or tape.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Entity, Group, Layout
from arael.runtime.machine.compiled import Program, TapeProgram
from arael.runtime.machine.tape import Tape

if TYPE_CHECKING:
    from arael.runtime.machine.compiled import NativeTable

Array = NDArray[Any]


def group_program(layout: Layout, group: Group) -> Program:
    """Program of a group of the layout."""
    found: Program | None = group.__dict__.get("program")
    if found is None:
        natives = [f.name for f in layout.functions if f.native]
        found = Program(group, layout.entities, layout.precision == "f32", natives)
        group.__dict__["program"] = found
    return found


def entity_program(entity: Entity) -> TapeProgram:
    """Program that moves rows of an entity by a step."""
    return tape_program(entity.refresh, entity.stored + entity.tangent)


def evaluate(
    tape: Tape,
    inputs: Sequence[Any],
    dtype: np.dtype[Any] | type = np.float64,
    natives: NativeTable | None = None,
) -> list[Array]:
    """Outputs of a tape on arrays.

    Parameters
    ----------
    tape : the program
    inputs : one array or number per input, broadcastable against each other
    dtype : precision of the evaluation, f64 or f32
    natives : the native functions that the tape calls

    Returns
    -------
    One array per output, of the shape that the inputs broadcast to. Invalid operations give NaN or
    infinity silently, as compiled kernels do.

    Raises
    ------
    Exception
        What a native function in Python raises.
    """
    found, shape = columns_of(tape, inputs, dtype, natives)
    return list(found if len(shape) == 1 else found.reshape(len(found), *shape))


def columns_of(
    tape: Tape,
    inputs: Sequence[Any],
    dtype: np.dtype[Any] | type = np.float64,
    natives: NativeTable | None = None,
) -> tuple[Array, tuple[int, ...]]:
    """Outputs of a tape as one array (outputs, scalars), and their shape; see `evaluate`."""
    dtype = np.dtype(dtype)
    names = () if natives is None else tuple(natives.names)
    arrays = [np.asarray(one, dtype=dtype) for one in inputs]
    shapes = {one.shape for one in arrays if one.ndim}
    shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    if shapes or len(shape) > 1:
        arrays = [one if one.ndim == 0 else np.broadcast_to(one, shape).ravel() for one in arrays]
    n = prod(shape)
    found = tape_program(tape, len(arrays), names).columns(arrays, n, dtype, natives)
    if natives is not None:
        natives.raise_failure()
    return found, shape


def tape_program(tape: Tape, inputs: int, natives: tuple[str, ...] = ()) -> TapeProgram:
    """Program of a tape of so many inputs, which calls these native functions."""
    known = tape.__dict__.setdefault("programs", {})
    key = inputs, natives
    found: TapeProgram | None = known.get(key)
    if found is None:
        found = known[key] = TapeProgram(tape, inputs, natives)
    return found
