"""What leaves a model, as a linear system in the parameters that it reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Group, Layout, ParamUse

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Masks = Mapping[str, NDArray[np.bool_]]
Place = tuple[int, int, int]
"""Entity, row, and number of the parameter in the entity."""


class System(Protocol):
    """The instances that read rows that leave, in a problem or in the factor of `Model.update`."""

    layout: Layout

    def neighbours(self) -> set[Place]:
        """Free parameters of rows that stay, which these instances read."""

    def free_of(self, place: Place) -> NDArray[np.bool_]:
        """(tangent,) scalars of a parameter that are solved for."""

    def value_at(self, place: Place) -> Floats:
        """(stored,) present value of a parameter."""

    def columns_of(self, place: Place) -> Ints:
        """Columns of the scalars of a parameter; none if its row is not solved for."""

    def linearise(self, bases: Mapping[Place, Floats]) -> tuple[Floats, Floats, Ints]:
        """Jacobian (m, n) and residuals (m,) of the instances, and the columns (n,), ascending.

        Parameters
        ----------
        bases : first estimates of parameters that have some

        Notes
        -----
        With x the present values, x0 the first estimates and J the Jacobian at x0, the residuals
        are ``r(x) + J (y boxminus x0) - J (x boxminus x0)`` of y: exact at x, with the derivatives
        of every earlier linearisation of the same parameters, so that what they cannot observe
        stays so (G. Huang, A. Mourikis, S. Roumeliotis, "Observability-based rules for designing
        consistent EKF SLAM estimators", 2010).
        """


def use_of(layout: Layout, place: Place) -> ParamUse:
    """The parameter at a place, in its entity."""
    return layout.entities[place[0]].params[place[2]]


def touching(group: Group, rows: Ints, slot_rows: Sequence[Ints], gone: Masks) -> NDArray[np.bool_]:
    """(n,) instances of a group, `rows` of its table, that read a row that leaves."""
    found = np.zeros(len(rows), dtype=bool)
    if group.table in gone:
        found |= gone[group.table][rows]
    for slot, read in zip(group.slots, slot_rows, strict=True):
        if slot.steps and slot.table in gone and gone[slot.table].any():
            found |= (read >= 0) & gone[slot.table][read]
    return found


def free_places(
    layout: Layout,
    number: int,
    read: Sequence[Ints],
    gone: Masks,
    free: Sequence[NDArray[np.bool_]],
) -> set[Place]:
    """Free parameters of rows that stay, which chosen instances of a group read.

    Parameters
    ----------
    read : per use, the rows that the instances read
    free : per entity, (rows, tangent) scalars that are solved for
    """
    found: set[Place] = set()
    tangents: dict[int, set[int]] = {}
    for _, use, tangent in layout.groups[number].jacobian:
        tangents.setdefault(use, set()).add(tangent)
    for use, moves in tangents.items():
        entity = layout.groups[number].uses[use].entity
        leaves = gone.get(layout.entities[entity].table)
        for k, p in enumerate(layout.entities[entity].params):
            end = p.tangent_start + p.tangent
            if moves.isdisjoint(range(p.tangent_start, end)):
                continue
            for row in set(read[use].tolist()):
                if leaves is not None and leaves[row]:
                    continue
                if free[entity][row, p.tangent_start : end].any():
                    found.add((entity, row, k))
    return found
