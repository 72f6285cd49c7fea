"""Which observations decide a solution: leverage, Cook's distance, and shares of a parameter.

With the residuals r_i and the Jacobian J_i of one instance and ``C = (J'J)^-1``, its leverage is
the trace of ``H_i = J_i C J_i'``: how far the fit follows it, between 0 and the number of its
residuals. All leverages sum to the number of parameters. Without the instance the solution is, to
first order, ``x + C J_i' (I - H_i)^-1 r_i``; Cook's distance is the square of that change in units
of the uncertainty, divided by the number of parameters (R. Cook and S. Weisberg, "Residuals and
influence in regression", 1982, section 3.5). The variance of a scalar q is a sum over instances,
``dq' C dq = sum_i |J_i C dq|^2``, whose terms are their shares.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.implicit import ImplicitSystem
from arael.analysis.sensitivities import Quantity
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.linear.selected import SelectedInverse

Floats = NDArray[np.float64]

TEN = 10
"""Observations that are listed."""
_ALONE = 1e-9
"""Least eigenvalue of I - H below which nothing else determines what an instance measures."""


@dataclass(frozen=True)
class Observation:
    """One instance of a constraint.

    Attributes
    ----------
    label, place : the constraint, and the row it acts at
    leverage, cook : see `Influence`
    share : of the variance of the quantity asked for; NaN without one
    change : of that quantity if the instance is removed, to first order; NaN without one, infinite
        where nothing else determines what it measures
    """

    label: str
    place: str
    leverage: float
    cook: float
    share: float
    change: float

    def __str__(self) -> str:
        text = f"{self.label} at {self.place}: leverage {self.leverage:.3g}, Cook {self.cook:.3g}"
        if np.isnan(self.share):
            return text
        return f"{text}, share {100 * self.share:.3g} %, without it {self.change:+.3g}"


class Influence(Displayed):
    """Influence of every active instance of the constraints, in the order of the model.

    Attributes
    ----------
    of : the scalar that shares and changes are of; "" for none
    leverage : (n,) trace of ``J_i C J_i'``
    cook : (n,) Cook's distance; infinite where nothing else determines what the instance measures
    share : (n,) share of the variance of the scalar; they sum to 1
    change : (n,) change of the scalar without the instance, to first order
    """

    def __init__(self, system: ImplicitSystem, quantity: Quantity | None, variance: float) -> None:
        self._problem = system.problem
        self.of = "" if quantity is None else quantity.text
        v = None if quantity is None else system.solved(quantity.by_parameters[0])
        spread = 1.0 if quantity is None or v is None else float(quantity.by_parameters[0] @ v)
        parts = list(_groups(system, v))
        self._group = np.concatenate([np.full(len(p[1]), p[0]) for p in parts] or [np.zeros(0)])
        self._instance = _joined([p[1] for p in parts])
        self.leverage = _joined([p[2] for p in parts])
        self.cook = _joined([p[3] for p in parts]) / (max(len(system.free), 1) * variance)
        self.share = _joined([p[4] for p in parts]) / spread
        self.change = _joined([p[5] for p in parts])

    def __len__(self) -> int:
        return len(self.leverage)

    def observation(self, k: int) -> Observation:
        """The instance of number k."""
        group, instance = int(self._group[k]), int(self._instance[k])
        return Observation(
            self._problem.layout.groups[group].label,
            self._problem.instance_place(group, instance),
            float(self.leverage[k]),
            float(self.cook[k]),
            float(self.share[k]),
            float(self.change[k]),
        )

    def strongest(self, count: int = TEN) -> list[Observation]:
        """The instances with the largest Cook's distance."""
        return [self.observation(int(k)) for k in np.argsort(-self.cook, kind="stable")[:count]]

    def deciding(self, count: int = TEN) -> list[Observation]:
        """The instances with the largest shares of the variance of the scalar asked for."""
        if not self.of:
            return []
        return [self.observation(int(k)) for k in np.argsort(-self.share, kind="stable")[:count]]

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: the strongest instances, and those that decide."""
        return {
            "of": self.of,
            "strongest": [_plain(one) for one in self.strongest()],
            "deciding": [_plain(one) for one in self.deciding()],
        }

    @cached_property
    def _lines(self) -> list[str]:
        lines = ["observations of the largest Cook's distance"]
        lines += [f"  {one}" for one in self.strongest()]
        if self.of:
            lines.append(f"observations that decide {self.of}")
            lines += [f"  {one}" for one in self.deciding()]
        return lines

    def _sheet(self) -> Sheet:
        rows = [
            (one.label, one.place, f"{one.leverage:.3g}", f"{one.cook:.3g}", f"{one.share:.3g}")
            for one in self.deciding() or self.strongest()
        ]
        head = ("constraint", "at", "leverage", "Cook", "share")
        return Sheet(repr(self).strip("<>"), head, rows)

    def __repr__(self) -> str:
        of = f" on {self.of}" if self.of else ""
        return f"<Influence of {len(self)} observations{of}>"

    def __str__(self) -> str:
        return "\n".join(self._lines)


def _plain(one: Observation) -> dict[str, Any]:
    return {k: v if isinstance(v, str) or np.isfinite(v) else None for k, v in vars(one).items()}


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(parts) if parts else np.zeros(0)


def _groups(system: ImplicitSystem, v: Floats | None) -> Any:
    """Per group: its number, instances, leverage, unscaled Cook's distance, share and change."""
    problem, equations = system.problem, system.equations
    inverse = SelectedInverse(equations.solver)
    trash = problem.structure.plan.trash
    moves = np.zeros(problem.size + trash)
    moves[equations.free] = equations.scale[equations.free]
    wide = np.zeros(problem.size + trash) if v is None else np.concatenate([v, np.zeros(trash)])
    for number, group in enumerate(problem.layout.groups):
        acting = np.flatnonzero(problem.evaluation.acting(number))
        if not len(acting):
            continue
        residuals, entries = problem.evaluation.group_rows(number)
        r = np.asarray(residuals, dtype=np.float64)[acting]
        values = np.asarray(entries, dtype=np.float64)[acting]
        at = problem.structure.placements[number].gradient_at[acting]
        tangents = sorted({(use, tangent) for _, use, tangent in group.jacobian})
        scalars = np.stack([at[:, use] + t for use, t in tangents], axis=1) if tangents else None
        jacobian = np.zeros((len(acting), group.residuals, len(tangents)))
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            jacobian[:, residual, tangents.index((use, tangent))] += values[:, k]
        if scalars is None:
            continue
        along = np.einsum("nmt,nt->nm", jacobian, wide[scalars])
        jacobian *= moves[scalars][:, None, :]
        block = inverse.entries(np.minimum(scalars, problem.size - 1))
        hat = jacobian @ block @ jacobian.transpose(0, 2, 1)
        left = np.eye(group.residuals) - hat
        alone = np.linalg.eigvalsh(left)[:, 0] < _ALONE
        left[alone] = np.eye(group.residuals)
        lifted = np.linalg.solve(left, r[:, :, None])[:, :, 0]
        cook = np.einsum("nm,nmk,nk->n", lifted, hat, lifted)
        share, change = (along**2).sum(axis=1), (along * lifted).sum(axis=1)
        matters = alone & (np.abs(along).max(axis=1) > 0)
        cook[alone], change[matters] = np.inf, np.inf
        if v is None:
            share, change = np.full(len(acting), np.nan), np.full(len(acting), np.nan)
        leverage = np.trace(hat, axis1=1, axis2=2)
        yield number, acting, leverage, cook, share, change
