"""The result of a fit: parameters, uncertainty, predictions with bands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.profile import Profile, profile
from arael.analysis.report import Estimate, Report, strongest, suspicions
from arael.diagnostics.arguments import described
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.fitting.curve import Curve
from arael.fitting.estimates import Estimates
from arael.fitting.formula import Formula
from arael.fitting.messages import check_parameter, mistake
from arael.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bands:
    """A curve with its uncertainty, arrays (m,).

    Attributes
    ----------
    value : of the curve
    sigma : its standard error
    low, high : confidence band: with the probability `level` it holds the true curve at this point
    predicted_low, predicted_high : prediction band: it holds a further measurement at this point
    level : of both
    """

    value: Array
    sigma: Array
    low: Array
    high: Array
    predicted_low: Array
    predicted_high: Array
    level: float


@dataclass(frozen=True, repr=False)
class Fit(Displayed):
    """A fitted curve; made by `arael.fit`.

    Attributes
    ----------
    formula : the formula and its names
    curve : the residuals over the model; ``curve.model`` is an ordinary `arael.Model`
    result : of the last solve
    estimates : covariance and statistics
    known : whether the standard deviations of the points are known
    values : (p,) the parameters, in the order of `names`
    starts : where the last solve began, by parameter
    on_bound : parameters on an active bound, each with the bound in words
    skipped : number of points left out because a value is missing
    promise : decrease of the cost, as a fraction of it, that a further step would bring
    """

    formula: Formula
    curve: Curve
    result: Result
    estimates: Estimates
    known: bool
    values: Array
    starts: dict[str, float]
    on_bound: dict[str, str]
    skipped: int
    promise: float

    @property
    def names(self) -> tuple[str, ...]:
        """(p,) names of the parameters, ``a``, or ``a[left]`` of the group `left`."""
        return self.curve.names

    @property
    def parameters(self) -> dict[str, float]:
        """Values by name."""
        return dict(zip(self.names, self.values.tolist(), strict=True))

    def __getitem__(self, name: str) -> float:
        """Value of a parameter; E0872 if there is none of that name."""
        check_parameter(name, self.names, "fit")
        return self.parameters[name]

    @property
    def sigma(self) -> dict[str, float]:
        """Standard errors by name; 0 of fixed parameters and those on a bound."""
        return dict(zip(self.names, self.estimates.sigma.tolist(), strict=True))

    @property
    def covariance(self) -> Array:
        """(p, p) covariance of the parameters."""
        return self.estimates.covariance

    @property
    def correlation(self) -> Array:
        """(p, p) correlations; NaN of parameters without variance."""
        sigma = self.estimates.sigma
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.covariance / (sigma[:, None] * sigma[None, :]))

    @property
    def converged(self) -> bool:
        """Whether the solve converged, or no step would bring a noticeable decrease."""
        return self.result.converged or self.promise <= 1e-14

    @cached_property
    def residuals(self) -> Array:
        """(n,) measured minus fitted, without whitening and loss; of a residual formula its value.

        In the order of the points, without those that lack a value.
        """
        points = self.curve.points
        formula = self.formula.text
        found, _ = self.curve.predict(formula, self.values, points.columns, points.group)
        if self.formula.predicts is None:
            return found
        return np.asarray(points.columns[self.formula.predicts] - found)

    @property
    def r_squared(self) -> float | None:
        """``1 - sum w r^2 / sum w (y - mean)^2`` with the weights of the points.

        None with a loss, and for a formula that predicts no column.
        """
        predicts = self.formula.predicts
        if predicts is None or self.curve.loss is not None:
            return None
        weight = self.curve.points.sigma**-2
        y = self.curve.points.columns[predicts]
        total = float(weight @ (y - weight @ y / weight.sum()) ** 2)
        return 1 - float(weight @ self.residuals**2) / total if total > 0 else None

    # --- predictions -----------------------------------------------------------------------------

    def predict(self, data: Mapping[str, Any], group: Any = None) -> Array:
        """Values (m,) of the curve at other points.

        Parameters
        ----------
        data : columns that the formula reads, by name: arrays (m,) or numbers
        group : name of the group of the points, or one per point

        Raises
        ------
        AraelError
            E0871: a column is missing; E0874: no such group, or a residual formula.
        """
        return self._predicted(data, group)[0]

    def bands(self, data: Mapping[str, Any], level: float = 0.95, group: Any = None) -> Bands:
        """The curve at other points with confidence and prediction bands.

        The variance of the curve is ``J C J'`` with its derivatives J by the parameters; bands are
        that of one point at a time, by Student's t, or by the normal distribution if the standard
        deviations of the points are known (Bates and Watts, 1988, section 2.3.2). Of a further
        measurement the variance of the points is added: the scatter, or the mean square of known
        standard deviations.

        Parameters
        ----------
        data, group : as for `predict`
        level : probability
        """
        if not isinstance(level, int | float) or not 0 < level < 1:
            raise mistake(
                "E0874",
                f"the level {described(level)} is not between 0 and 1",
                "bands",
                "write 0.95",
            )
        value, matrix = self._predicted(data, group)
        variance = np.einsum("ij,jk,ik->i", matrix, self.covariance, matrix)
        sigma = np.sqrt(np.maximum(variance, 0))
        factor = self._quantile(level)
        # The scatter multiplies deviations that are given as ratios only.
        measured = self.estimates.statistics.variance * float(np.mean(self.curve.points.sigma**2))
        wide = np.sqrt(variance + measured)
        return Bands(
            value,
            sigma,
            value - factor * sigma,
            value + factor * sigma,
            value - factor * wide,
            value + factor * wide,
            level,
        )

    def _quantile(self, level: float) -> float:
        # imported here: start-up time
        from scipy import special

        if self.known:
            return float(special.ndtri((1 + level) / 2))
        freedom = self.estimates.statistics.freedom
        return float(special.stdtrit(freedom, (1 + level) / 2)) if freedom > 0 else math.nan

    def _predicted(self, data: Any, group: Any) -> tuple[Array, Array]:
        if self.formula.predicts is None:
            raise mistake(
                "E0874", "a residual formula predicts no column", "predict", "write NAME = FORMULA"
            )
        read = [name for name in self.formula.columns if name != self.formula.predicts]
        if not isinstance(data, Mapping) and not hasattr(data, "columns"):
            raise mistake(
                "E0873",
                f"expected columns by name, found {type(data).__name__}",
                "predict",
                f'write {{"{read[0] if read else "x"}": [0.0, 1.0]}}',
            )
        for name in read:
            if name not in data:
                raise mistake("E0871", f"the column '{name}' is missing", "predict")
        try:
            given = [np.atleast_1d(np.asarray(data[name], dtype=np.float64)) for name in read]
        except (TypeError, ValueError):
            raise mistake("E0873", f"the columns {read} are not all numbers", "predict") from None
        numbers = np.atleast_1d(self._groups(group))
        # A formula without columns has a value for each point as well.
        points = [] if read else [np.atleast_1d(column) for column in data.values()]
        *columns, numbers = np.broadcast_arrays(*given, numbers, *points)[: len(read) + 1]
        found = dict(zip(read, columns, strict=True))
        value, matrix = self.curve.predict(self.formula.text, self.values, found, numbers)
        size = len(numbers)
        if len(value) == size:
            return value, matrix
        return np.broadcast_to(value, size), np.broadcast_to(matrix, (size, matrix.shape[1]))

    def _groups(self, group: Any) -> NDArray[np.int64]:
        groups = self.curve.points.groups
        if group is not None and not groups:
            raise mistake("E0874", "the fit has no groups", "predict", "leave `group` out")
        if not self.curve.own or not groups:
            return np.zeros(1, dtype=np.int64)
        number = {name: k for k, name in enumerate(groups)}
        wanted = [group] if isinstance(group, str) or not np.ndim(group) else list(group)
        for name in wanted:
            if str(name) not in number:
                raise mistake(
                    "E0874",
                    f"there is no group '{name}'",
                    "predict",
                    f"there are {', '.join(groups[:8])}{', ...' if len(groups) > 8 else ''}",
                )
        return np.array([number[str(name)] for name in wanted], dtype=np.int64)

    def profile(self, name: str, level: float = 0.95) -> Profile:
        """Confidence interval of a parameter by profile likelihood; see `arael.Model.profile`.

        Raises
        ------
        AraelError
            E0872: no such parameter; E1036: no profile.
        """
        check_parameter(name, self.names, "profile")
        scale = "known" if self.known else "residual"
        return replace(profile(self.curve.model, self.curve.scalar(name), level, scale), name=name)

    # --- reports ---------------------------------------------------------------------------------

    def report(self, intervals: float | None = None) -> Report:
        """Everything about the fit, to print.

        Parameters
        ----------
        intervals : level of intervals by profile likelihood, which take some solves; None: none
        """
        moves = self.estimates.moves
        names = [name for name, one in zip(self.names, moves, strict=True) if one]
        correlation = self.correlation[np.ix_(moves, moves)]
        pairs = strongest(names, correlation)
        notes = [f"{self.skipped} points without a value are left out"] if self.skipped else []
        if not self.converged:
            notes.append(f"the solve ended as {self.result.status}")
        if self.estimates.statistics.freedom <= 0 and not self.known:
            notes.append("as many parameters as points: standard errors cannot be estimated")
        return Report(
            self.formula.text,
            tuple(self._estimate(k, intervals) for k in range(len(self.names))),
            pairs,
            self.estimates.statistics,
            self.r_squared,
            (
                *self.estimates.flat,
                *suspicions(self.estimates.statistics, pairs, self.on_bound),
            ),
            tuple(notes),
        )

    def _estimate(self, k: int, intervals: float | None) -> Estimate:
        name, sigma = self.names[k], float(self.estimates.sigma[k])
        if not self.curve.free[k]:
            return Estimate(name, float(self.values[k]), None, note="fixed")
        if name in self.on_bound:
            return Estimate(name, float(self.values[k]), None, note=f"on {self.on_bound[name]}")
        interval = None
        if intervals is not None and not math.isnan(sigma):
            found = self.profile(name, intervals)
            interval = (found.low, found.high)
        return Estimate(
            name, float(self.values[k]), None if math.isnan(sigma) else sigma, interval=interval
        )

    def table(self, level: float = 0.95) -> dict[str, Array]:
        """The points with the fit, as columns (n,): what was read, curve, residual and bands."""
        points = self.curve.points
        found = dict(points.columns)
        taken = set(found)

        def put(name: str, column: Array) -> None:
            while name in taken:
                name += "_"
            found[name] = column

        if self.formula.predicts is not None:
            group = [points.groups[k] for k in points.group] if points.groups else None
            bands = self.bands(points.columns, level, group)
            put("fit", bands.value)
            put("low", bands.low)
            put("high", bands.high)
            put("predicted_low", bands.predicted_low)
            put("predicted_high", bands.predicted_high)
        put("residual", self.residuals)
        return found

    def plot(self, level: float = 0.95) -> Figure:
        """Points, curve and bands over the first column, and the residuals; needs matplotlib."""
        # imported here: start-up time
        from arael.plot.curve import curve_figure

        return curve_figure(self, self.formula, self.curve.points, level)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "status": self.result.status,
            "converged": self.converged,
            "formula": self.formula.text,
            "predicts": self.formula.predicts,
            "points": self.curve.points.size,
            "skipped": self.skipped,
            "starts": self.starts,
            "iterations": self.result.iterations,
            "report": self.report().to_dict(),
        }

    def __repr__(self) -> str:
        return f"<Fit of {self.formula.text}: {self.curve.points.size} points>"

    def __str__(self) -> str:
        return str(self.report())

    def _sheet(self) -> Sheet:
        return replace(self.report()._sheet(), title=repr(self).strip("<>"))
