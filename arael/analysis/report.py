"""The report on a solution: parameters with standard errors, quality of the fit, suspicions."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.cost_table import cost_table
from arael.analysis.covariance import Covariance, check_scale
from arael.analysis.diagnosis import diagnose
from arael.analysis.scalars import tangent_units
from arael.analysis.sigmas import sigmas
from arael.display.displayed import Displayed
from arael.display.measured import measured, rounded
from arael.display.sheet import Sheet
from arael.runtime.failures import SolveError
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

CORRELATED = 0.9
"""Least correlation that is listed."""
_DIGITS = 8
"""Digits of a value without a standard error."""
_NEARLY_ONE = 0.999
_PAIRS = 10
_CHANCE = 1e-4
"""Probability of a chi-square, in one of its tails, below which it is suspicious."""
_DENSE = 2000
"""Most scalars whose correlations are computed."""
_SHOWN = 50
"""Most parameters listed one by one; those of collections are summarised where there are more."""
_MOST = 20_000
"""Largest system whose standard errors are computed, in about a second."""
_ROW = re.compile(r"([^\[]+)(\[.*?\])(.*)", re.DOTALL)
"""Name of a scalar in a collection: path, row, and the rest."""


@dataclass(frozen=True)
class Statistics:
    """What the residuals say about the fit.

    Attributes
    ----------
    cost : sum of squared residuals: chi-square, if they are whitened by known standard deviations
    residuals : their number n
    parameters : number k of scalars solved for, without those on an active bound
    scatter : whether the variance of the residuals is estimated from their scatter
    robust : whether a residual has a loss, so that the cost is no likelihood of normal errors
    """

    cost: float
    residuals: int
    parameters: int
    scatter: bool
    robust: bool = False

    @property
    def freedom(self) -> int:
        """Degrees of freedom, n - k."""
        return self.residuals - self.parameters

    @property
    def reduced(self) -> float:
        """Reduced chi-square, ``cost / (n - k)``; NaN without degrees of freedom."""
        return self.cost / self.freedom if self.freedom > 0 else math.nan

    @property
    def rms(self) -> float:
        """Root mean square, ``sqrt(cost / n)``."""
        return math.sqrt(self.cost / self.residuals) if self.residuals else math.nan

    @property
    def variance(self) -> float:
        """Factor of ``(J'J)^-1``: 1, or the reduced chi-square."""
        return self.reduced if self.scatter else 1.0

    @property
    def deviance(self) -> float:
        """``-2 log L`` of normal errors at its largest, without the terms of known deviations.

        The cost; of an unknown common variance ``n (log(2 pi cost / n) + 1)``. NaN with a loss.
        """
        if self.robust or not self.residuals:
            return math.nan
        if not self.scatter:
            return self.cost
        if not self.cost > 0 or self.freedom <= 0:
            return math.nan
        return self.residuals * (math.log(2 * math.pi * self.cost / self.residuals) + 1)

    @property
    def aic(self) -> float:
        """Akaike's criterion ``-2 log L + 2 K``; K counts an unknown variance (Akaike, 1974)."""
        return self.deviance + 2 * self._counted

    @property
    def bic(self) -> float:
        """Schwarz's criterion ``-2 log L + K log n`` (Schwarz, 1978)."""
        return self.deviance + math.log(max(self.residuals, 1)) * self._counted

    @property
    def _counted(self) -> int:
        return self.parameters + (1 if self.scatter else 0)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; None for what does not exist."""
        found = {
            "chi_square": self.cost,
            "residuals": self.residuals,
            "parameters": self.parameters,
            "degrees_of_freedom": self.freedom,
            "reduced_chi_square": self.reduced,
            "rms": self.rms,
            "aic": self.aic,
            "bic": self.bic,
        }
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in found.items()}


@dataclass(frozen=True)
class Estimate:
    """One scalar of a solution.

    Attributes
    ----------
    value : None for a scalar of a rotation, whose tangent is not stored
    sigma : standard error; None without one
    note : the reason: ``fixed``, ``on its upper bound 1``, ``not determined``
    interval : (low, high), if it was computed
    """

    name: str
    value: float | None
    sigma: float | None
    unit: str = ""
    note: str = ""
    interval: tuple[float, float] | None = None

    def __str__(self) -> str:
        value, sigma = measured(self.value, self.sigma, _DIGITS)
        spread = f"+- {sigma}" if sigma else ""
        percent = ""
        if self.sigma is not None and self.value and math.isfinite(self.sigma):
            share = 100 * self.sigma / abs(self.value)
            percent = f"({share:.3g} %)" if share < 1000 else ""
        parts = [value, spread, self.unit, percent]
        if self.interval is not None:
            parts.append(f"[{', '.join(rounded(end, self.sigma) for end in self.interval)}]")
        parts.append(f"({self.note})" if self.note else "")
        return " ".join(part for part in parts if part)


@dataclass(frozen=True)
class Column:
    """One scalar of all rows of a collection, summarised.

    Attributes
    ----------
    name : with ``*`` for the row: ``poses[*].t.x``
    estimates : of the rows
    """

    name: str
    estimates: tuple[Estimate, ...]

    @property
    def values(self) -> tuple[float, float] | None:
        """Least and largest value; None for scalars of rotations."""
        found = [one.value for one in self.estimates if one.value is not None]
        return (min(found), max(found)) if found else None

    @property
    def sigmas(self) -> tuple[float, float, Estimate] | None:
        """Median and largest standard error, and what has the largest; None without any."""
        found = sorted((e for e in self.estimates if e.sigma is not None), key=_sigma)
        return (_sigma(found[len(found) // 2]), _sigma(found[-1]), found[-1]) if found else None

    def __str__(self) -> str:
        parts = [f"{len(self.estimates)} values"]
        if self.values is not None:
            parts.append(f"{self.values[0]:.6g} to {self.values[1]:.6g}")
        if self.sigmas is not None:
            median, largest, one = self.sigmas
            parts.append(f"standard error {median:.3g} at the median, {largest:.3g} of {one.name}")
        notes = sum(bool(one.note) for one in self.estimates)
        if notes:
            parts.append(f"{notes} with notes")
        unit = self.estimates[0].unit
        return "; ".join(parts) + (f" [{unit}]" if unit else "")


def _sigma(one: Estimate) -> float:
    return math.nan if one.sigma is None else one.sigma


@dataclass(frozen=True, repr=False)
class Report(Displayed):
    """A solution and how much it can be trusted; print it, or read its fields.

    Attributes
    ----------
    name : of the model
    parameters : every scalar that was solved for, and those on a bound
    correlations : (name, name, correlation) of the most correlated pairs, above 0.9
    statistics : numbers of the residuals, chi-square, AIC, BIC
    r_squared : share of the weighted variance of the measured column that the fit explains; None
        for models without one such column, and with a loss
    findings : suspicious findings in words
    notes : why something is missing
    """

    name: str
    parameters: tuple[Estimate, ...]
    correlations: tuple[tuple[str, str, float], ...]
    statistics: Statistics
    r_squared: float | None = None
    findings: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        return f"<Report on {self.name}: {len(self.parameters)} parameters>"

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield "parameters"
        listed: list[tuple[str, Estimate | Column]] = [(e.name, e) for e in self._listed()]
        listed += [(c.name, c) for columns in self._summarised().values() for c in columns]
        width = max((len(name) for name, _ in listed), default=0)
        for name, one in listed:
            unknown = isinstance(one, Estimate) and one.value is None
            yield f"  {name:<{width}} {' ' if unknown else '='} {one}"
        if len(self._single) > len(self._listed()):
            yield f"  ... {len(self._single) - len(self._listed())} more"
        if self.correlations:
            yield "correlations above 0.9"
            pairs = [(f"{a}, {b}", rho) for a, b, rho in self.correlations]
            width = max(len(pair) for pair, _ in pairs)
            yield from (f"  {pair:<{width}}  {rho:+.4f}" for pair, rho in pairs)
        yield "fit"
        yield from (f"  {name:<24} {text}" for name, text in self.figures())
        yield from (f"suspicious: {one}" for one in self.findings)
        yield from (f"note: {one}" for one in self.notes)

    @cached_property
    def collections(self) -> dict[str, tuple[Column, ...]]:
        """Parameters of collections by path, a `Column` for each scalar of their rows."""
        found: dict[str, dict[str, list[Estimate]]] = {}
        for one in self.parameters:
            match = _ROW.fullmatch(one.name)
            if match:
                path, _, rest = match.groups()
                found.setdefault(path, {}).setdefault(f"{path}[*]{rest}", []).append(one)
        return {
            path: tuple(Column(name, tuple(rows)) for name, rows in columns.items())
            for path, columns in found.items()
        }

    @cached_property
    def _single(self) -> tuple[Estimate, ...]:
        """What is listed one by one: all parameters, or where they are many those of the root."""
        if len(self.parameters) <= _SHOWN:
            return self.parameters
        return tuple(one for one in self.parameters if not _ROW.fullmatch(one.name))

    def _listed(self) -> tuple[Estimate, ...]:
        return self._single[:_SHOWN]

    def _summarised(self) -> dict[str, tuple[Column, ...]]:
        return self.collections if len(self.parameters) > _SHOWN else {}

    def figures(self) -> Iterator[tuple[str, str]]:
        """Name and text of each number of the fit."""
        of = self.statistics
        yield "residuals", str(of.residuals)
        yield "degrees of freedom", str(of.freedom)
        yield "sum of squares" if of.scatter else "chi-square", f"{of.cost:.8g}"
        if of.freedom > 0:
            if of.scatter:
                yield "residual deviation", f"{math.sqrt(of.reduced):.6g}"
            else:
                yield "reduced chi-square", f"{of.reduced:.6g}"
        if self.r_squared is not None:
            yield "R squared", f"{self.r_squared:.8g}"
        if not math.isnan(of.aic):
            yield "AIC", f"{of.aic:.6g}"
            yield "BIC", f"{of.bic:.6g}"

    def _sheet(self) -> Sheet:
        rows = [
            (one.name, *measured(one.value, one.sigma, _DIGITS), one.unit, one.note)
            for one in self._listed()
        ]
        for columns in self._summarised().values():
            for column in columns:
                low_high, spread = column.values, column.sigmas
                rows.append(
                    (
                        column.name,
                        "" if low_high is None else f"{low_high[0]:.6g} to {low_high[1]:.6g}",
                        "" if spread is None else f"up to {spread[1]:.3g}",
                        column.estimates[0].unit,
                        f"{len(column.estimates)} values",
                    )
                )
        more = len(self._single) - len(self._listed())
        notes = [
            *([f"{more} more parameters"] if more > 0 else []),
            ", ".join(f"{name} {text}" for name, text in self.figures()),
            *(f"correlation of {a} and {b}: {rho:+.4f}" for a, b, rho in self.correlations),
            *(f"suspicious: {one}" for one in self.findings),
            *(f"note: {one}" for one in self.notes),
        ]
        head = ("parameter", "value", "standard error", "unit", "")
        return Sheet(f"report on {self.name}", head, rows, notes)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "parameters": {
                one.name: {
                    "value": one.value,
                    "sigma": one.sigma,
                    "unit": one.unit,
                    **({"note": one.note} if one.note else {}),
                    **({"interval": list(one.interval)} if one.interval else {}),
                }
                for one in self.parameters
            },
            "correlations": [[a, b, rho] for a, b, rho in self.correlations],
            **{k: v for k, v in self.statistics.to_dict().items() if k != "parameters"},
            "r_squared": self.r_squared,
            "findings": list(self.findings),
            "notes": list(self.notes),
        }


def report(problem: Problem, scale: str = "known") -> Report:
    """Report on the current values of a problem; never raises for a singular one.

    Parameters
    ----------
    scale : as of `Covariance`
    """
    check_scale(scale)
    table = cost_table(problem)
    count = sum(table.residuals.values())
    robust = any(group.loss_text for group in problem.layout.groups)
    scatter = scale == "residual"
    notes: list[str] = []
    pairs: tuple[tuple[str, str, float], ...] = ()
    exact = 0
    try:
        if problem.size > _MOST:
            raise _TooLarge
        found = Covariance(problem)
        spread = dict(zip(found.names, found.sigma().tolist(), strict=True))
        on_bound, exact = found.on_bound, found.exact_directions
        if len(found.names) <= _DENSE:
            pairs = strongest(found.names, found.correlation())
    except _TooLarge:
        spread, on_bound = {}, {}
        notes = [f"standard errors are omitted: more than {_MOST} parameters"]
    except SolveError:
        known = sigmas(problem)
        spread, on_bound, notes = known.values, known.on_bound, list(known.notes)
    unknown = len(problem.free) - len(on_bound) - exact
    statistics = Statistics(table.total, count, unknown, scatter, robust)
    factor = math.sqrt(statistics.variance)
    if scatter and math.isnan(factor):
        notes.append("as many parameters as residuals: their scatter is not known")
    if problem.hooks is not None:
        notes += problem.hooks.notes
    parameters = []
    for name, value, unit in scalars_of(problem):
        sigma = spread.get(name)
        note = f"on {on_bound[name]}" if name in on_bound else ""
        if sigma is None and not note:
            note = "not determined" if spread else "without standard error"
        spread_here = None if sigma is None or math.isnan(factor) else sigma * factor
        parameters.append(Estimate(name, value, spread_here, unit, note))
    findings = [one.message for one in diagnose(problem).findings]
    findings += suspicions(statistics, pairs, on_bound)
    return Report(
        problem.layout.name,
        tuple(parameters),
        pairs,
        statistics,
        findings=tuple(findings),
        notes=tuple(notes),
    )


class _TooLarge(Exception):
    """The problem has too many scalars for standard errors."""


def strongest(names: Sequence[str], correlation: Floats) -> tuple[tuple[str, str, float], ...]:
    """The most correlated pairs, above `CORRELATED`."""
    upper = np.triu(np.abs(np.nan_to_num(correlation)), 1)
    rows, columns = np.nonzero(upper > CORRELATED)
    order = np.argsort(-upper[rows, columns], kind="stable")[:_PAIRS]
    return tuple((names[i], names[j], float(correlation[i, j]))
                 for i, j in zip(rows[order], columns[order], strict=True))  # fmt: skip


def suspicions(
    statistics: Statistics,
    pairs: Sequence[tuple[str, str, float]],
    on_bound: dict[str, str],
) -> list[str]:
    """What the numbers of a solution give reason to doubt, in words."""
    found = [f"`{name}` is on {text}" for name, text in on_bound.items()]
    found += [
        f"`{a}` and `{b}` can hardly be distinguished: their correlation is {rho:+.5f}"
        for a, b, rho in pairs
        if abs(rho) > _NEARLY_ONE
    ]
    if _is_off(statistics):
        why = "small, or the model does not describe the data"
        if statistics.reduced < 1:
            why = "large, or parameters follow the noise"
        found.append(
            f"the reduced chi-square is {statistics.reduced:.3g}, expected near 1: the standard "
            f"deviations are too {why}"
        )
    return found


def _is_off(statistics: Statistics) -> bool:
    """Whether a chi-square differs from its degrees of freedom noticeably, and not by chance."""
    if statistics.scatter or statistics.robust or statistics.freedom <= 0:
        return False
    if 2 / 3 < statistics.reduced < 1.5:
        return False
    # imported here: start-up time
    from scipy import special

    below = float(special.chdtr(statistics.freedom, statistics.cost))
    above = float(special.chdtrc(statistics.freedom, statistics.cost))
    return min(below, above) < _CHANCE


def scalar_values(problem: Problem) -> dict[str, float | None]:
    """Values of the free scalars by name; None for those of rotations."""
    return {name: value for name, value, _ in scalars_of(problem)}


def scalars_of(problem: Problem) -> Iterator[tuple[str, float | None, str]]:
    """Name, value and unit of every free scalar, in the order of the system.

    The value is None for a scalar of a rotation, whose tangent is not stored.
    """
    names = problem.parameter_names()
    system = problem.structure.system
    value_of: list[float | None] = [None] * problem.size
    unit_of = [""] * problem.size
    for number, (entity, blocks) in enumerate(
        zip(problem.layout.entities, system.blocks, strict=True)
    ):
        own = tangent_units(problem.layout, entity)
        first = np.asarray(blocks.first)
        state = np.asarray(problem.states[number], dtype=np.float64)
        for row in np.flatnonzero(first >= 0).tolist():
            at = int(first[row])
            unit_of[at : at + entity.tangent] = own
            for use in entity.params:
                if use.stored != use.tangent:
                    continue
                start = at + use.tangent_start
                value_of[start : start + use.tangent] = state[
                    row, use.stored_start : use.stored_start + use.stored
                ].tolist()
    for name, scalar in zip(names, problem.free.tolist(), strict=True):
        yield name, value_of[scalar], unit_of[scalar]
