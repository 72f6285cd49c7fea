"""The accepted state of a problem: moved for a trial, and put back."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.constrained.rows import Floats, Ints
from arael.runtime.problem import Problem


class States:
    """Moves of the accepted state of `problem`."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        system = problem.structure.system
        self._parts = [
            (len(block.free), entity.stored)
            for entity, block in zip(problem.layout.entities, system.blocks, strict=True)
        ]
        self._plain: list[tuple[int, Ints, Ints]] = []
        for number, (entity, block) in enumerate(
            zip(problem.layout.entities, system.blocks, strict=True)
        ):
            rows = np.flatnonzero(block.first >= 0)[:, None]
            tangent: list[int] = []
            stored: list[int] = []
            for use in entity.params:
                if use.stored == use.tangent:
                    tangent += range(use.tangent_start, use.tangent_start + use.tangent)
                    stored += range(use.stored_start, use.stored_start + use.stored)
            if tangent and len(rows):
                scalars = block.first[rows] + np.array(tangent)
                at = rows * entity.state + np.array(stored)
                self._plain.append((number, scalars.ravel(), at.ravel()))

    def saved(self) -> list[NDArray[Any]]:
        """The stored scalars of all entities."""
        return [
            np.array(state[:rows, :stored])
            for state, (rows, stored) in zip(self.problem.states, self._parts, strict=True)
        ]

    def back(self, saved: list[NDArray[Any]]) -> None:
        """Put saved scalars back."""
        for number, values in enumerate(saved):
            self.problem.evaluation.start_at(number, values)

    @contextmanager
    def moved(self, step: Floats) -> Iterator[None]:
        """The state moved by a step, for a while."""
        before = self.saved()
        self.problem.evaluation.moved_by(step)
        try:
            yield
        finally:
            self.back(before)

    def sizes(self) -> Floats:
        """(n,) magnitude of plain scalars; 1 for those of rotations and directions."""
        found = np.ones(self.problem.size)
        states = self.problem.states
        for number, scalars, at in self._plain:
            found[scalars] = np.abs(states[number].reshape(-1)[at])
        return found
