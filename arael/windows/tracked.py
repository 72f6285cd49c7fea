"""Residuals and Jacobian of the constraints that leave, from the factor of `Model.update`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.geometry.differences import difference
from arael.online.priors import only_priors
from arael.online.tracker import Tracker
from arael.online.update import unsupported
from arael.runtime.assembly.structure import rows_of_slots
from arael.session import session_of
from arael.windows.system import Floats, Ints, Masks, Place, free_places, touching, use_of


def tracked_system(model: Any, gone: Masks) -> TrackedSystem | None:
    """What leaves a model, which the factor of `Model.update` has taken in; None without one."""
    session, priors = session_of(model), only_priors(model)
    tracker = session.online
    if not isinstance(tracker, Tracker) or tracker.frozen or priors is None or unsupported(model):
        return None
    try:
        tracker.take(frozenset(), priors)
        tracker.engine.prepare()
    except BaseException:
        session.online = None
        raise
    return TrackedSystem(tracker, gone)


class TrackedSystem:
    """A `System` of a tracker: only the instances that leave are evaluated.

    Parameters
    ----------
    tracker : that has taken in all changes
    gone : rows that leave
    """

    def __init__(self, tracker: Tracker, gone: Masks) -> None:
        self.tracker, self.layout, self.gone = tracker, tracker.layout, gone
        self._free = [~held for held in tracker.held]
        self._first: dict[tuple[int, int], int] = {}  # columns of a row of an entity
        self._width = 0
        self._chosen: list[tuple[int, NDArray[np.int32], list[Ints]]] = []
        for number, group in enumerate(self.layout.groups):
            terms = tracker.terms[number]
            if not len(terms.rows):
                continue
            slot_rows = rows_of_slots(tracker.store, group, terms.rows)
            mask = touching(group, terms.rows, slot_rows, gone)
            if mask.any():
                read = [slot_rows[use.slot][mask] for use in group.uses]
                self._chosen.append((number, terms.numbers[mask], read))

    def neighbours(self) -> set[Place]:
        """See `System`."""
        found: set[Place] = set()
        for number, _, read in self._chosen:
            found |= free_places(self.layout, number, read, self.gone, self._free)
        return found

    def free_of(self, place: Place) -> NDArray[np.bool_]:
        """See `System`."""
        use = use_of(self.layout, place)
        free = self._free[place[0]][place[1]]
        found: NDArray[np.bool_] = free[use.tangent_start : use.tangent_start + use.tangent]
        return found

    def value_at(self, place: Place) -> Floats:
        """See `System`."""
        use = use_of(self.layout, place)
        state = self.tracker.stored[place[0]][place[1]]
        return np.array(state[use.stored_start : use.stored_start + use.stored])

    def columns_of(self, place: Place) -> Ints:
        """See `System`."""
        use = use_of(self.layout, place)
        return self._start(place[0], place[1]) + use.tangent_start + np.arange(use.tangent)

    def _start(self, entity: int, row: int) -> int:
        """First column of a row, the next free one if it has none."""
        found = self._first.get((entity, row))
        if found is None:
            found = self._first[entity, row] = self._width
            self._width += self.layout.entities[entity].tangent
        return found

    def linearise(self, bases: Mapping[Place, Floats]) -> tuple[Floats, Floats, Ints]:
        """See `System`."""
        starts = [self._starts(number, read) for number, _, read in self._chosen]
        now = self._blocks()
        moved = np.zeros(self._width)
        there = self._blocks_at(bases, moved)
        rows, residuals, used = [], [], np.zeros(self._width, dtype=bool)
        for (number, _, read), first, block, other in zip(
            self._chosen, starts, now, there, strict=True
        ):
            group = self.layout.groups[number]
            acting = block.any(axis=(1, 2))  # false where a guard holds no longer
            jacobian = np.zeros((len(block), group.residuals, self._width))
            at = 0
            for u, use in enumerate(group.uses):
                free = self._free[use.entity][read[u]]
                for k in range(free.shape[1]):
                    column = first[u] + k
                    values = other[:, :, at + k] * (free[:, k] & acting)[:, None]
                    jacobian[np.arange(len(block)), :, column] += values
                    used[column[values.any(axis=1)]] = True
                at += free.shape[1]
            rows.append(jacobian.reshape(-1, self._width))
            residuals.append(block[:, :, -1].ravel())
        whole = np.concatenate(rows or [np.zeros((0, self._width))])
        residual = np.concatenate(residuals or [np.zeros(0)]) - whole @ moved
        columns = np.flatnonzero(used)
        return whole[:, columns], residual, columns

    def _starts(self, number: int, read: list[Ints]) -> list[Ints]:
        """Per use, the first column of each row that is read."""
        return [
            np.array([self._start(use.entity, row) for row in rows.tolist()], dtype=np.int64)
            for use, rows in zip(self.layout.groups[number].uses, read, strict=True)
        ]

    def _blocks(self) -> list[Floats]:
        engine = self.tracker.engine
        return [engine.at_estimates(number, terms) for number, terms, _ in self._chosen]

    def _blocks_at(self, bases: Mapping[Place, Floats], moved: Floats) -> list[Floats]:
        """Blocks at first estimates; sets present values boxminus these in `moved`."""
        tracker = self.tracker
        states: dict[tuple[int, int], Floats] = {}
        for place, base in bases.items():
            entity, row, _ = place
            if (entity, row) not in self._first:
                continue  # read by no instance that leaves
            use, value = use_of(self.layout, place), self.value_at(place)
            moved[self.columns_of(place)] = difference(use.kind, base[None], value[None])[0]
            state = states.setdefault((entity, row), tracker.stored[entity][row].copy())
            state[use.stored_start : use.stored_start + use.stored] = base
        try:
            for (entity, row), state in states.items():
                tracker.engine.put_estimates(
                    entity, tracker.variables[entity][row : row + 1], state[None]
                )
            return self._blocks()
        finally:
            for entity, row in states:
                tracker.engine.put_estimates(
                    entity,
                    tracker.variables[entity][row : row + 1],
                    tracker.stored[entity][row : row + 1],
                )
