"""Groups that functions of the caller evaluate: their results in the data of the groups' lanes.

The tape of such a group reads residuals and Jacobian entries from its lane data and applies what
follows from them: the chart of the parameters, the loss. Everything behind it (products J'r and
J'J, scatter plan, threads, linear solvers) is that of any other group.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.structure import Structure
from arael.runtime.layout import pair_of
from arael.runtime.store.access import Array, Ints

Floats = NDArray[np.float64]


class Hook(Protocol):
    """What evaluates one group."""

    def columns(self, states: Sequence[Floats], rows: Ints, derivatives: bool) -> Floats:
        """Leading columns (n, k) of the group's data: residuals, with `derivatives` all of them.

        Parameters
        ----------
        states : per use of the group, stored scalars (n, stored) of its entity
        rows : (n,) rows of the group's table
        """

    def curvature(self) -> tuple[Ints, Ints, Ints, Ints, Ints, Floats] | None:
        """Triplets to be added to the Hessian of the cost, at the state of the last `columns`.

        Returns
        -------
        Instance, use and tangent scalar of the row, use and tangent scalar of the column, value:
        each (m,); an entry stands for its mirror image too. None if there are none.
        """

    def restart(self) -> None:
        """Take the present data, and forget results."""

    def note(self) -> str:
        """What a report is to mention; "" if nothing."""


class Update(Protocol):
    """What is called before each linearisation."""

    def __call__(self, rows_of: Callable[[int], Floats]) -> None:
        """Call the function; `rows_of` gives stored scalars (rows, stored) of an entity."""


class Hooks:
    """Functions of the caller in one problem.

    Parameters
    ----------
    structure : of the problem
    items : number of a group -> what evaluates it
    before : what is called before each linearisation
    """

    def __init__(
        self, structure: Structure, items: Mapping[int, Hook], before: Sequence[Update]
    ) -> None:
        self.items = dict(items)
        self._structure = structure
        self._before = before
        self._states: Any = None
        self._data: Any = None
        self._orders: Any = None

    @classmethod
    def of(cls, store: Any, structure: Structure) -> Hooks | None:
        """Those of a model with its runtime residuals; None if there are none."""
        items: Mapping[int, Callable[[], Hook]] = getattr(store, "hooks", {})
        before: Sequence[Update] = getattr(store, "updates", ())
        if not (items or before):
            return None
        return cls(structure, {number: make() for number, make in items.items()}, before)

    @property
    def updates(self) -> bool:
        """Whether functions are called before each linearisation."""
        return bool(self._before)

    def attach(self, states: Any, data: Any, orders: Any) -> None:
        """Take the state pair, and per group its data in lane order and the order in lanes."""
        self._states, self._data, self._orders = states, data, orders

    @property
    def notes(self) -> tuple[str, ...]:
        """What a report is to mention."""
        return tuple(note for hook in self.items.values() if (note := hook.note()))

    def restart(self) -> None:
        """Forget results of functions: their data may have changed."""
        for hook in self.items.values():
            hook.restart()

    def fill(self, which: int, derivatives: bool, group: int) -> None:
        """Evaluate one group, or all (group < 0), at one of the two states, into its lanes."""
        states = self._states.arrays[which]
        for number in self.items if group < 0 else [group]:
            if number in self.items:
                self._put(number, self.columns_at(number, states, derivatives))

    def columns_at(self, number: int, states: Sequence[Array], derivatives: bool = True) -> Floats:
        """Data (n, k) of a group at states (rows, state) of all entities."""
        structure = self._structure
        at = structure.placements[number].rows
        layout = structure.system.layout
        found = []
        for u, use in enumerate(layout.groups[number].uses):
            stored = layout.entities[use.entity].stored
            rows = np.asarray(states[use.entity])[at[:, u], :stored]
            found.append(np.ascontiguousarray(rows, dtype=np.float64))
        return self.items[number].columns(found, structure.active[number], derivatives)

    def fail(self) -> None:
        """Make all residuals NaN: a function failed."""
        for number in self.items:
            self._data[number][0][...] = np.nan

    def _put(self, number: int, found: Floats) -> None:
        """Write leading columns of a group into its lanes."""
        lanes, order = self._data[number][0], self._orders[number]
        blocks, _, width = lanes.shape
        n, k = found.shape
        if not n:
            return
        padded = np.empty((blocks * width, k))
        padded[:n] = found if order is None else found[order]
        padded[n:] = padded[n - 1]  # kernels run over whole blocks
        with np.errstate(over="ignore"):
            lanes[:, :k] = padded.reshape(blocks, width, k).transpose(0, 2, 1)

    def update(self, which: int) -> None:
        """Call what is to be called before a linearisation; residuals are then evaluated anew."""
        layout = self._structure.system.layout

        def rows_of(entity: int) -> Floats:
            state = np.asarray(self._states.arrays[which][entity], dtype=np.float64)
            rows = len(self._structure.system.blocks[entity].first)
            return np.array(state[:rows, : layout.entities[entity].stored])

        for one in self._before:
            one(rows_of)
        self.restart()

    def add_curvature(self, values: Array) -> None:
        """Add the triplets of all groups to the values of J'J: half of what they add to H."""
        for number, hook in self.items.items():
            found = hook.curvature()
            if found is None:
                continue
            offsets, what = self._places(number, *found)
            np.add.at(values, offsets, (0.5 * what).astype(values.dtype))

    def _places(
        self, number: int, instance: Ints, a: Ints, s: Ints, b: Ints, t: Ints, value: Floats
    ) -> tuple[Ints, Floats]:
        """Offsets of triplets in the values, and what is added there: the lower triangle."""
        structure = self._structure
        layout = structure.system.layout
        placement = structure.placements[number]
        uses = layout.groups[number].uses
        tangents = np.array([layout.entities[use.entity].tangent for use in uses])
        swap = (b > a) | ((a == b) & (t > s))
        a, b, s, t = (
            np.where(swap, x, y) for x, y in ((b, a), (a, b), (t, s), (s, t))
        )  # of a pair of uses the second is first
        pair = np.array(
            [pair_of(int(i), int(j)) for i, j in zip(a, b, strict=True)], dtype=np.int64
        )
        at, turn = placement.block_at[instance, pair], placement.turn[instance, pair]
        # Both uses are one row: an entry and its mirror image fall into the same square.
        onto = turn == 2
        low, high = np.minimum(s, t), np.maximum(s, t)
        straight = at + s * tangents[b] + t
        turned = at + t * tangents[a] + s
        square = at + high * tangents[b] + low
        offsets = np.where(onto, square, np.where(turn == 1, turned, straight))
        twice = onto & (s == t)
        return offsets, np.where(twice, 2.0 * value, value)
