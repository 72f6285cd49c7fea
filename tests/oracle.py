"""A problem evaluated by NumPy: the reference for kernels and for the expression machine.

It shares no code with them beyond the tapes and what the store holds: values of tapes, states after
a step, residuals, J'r and J'J are formed here, row by row of the system.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.operations import OPERATIONS
from arael.runtime.machine.tape import NATIVE, Tape
from arael.runtime.problem import Problem
from arael.runtime.store.access import gather

Array = NDArray[Any]


def evaluate(
    tape: Tape, inputs: Sequence[Any], dtype: Any = np.float64, natives: Any = None
) -> list[Array]:
    """Value of every node of a tape, on whole columns at once."""
    values: list[Array] = []
    with np.errstate(all="ignore"):
        for op, args in zip(tape.ops, tape.args, strict=True):
            if op == "input":
                values.append(np.asarray(inputs[args[0]]))
            elif op == "const":
                values.append(np.asarray(tape.constants[args[0]], dtype=dtype))
            elif op.startswith(NATIVE):
                values.append(natives[op.removeprefix(NATIVE)](*(values[a] for a in args)))
            else:
                function = OPERATIONS[op].numpy
                assert function is not None
                values.append(np.asarray(function(*(values[a] for a in args))))
    return values


def outputs(tape: Tape, inputs: Sequence[Any], n: int, dtype: Any, natives: Any = None) -> Array:
    """(n, outputs) of a tape."""
    values = evaluate(tape, inputs, dtype, natives)
    found = np.empty((n, len(tape.outputs)), dtype=dtype)
    for k, node in enumerate(tape.outputs):
        found[:, k] = values[node]
    return found


class Oracle:
    """A problem at the values in its store, and after steps from there.

    Attributes
    ----------
    states : one array (rows, state) per entity
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.dtype = problem, problem.dtype
        self.states = [
            np.array(states[: len(blocks.first)], dtype=self.dtype)
            for states, blocks in zip(problem.states, problem.structure.system.blocks, strict=True)
        ]
        self.moved_by(np.zeros(problem.size))
        self._data = [self._gathered(g) for g in range(len(problem.layout.groups))]

    def moved_by(self, step: Array) -> None:
        """Move the states by a step (size,)."""
        problem = self.problem
        for e, entity in enumerate(problem.layout.entities):
            at, steps = self._at(e), np.zeros((len(self.states[e]), entity.tangent), self.dtype)
            for row in np.flatnonzero(at >= 0):
                steps[row] = step[at[row] : at[row] + entity.tangent]
            inputs = [*self.states[e][:, : entity.stored].T.copy(), *steps.T]
            self.states[e] = outputs(entity.refresh, inputs, len(steps), self.dtype)

    def _at(self, e: int) -> Array:
        """First scalar of the step of each row of an entity, -1 where none moves."""
        blocks = self.problem.structure.system.blocks[e]
        return np.where(blocks.solved, blocks.first, -1)

    def _gathered(self, g: int) -> Array:
        """(n, data and uniforms) of a group, rounded to the precision of the problem."""
        problem, group = self.problem, self.problem.layout.groups[g]
        rows = problem.structure.slot_rows[g]
        raw = [gather(problem.store, group.slots, rows, one) for one in group.raw]
        n = len(problem.structure.active[g])
        return outputs(group.prepare, raw, n, np.float64, problem.natives).astype(self.dtype)

    def inputs(self, g: int) -> list[Array]:
        """Inputs of the tape of a group."""
        group, rows = self.problem.layout.groups[g], self.problem.structure.slot_rows[g]
        uses = [(group.uses[u].entity, rows[group.uses[u].slot], k) for u, k in group.states]
        found = [*(self.states[e][at, k] for e, at, k in uses), *self._data[g].T]
        if group.moving_guard is not None:
            n, last = len(self._data[g]), len(group.states) + group.data_count - 1
            holds = outputs(group.moving_guard, found, n, self.dtype, self.problem.natives)[:, 0]
            found[last] = ((holds != 0) & ~np.isnan(holds)).astype(self.dtype)
        return found

    def acting(self, g: int) -> Array:
        """(n,) bool, active instances."""
        group = self.problem.layout.groups[g]
        if group.moving_guard is None:
            return np.ones(len(self._data[g]), dtype=bool)
        return self.inputs(g)[len(group.states) + group.data_count - 1] != 0

    def rows(self, g: int) -> tuple[Array, Array]:
        """Residuals (n, residuals) and Jacobian entries (n, entries)."""
        group = self.problem.layout.groups[g]
        n = len(self._data[g])
        found = outputs(group.tape, self.inputs(g), n, self.dtype, self.problem.natives)
        return found[:, : group.residuals], found[:, group.residuals :]

    def cost(self) -> float:
        """Sum of squared residuals, in f64."""
        groups = range(len(self.problem.layout.groups))
        flat = [self.rows(g)[0].astype(np.float64).ravel() for g in groups]
        return float(sum(r @ r for r in flat))

    def linearised(self) -> tuple[Array, Array]:
        """J'r (size,) and J'J (size, size), in f64; scalars that are held included."""
        problem = self.problem
        gradient, hessian = np.zeros(problem.size), np.zeros((problem.size, problem.size))
        for g, group in enumerate(problem.layout.groups):
            residuals, entries = (part.astype(np.float64) for part in self.rows(g))
            rows = problem.structure.slot_rows[g]
            first = [self._at(use.entity)[rows[use.slot]] for use in group.uses]
            for i in range(len(residuals)):
                jacobian = np.zeros((group.residuals, problem.size))
                for k, (residual, use, tangent) in enumerate(group.jacobian):
                    if first[use][i] >= 0:
                        jacobian[residual, first[use][i] + tangent] += entries[i, k]
                gradient += jacobian.T @ residuals[i]
                hessian += jacobian.T @ jacobian
        return gradient, hessian

    def gradient(self) -> Array:
        """Gradient 2 J'r over the scalars that move."""
        return 2 * self.linearised()[0][self.problem.free]

    def hessian(self) -> Array:
        """Gauss-Newton Hessian 2 J'J over the scalars that move."""
        return 2 * self.linearised()[1][np.ix_(self.problem.free, self.problem.free)]
