"""Confidence intervals by profile likelihood.

The profile of a parameter is the least cost over all others as a function of its value. Where the
model is linear it is a parabola and the interval is ``value +- k sigma``; elsewhere the interval
follows the cost (D. Bates and D. Watts, "Nonlinear regression analysis and its applications", 1988,
section 6.1).

The parameter need not be held: a residual ``w (p - c)`` that pulls it to c moves the minimum along
the profile, since for the value of p where it ends all other parameters are at their best. The pull
c is changed until the cost without that residual has risen by the wanted amount.

Of a rotation or a transform p is a component of the tangent vector from the solution, ``log(q0^-1
q)``, which the residual computes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.coordinates import Coordinate, coordinate_of
from arael.analysis.covariance import Covariance, check_scale
from arael.analysis.report import Statistics, scalar_values
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.display.measured import rounded

Floats = NDArray[np.float64]

_LABEL = "profile_pull"
_CLOSE = 1e-7
_MOST = 40


@dataclass(frozen=True)
class Profile:
    """Interval of one scalar by profile likelihood.

    Attributes
    ----------
    value : of the solution; 0 of a scalar of a rotation or a transform, whose values are components
        of the tangent vector from the solution: of a rotation vector, of a twist
    low, high : ends of the interval; infinite where the cost never rises enough, a bound of the
        parameter where it stops there
    level : of confidence
    values : (k,) values of the parameter on the way, ascending
    increase : (k,) rise of the cost there over the solution's
    """

    name: str
    value: float
    low: float
    high: float
    level: float
    values: Floats = field(repr=False)
    increase: Floats = field(repr=False)

    def __str__(self) -> str:
        spread = min(self.high - self.value, self.value - self.low) / 2
        value, low, high = (rounded(one, spread) for one in (self.value, self.low, self.high))
        return f"{self.name} = {value} in [{low}, {high}] at {100 * self.level:g} %"


def profile(model: Any, name: str, level: float, scale: str) -> Profile:
    """Interval of a scalar of a solved model; see `arael.Model.profile`."""
    if not (isinstance(level, int | float) and 0 < level < 1):
        raise _wrong(f"the level is {level!r:.40}", "it lies between 0 and 1, such as 0.95")
    if not isinstance(name, str):
        raise wrong_argument("profile", "name", "the name of a scalar", name)
    check_scale(scale)
    problem = model._problem()
    values = scalar_values(problem)
    covariance = Covariance(problem)
    known = name in covariance.names
    coordinate = coordinate_of(problem, name, values.get(name)) if known else None
    if coordinate is None:
        raise _wrong(f"`{name}` has no profile", _advice(name, values, covariance))
    start = coordinate.start
    sigma = float(covariance.sigma()[covariance.names.index(name)])
    base = model.cost()
    statistics = Statistics(base, _count(problem), len(covariance.names), scale == "residual")
    rise = threshold(statistics, level)
    if math.isnan(rise):
        raise _wrong("as many parameters as residuals: their scatter is not known", "")
    before = model.serialize()
    label = _free_label(model)
    model.residuals.add(
        f"({coordinate.formula} - target_) * pull_",
        label=label,
        data={**coordinate.data, "target_": start, "pull_": 1 / sigma},
    )
    pull = _Pull(model, model.residuals[label], label, coordinate, sigma, base, rise)
    try:
        ends = []
        for side in (-1.0, 1.0):
            model.deserialize(before)
            ends.append(pull.end(side))
    finally:
        model.residuals.remove(label)
        model.deserialize(before)
    order = np.argsort(pull.seen, kind="stable")
    return Profile(
        name,
        start,
        ends[0],
        ends[1],
        float(level),
        np.array(pull.seen)[order],
        np.array(pull.rises)[order],
    )


def threshold(statistics: Statistics, level: float) -> float:
    """Rise of the cost at the end of an interval; NaN where the scatter is not known."""
    # imported here: start-up time
    from scipy import special

    if not statistics.scatter:
        return float(special.chdtri(1, 1 - level))
    if statistics.freedom <= 0 or not statistics.reduced > 0:
        return math.nan
    return float(special.stdtrit(statistics.freedom, (1 + level) / 2) ** 2 * statistics.reduced)


class _Pull:
    """Solves with the parameter pulled to one side, at increasing rises of the cost."""

    def __init__(
        self,
        model: Any,
        residual: Any,
        label: str,
        coordinate: Coordinate,
        sigma: float,
        base: float,
        rise: float,
    ) -> None:
        self.model, self.residual, self.label = model, residual, label
        self.coordinate, self.name, self.start = coordinate, coordinate.name, coordinate.start
        self.sigma, self.base, self.rise = sigma, base, rise
        self.seen = [self.start]
        self.rises = [0.0]

    def end(self, side: float) -> float:
        """The end of the interval on one side."""
        step = 2 * math.sqrt(self.rise) * self.sigma
        inner, outer = (0.0, 0.0, self.start), None  # pull, relative rise, value
        pull = step
        for _ in range(_MOST):
            if outer is None and pull >= self.coordinate.reach:
                return side * math.inf
            value, high = self._at(self.start + side * pull)
            if abs(high - 1) <= _CLOSE:
                return value
            if high < 1:
                if outer is None and inner[0] and value == inner[2]:
                    return value  # it stands on a bound
                inner = (pull, high, value)
            else:
                outer = (pull, high, value)
            if outer is None:
                pull *= 2 if high < 0.2 else min(2.0, 1.1 / high)
                continue
            # Of the square root of the rise, which is nearly linear in the pull.
            share = (1 - inner[1]) / (outer[1] - inner[1])
            pull = inner[0] + min(max(share, 0.02), 0.98) * (outer[0] - inner[0])
            if outer[0] - inner[0] <= 1e-12 * outer[0]:
                return value
        return value if outer is not None else side * math.inf

    def _at(self, target: float) -> tuple[float, float]:
        """Value of the parameter, and square root of the rise as a share of the wanted one."""
        self.residual.set_data(target_=target)
        self.model.solve(passes=[], rel_precision=1e-14)
        value = self._value(target)
        rise = self.model.cost() - ((value - target) / self.sigma) ** 2 - self.base
        if rise < -1e-4 * self.rise - 1e-9 * self.base:
            raise _wrong(
                f"`{self.name}` = {value:.6g} has a lower cost, {self.base + rise:.8g}, than the "
                f"values of the model, {self.base:.8g}",
                "solve the model first; a profile begins at a minimum",
            )
        self.seen.append(value)
        self.rises.append(rise)
        return value, math.sqrt(max(rise, 0.0) / self.rise)

    def _value(self, target: float) -> float:
        """Value of the parameter: stored, or of the residual that computes it."""
        if self.coordinate.data:
            residual = self.model.residual_values(self.label).whitened
            return target + float(np.asarray(residual).item()) * self.sigma
        value = scalar_values(self.model._problem())[self.name]
        assert value is not None
        return value


def _count(problem: Any) -> int:
    return sum(
        int(problem.evaluation.acting(number).sum()) * group.residuals
        for number, group in enumerate(problem.layout.groups)
        if not group.require
    )


def _free_label(model: Any) -> str:
    label = _LABEL
    while label in model.residuals:
        label += "_"
    return label


def _advice(name: str, values: dict[str, float | None], covariance: Covariance) -> str:
    if name in covariance.on_bound:
        return f"it is on {covariance.on_bound[name]}"
    if name in values:
        return "directions have no profile: their tangent vector is not a formula of the language"
    near = closest(name, list(values))
    return f"did you mean `{near[0]}`?" if near else "`parameter_names()` lists what is solved for"


def _wrong(message: str, advice: str) -> AraelError:
    help = (advice,) if advice else ()
    return AraelError(Diagnostic("E1036", message, origin="profile", help=help))
