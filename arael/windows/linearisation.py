"""Residuals and Jacobian of the constraints that leave with rows, in the problem of the model."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.geometry.differences import difference
from arael.runtime.problem import Problem
from arael.windows.system import Floats, Ints, Masks, Place, free_places, touching, use_of


class WholeSystem:
    """A `System` of a problem, whose evaluation may be moved; it is not used afterwards.

    Parameters
    ----------
    gone : rows that leave
    left_out : numbers of groups that are no part of it
    """

    def __init__(self, problem: Problem, gone: Masks, left_out: Collection[int]) -> None:
        self.problem, self.gone, self.layout = problem, gone, problem.layout
        structure = problem.structure
        self._instances = [
            touching(group, structure.active[number], structure.slot_rows[number], gone)
            if number not in left_out
            else np.zeros(len(structure.active[number]), dtype=bool)
            for number, group in enumerate(self.layout.groups)
        ]
        self._free = [block.free for block in structure.system.blocks]

    def neighbours(self) -> set[Place]:
        """See `System`."""
        found: set[Place] = set()
        for number, mask in enumerate(self._instances):
            if mask.any():
                rows = self.problem.structure.placements[number].rows[mask]
                read = [*rows.T.astype(np.int64)]
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
        state = self.problem.states[place[0]][place[1]]
        return np.array(state[use.stored_start : use.stored_start + use.stored], dtype=np.float64)

    def columns_of(self, place: Place) -> Ints:
        """See `System`."""
        use = use_of(self.layout, place)
        first = int(self.problem.structure.system.blocks[place[0]].first[place[1]])
        return first + use.tangent_start + np.arange(use.tangent if first >= 0 else 0)

    def linearise(self, bases: Mapping[Place, Floats]) -> tuple[Floats, Floats, Ints]:
        """See `System`."""
        problem, structure = self.problem, self.problem.structure
        width = problem.size + structure.trash
        chosen = [
            mask & np.asarray(problem.evaluation.acting(number)) if mask.any() else mask
            for number, mask in enumerate(self._instances)
        ]
        now = [
            problem.evaluation.group_rows(number) if mask.any() else None
            for number, mask in enumerate(chosen)
        ]
        residual = np.concatenate(
            [
                np.asarray(found[0][mask], dtype=np.float64).ravel()
                for found, mask in zip(now, chosen, strict=True)
                if found is not None
            ]
            or [np.zeros(0)]
        )
        moved = self._move_to(bases, width)
        jacobian = np.zeros((len(residual), 0))
        rows, columns, values = [], [], []
        first = 0
        for number, mask in enumerate(chosen):
            found = now[number]
            if found is None:
                continue
            entries = found[1] if moved is None else problem.evaluation.group_rows(number)[1]
            group = problem.layout.groups[number]
            own = first + group.residuals * np.arange(mask.sum())
            at = structure.placements[number].gradient_at[mask]
            for k, (component, use, tangent) in enumerate(group.jacobian):
                rows.append(own + component)
                columns.append(at[:, use] + tangent)
                values.append(np.asarray(entries[mask, k], dtype=np.float64))
            first += group.residuals * len(own)
        held = np.zeros(width, dtype=bool)
        held[structure.system.held] = True
        held[problem.size :] = True
        where = np.concatenate(columns or [np.zeros(0, dtype=np.int64)]).astype(np.int64)
        used = np.unique(where[~held[where]])
        if len(used):
            place = np.full(width, -1)
            place[used] = np.arange(len(used))
            row, column, value = np.concatenate(rows), place[where], np.concatenate(values)
            jacobian = np.zeros((len(residual), len(used)))
            np.add.at(jacobian, (row[column >= 0], column[column >= 0]), value[column >= 0])
            if moved is not None:
                residual -= jacobian @ moved[used]
        return jacobian, residual, used

    def _move_to(self, bases: Mapping[Place, Floats], width: int) -> Floats | None:
        """Move the evaluation to first estimates; (width,) present values boxminus these."""
        problem = self.problem
        moved = np.zeros(width)
        states: dict[int, NDArray[Any]] = {}
        for place, base in bases.items():
            at = self.columns_of(place)
            if not len(at):
                continue
            use, value = use_of(self.layout, place), self.value_at(place)
            if np.array_equal(base, value):
                continue
            moved[at] = difference(use.kind, base[None], value[None])[0]
            entity = problem.layout.entities[place[0]]
            state = states.get(place[0])
            if state is None:
                rows = len(problem.structure.system.blocks[place[0]].first)
                state = np.array(problem.states[place[0]][:rows, : entity.stored])
                states[place[0]] = state
            state[place[1], use.stored_start : use.stored_start + use.stored] = base
        if not states:
            return None
        for number, state in states.items():
            problem.evaluation.start_at(number, state)
        return moved
