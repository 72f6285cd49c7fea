"""A model as a problem for minimisers and samplers of one's own, in tangent coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.geometry.charts import chart_derivative
from arael.runtime.failures import refuse_required
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

# Central differences of retractions, where an update of a component is part of them.
_STEP = 1e-5


class TangentProblem:
    """Cost, residuals and derivatives around a base point, from `Model.problem`.

    The base point holds the parameters of the model when the problem was made, or after the last
    `retract`. An argument `delta`, (n,), is a tangent vector there: one entry for each free scalar,
    in order of `names` (angles in radians; three for a rotation, six for a transform). Functions of
    `delta` evaluate at the base point moved by it, and their derivatives are those by `delta`: a
    minimiser can treat the problem as one of n plain numbers, starting at zeros.

    Data is that of the time when the problem was made; the model is not changed until `write_back`.

    Attributes
    ----------
    names : (n,) names of the free scalars, ``poses[3].ea.z``
    low, high : (n,) bounds of delta, infinite where a parameter has none

    Notes
    -----
    The cost is the sum of squared residuals, without a factor of 1/2; losses are part of residuals.
    The number of residuals is constant: an instance that a guard over parameters leaves out
    contributes zeros. Where several residuals share a loss, the derivative of their squared norm is
    exact, not that of each of them. Models with ``precision f32`` are evaluated in f32.

    An instance is not for use by several threads at once.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats

    def __init__(self, problem: Problem) -> None:
        refuse_required(
            problem.layout,
            "a problem for other minimisers",
            "solve it with `solve`, or write it as a constraint with a small sigma",
        )
        self._problem = problem
        self._free = problem.free
        self._base = self._stored()
        self._at = np.zeros(problem.size)
        self._where: Floats | None = self._at.copy()
        self._rows = sum(
            len(active) * group.residuals
            for active, group in zip(problem.structure.active, problem.layout.groups, strict=True)
        )
        self.names = tuple(problem.parameter_names())
        self._set_bounds()

    @property
    def size(self) -> int:
        """Number of free scalars n."""
        return len(self._free)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of residuals and of free scalars (m, n)."""
        return self._rows, self.size

    @property
    def x(self) -> Floats:
        """Stored scalars at the base point, as `Model.serialize` has them."""
        self._move_to(None)
        return self._problem.x

    # --- at base point + delta ---------------------------------------------------------------

    def cost(self, delta: ArrayLike | None = None) -> float:
        """Sum of squared residuals."""
        self._move_to(delta)
        return self._problem.cost()

    def residuals(self, delta: ArrayLike | None = None) -> Floats:
        """(m,) residuals by constraint, instance and component."""
        self._move_to(delta)
        return self._linearised()[0]

    def jacobian(self, delta: ArrayLike | None = None) -> Any:
        """(m, n) derivatives of the residuals by delta, a SciPy CSR array."""
        full = self._move_to(delta)
        entries = self._linearised()[1]
        charts = self._charts(full)
        found = entries if charts is None else entries @ charts
        return found[:, self._free].tocsr()

    def gradient(self, delta: ArrayLike | None = None) -> Floats:
        """(n,) derivative of the cost by delta: ``2 J'r``."""
        full = self._move_to(delta)
        charts = self._charts(full)
        if charts is None:
            return self._problem.gradient()
        residuals, entries = self._linearised()
        found: Floats = 2.0 * (charts.T @ (entries.T @ residuals))[self._free]
        return found

    def product(self, v: ArrayLike, delta: ArrayLike | None = None) -> Floats:
        """(n,) product of the Gauss-Newton Hessian with a vector: ``2 J'J v``."""
        vector = self._checked(v, "v")
        jacobian = self.jacobian(delta)
        found: Floats = 2.0 * (jacobian.T @ (jacobian @ vector))
        return found

    # --- the base point ----------------------------------------------------------------------

    def retract(self, delta: ArrayLike) -> None:
        """Move the base point by `delta`; tangent vectors are of the new point from then on.

        Raises
        ------
        AraelError
            E0703, E0704 for anything but one number for each of `names`; E0705 if one is not
            finite: the base point would be lost.
        """
        step = self._checked(delta, "delta")
        if not np.isfinite(step).all():
            k = int(np.argmin(np.isfinite(step)))
            raise AraelError(
                Diagnostic(
                    "E0705",
                    f"the step of `{self.names[k]}` is {step[k]:g}",
                    origin="delta",
                    help=("the base point is unchanged: try a shorter step",),
                )
            )
        self._move_to(step)
        self._base = self._stored()
        self._where = None
        self._set_bounds()

    def write_back(self) -> None:
        """Set the parameters of the model to the base point."""
        self._move_to(None)
        self._problem.write_back()

    # --- evaluation --------------------------------------------------------------------------

    def _stored(self) -> list[NDArray[Any]]:
        problem = self._problem
        return [
            np.array(state[: len(block.free), : entity.stored])
            for entity, block, state in zip(
                problem.layout.entities,
                problem.structure.system.blocks,
                problem.states,
                strict=True,
            )
        ]

    def _checked(self, values: ArrayLike, name: str) -> Floats:
        try:
            found = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            raise AraelError(
                Diagnostic(
                    "E0703", f"expected {self.size} numbers, found {values!r:.60}", origin=name
                )
            ) from None
        if found.shape != (self.size,):
            raise AraelError(
                Diagnostic(
                    "E0704",
                    f"expected {self.size} numbers, found an array of shape {found.shape}",
                    origin=name,
                    help=("one number for each of `names`",),
                )
            )
        return found

    def _move_to(self, delta: ArrayLike | None) -> Floats:
        """Move the state to base point + `delta`; returns delta over all scalars, held ones 0."""
        full = np.zeros(self._problem.size)
        if delta is not None:
            full[self._free] = self._checked(delta, "delta")
        if self._where is None or not np.array_equal(full, self._where):
            self._where = None
            self._step_from(self._base, full)
            self._where = full
        return full

    def _step_from(self, stored: list[NDArray[Any]], full: Floats) -> None:
        evaluation = self._problem.evaluation
        for number, values in enumerate(stored):
            evaluation.start_at(number, values)
        if full.any():
            evaluation.moved_by(full)

    def _linearised(self) -> tuple[Floats, Any]:
        """Residuals (m,) and their derivatives (m, size) by a further small step, CSR."""
        # imported here: start-up time
        from scipy.sparse import csr_array

        problem = self._problem
        width = problem.size + problem.structure.trash
        residuals = np.zeros(self._rows)
        rows, columns, values = [], [], []
        first = 0
        for number, group in enumerate(problem.layout.groups):
            count = len(problem.structure.active[number])
            if not count:
                continue
            acting = np.asarray(problem.evaluation.acting(number))
            found, entries = problem.evaluation.group_rows(number)
            part = slice(first, first + count * group.residuals)
            residuals[part] = np.where(acting[:, None], found, 0.0).ravel()
            at = problem.structure.placements[number].gradient_at
            own = first + group.residuals * np.flatnonzero(acting)
            for k, (residual, use, tangent) in enumerate(group.jacobian):
                rows.append(own + residual)
                columns.append(at[acting, use] + tangent)
                values.append(np.asarray(entries[acting, k], dtype=np.float64))
            first = part.stop
        if not rows:
            return residuals, csr_array((self._rows, problem.size))
        where = np.concatenate(rows), np.concatenate(columns).astype(np.int64)
        matrix = csr_array((np.concatenate(values), where), shape=(self._rows, width))
        return residuals, matrix[:, : problem.size]

    # --- charts ------------------------------------------------------------------------------

    def _charts(self, full: Floats) -> Any:
        """(size, size) block-diagonal matrix D of all parameters; None where it is the identity."""
        if not full.any():
            return None
        system = self._problem.structure.system
        found = []
        for number, entity in enumerate(self._problem.layout.entities):
            first = system.blocks[number].first
            solved = np.flatnonzero(first >= 0)
            if not len(solved):
                continue
            starts = first[solved]
            if entity.updated:
                found.append((starts, self._differences(number, solved, starts, full)))
                continue
            for use in entity.params:
                if use.kind in ("real", "vec", "euler", "angle"):
                    continue
                own = starts + use.tangent_start
                moved = full[own[:, None] + np.arange(use.tangent)]
                begin = slice(use.stored_start, use.stored_start + use.stored)
                stored = np.asarray(self._base[number][solved, begin], dtype=np.float64)
                found.append((own, chart_derivative(use.kind, stored, moved)))
        return _block_diagonal(found, self._problem.size) if found else None

    def _differences(
        self, number: int, solved: NDArray[np.int64], starts: NDArray[np.int64], full: Floats
    ) -> Floats:
        """(rows, k, k) D of an entity whose components are updated, by central differences.

        The least-squares solution of ``d((x [+] full) [+] e)/de D = d(x [+] (full + h))/dh`` over
        all stored scalars.
        """
        entity = self._problem.layout.entities[number]
        self._step_from(self._base, full)
        here = self._stored()

        def slopes(stored: list[NDArray[Any]], step: Floats) -> Floats:
            columns = []
            for k in range(entity.tangent):
                ends = []
                for sign in (1, -1):
                    moved = step.copy()
                    moved[starts + k] += sign * _STEP
                    self._step_from(stored, moved)
                    ends.append(self._stored()[number][solved].astype(np.float64))
                columns.append((ends[0] - ends[1]) / (2 * _STEP))
            return np.stack(columns, axis=-1)

        by_e = slopes(here, np.zeros_like(full))
        by_h = slopes(self._base, full)
        self._where = None
        self._move_to(full[self._free])
        found: Floats = np.linalg.pinv(by_e) @ by_h
        return found

    def _set_bounds(self) -> None:
        """Bounds of delta: those of the parameters less their values at the base point."""
        problem = self._problem
        system = problem.structure.system
        low, high = np.array(system.low), np.array(system.high)
        for number, entity in enumerate(problem.layout.entities):
            first = system.blocks[number].first
            solved = np.flatnonzero(first >= 0)
            for use in entity.params:
                if use.tangent != use.stored:
                    continue
                for k in range(use.tangent):
                    at = first[solved] + use.tangent_start + k
                    value = self._base[number][solved, use.stored_start + k]
                    low[at] -= value
                    high[at] -= value
        self.low, self.high = low[self._free], high[self._free]

    def __repr__(self) -> str:
        m, n = self.shape
        return f"<TangentProblem of {self._problem.layout.root}: {m} residuals, {n} parameters>"


def _block_diagonal(found: list[tuple[NDArray[np.int64], Floats]], size: int) -> Any:
    """CSR array (size, size) of the identity with blocks (n, k, k) at first scalars (n,)."""
    # imported here: start-up time
    from scipy.sparse import csr_array

    plain = np.ones(size, dtype=bool)
    rows, columns, values = [], [], []
    for first, blocks in found:
        k = np.arange(blocks.shape[1])
        at = first[:, None] + k
        plain[at] = False
        shape = blocks.shape
        rows.append(np.broadcast_to(at[:, :, None], shape).ravel())
        columns.append(np.broadcast_to(at[:, None, :], shape).ravel())
        values.append(blocks.ravel())
    rest = np.flatnonzero(plain)
    where = np.concatenate([*rows, rest]), np.concatenate([*columns, rest])
    return csr_array((np.concatenate([*values, np.ones(len(rest))]), where), shape=(size, size))
