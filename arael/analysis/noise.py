"""What the residuals of a solution tell about the noise: its size, its pattern, suspicious groups.

Residuals of a fit are correlated by the fit itself: with whitened residuals ``r`` of unit variance
their covariance is ``I - H``, with ``H = J (J'J)^-1 J'``. All tests use it, so that rows that only
determine their own parameters are not suspicious for being small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.jacobian import Jacobian
from arael.analysis.normal import NormalEquations
from arael.diagnostics.records import AraelError
from arael.runtime.problem import Problem
from arael.runtime.system import row_names

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_CHANCE = 1e-6
"""Probability, divided by the number of tests of one kind, below which a pattern is no accident."""
_NOTICEABLE = 1.25
"""Least ratio of measured and assumed standard deviation that is reported, either way."""
_OUTLYING = 1.5
"""Least ratio of the standard deviations of a group and of its constraint that is reported."""
_CORRELATED = 0.2
"""Least correlation of neighbours that is reported."""
_BIASED = 0.3
"""Least mean of a group, in standard deviations, that is reported."""
_FEWEST = 8
"""Fewest residuals, less the parameters they determine, that a statement is made from."""
_CELLS = 5
"""Cells of a picture in each direction."""
_REJECTED = 0.4
"""Mean weight of a group, relative to the median group, below which a loss rejects it."""
_SHOWN = 3
_TIMES = ("t", "time", "times", "stamp", "timestamp")


@dataclass(frozen=True)
class Scatter:
    """Noise of one constraint.

    Attributes
    ----------
    label : of the constraint
    residuals : their number
    freedom : degrees of freedom: residuals less what they lose to the parameters
    ratio : standard deviation relative to what the model assumes, without suspicious groups
    """

    label: str
    residuals: int
    freedom: float
    ratio: float


@dataclass(frozen=True)
class Pattern:
    """One suspicious pattern of the residuals.

    Attributes
    ----------
    topic : ``scale``, ``group``, ``order`` (correlated in time), ``place`` (by the part of the
        picture), ``bias`` (means of groups differ from zero)
    message, advice : in words
    """

    topic: str
    message: str
    advice: str


@dataclass(frozen=True)
class Noise:
    """Noise of a solution by constraint, and what is suspicious about it."""

    scatters: tuple[Scatter, ...] = ()
    patterns: tuple[Pattern, ...] = ()


@dataclass(frozen=True)
class _Rows:
    """Residuals of one constraint.

    Attributes
    ----------
    residuals : (n, m) by instance
    left : (n, m) expected square of each: 1 less its leverage
    derivatives, weighted : J (n * m, k) and J C, dense
    rows : (n,) rows of the table
    """

    label: str
    table: str
    residuals: Floats
    left: Floats
    derivatives: Floats
    weighted: Floats
    rows: Ints

    def covariance_of(self, sums: Floats) -> Floats:
        """Covariance (g, g) of weighted sums (g, n * m) of residuals of unit variance."""
        return sums @ sums.T - (sums @ self.derivatives) @ (sums @ self.weighted).T


def noise(problem: Problem, equations: NormalEquations, rows: Jacobian, inverse: Floats) -> Noise:
    """Test the residuals of a problem at its solution.

    Parameters
    ----------
    rows : its Jacobian
    inverse : (n, n) covariance of the scalars that are free in the equations
    """
    kept = np.isin(problem.free, equations.free)
    scatters, patterns = [], []
    for one in _constraints(problem, rows, inverse, kept):
        scatter, found = _tested(problem, one)
        if scatter is not None:
            scatters.append(scatter)
        patterns += found
    return Noise(tuple(scatters), tuple(patterns))


def rejected_groups(model: Any, problem: Problem) -> list[Pattern]:
    """Groups of measurements from which a loss takes most of the weight."""
    found = []
    groups = problem.layout.groups
    labels = [group.label for group in groups if group.case_of < 0]
    for number, group in enumerate(groups):
        if not group.loss_text or labels.count(group.label) != 1:
            continue
        try:
            weight = model.residual_values(group.label).weight
        except AraelError:
            continue  # a model without its text
        _, acting, active = problem.constraint_rows(number)
        for key, (member, names) in _keys(problem, group.table, active[acting]).items():
            sizes = np.bincount(member)
            means = np.bincount(member, weight) / np.maximum(sizes, 1)
            large = np.flatnonzero(sizes >= _FEWEST)
            if key == "row" or len(large) < 4:
                continue
            odd = large[means[large] < _REJECTED * np.median(means[large])]
            if not 0 < len(odd) <= len(large) / 3:
                continue
            listed = ", ".join(f"`{name}`" for name in names(odd[:_SHOWN]))
            more = f" and {len(odd) - _SHOWN} more" if len(odd) > _SHOWN else ""
            found.append(
                Pattern(
                    "group",
                    f"the loss of `{group.label}` takes most of the weight from the measurements "
                    f"at {listed}{more}",
                    "check these measurements: most of them are rejected",
                )
            )
    return found


def _constraints(
    problem: Problem, rows: Jacobian, inverse: Floats, kept: NDArray[np.bool_]
) -> Iterator[_Rows]:
    """Residuals of each constraint without a loss."""
    groups = problem.layout.groups
    ends = np.cumsum([0, *(len(active) for active in problem.structure.active)])
    for number, label in enumerate(rows.labels):
        own = [k for k, group in enumerate(groups) if group.label == label]
        first = groups[own[0]]
        if any(groups[k].loss_text or groups[k].sigma is not None for k in own):
            continue
        if any(groups[k].residuals != first.residuals for k in own):
            continue
        at = np.flatnonzero(rows.label_of == number)
        if not len(at):
            continue
        derivatives = np.asarray(rows.matrix[at][:, np.flatnonzero(kept)].toarray())
        weighted = derivatives @ inverse
        left = 1 - np.sum(derivatives * weighted, axis=1)
        m = first.residuals
        instance = rows.constraint[at][::m]
        table_rows = np.empty(len(instance), dtype=np.int64)
        for k in own:
            mine = (instance >= ends[k]) & (instance < ends[k + 1])
            table_rows[mine] = problem.structure.active[k][instance[mine] - ends[k]]
        yield _Rows(
            label,
            first.table,
            rows.residuals[at].reshape(-1, m),
            np.clip(left, 0.0, 1.0).reshape(-1, m),
            derivatives,
            weighted,
            table_rows,
        )


def _tested(problem: Problem, one: _Rows) -> tuple[Scatter | None, list[Pattern]]:
    """Scale and patterns of one constraint."""
    freedom = float(one.left.sum())
    if freedom < _FEWEST or not np.isfinite(one.residuals).all():
        return None, []
    keys = _keys(problem, one.table, one.rows)
    bad, patterns = _suspicious_groups(one, keys)
    good = ~bad
    freedom = float(one.left[good].sum())
    if freedom < _FEWEST:
        return None, patterns
    variance = float((one.residuals[good] ** 2).sum() / freedom)
    ratio = float(np.sqrt(variance))
    scatter = Scatter(one.label, one.residuals.size, freedom, ratio)
    patterns += _scale(scatter)
    if variance > 0:
        clean = np.where(good[:, None], one.residuals, 0.0) / ratio
        patterns += _order(problem, one, clean, keys) + _means(problem, one, clean, keys)
    return scatter, patterns


def _scale(scatter: Scatter) -> list[Pattern]:
    # imported here: start-up time
    from scipy import special

    ratio, freedom = scatter.ratio, scatter.freedom
    if 1 / _NOTICEABLE < ratio < _NOTICEABLE:
        return []
    square = freedom * ratio**2
    tail = special.chdtrc(freedom, square) if ratio > 1 else special.chdtr(freedom, square)
    if tail > _CHANCE:
        return []
    advice = (
        f"multiply its sigma by {ratio:.2g}, unless the model lacks an effect"
        if ratio > 1
        else f"multiply its sigma by {ratio:.2g}, or look for repeated measurements"
    )
    return [
        Pattern(
            "scale",
            f"the noise of `{scatter.label}` is {ratio:.2g} times what its sigma says "
            f"({freedom:.0f} degrees of freedom)",
            advice,
        )
    ]


def _keys(problem: Problem, path: str, rows: Ints) -> dict[str, tuple[Ints, Any]]:
    """Groups of the instances: by ref, by owner, by row; the number of each, and their names."""
    if not path or path.endswith("/rows"):
        return {}
    store, layout = problem.store, problem.layout.table(path)
    table = store.tables[path]
    found: dict[str, tuple[Ints, Any]] = {}

    def names_in(target: str) -> Any:
        return lambda chosen: row_names(store, target, chosen)

    for column in layout.columns:
        if column.role != "ref" or column.target is None or column.path.endswith("?"):
            continue
        target = np.asarray(table.target_rows(column.path))[rows]
        if (target >= 0).all():
            found[column.path] = (target, names_in(column.target.table))
    if layout.parent:
        owners = np.asarray(table.parent_rows())[rows]
        found[layout.parent] = (owners, names_in(layout.parent))
    found["row"] = (rows, names_in(path))
    return found


def _suspicious_groups(
    one: _Rows, keys: dict[str, tuple[Ints, Any]]
) -> tuple[NDArray[np.bool_], list[Pattern]]:
    """Rows (n,) in groups of far larger residuals than the rest, and the groups in words."""
    # imported here: start-up time
    from scipy import special

    bad = np.zeros(len(one.residuals), dtype=bool)
    patterns: list[Pattern] = []
    square, left = (one.residuals**2).sum(axis=1), one.left.sum(axis=1)
    for group, names in keys.values():
        count = int(group.max()) + 1
        sizes = np.bincount(group[~bad], minlength=count)
        costs: Floats = np.bincount(group[~bad], square[~bad], count).astype(np.float64)
        freedoms: Floats = np.bincount(group[~bad], left[~bad], count).astype(np.float64)
        known = np.flatnonzero((sizes > 0) & (freedoms > 0.5))
        if len(known) < 4:
            continue
        ratios = costs[known] / freedoms[known]
        usual = _robust_variance(costs[known], freedoms[known])
        tails = special.chdtrc(freedoms[known], costs[known] / usual)
        odd = (tails < _CHANCE / len(known)) & (ratios > _OUTLYING**2 * usual)
        odd &= costs[known] > 0
        if not odd.any() or odd.sum() > len(known) / 3:
            continue
        chosen = known[odd][np.argsort(-ratios[odd], kind="stable")]
        listed = [
            f"`{name}` ({np.sqrt(costs[k] / freedoms[k] / usual):.2g} times)"
            for name, k in zip(names(chosen[:_SHOWN]), chosen[:_SHOWN], strict=True)
        ]
        more = f" and {len(chosen) - _SHOWN} more" if len(chosen) > _SHOWN else ""
        patterns.append(
            Pattern(
                "group",
                f"the residuals of `{one.label}` are larger than elsewhere at "
                f"{', '.join(listed)}{more}",
                "check these measurements; a robust loss limits their influence",
            )
        )
        bad |= np.isin(group, chosen)
    return bad, patterns


def _robust_variance(costs: Floats, freedoms: Floats) -> float:
    """Variance of most groups: the median of their ratios, by what chi-square's median is."""
    # imported here: start-up time
    from scipy import special

    middle = special.chdtri(freedoms, 0.5)  # median of chi-square
    found = float(np.median(costs / middle))
    return max(found, 1e-300)


def _order(
    problem: Problem, one: _Rows, clean: Floats, keys: dict[str, tuple[Ints, Any]]
) -> list[Pattern]:
    """Correlation of neighbours in time, or in the order of the rows; of all and of each group."""
    time, by_time = _times(problem, one)
    m = one.residuals.shape[1]
    worst: tuple[float, float, str] = (0.0, 0.0, "")
    for key in ("", *(k for k in keys if k != "row")):
        group = keys[key][0] if key else np.zeros(len(one.rows), dtype=np.int64)
        order = np.lexsort((one.rows, time, group))
        together = group[order[1:]] == group[order[:-1]]
        a, b = order[:-1][together], order[1:][together]
        if len(a) < _FEWEST:
            continue
        for k in range(m):
            shared = np.sum(one.derivatives[a * m + k] * one.weighted[b * m + k], axis=1)
            spread = np.sqrt(np.sum(one.left[a, k] * one.left[b, k] + shared**2))
            if spread < np.sqrt(_FEWEST) / 2:
                continue
            excess = float(np.sum(clean[a, k] * clean[b, k] + shared))
            size = float(np.sum(np.sqrt(one.left[a, k] * one.left[b, k])))
            if abs(excess) / spread > abs(worst[0]):
                worst = (excess / spread, excess / size, key)
    z, correlation, key = worst
    if abs(z) < 6 or abs(correlation) < _CORRELATED:
        return []
    what = "in time" if by_time else "in the order of the rows"
    within = f" within one `{key}`" if key else ""
    slow = "drift, a clock, temperature" if by_time else "with what orders the rows"
    return [
        Pattern(
            "order",
            f"the residuals of `{one.label}` are not white: neighbours {what}{within} have a "
            f"correlation of {correlation:+.2f}",
            f"the model lacks an effect that changes slowly ({slow}), or the noise is correlated "
            "and all standard deviations are too small",
        )
    ]


def _times(problem: Problem, one: _Rows) -> tuple[Floats, bool]:
    """Time of each instance, if its row or a row that it refers to has one; else its row."""
    layout = problem.layout
    if one.table and not one.table.endswith("/rows"):
        table = problem.store.tables[one.table]
        ways: list[tuple[str, Ints]] = [(one.table, one.rows)]
        for column in layout.table(one.table).columns:
            if column.role == "ref" and column.target is not None:
                target = np.asarray(table.target_rows(column.path))[one.rows]
                if (target >= 0).all():
                    ways.append((column.target.table, target))
        if layout.table(one.table).parent:
            parents = np.asarray(table.parent_rows())[one.rows]
            ways.append((layout.table(one.table).parent, parents))
        for path, rows in ways:
            for column in layout.table(path).columns:
                name = column.path.rpartition(".")[2].lower()
                if column.role == "data" and not column.shape and name in _TIMES:
                    values = np.asarray(problem.store.tables[path].column(column.path))
                    return values[rows].astype(np.float64), True
    return one.rows.astype(np.float64), False


def _means(
    problem: Problem, one: _Rows, clean: Floats, keys: dict[str, tuple[Ints, Any]]
) -> list[Pattern]:
    """Means of groups and of cells of a picture that differ from zero."""
    found = []
    parts: dict[str, Ints] = {k: group for k, (group, _) in keys.items() if k != "row"}
    ends: dict[str, Floats] = {}
    for name, cells, edges in _cells(problem, one):
        parts[f"{name}:"], ends[f"{name}:"] = cells, edges
    tests = max(1, len(parts) * clean.shape[1])
    for key, group in parts.items():
        most = (0.0, 0)
        for k in range(clean.shape[1]):
            size, where = _mean_test(one, clean, group, k, tests)
            most = max(most, (size, where))
        size, where = most
        if not size:
            continue
        if key.endswith(":"):
            i, j = divmod(where, _CELLS)
            x, y = ends[key]
            place = (
                f"`{key[:-1]}` is {x[i]:.4g} to {x[i + 1]:.4g} in x and {y[j]:.4g} to "
                f"{y[j + 1]:.4g} in y"
            )
            found.append(
                Pattern(
                    "place",
                    f"the residuals of `{one.label}` are not white: their mean is {size:.2g} "
                    f"standard deviations where {place}",
                    "the model does not follow the data there: it may lack a term of distortion, "
                    "or the target is not flat",
                )
            )
            continue
        name = keys[key][1](np.array([where]))[0]
        found.append(
            Pattern(
                "bias",
                f"the residuals of `{one.label}` are not white by `{key}`: their mean at `{name}` "
                f"is {size:.2g} standard deviations",
                f"what belongs to `{key}` may have an error of its own that the model lacks",
            )
        )
    return found


def _cells(problem: Problem, one: _Rows) -> Iterator[tuple[str, Ints, Floats]]:
    """Cells of pairs of coordinates in the data of the rows, with their edges (2, cells + 1)."""
    if not one.table or one.table.endswith("/rows"):
        return
    for column in problem.layout.table(one.table).columns:
        if column.role != "data" or column.kind != "real" or column.shape != (2,):
            continue
        values = np.asarray(problem.store.tables[one.table].column(column.path))[one.rows]
        low, high = values.min(axis=0), values.max(axis=0)
        if (high > low).all():
            at = np.clip((_CELLS * (values - low) / (high - low)).astype(int), 0, _CELLS - 1)
            edges = np.linspace(low, high, _CELLS + 1).T
            yield column.path, at[:, 0] * _CELLS + at[:, 1], edges


def _mean_test(one: _Rows, clean: Floats, group: Ints, k: int, tests: int) -> tuple[float, int]:
    """Largest mean of the groups in standard deviations, and where; 0 if all are by accident."""
    # imported here: start-up time
    from scipy import special

    groups, member = np.unique(group, return_inverse=True)
    n, m = clean.shape
    if not 1 < len(groups) <= min(200, n // 2):
        return 0.0, 0
    sums = np.zeros((len(groups), n * m))
    sums[member, np.arange(n) * m + k] = 1
    totals = np.bincount(member, clean[:, k])
    covariance = one.covariance_of(sums)
    values, vectors = np.linalg.eigh(covariance)
    # Means that the parameters absorb have no variance and tell nothing.
    known = values > 1e-6 * max(float(values[-1]), 1e-300)
    square = float(np.sum((vectors[:, known].T @ totals) ** 2 / values[known]))
    if special.chdtrc(int(known.sum()), square) > _CHANCE / tests:
        return 0.0, 0
    counts = np.bincount(member)
    means = np.abs(totals) / counts
    means[counts < 4] = 0
    at = int(np.argmax(means))
    return (float(means[at]), int(groups[at])) if means[at] > _BIASED else (0.0, 0)
