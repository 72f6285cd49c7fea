"""The data of a group's active instances, gathered once per solve."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arael.runtime.access import Array, Ints, StoreLike, gather, outputs
from arael.runtime.layout import Group
from arael.runtime.tape import Natives


@dataclass(frozen=True)
class Instances:
    """Active instances of one group.

    Attributes
    ----------
    rows : (n,) rows of the group's table
    data : (n, data_count) what does not change within a solve
    uniform : (uniform_count,) what is the same for all instances
    lanes : `data` in lane order by number of lanes, once it has been asked for
    """

    rows: Ints
    data: Array
    uniform: Array
    lanes: dict[int, Array] = field(default_factory=dict, compare=False, repr=False)


def gather_instances(
    store: StoreLike,
    group: Group,
    rows: Ints,
    slot_rows: list[Ints],
    dtype: np.dtype[Any],
    natives: Natives | None = None,
) -> Instances:
    """Evaluate the group's `prepare` tape over its active rows, in f64, then round to `dtype`."""
    n = len(rows)
    data = np.zeros((n, group.data_count), dtype=dtype)
    uniform = np.zeros(group.uniform_count, dtype=dtype)
    if n:
        inputs = [gather(store, group.slots, slot_rows, raw) for raw in group.raw]
        found = outputs(group.prepare, inputs, n, natives)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(group.data_count):
                data[:, k] = found[k]
            for k in range(group.uniform_count):
                uniform[k] = found[group.data_count + k][0]
    return Instances(rows, data, uniform)


def in_lanes(values: Array, lanes: int) -> Array:
    """(n, k) in lane order [blocks][k][lanes], the last block padded by the last instance."""
    n, k = values.shape
    blocks = -(-n // lanes)
    if n == 0:
        return np.zeros((0, k, lanes), dtype=values.dtype)
    if blocks == 1:
        only = np.empty((1, k, lanes), dtype=values.dtype)
        only[0, :, :n] = values.T
        only[0, :, n:] = values[-1][:, None]
        return only
    padded = np.concatenate((values, np.repeat(values[-1:], blocks * lanes - n, axis=0)))
    return np.ascontiguousarray(padded.reshape(blocks, lanes, k).transpose(0, 2, 1))
