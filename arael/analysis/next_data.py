"""Which of several candidate measurements to take next.

A candidate is a row of a collection of measurements. Its Jacobian at the solution gives the fall of
the covariance of the wanted parameters, without a new solve. Candidates are chosen greedily, by the
fall of the determinant (D-optimal) or of the trace (A-optimal) of that covariance (F. Pukelsheim,
"Optimal design of experiments", 2006). One solve with the factor of J'J for the rows of all
candidates gives all that is needed; each choice is an update of low rank.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.jacobian import jacobian
from arael.analysis.normal import NormalEquations
from arael.analysis.variations import Experiments
from arael.analysis.weakness import MANY, plain_name
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.failures import refuse_required
from arael.runtime.layout import Column

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CRITERIA = ("d", "a")
_MOST = 20_000_000
"""Most entries of the Jacobian of all candidates, which is dense here."""


@dataclass(frozen=True, repr=False)
class NextData(Displayed):
    """Candidates in the order in which they lower the uncertainty most.

    Attributes
    ----------
    collection : the collection that they are rows of
    rows : numbers of the chosen candidates, from 0
    wanted : the scalars whose uncertainty counts
    sigma : (count + 1,) root mean square of their standard deviations relative to the present ones,
        before and after each candidate; infinite while one is not determined
    worst : the wanted scalar of the largest standard deviation, relative to that at the start,
        after each candidate
    criterion : ``"d"`` or ``"a"``
    """

    collection: str
    rows: tuple[int, ...]
    wanted: tuple[str, ...]
    sigma: tuple[float, ...]
    worst: tuple[str, ...]
    criterion: str

    def __repr__(self) -> str:
        return f"<NextData {self.collection}: {list(self.rows)}>"

    def __str__(self) -> str:
        lines = [self._title()]
        lines += [f"  {number:>3}  {row:<8} {sigma}" for number, row, sigma, _ in self._cells()]
        return "\n".join(lines)

    def _title(self) -> str:
        kind = {"d": "D-optimal", "a": "A-optimal"}[self.criterion]
        count = len(self.wanted)
        return (
            f"next {len(self.rows)} of the candidates for `{self.collection}`, {kind}: number, "
            f"row, standard deviations of {count} scalar{'s' * (count != 1)} relative to now"
        )

    def _cells(self) -> list[tuple[str, str, str, str]]:
        return [
            (str(k + 1), str(row), _relative(self.sigma[k + 1]), self.worst[k])
            for k, row in enumerate(self.rows)
        ]

    def _sheet(self) -> Sheet:
        head = ("number", "row", "standard deviations", "largest at")
        return Sheet(self._title(), head, self._cells())

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "collection": self.collection,
            "criterion": self.criterion,
            "rows": list(self.rows),
            "wanted": list(self.wanted),
            "sigma": [s if math.isfinite(s) else None for s in self.sigma],
            "largest_at": list(self.worst),
        }


def next_data(
    model: Any,
    count: int,
    candidates: Any,
    collection: str,
    of: Sequence[str] | str | None = None,
    criterion: str = "d",
) -> NextData:
    """Choose candidates for a solved model; see `arael.Model.next_data`."""
    refuse_required(
        model._problem().layout, "`next_data`", "compare `covariance()` with and without candidates"
    )
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise wrong_argument("next_data", "count", "a whole number of at least 1", count)
    if criterion not in CRITERIA:
        raise wrong_argument("next_data", "criterion", '"d" or "a"', criterion)
    if not isinstance(candidates, Mapping):
        expected = "columns of the candidates by name"
        raise wrong_argument("next_data", "candidates", expected, candidates)
    trial = model.copy()
    rows = trial[_checked(model, collection)]
    unknown = {c.path: np.zeros(c.shape) for c in measured_columns(model, collection)}
    rows.clear()
    rows.extend(**{**unknown, **candidates})
    return chosen(model, count, trial, collection, of, criterion)


def chosen(
    model: Any,
    count: int,
    trial: Any,
    collection: str,
    of: Sequence[str] | str | None = None,
    criterion: str = "d",
) -> NextData:
    """Choose among the rows of a collection of `trial`, otherwise a copy of the model."""
    _checked(model, collection)
    problem = model._problem()
    equations = NormalEquations(problem, hold_bounds=True)
    rows = jacobian(trial._problem())
    number, total = _rows_of(trial, rows, collection)
    known = number >= 0
    known &= np.isfinite(rows.residuals)
    bad = np.repeat(np.arange(len(rows)), np.diff(rows.matrix.indptr))
    known[bad[~np.isfinite(rows.matrix.data)]] = False
    most = _MOST // max(1, len(equations.free))
    if np.count_nonzero(known) > most:
        raise _refused(
            f"the candidates have {np.count_nonzero(known)} residuals",
            f"give candidates with at most {most} together",
        )
    kept = np.isin(problem.free, equations.free)
    scale = equations.scale[equations.free]
    matrix = rows.matrix[np.flatnonzero(known)][:, np.flatnonzero(kept)].toarray() * scale
    wanted = _wanted(equations.names, of)
    greedy = _Greedy(equations, matrix, number[known], wanted, criterion)
    for _ in range(min(count, total)):
        if not greedy.take():
            break
    names = tuple(equations.names[k] for k in wanted)
    return NextData(
        collection,
        tuple(greedy.chosen),
        names,
        tuple(greedy.sigma),
        tuple(names[k] for k in greedy.worst),
        criterion,
    )


def measured_columns(model: Any, collection: str) -> list[Column]:
    """Columns that a candidate needs no values of: no derivative depends on them.

    None if the model has no rows of the collection, from which this is found.
    """
    own = model._problem().layout.table(_checked(model, collection))
    if not model._store.tables[collection].size:
        return []
    kept = np.ones(len(model.parameter_names()), dtype=bool)
    return [
        own.column(path)
        for table, path in Experiments(model, kept).measured.values()
        if table == collection and "." not in path and own.column(path).default is None
    ]


def _checked(model: Any, collection: str) -> str:
    tables = [t.path for t in model._problem().layout.tables if t.path and not t.parent]
    if collection not in tables:
        raise _refused(
            f"there is no collection `{collection}` of the root",
            f"there are {', '.join(f'`{path}`' for path in tables)}",
        )
    moving = {entity.table for entity in model._problem().layout.entities}
    if any(path == collection or path.startswith(f"{collection}.") for path in moving):
        raise _refused(
            f"candidates for `{collection}` would bring parameters of their own",
            "add rows of a collection of measurements, which has no parameters",
        )
    return collection


def _rows_of(trial: Any, rows: Any, collection: str) -> tuple[Ints, int]:
    """Candidate of each residual, -1 for those of other constraints; number of candidates."""
    problem = trial._problem()
    number = np.full(len(rows), -1, dtype=np.int64)
    ends = np.cumsum([0, *(len(active) for active in problem.structure.active)])
    for k, group in enumerate(problem.layout.groups):
        if group.table == collection:
            mine = (rows.constraint >= ends[k]) & (rows.constraint < ends[k + 1])
            number[mine] = problem.structure.active[k][rows.constraint[mine] - ends[k]]
    return number, int(trial._store.tables[collection].size)


def _wanted(names: list[str], of: Sequence[str] | str | None) -> Ints:
    """Numbers of the scalars whose uncertainty counts."""
    if of is None:
        plain = [plain_name(name) for name in names]
        few = [k for k, group in enumerate(plain) if plain.count(group) <= MANY]
        return np.array(few or range(len(names)), dtype=np.int64)
    found: list[int] = []
    for one in [of] if isinstance(of, str) else of:
        own = [
            k for k, name in enumerate(names) if _is_of(name, one) or _is_of(plain_name(name), one)
        ]
        if not own:
            near = ", ".join(f"`{name}`" for name in names[:8])
            raise _refused(f"nothing named `{one}` is solved for", f"there are {near}")
        found += own
    return np.array(sorted(set(found)), dtype=np.int64)


def _is_of(name: str, path: str) -> bool:
    """Whether a scalar is what `path` names, or part of it."""
    return name == path or name.startswith((f"{path}.", f"{path}["))


class _Greedy:
    """The choice: covariances between candidates and wanted scalars, updated by each choice."""

    def __init__(
        self, equations: NormalEquations, matrix: Floats, number: Ints, wanted: Ints, criterion: str
    ) -> None:
        solver = equations.damped()

        def solved(columns: Floats) -> Floats:
            whole = np.zeros((equations.problem.size, columns.shape[1]))
            whole[equations.free] = columns
            found: Floats = np.asarray(solver.solved(whole))[equations.free]
            return found

        self._matrix, self._wanted = matrix, wanted
        self._through = solved(np.ascontiguousarray(matrix.T))  # C J', updated by each choice
        unit = np.zeros((matrix.shape[1], len(wanted)))
        unit[wanted, np.arange(len(wanted))] = 1
        self._covariance = solved(unit)[wanted]
        self._first = np.diag(self._covariance).copy()
        self._criterion = criterion
        self._places = {int(k): np.flatnonzero(number == k) for k in np.unique(number)}
        sizes = {len(at) for at in self._places.values()}
        # Candidates of as many residuals are compared at once.
        self._batches = [
            (
                np.array([k for k, at in self._places.items() if len(at) == size]),
                np.array([at for at in self._places.values() if len(at) == size]),
            )
            for size in sorted(sizes)
        ]
        free = equations.smallest()[1]
        loose = np.linalg.norm(free[wanted], axis=1) > 1e-6 if free.shape[1] else None
        self._loose = np.zeros(len(wanted), bool) if loose is None else loose
        self.chosen: list[int] = []
        self.worst: list[int] = []
        self.sigma = [math.inf if self._loose.any() else 1.0]

    def take(self) -> bool:
        """Choose the best candidate that is left; False if there is none."""
        gain, best = -math.inf, -1
        for candidates, at in self._batches:
            gains = self._gains(at)
            gains[np.isin(candidates, self.chosen)] = -math.inf
            first = int(np.argmax(gains))
            if gains[first] > gain:
                gain, best = float(gains[first]), int(candidates[first])
        if best < 0:
            return False
        self._update(self._places[best])
        self.chosen.append(best)
        now = np.maximum(np.diag(self._covariance), 0.0)
        ratio = np.sqrt(now / self._first)
        self.worst.append(int(np.argmax(np.where(self._loose, now, ratio))))
        # Relative to infinity: what is determined by now has no ratio.
        loose = self._loose & (now > 1e-6 * self._first)
        known = ratio[~self._loose]
        mean = float(np.sqrt(np.mean(known**2))) if len(known) else 0.0
        self.sigma.append(math.inf if loose.any() else mean)
        return True

    def _gains(self, at: Ints) -> Floats:
        """(k,) fall of the trace or of the logarithm of the determinant, by candidates (k, r)."""
        own = np.swapaxes(self._through.T[at], 1, 2)  # (k, n, r)
        inner = np.eye(at.shape[1]) + self._matrix[at] @ own
        across = own[:, self._wanted]
        if self._criterion == "a":
            through = np.linalg.solve(inner, np.swapaxes(across, 1, 2))
            fall = np.einsum("kwr,krw->kw", across, through)
            return np.asarray(fall @ (1 / self._first))
        # det(C - B M^-1 B') = det(C) det(M - B' C^-1 B) / det(M)
        left = inner - np.swapaxes(across, 1, 2) @ np.linalg.solve(self._covariance, across)
        return np.asarray(np.linalg.slogdet(inner)[1] - np.linalg.slogdet(left)[1])

    def _update(self, at: Ints) -> None:
        """Add the residuals `at`: C - C J' (I + J C J')^-1 J C."""
        own = self._through[:, at]
        inverse = np.linalg.inv(np.eye(len(at)) + self._matrix[at] @ own)
        part = own[self._wanted]
        self._covariance = self._covariance - part @ inverse @ part.T
        self._through = self._through - own @ inverse @ (self._matrix[at] @ self._through)


def _relative(sigma: float) -> str:
    return f"{sigma:.3g}" if math.isfinite(sigma) else "not determined yet"


def _refused(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E0790", message, origin="next_data", help=(advice,)))
