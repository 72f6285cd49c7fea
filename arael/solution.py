"""What a solution can be asked: sensitivities, the effect of uncertain data, influence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.failures import refuse_required
from arael.solving import problem_of

if TYPE_CHECKING:
    from arael.analysis.influence import Influence
    from arael.analysis.propagation import Propagation
    from arael.analysis.sensitivities import Quantity, Sensitivities, Sensitivity
    from arael.certificates.certificate import Certificate, Chordal
    from arael.result import Result


class Solution:
    """A solved model, as long as its values are those of the solve.

    The factor of its normal equations serves all questions.

    Parameters
    ----------
    model : the instance
    frozen : paths of parameters that the last pass froze
    x, cost : what it was solved to, as `arael.Result.x`, and its cost; None: the present values

    Raises
    ------
    AraelError
        E1060: the model has other values or other data now.
        E1038: rows of the model hold exactly.
    SolveError
        E1008: directions are free; they are named.
    """

    def __init__(
        self, model: Any, frozen: Iterable[str] = (), x: Any = None, cost: float | None = None
    ) -> None:
        # imported here: start-up time
        from arael.analysis.implicit import ImplicitSystem
        from arael.session_factor import session_factor

        self.model, self.frozen = model, frozenset(frozen)
        model._store.check_complete()
        self.problem = problem_of(model, self.frozen)
        refuse_required(
            self.problem.layout, "sensitivities and influence", "solve again with other data"
        )
        now = self.problem.x
        if x is not None and not _same_values(now, x):
            raise _changed(self.problem.layout.name, "values")
        if cost is not None and not self._has_cost(cost):
            raise _changed(self.problem.layout.name, "data")
        self.system = ImplicitSystem(self.problem, session_factor(model, self.problem))

    def _has_cost(self, cost: float) -> bool:
        """Whether the cost is still that of the solve, or does not tell.

        Where constraints read stored values of parameters, these are other values after a solve.
        """
        layout = self.problem.layout
        if any(
            layout.table(group.slots[raw.slot].table).column(raw.column).role == "param"
            for group in layout.groups
            for raw in group.raw
            if not raw.column.endswith("?") and "#" not in raw.column
        ):
            return True
        single = layout.precision == "f32"
        now = self.problem.cost()
        return abs(now - cost) <= (1e-3 if single else 1e-8) * max(now, cost) + 1e-20

    def is_current(self, x: Any) -> bool:
        """Whether the model still has the data and the values of this solution."""
        now = problem_of(self.model, self.frozen)
        return (
            now.structure is self.problem.structure
            and _same_values(now.x, x)
            and all(
                a is b or (np.array_equal(a.data, b.data) and np.array_equal(a.uniform, b.uniform))
                for a, b in zip(now.instances, self.problem.instances, strict=True)
            )
        )

    def sensitivity(
        self, of: str, to: str | Iterable[str] | None = None, exact: bool = False
    ) -> Sensitivity:
        """Derivatives of a quantity; see `arael.Result.sensitivity`."""
        # imported here: start-up time
        from arael.analysis.sensitivities import paths_of

        paths = paths_of(to)
        return self.sensitivities().of(self.quantity(of), paths, bool(exact))

    def sensitivities(self) -> Sensitivities:
        """Derivatives of quantities of this solution."""
        # imported here: start-up time
        from arael.analysis.sensitivities import Sensitivities

        residuals = self.model.residuals
        return Sensitivities(
            self.system, residuals.constant_names, partial(residuals.varied, self.problem)
        )

    def propagate(
        self, uncertain: Mapping[str, Any], of: str | Iterable[str] | None, exact: bool
    ) -> Propagation:
        """Covariance with uncertain data; see `arael.Result.propagate`."""
        # imported here: start-up time
        from arael.analysis.propagation import all_scalars, propagate
        from arael.analysis.sensitivities import joined

        if not isinstance(uncertain, Mapping) or not all(isinstance(k, str) for k in uncertain):
            expected = "standard deviations by path of data"
            help = '`propagate({"board.square": 1e-3})`'
            raise wrong_argument("propagate", "uncertain", expected, uncertain, help)
        sensitivities = self.sensitivities()
        if of is None:
            quantity = all_scalars(sensitivities)
        else:
            quantity = joined([self.quantity(t) for t in ([of] if isinstance(of, str) else of)])
        return propagate(sensitivities, quantity, uncertain, bool(exact))

    def influence(self, of: str | None, scale: str) -> Influence:
        """Influence of the observations; see `arael.Result.influence`."""
        # imported here: start-up time
        from arael.analysis.covariance import check_scale, residual_variance
        from arael.analysis.influence import Influence

        check_scale(scale)
        variance = 1.0
        if scale != "known":
            variance = residual_variance(self.problem, len(self.system.free))
        quantity = None if of is None else self.quantity(of)
        if quantity is not None and len(quantity.names) > 1:
            raise AraelError(
                Diagnostic(
                    "E1060",
                    f"`{of}` has {len(quantity.names)} scalars",
                    origin="influence",
                    help=(f"take one of them: `{quantity.names[0]}`",),
                )
            )
        return Influence(self.system, quantity, variance)

    def quantity(self, text: str) -> Quantity:
        """A scalar, the scalars of a parameter or a row, or a formula over the model."""
        # imported here: start-up time
        from arael.analysis.adjoint import (
            by_tangent,
            constant_products,
            in_system,
            value_products,
        )
        from arael.analysis.sensitivities import Quantity, named_quantity

        if not isinstance(text, str):
            raise wrong_argument("sensitivity", "of", "a parameter or a formula", text)
        found = named_quantity(self.system, text)
        if found is not None:
            return found
        probed, number = self._probed(text)
        count = probed.layout.groups[number].residuals
        direct = tuple(value_products(probed, number, row) for row in np.eye(count))
        by_parameters = [in_system(probed, by_tangent(probed, one.states)) for one in direct]
        names = (text,) if count == 1 else tuple(f"{text}[{k}]" for k in range(count))

        def by_constant(name: str) -> Any:
            varied = self.model.residuals.varied(probed, name)
            if varied is None:
                return np.zeros((count, 1))
            v = np.zeros(probed.size)
            rows = [constant_products(probed, varied, v, {number: row}) for row in np.eye(count)]
            return np.array(rows)

        return Quantity(text, names, np.array(by_parameters), direct, by_constant)

    def values(self, text: str) -> Any:
        """(m,) values of a formula over the model."""
        probed, number = self._probed(text)
        return np.asarray(probed.evaluation.group_rows(number)[0], dtype=np.float64).ravel()

    def weighted(self, text: str, weights: Any) -> Quantity:
        """The sum of the values of a formula with weights (m,)."""
        # imported here: start-up time
        from arael.analysis.adjoint import by_tangent, in_system, value_products
        from arael.analysis.sensitivities import Quantity

        probed, number = self._probed(text)
        direct = value_products(probed, number, weights)
        step = in_system(probed, by_tangent(probed, direct.states))
        return Quantity(text, (text,), step[None], (direct,))

    def _probed(self, text: str) -> tuple[Any, int]:
        """A problem with a formula of one row as a group, and the number of that."""
        probed, number = self.model.residuals.probed(text, self.frozen)
        count = len(probed.structure.active[number])
        if count != 1:
            raise AraelError(
                Diagnostic(
                    "E1060",
                    f"`{text:.60}` has values of {count} rows",
                    origin="sensitivity",
                    help=("name a single row: `poses[3].pos.x`",),
                )
            )
        return probed, number


def solution_of(model: Any, result: Result) -> Solution:
    """The solution of a result of a model, whose factor is kept with it.

    Raises
    ------
    AraelError
        E1060: the model has other values or other data now.
    """
    known: Solution | None = result.__dict__.get("solution")
    if known is None or not known.is_current(result.x):
        known = Solution(model, result.frozen, result.x, result.end_cost)
        result.__dict__["solution"] = known
    return known


def certified(model: Any, result: Result) -> tuple[Certificate, Chordal]:
    """Certificate of a result of a model, and the chordal problem that it is of.

    Raises
    ------
    AraelError
        E1060: the model has other values now; E1061: there is no certificate of this model.
    """
    # imported here: start-up time
    from arael.certificates.certificate import certify

    problem = problem_of(model, result.frozen)
    if not _same_values(problem.x, result.x):
        raise _changed(problem.layout.name, "values")
    return certify(model._compiled, problem)


def escaped(model: Any, result: Result, settings: Mapping[str, Any]) -> Result:
    """The result of a solve from a lower minimum; `result` if it is certified.

    Raises
    ------
    AraelError
        As `certified`.
    """
    # imported here: start-up time
    from arael.certificates.certificate import climbed

    found, chordal = certified(model, result)
    if found.certified:
        return result
    chordal.put(climbed(chordal, found))
    lower: Result = model.solve(**settings)
    return lower


def _same_values(now: Any, x: Any) -> bool:
    """Whether values are those of a solve; quaternions are normalised when they are written."""
    return len(now) == len(x) and np.allclose(now, x, rtol=1e-12, atol=1e-12)


def _changed(name: str, what: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1060",
            f"the model has other {what} than at the end of this solve",
            origin=name,
            help=("solve again, and ask the result of that solve",),
        )
    )
