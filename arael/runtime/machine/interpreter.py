"""Evaluation of constraints and parameters by NumPy, for use without a C compiler.

It performs the operations of the generated kernels on the same arrays, and is the reference in
their tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from arael.runtime.assembly.placement import Placement
from arael.runtime.evaluation.instances import Instances
from arael.runtime.layout import Entity, Group, Layout, pair_of
from arael.runtime.machine.tape import Natives, Tape, evaluate
from arael.runtime.store.access import Array


def restricted(tape: Tape, outputs: tuple[int, ...]) -> Tape:
    """The part of a tape that computes the given nodes, with these as outputs."""
    needed = set(outputs)
    for node in range(len(tape.ops) - 1, -1, -1):
        if node in needed and tape.ops[node] not in ("input", "const"):
            needed.update(tape.args[node])
    kept = sorted(needed)
    number = {node: i for i, node in enumerate(kept)}

    def renumbered(node: int) -> tuple[int, ...]:
        if tape.ops[node] in ("input", "const"):
            return tape.args[node]
        return tuple(number[a] for a in tape.args[node])

    return Tape(
        tuple(tape.ops[node] for node in kept),
        tuple(renumbered(node) for node in kept),
        tape.constants,
        tuple(number[node] for node in outputs),
        tuple(tape.places[node] for node in kept) if tape.places else (),
    )


class GroupInterpreter:
    """One group's instances.

    Parameters
    ----------
    group : the constraint
    tangents : (uses) scalars solved for in each used entity
    instances : its data
    placement : scatter offsets of its contributions
    dtype : precision of the root
    natives : native functions of the model
    """

    def __init__(
        self,
        group: Group,
        entities: Sequence[Entity],
        instances: Instances,
        placement: Placement,
        dtype: np.dtype[Any],
        natives: Natives | None = None,
    ) -> None:
        self.group = group
        self.instances = instances
        self.placement = placement
        self.dtype = dtype
        self.natives = natives
        self.tangents = [entities[use.entity].tangent for use in group.uses]
        self._residual_tape = restricted(group.tape, group.tape.outputs[: group.residuals])

    def inputs(self, states: Sequence[Array]) -> list[Array]:
        """Inputs of the group's tape, each (n,) or a scalar; `states` one array per entity."""
        at = self.placement.rows
        uses = self.group.uses
        moving = [states[uses[u].entity][at[:, u], offset] for u, offset in self.group.states]
        return [*moving, *self.instances.data.T, *self.instances.uniform]

    def residuals(self, states: Sequence[Array]) -> Array:
        """(n, residuals)."""
        return self._run(self._residual_tape, states)

    def guard(self, states: Sequence[Array]) -> None:
        """Evaluate the guard over parameters, if there is one, to select the active instances."""
        if self.group.moving_guard is not None:
            holds = self._run(self.group.moving_guard, states)[:, 0]
            self.instances.data[:, -1] = (holds != 0) & ~np.isnan(holds)

    @property
    def acting(self) -> Array:
        """(n,) bool, active instances of the last evaluation of the guard."""
        if self.group.moving_guard is None:
            return np.ones(len(self.instances.rows), dtype=bool)
        return np.asarray(self.instances.data[:, -1] != 0)

    def cost(self, states: Sequence[Array]) -> float:
        """Sum of squared residuals, in f64."""
        return _squares(self.residuals(states))

    def costs(self, states: Sequence[Array]) -> Array:
        """(n,) squared residuals of each instance, in f64."""
        r = self.residuals(states).astype(np.float64)
        with np.errstate(all="ignore"):
            return np.asarray(np.einsum("nr,nr->n", r, r))

    def rows(self, states: Sequence[Array]) -> tuple[Array, Array]:
        """Residuals (n, residuals) and Jacobian entries (n, entries) as in `Group.jacobian`."""
        found = self._run(self.group.tape, states)
        return found[:, : self.group.residuals], found[:, self.group.residuals :]

    def linearise(self, states: Sequence[Array], gradient: Array, values: Array) -> float:
        """Add J'r and the blocks of J'J of all instances; return the cost."""
        r, entries = self.rows(states)
        n = len(r)
        with np.errstate(all="ignore"):
            jacobians = [np.zeros((n, self.group.residuals, t), self.dtype) for t in self.tangents]
            for k, (residual, use, tangent) in enumerate(self.group.jacobian):
                jacobians[use][:, residual, tangent] += entries[:, k]
            for use, jac in enumerate(jacobians):
                at = self.placement.gradient_at[:, use, None] + np.arange(jac.shape[2])
                np.add.at(gradient, at, np.einsum("nrt,nr->nt", jac, r))
            for a in range(len(jacobians)):
                for b in range(a + 1):
                    product = np.einsum("nri,nrj->nij", jacobians[a], jacobians[b])
                    self._add_block(a, b, product, values)
        return _squares(r)

    def _add_block(self, a: int, b: int, product: Array, values: Array) -> None:
        pair = pair_of(a, b)
        at, turn = self.placement.block_at[:, pair], self.placement.turn[:, pair]
        height, width = product.shape[1:]
        i, j = np.arange(height)[:, None], np.arange(width)[None, :]
        lower = (i >= j).ravel() if a == b else slice(None)
        for kind in range(3):
            chosen = turn == kind
            if not chosen.any():
                continue
            part = product[chosen]
            if kind == 2:
                part, lower = part + part.transpose(0, 2, 1), (i >= j).ravel()
            offsets = (j * height + i if kind == 1 else i * width + j).ravel()
            where = at[chosen, None] + offsets[None, lower]
            np.add.at(values, where, part.reshape(len(part), -1)[:, lower])

    def _run(self, tape: Tape, states: Sequence[Array]) -> Array:
        n = len(self.instances.rows)
        values = evaluate(tape, self.inputs(states), self.dtype, self.natives)
        found = np.empty((n, len(tape.outputs)), dtype=self.dtype)
        for k, node in enumerate(tape.outputs):
            found[:, k] = values[node]
        return found


class Interpreters:
    """The interpreters of all groups, created on first use."""

    def __init__(
        self,
        layout: Layout,
        instances: Sequence[Instances],
        placements: Sequence[Placement],
        dtype: np.dtype[Any],
        natives: Natives | None,
    ) -> None:
        self._layout, self._placements = layout, placements
        self._instances = list(instances)
        self._dtype, self._natives = dtype, natives
        self._made: dict[int, GroupInterpreter] = {}

    def __getitem__(self, g: int) -> GroupInterpreter:
        if g not in self._made:
            self._made[g] = GroupInterpreter(
                self._layout.groups[g],
                self._layout.entities,
                self._instances[g],
                self._placements[g],
                self._dtype,
                self._natives,
            )
        return self._made[g]

    def replace(self, g: int, one: Instances) -> None:
        """Replace the data of a group."""
        self._instances[g] = one
        self._made.pop(g, None)


def _squares(residuals: Array) -> float:
    flat = residuals.astype(np.float64).ravel()
    with np.errstate(all="ignore"):
        return float(flat @ flat)


def refresh(entity: Entity, state: Array, step: Array, moved: Array) -> None:
    """States of all rows after a step.

    Parameters
    ----------
    entity : entity of the rows
    state : (rows, state) before; only the stored scalars are read
    step : (rows, tangent), zero for fixed scalars
    moved : (rows, state) output; may be `state`
    """
    inputs = [*state[:, : entity.stored].T.copy(), *step.T]
    values = evaluate(entity.refresh, inputs, state.dtype)
    for k, node in enumerate(entity.refresh.outputs):
        moved[:, k] = values[node]
