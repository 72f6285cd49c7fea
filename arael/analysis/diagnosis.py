"""Runs all analyses, and lists possible reasons for a failed solve or a poor result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.analysis.cost_table import CostTable, cost_table
from arael.analysis.freedom import FreeDirections
from arael.analysis.jacobian import Jacobian, jacobian
from arael.analysis.normal import NormalEquations
from arael.diagnostics.records import Diagnostic
from arael.runtime.constrained.active import acting_rows
from arael.runtime.constrained.rows import Rows
from arael.runtime.failures import listed
from arael.runtime.levenberg.diagnosis import non_finite
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

Topic = Literal[
    "non-finite", "inactive", "dominant", "outlier", "untouched", "free", "not-minimal", "stiff",
    "violated",
]  # fmt: skip

_DOMINANT = 0.9
_OUTLIER = 0.1
"""Share of the cost above which a single instance is reported."""
_STIFF = 1e9
"""Condition number of J'J above which the problem is reported as stiff, in f64."""
_MINIMAL = 1e-3


@dataclass(frozen=True)
class Finding:
    """One suspicious finding.

    Attributes
    ----------
    topic : its subject
    message : the finding, with names
    advice : what to do about it
    """

    topic: Topic
    message: str
    advice: str

    def __str__(self) -> str:
        return f"{self.message}\n    {self.advice}"


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """The state of a problem at its current values.

    Attributes
    ----------
    model : its name
    cost : sum of squared residuals
    table : the cost by constraint
    parameters, residuals : their numbers
    findings : suspicious findings, most severe first
    worst : instances of the largest cost: (instance, cost)
    gradient : largest entry of ``2 J'r`` by magnitude, with the name of its parameter; of
        parameters that no active bound holds, if there are any
    decrement : decrease of the cost that the linear model predicts for a full Gauss-Newton step of
        what no active bound holds, or NaN
    eigenvalues : smallest non-zero and largest eigenvalue of J'J with its diagonal scaled to 1
    sensitivity : smallest and largest length of a Jacobian column, with their parameters
    free : the free directions; None if the derivatives are not finite
    """

    model: str
    cost: float
    table: CostTable
    parameters: int
    residuals: int
    findings: tuple[Finding, ...]
    worst: tuple[tuple[str, float], ...] = ()
    gradient: tuple[str, float] = ("", 0.0)
    decrement: float = float("nan")
    eigenvalues: tuple[float, float] = (float("nan"), float("nan"))
    sensitivity: tuple[tuple[str, float], ...] = ()
    free: FreeDirections | None = field(default=None)

    def __repr__(self) -> str:
        return f"<Diagnosis of {self.model}: cost {self.cost:.6g}, {len(self.findings)} findings>"

    def __str__(self) -> str:
        lines = [
            f"{self.model}: {self.parameters} parameters, {self.residuals} residuals, "
            f"cost {self.cost:.6g}",
            "",
            str(self.table),
            "",
        ]
        if self.worst:
            lines.append("costliest instances")
            lines += [f"  {cost:<10.4g} {name}" for name, cost in self.worst]
            lines.append("")
        if self.free is not None:
            lines += [*self._numbers(), str(self.free), ""]
        lines += [f"found: {one}" for one in self.findings] or ["nothing suspicious was found"]
        return "\n".join(lines)

    def _numbers(self) -> list[str]:
        name, value = self.gradient
        low, high = self.eigenvalues
        found = [f"largest gradient: {value:.3g} at `{name}`"] if name else []
        if np.isfinite(self.decrement):
            found.append(f"predicted decrease of a full step: {self.decrement:.3g}")
        found += [
            f"{what} sensitivity: {length:.3g} sigmas per unit of `{scalar}`"
            for what, (scalar, length) in zip(("least", "largest"), self.sensitivity, strict=False)
        ]
        if np.isfinite(low) and low > 0:
            found.append(f"eigenvalues of the scaled J'J: {low:.3g} to {high:.3g}")
        return found

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "model": self.model,
            "cost": self.cost,
            "parameters": self.parameters,
            "residuals": self.residuals,
            "costs": dict(self.table),
            "instances": dict(self.table.instances),
            "worst": [{"instance": name, "cost": cost} for name, cost in self.worst],
            "rank": None if self.free is None else self.free.rank,
            "free": [] if self.free is None else [one.words for one in self.free],
            "findings": [
                {"topic": f.topic, "message": f.message, "advice": f.advice} for f in self.findings
            ],
        }


def diagnose(problem: Problem) -> Diagnosis:
    """Run all analyses at the current values of a problem; never raises for its numbers."""
    table = cost_table(problem)
    rows = jacobian(problem)
    findings = _inactive(table)
    costs: Floats = np.zeros(int(rows.constraint.max(initial=-1)) + 1)
    np.add.at(costs, rows.constraint, rows.residuals**2)
    known: dict[str, Any] = {}
    broken = [_as_finding(problem, derivatives) for derivatives in (False, True)
              if _is_broken(rows, derivatives)][:1]  # fmt: skip
    if broken:
        findings = broken + findings
    elif len(rows.names):
        known, more = _linearised(problem, rows, table.total)
        findings = more + findings
        findings += _dominant(table) + _outliers(rows, costs, table)
    order = np.argsort(-np.nan_to_num(costs), kind="stable")[:5]
    worst = tuple((rows.instance(int(i)), float(costs[i])) for i in order if costs[i] > 0)
    return Diagnosis(
        problem.layout.name,
        table.total,
        table,
        len(rows.names),
        len(rows),
        tuple(findings),
        worst,
        **known,
    )


def _is_broken(rows: Jacobian, derivatives: bool) -> bool:
    return not np.isfinite(rows.matrix.data if derivatives else rows.residuals).all()


def _as_finding(problem: Problem, derivatives: bool) -> Finding:
    said: Diagnostic = non_finite(problem, derivatives)
    message = said.message.removesuffix(" at the start")
    notes = "".join(f"\n    {note}" for note in said.notes)
    return Finding("non-finite", message + notes, said.help[0])


def _inactive(table: CostTable) -> list[Finding]:
    idle = [label for label, count in table.instances.items() if count == 0]
    if not idle:
        return []
    return [
        Finding(
            "inactive",
            f"{listed(idle)} {'has' if len(idle) == 1 else 'have'} no active instance",
            "is the list empty, or the guard false everywhere?",
        )
    ]


def _dominant(table: CostTable) -> list[Finding]:
    acting = [label for label, count in table.instances.items() if count]
    if len(acting) < 2 or table.total <= 0:
        return []
    label = max(acting, key=table.__getitem__)
    rms = table.rms(label)
    if table[label] < _DOMINANT * table.total or rms < 2:
        return []
    return [
        Finding(
            "dominant",
            f"`{label}` is {100 * table[label] / table.total:.0f} % of the cost, {rms:.3g} "
            "sigmas per residual",
            "is its sigma too small, a start value wrong, or does it contradict others?",
        )
    ]


def _outliers(rows: Jacobian, costs: Floats, table: CostTable) -> list[Finding]:
    if len(costs) < 8 or table.total <= 0:
        return []
    at = int(np.argmax(costs))
    count = int(np.count_nonzero(rows.constraint == at))
    if costs[at] < _OUTLIER * table.total or costs[at] < 25 * count:
        return []
    return [
        Finding(
            "outlier",
            f"`{rows.instance(at)}` alone is {100 * costs[at] / table.total:.0f} % of the cost",
            "check its data; a robust loss limits the influence of a wrong measurement",
        )
    ]


def _linearised(
    problem: Problem, rows: Jacobian, cost: float
) -> tuple[dict[str, Any], list[Finding]]:
    """Findings from gradient and Hessian, if they are finite."""
    findings: list[Finding] = []
    gradient = 2 * (rows.matrix.T @ rows.residuals)
    if problem.layout.required:
        gradient = 2 * acting_rows(problem).gradient[problem.free]
        findings += _violated(problem)
    lengths = rows.sensitivities()
    loose = np.flatnonzero(lengths == 0)
    if len(loose):
        names = [rows.names[i] for i in loose]
        findings.append(
            Finding(
                "untouched",
                f"no residual changes with {listed(names)}",
                "is a guard false or a list empty? otherwise freeze it, or add a prior",
            )
        )
    equations = NormalEquations(problem)
    values, basis = equations.smallest()
    free = FreeDirections(equations, basis, second_order=True)
    held = free.rank > 0 and len(values) > basis.shape[1]
    low = float(values[basis.shape[1]]) if held else float("nan")
    if len(free) > len(loose):
        findings.append(
            Finding(
                "free",
                f"{len(free)} of {free.parameters} directions are free: "
                + "; ".join(one.words for one in free[:4]),
                "fix as many coordinates, add a prior or measurements; if they should be free, a "
                "solve works with damping, but there is no covariance",
            )
        )
    decrement = float("nan")
    moves = np.ones(len(gradient), dtype=np.bool_)
    if not len(free):
        within = NormalEquations(problem, hold_bounds=True) if problem.box.count else equations
        moves = np.isin(problem.free, within.free)
        decrement = _decrement(within, gradient[moves])
        if decrement > _MINIMAL * max(cost, 1e-12) and decrement > 1e-9:
            findings.append(
                Finding(
                    "not-minimal",
                    f"this is not a minimum: the predicted decrease of a full step is "
                    f"{decrement:.3g}",
                    "this is normal before a solve; after it, allow more iterations or a "
                    "tighter precision, or check the derivatives (`check_gradients`)",
                )
            )
    condition = equations.largest / low if held else 1.0
    if condition > _STIFF * (1e-3 if problem.layout.precision == "f32" else 1):
        findings.append(
            Finding(
                "stiff",
                f"condition number of the scaled J'J: {condition:.1e}",
                "use more similar sigmas, loosen the tight ones in a first pass, or constrain "
                "the weak direction with a prior",
            )
        )
    # At a minimum on a bound, the gradient across it does not vanish.
    biggest = int(np.argmax(np.abs(gradient) * (moves if moves.any() else 1)))
    ends = (int(np.argmin(lengths)), int(np.argmax(lengths)))
    known = {
        "gradient": (rows.names[biggest], float(np.abs(gradient[biggest]))),
        "decrement": decrement,
        "eigenvalues": (low, equations.largest),
        "sensitivity": tuple((rows.names[i], float(lengths[i])) for i in ends),
        "free": free,
    }
    return known, findings


def _violated(problem: Problem) -> list[Finding]:
    """Rows that hold exactly at a solution, and do not here."""
    rows = Rows(problem)
    values, entries = rows.evaluate()
    off = rows.violations(values)
    off = off / np.maximum(rows.lengths(entries, np.maximum(rows.sizes(), 1e-6)), 1e-300)
    at = np.flatnonzero(off > 1e-6)
    if not len(at):
        return []
    names = list(dict.fromkeys(rows.name(int(k)) for k in at[np.argsort(-off[at])]))
    return [
        Finding(
            "violated",
            f"{listed(names)} {'does' if len(names) == 1 else 'do'} not hold",
            "this is normal before a solve; after it, `result.conflict` names what cannot hold "
            "together",
        )
    ]


def _decrement(equations: NormalEquations, gradient: Floats) -> float:
    """Predicted decrease ``g' H^-1 g`` of a full step, of the scalars that move."""
    half = 0.5 * gradient
    scaled = np.zeros(equations.problem.size)
    scaled[equations.free] = half * equations.scale[equations.free]
    return float(scaled @ equations.solver.solved(scaled))
