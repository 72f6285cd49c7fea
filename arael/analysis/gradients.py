"""Comparison of the Jacobian with central differences of the residuals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.layout import Entity, Group
from arael.runtime.machine.programs import evaluate
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

LENGTHS = tuple(0.25 * 16.0**-k for k in range(8))
"""Step lengths relative to each parameter's magnitude."""
TOLERANCE = 1e-5
"""Largest relative difference beyond its error bound that counts as rounding."""

# Rounding error of a residual or an entry, as a multiple of the precision, for long formulas.
_ROUNDINGS = 32.0


@dataclass(frozen=True)
class GradientCheck:
    """Agreement of the derivatives of one constraint with central differences.

    Attributes
    ----------
    label : of the constraint
    instances : number of instances compared
    difference : the relative difference that exceeds its bound most
    bound : its error bound, from rounding and curvature
    worst : name of its instance, and its row
    residual : number of its residual, 0 for several residuals with a loss
    derivative, measured : the value of the Jacobian and the central difference
    parameter : where they disagree, the scalar whose derivative is wrong in that instance
    """

    label: str
    instances: int
    difference: float
    bound: float
    worst: str
    residual: int
    derivative: float
    measured: float
    parameter: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the difference is within `TOLERANCE` and its error bound."""
        return self.difference <= TOLERANCE + self.bound

    @property
    def conclusive(self) -> bool:
        """Whether the bound is small enough to detect a wrong derivative."""
        return self.bound <= 1e-3


class GradientChecks(Displayed, list[GradientCheck]):
    """The checks of all constraints; a table in notebooks and for rich."""

    def _sheet(self) -> Sheet:
        head = ("constraint", "instances", "difference", "bound", "agrees", "worst")
        rows = [
            (
                one.label,
                str(one.instances),
                f"{one.difference:.2g}",
                f"{one.bound:.2g}",
                ("yes" if one.conclusive else "not conclusive") if one.agrees else "no",
                f"{one.worst}, {one.parameter}" if one.parameter else one.worst,
            )
            for one in self
        ]
        return Sheet("derivatives beside central differences", head, rows)


def check_gradients(problem: Problem, directions: int = 3, seed: int = 0) -> GradientChecks:
    """Compare J d with central differences of the residuals along random directions d.

    Where several residuals have a loss, only their part of the gradient is a derivative
    (`arael.compiler.losses`): there, half the squared residuals of an instance take the place of
    its residuals.

    Steps are in proportion to the magnitude of each parameter. Differences are computed in f64 with
    eight step lengths, and for each residual the two that agree best are used: long steps suffer
    from curvature, short ones from rounding. The error bound is the difference of these two plus
    the rounding of residuals and Jacobian.

    Parameters
    ----------
    problem : in f64, or in f32 with larger rounding bounds
    directions : number of random directions; each changes every free parameter

    Returns
    -------
    The largest difference for each constraint that has instances, in the order of the model.
    """
    rng = np.random.default_rng(seed)
    found: dict[int, GradientCheck] = {}
    system = problem.structure.system
    scales = [
        _scales(entity, np.asarray(state, dtype=np.float64)[: len(block.free)])
        for entity, block, state in zip(
            problem.layout.entities, system.blocks, problem.states, strict=True
        )
    ]
    checked = [
        _Group(problem, number)
        for number, active in enumerate(problem.structure.active)
        if len(active) and not _is_constant(problem.layout.groups[number])
    ]
    still: list[Floats] = [np.zeros(block.free.shape) for block in system.blocks]
    here = _moved(problem, still, 0.0)
    for _ in range(directions):
        steps: list[Floats] = [
            np.asarray(rng.standard_normal(block.free.shape) * block.free * scale, np.float64)
            for block, scale in zip(system.blocks, scales, strict=True)
        ]
        both = [
            (length, _moved(problem, steps, length), _moved(problem, steps, -length))
            for length in LENGTHS
        ]
        for group in checked:
            one, instance = group.compare(steps, here, both)
            known = found.get(group.number)
            if known is None or not one.difference - one.bound <= known.difference - known.bound:
                found[group.number], group.worst = one, instance
    for group in checked:
        one = found[group.number]
        if not one.agrees:
            found[group.number] = replace(one, parameter=group.wrong_parameter(scales, here))
    return _joined(problem, found)


def _is_constant(group: Group) -> bool:
    """Whether a constraint that sums over rows reads no parameter, since there are no rows."""
    return group.row_sums is not None and not group.jacobian


def _joined(problem: Problem, found: dict[int, GradientCheck]) -> GradientChecks:
    """One check for each constraint: the groups of one that sums over rows are one constraint."""
    joined: dict[int, GradientCheck] = {}
    for number in sorted(found):
        one, case_of = found[number], problem.layout.groups[number].case_of
        known = joined.get(case_of if case_of >= 0 else number)
        if known is not None:
            worse = one if one.difference - one.bound > known.difference - known.bound else known
            one = replace(worse, instances=known.instances + one.instances)
        joined[case_of if case_of >= 0 else number] = one
    return GradientChecks(joined[number] for number in sorted(joined))


def _scales(entity: Entity, state: Floats) -> Floats:
    """(rows, tangent) magnitude of each parameter; 1 for rotations and where all are zero."""
    scales = np.ones((len(state), entity.tangent))
    for use in entity.params:
        if use.tangent != use.stored or not len(state):
            continue
        values = np.abs(state[:, use.stored_start : use.stored_start + use.stored]).max(axis=1)
        known = values[np.isfinite(values) & (values > 0)]
        usual = float(np.median(known)) if len(known) else 1.0
        size = np.where(np.isfinite(values) & (values > 0), values, usual)
        scales[:, use.tangent_start : use.tangent_start + use.tangent] = size[:, None]
    return scales


def _moved(problem: Problem, steps: list[Floats], length: float) -> list[Floats]:
    states = []
    for entity, state, step in zip(problem.layout.entities, problem.states, steps, strict=True):
        moved = np.array(state, dtype=np.float64)
        if len(step):
            inputs = [*moved[: len(step), : entity.stored].T, *(length * step).T]
            for k, column in enumerate(evaluate(entity.refresh, inputs)):
                moved[: len(step), k] = column
        states.append(moved)
    return states


class _Group:
    """One constraint at the accepted state."""

    def __init__(self, problem: Problem, number: int) -> None:
        self.problem, self.number = problem, number
        self.group = problem.layout.groups[number]
        self.tape = msgspec.structs.replace(
            self.group.tape, outputs=self.group.tape.outputs[: self.group.residuals]
        )
        self.residuals, self.entries = (
            np.asarray(part, dtype=np.float64) for part in problem.evaluation.group_rows(number)
        )
        self.rows = problem.structure.placements[number].rows
        self.worst = 0  # instance with the largest difference so far
        self.squared = bool(self.group.loss_text) and self.group.residuals > 1

    def wrong_parameter(self, scales: list[Floats], here: list[Floats]) -> str:
        """Return the scalar along which the worst instance disagrees most."""
        problem, group = self.problem, self.group
        instance = self.worst
        worst, name = -np.inf, ""
        for use, tangent in dict.fromkeys((use, tangent) for _, use, tangent in group.jacobian):
            number, row = group.uses[use].entity, int(self.rows[instance, use])
            block = problem.structure.system.blocks[number]
            if row >= len(block.free) or not block.free[row, tangent]:
                continue
            steps = [np.zeros_like(scale) for scale in scales]
            steps[number][row, tangent] = scales[number][row, tangent]
            both = [
                (length, _moved(problem, steps, length), _moved(problem, steps, -length))
                for length in LENGTHS
            ]
            one, _ = self.compare(steps, here, both, instance)
            if one.difference - one.bound > worst:
                worst = one.difference - one.bound
                first = int(problem.structure.placements[self.number].gradient_at[instance, use])
                name = problem.structure.system.name_of(first + tangent)
        return name

    def compare(
        self,
        steps: list[Floats],
        here: list[Floats],
        both: list[tuple[float, list[Floats], list[Floats]]],
        only: int | None = None,
    ) -> tuple[GradientCheck, int]:
        """Return the instance whose difference exceeds its bound most, along one direction.

        With `only`, that instance. Its number is the second result.
        """
        group, problem = self.group, self.problem
        derivative, terms = np.zeros((2, *self.residuals.shape))
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            direction = steps[group.uses[use].entity][self.rows[:, use], tangent]
            derivative[:, residual] += self.entries[:, k] * direction
            terms[:, residual] += np.abs(self.entries[:, k] * direction)
        if self.squared:
            derivative = (self.residuals * derivative).sum(axis=1, keepdims=True)
            terms = (np.abs(self.residuals) * terms).sum(axis=1, keepdims=True)
        with np.errstate(all="ignore"):
            measured, error, curvature = self._differences(here, both)
            precision = float(np.finfo(problem.dtype.type).eps)
            error = error + _ROUNDINGS * precision * (terms + np.abs(curvature))
            size = np.maximum(np.maximum(terms, np.abs(measured)), np.finfo(np.float64).tiny)
            difference = np.abs(derivative - measured) / size
            bound = error / size
        difference[~np.isfinite(difference)] = np.inf
        bound[~np.isfinite(bound)] = 0.0
        excess = difference - bound
        if only is not None:
            excess[np.arange(len(excess)) != only] = -np.inf
        worst = int(np.argmax(excess))
        instance, column = (int(k) for k in np.unravel_index(worst, difference.shape))
        name = problem.instance_name(self.number, instance)
        found = GradientCheck(
            label=group.label,
            instances=len(self.rows),
            difference=float(difference[instance, column]),
            bound=float(bound[instance, column]),
            worst=f"{name} at {problem.instance_place(self.number, instance)}",
            residual=column,
            derivative=float(derivative[instance, column]),
            measured=float(measured[instance, column]),
        )
        return found, instance

    def _differences(
        self, here: list[Floats], both: list[tuple[float, list[Floats], list[Floats]]]
    ) -> tuple[Floats, Floats, Floats]:
        """Central differences (n, residuals) with their error bounds, and second differences."""
        middle = self._values(here)
        precision = _ROUNDINGS * float(np.finfo(np.float64).eps)
        best = np.full_like(middle, np.nan)
        least = np.full_like(middle, np.inf)
        curved = np.zeros_like(middle)
        before = None
        for length, ahead, behind in both:
            right, left = self._values(ahead), self._values(behind)
            slope = (right - left) / (2 * length)
            if before is not None:
                rounding = precision * np.maximum(np.abs(right), np.abs(left)) / length
                error = np.abs(slope - before) + rounding
                better = error < least
                best = np.where(better, slope, best)
                least = np.where(better, error, least)
                curved = np.where(better, (right - 2 * middle + left) / length**2, curved)
            before = slope
        return best, least, curved

    def _values(self, states: list[Floats]) -> Floats:
        """What is differentiated: (n, residuals), or (n, 1) half their squares."""
        # The active instances are those of the state in between.
        inputs = self.problem.group_inputs(self.number, states, derivatives=False)
        columns = evaluate(self.tape, inputs, natives=self.problem.natives)
        residuals = np.stack([np.broadcast_to(c, len(self.rows)) for c in columns], axis=1)
        return 0.5 * np.square(residuals).sum(axis=1, keepdims=True) if self.squared else residuals
