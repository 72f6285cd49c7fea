"""The verdict on a calibration: what the data determines, what is missing, what is suspicious."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.cost_table import cost_table
from arael.analysis.diagnosis import diagnose
from arael.analysis.freedom import FreeDirections
from arael.analysis.jacobian import Jacobian, jacobian
from arael.analysis.noise import Noise, Scatter, noise, rejected_groups
from arael.analysis.normal import NormalEquations
from arael.analysis.projection import projection_uncertainty
from arael.analysis.report import scalars_of
from arael.analysis.weakness import MANY, WeakDirection, plain_name, weak_directions
from arael.diagnostics.records import AraelError
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.failures import refuse_required
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

MOST_SCALARS = 1500
"""Largest problem, in free scalars: matrices are dense, and each variation is an eigenproblem."""
_MOST_ENTRIES = 40_000_000
"""Most entries (residuals by scalars) of the dense matrix that the tests of residuals need."""
_AT_ONCE = 4096
_SHOWN = 60
_CORRELATED = 0.5
"""Least correlation that is shown."""
_UNCERTAIN = 5.0
"""Uncertainty of a projection relative to a measured pixel from which a camera is poor there."""
_PART = 0.25
"""Least part of the picture in which it is."""
_ZERO = 2.0
"""Standard deviations within which a parameter is not distinct from zero."""


@dataclass(frozen=True)
class Determined:
    """How one scalar, or one scalar of many rows, is determined.

    Attributes
    ----------
    name : of the scalar, ``cameras[0].f.x``, or of those of all rows, ``views.board.rotation.x``
    rows : number of rows
    value : of the solution; None of a rotation, and of many rows
    sigma : standard deviation, of many rows the median; infinite if it is not determined
    worst : the largest of many rows
    shares : part of its information by constraint, in the order of the model
        The relative fall of the variance for a relative rise of the weight of that constraint:
        ``c' Jg'Jg c / c' J'J c`` with c the column of ``(J'J)^-1``.
    inflation : standard deviation relative to that if all other scalars were known
    partner, correlation : the most correlated scalar; "" if none is
    """

    name: str
    rows: int
    value: float | None
    sigma: float
    worst: float
    unit: str
    shares: dict[str, float]
    inflation: float
    partner: str = ""
    correlation: float = 0.0

    @property
    def spread(self) -> str:
        """Standard deviation in words."""
        if not math.isfinite(self.worst):
            return "not determined" if self.rows == 1 or not math.isfinite(self.sigma) else (
                f"+- {self.sigma:.2g}, of some rows not determined"
            )  # fmt: skip
        if self.rows > 1:
            return f"+- {self.sigma:.2g} (worst {self.worst:.2g})"
        return f"+- {self.sigma:.2g}"

    @property
    def sources(self) -> str:
        """Constraints that determine it, ``Corner.lens 96 %, Camera.prior 4 %``."""
        wide = sorted(self.shares.items(), key=lambda pair: -pair[1])
        return ", ".join(f"{label} {100 * part:.0f} %" for label, part in wide[:3] if part > 0.005)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "name": self.name,
            "rows": self.rows,
            "value": self.value,
            "sigma": _finite(self.sigma),
            "worst": _finite(self.worst),
            "unit": self.unit,
            "shares": self.shares,
            "inflation": _finite(self.inflation),
            "correlated_with": self.partner or None,
            "correlation": self.correlation,
        }


@dataclass(frozen=True)
class Point:
    """One point of a verdict.

    Attributes
    ----------
    topic : ``non-finite``, ``not-minimal``, ``gauge`` (nothing holds the map), ``unseen`` (a motion
        or view is missing), ``redundant`` (two parameters for one effect), ``coverage`` (part of a
        picture has no points), ``scale`` (noise of another size than assumed), ``group`` (large
        residuals at some rows), ``order`` (correlated in time), ``place`` (by the part of the
        picture), ``bias`` (by group)
    message, advice : in words
    """

    topic: str
    message: str
    advice: str

    def __str__(self) -> str:
        return f"{self.message}\n    {self.advice}"


@dataclass(frozen=True, repr=False)
class Verdict(Displayed):
    """What the data of a solved problem determines; print it, or read its fields.

    Attributes
    ----------
    name : of the model
    residuals, parameters : their numbers
    determined : how each parameter is determined
    directions : weak and free directions, with the measurements that are missing
    noise : by constraint
    findings : what is suspicious; empty for a good calibration
    remarks : what is worth knowing, and what was not tested
    judged : whether the data was judged; not in problems that are too large
    """

    name: str
    residuals: int
    parameters: int
    determined: tuple[Determined, ...] = ()
    directions: tuple[WeakDirection, ...] = ()
    noise: tuple[Scatter, ...] = ()
    findings: tuple[Point, ...] = ()
    remarks: tuple[str, ...] = field(default=())
    judged: bool = True

    @property
    def good(self) -> bool:
        """Whether it was judged, and nothing suspicious was found."""
        return self.judged and not self.findings

    def __repr__(self) -> str:
        return f"<Verdict on {self.name}: {len(self.findings)} findings>"

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield self._title()
        if self.determined:
            yield ""
            yield "parameters"
            cells = self.rows()
            widths = [max(len(row[k]) for row in cells) for k in range(5)]
            for row in cells:
                parts = (text.ljust(width) for text, width in zip(row, widths, strict=True))
                yield "  " + "  ".join(parts).rstrip()
            more = len(self.determined) - _SHOWN
            if more > 0:
                yield f"  ... {more} more"
        if self.noise:
            yield ""
            yield "noise, relative to what is assumed"
            width = max(len(one.label) for one in self.noise)
            for one in self.noise:
                yield (
                    f"  {one.label:<{width}}  {one.ratio:.3g}  "
                    f"({one.freedom:.0f} degrees of freedom)"
                )
        yield ""
        yield from (f"found: {one}" for one in self.findings)
        if self.good:
            yield "nothing suspicious was found"
        yield from (f"note: {one}" for one in self.remarks)

    def _title(self) -> str:
        count = len(self.findings)
        verdict = "good" if self.good else f"{count} finding{'s' * (count > 1)}"
        verdict = verdict if self.judged else "not judged"
        return (
            f"verdict on {self.name}: {verdict} "
            f"({self.parameters} parameters, {self.residuals} residuals)"
        )

    def rows(self) -> list[tuple[str, ...]]:
        """Cells of the table of parameters: name, value, spread, sources, correlation."""
        found: list[tuple[str, ...]] = []
        for one in self.determined[:_SHOWN]:
            name = one.name if one.rows == 1 else f"{one.name} ({one.rows} rows)"
            value = "" if one.value is None else f"{one.value:.6g}"
            partner = f"{one.correlation:+.3f} {one.partner}" if one.partner else ""
            spread = f"{one.spread} {one.unit}".rstrip()
            found.append((name, value, spread, one.sources, partner))
        return found

    def _sheet(self) -> Sheet:
        head = ("parameter", "value", "standard deviation", "determined by", "most correlated")
        notes = [
            *(f"noise of {one.label}: {one.ratio:.3g} times what is assumed" for one in self.noise),
            *(f"found: {one.message}: {one.advice}" for one in self.findings),
            *(f"note: {one}" for one in self.remarks),
        ]
        return Sheet(self._title(), head, self.rows(), notes)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "name": self.name,
            "good": self.good,
            "judged": self.judged,
            "residuals": self.residuals,
            "parameters": self.parameters,
            "determined": [one.to_dict() for one in self.determined],
            "directions": [one.to_dict() for one in self.directions],
            "noise": {
                one.label: {"ratio": one.ratio, "degrees_of_freedom": one.freedom}
                for one in self.noise
            },
            "findings": [
                {"topic": one.topic, "message": one.message, "advice": one.advice}
                for one in self.findings
            ],
            "remarks": list(self.remarks),
        }


def verdict(model: Any) -> Verdict:
    """Judge the solution of a model; see `arael.Model.verdict`."""
    problem: Problem = model._problem()
    refuse_required(problem.layout, "a verdict", "ask `covariance()` and `diagnose()`")
    table = cost_table(problem)
    diagnosis = diagnose(problem)
    residuals, parameters = diagnosis.residuals, diagnosis.parameters
    findings = [
        Point(one.topic, one.message, one.advice)
        for one in diagnosis.findings
        if one.topic in ("non-finite", "not-minimal")
    ]
    remarks = [f"`{label}` has no active instance" for label, n in table.instances.items() if not n]
    broken = any(one.topic == "non-finite" for one in findings)
    if broken or not parameters or parameters > MOST_SCALARS:
        if parameters > MOST_SCALARS:
            remarks.append(
                f"there are more than {MOST_SCALARS} parameters: judge a solve of part of the "
                "data, every tenth view for example; `report()`, `covariance()` and "
                "`free_directions()` are for problems of any size"
            )
        return Verdict(
            problem.layout.name,
            residuals,
            parameters,
            findings=tuple(findings),
            remarks=tuple(remarks),
            judged=not parameters,
        )
    equations = NormalEquations(problem, hold_bounds=True)
    rows = jacobian(problem)
    scalars = {name: (value, unit) for name, value, unit in scalars_of(problem)}
    inverse, sigma = equations.covariance()
    units = {name: unit for name, (_, unit) in scalars.items()}
    free = diagnosis.free
    if free is None or equations.on_bound:
        free = FreeDirections(equations, second_order=True)
    directions = weak_directions(model, equations, free, units)
    findings += _points(directions)
    remarks += [f"`{name}` is on {text}" for name, text in equations.on_bound.items()]
    lossy = [g.label for g in problem.layout.groups if g.loss_text]
    if lossy:
        listed = ", ".join(f"`{label}`" for label in dict.fromkeys(lossy))
        remarks.append(f"size and pattern of residuals with a loss are not tested: {listed}")
    found = Noise()
    if residuals * parameters <= _MOST_ENTRIES:
        found = noise(problem, equations, rows, inverse)
    else:
        remarks.append("there are too many residuals to test their pattern")
    findings += [Point(one.topic, one.message, one.advice) for one in found.patterns]
    findings += [
        Point(one.topic, one.message, one.advice) for one in rejected_groups(model, problem)
    ]
    findings += _uncovered(model)
    determined = _determined(equations, rows, inverse, sigma, scalars)
    remarks += _without_effect(problem, determined)
    return Verdict(
        problem.layout.name,
        residuals,
        parameters,
        tuple(determined),
        tuple(directions),
        found.scatters,
        tuple(findings),
        tuple(remarks),
    )


def _uncovered(model: Any) -> Iterator[Point]:
    """Cameras that are far less certain in part of the picture than a corner is measured."""
    try:
        pictures = projection_uncertainty(model)
    except AraelError:
        return  # no pixels
    for one in pictures:
        known = one.sigma[np.isfinite(one.sigma)]
        uncertain = known > _UNCERTAIN * one.noise
        if not len(known) or uncertain.mean() < _PART:
            continue
        low, high = one.seen.min(axis=0), one.seen.max(axis=0)
        yield Point(
            "coverage",
            f"projections of `{one.camera}` are uncertain by {_UNCERTAIN:g} times the noise of a "
            f"measured pixel, or more, in {100 * uncertain.mean():.0f} % of the picture",
            f"missing: points elsewhere in the picture (now from {low[0]:.4g} to {high[0]:.4g} in "
            f"x and from {low[1]:.4g} to {high[1]:.4g} in y); `arael diagnose --verdict --plot` "
            "draws where",
        )


def _points(directions: list[WeakDirection]) -> Iterator[Point]:
    """Findings of weak directions; those of one gauge are one."""
    gauges = [one for one in directions if one.kind == "gauge"]
    for advice in dict.fromkeys(one.advice for one in gauges):
        words = "; ".join(one.words for one in gauges if one.advice == advice)
        yield Point("gauge", f"nothing holds the map in place: {words}", advice)
    for one in directions:
        if one.kind != "gauge":
            yield Point(one.kind, one.words, one.advice)


def _determined(
    equations: NormalEquations,
    rows: Jacobian,
    inverse: Floats,
    sigma: Floats,
    scalars: dict[str, tuple[float | None, str]],
) -> list[Determined]:
    """How each scalar is determined, scalars of many rows together."""
    names = equations.names
    shares = _shares(equations, rows, inverse)
    known = np.where(np.isfinite(sigma), sigma, 0.0)
    inflation = np.where(np.isfinite(sigma), known / equations.scale[equations.free], np.inf)
    safe = np.where(known > 0, known, 1.0)
    correlation = inverse / np.outer(safe, safe)
    correlation[~np.isfinite(sigma)] = 0
    correlation[:, ~np.isfinite(sigma)] = 0
    np.fill_diagonal(correlation, 0)
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        groups.setdefault(plain_name(name), []).append(k)
    parts: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        own = groups[plain_name(name)]
        parts.update({plain_name(name): own} if len(own) > MANY else {name: [k]})
    found = []
    for name, part in parts.items():
        block = np.abs(correlation[part])
        at = np.unravel_index(int(np.argmax(block)), block.shape)
        most = float(correlation[part[int(at[0])], at[1]])
        partner = names[int(at[1])] if abs(most) > _CORRELATED else ""
        value, unit = scalars[names[part[0]]]
        middle = shares[:, part].mean(axis=1)
        found.append(
            Determined(
                name,
                len(part),
                value if len(part) == 1 else None,
                float(np.median(sigma[part])),
                float(sigma[part].max()),
                unit,
                {label: float(s) for label, s in zip(rows.labels, middle, strict=True) if s > 0},
                float(np.median(inflation[part])),
                partner,
                most if partner else 0.0,
            )
        )
    return found


def _shares(equations: NormalEquations, rows: Jacobian, inverse: Floats) -> Floats:
    """(labels, n) part of the information on each scalar by constraint."""
    kept = np.flatnonzero(np.isin(equations.problem.free, equations.free))
    matrix = rows.matrix[:, kept]
    found = np.zeros((len(rows.labels), len(kept)))
    for begin in range(0, len(rows), _AT_ONCE):
        part = slice(begin, begin + _AT_ONCE)
        square = np.asarray(matrix[part] @ inverse) ** 2
        np.add.at(found, rows.label_of[part], square)
    total = found.sum(axis=0)
    return np.asarray(found / np.where(total > 0, total, 1.0))


def _without_effect(problem: Problem, determined: list[Determined]) -> list[str]:
    """Parameters that begin at zero and do not differ from it."""
    found = []
    zeros = {
        (table.path, column.path)
        for table in problem.layout.tables
        for column in table.columns
        if column.param is not None
        and column.param.kind in ("real", "vec")
        and column.default is not None
        and not isinstance(column.default, str)
        and not any(column.default)
    }
    for one in determined:
        if one.value is None or not math.isfinite(one.sigma) or abs(one.value) > _ZERO * one.sigma:
            continue
        plain = plain_name(one.name)
        for table, column in zeros:
            path = f"{table}.{column}" if table else column
            if plain == path or plain.startswith(f"{path}."):
                found.append(one.name)
                break
    if not found:
        return []
    listed = ", ".join(f"`{name}`" for name in found)
    are = "is zero within its" if len(found) == 1 else "are zero within their"
    return [f"{listed} {are} standard deviation: the model may do without"]


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
