"""Weak directions of a solution, and the measurements that would determine them.

A direction is free if the cost does not change along it, and weak if the data as a whole determines
it, but the same number of measurements elsewhere would determine it far better. Which measurements
these are is found by adding synthetic ones (`arael.analysis.variations`), one kind at a time, and
comparing the standard deviation of the direction's leading scalar.
"""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.analysis.freedom import FreeDirection, FreeDirections
from arael.analysis.normal import NormalEquations
from arael.analysis.variations import Experiments, Variation

Floats = NDArray[np.float64]

_WEAK = 3e-6
"""Eigenvalue of J'J with unit diagonal below which a direction may be weak: its standard deviation
is 600 times that of the same scalar if all others were known. Calibrations of cameras from random
views have 1e-5 to 1e-4."""
_NEAR = ((1.0, 5.0), (3.0, 10.0))
"""Factors of the range of numbers that are tried, and the least factor by which the standard
deviation of a weak direction must fall there. Twice as much data of the same kind lowers it by 1.4,
a line over twice the range by 2."""
_AS_GOOD = 3.0
"""Factor of the standard deviation up to which another variation is named beside the best."""
_INDISTINCT = 1e-9
"""Eigenvalue below which parameters count as two for one effect if no variation helps."""
_FAR = (30.0, 1e3, 1e6)
"""Factors that are tried beyond before a direction is called one that no data determines: the
estimate itself may be far off where the data is poor."""
_SMALL = 400
"""Most scalars of a problem in which these are tried."""
_RIDGE = 1e-13
_FREE = 1e-10
"""Scaled variance beyond 1 / this with `_RIDGE`: still free."""
_NAMED = 4
_SHARE = 0.05
"""Least part of a unit vector's square for which a group of scalars is named."""
MANY = 8
"""Rows of a collection above which their scalars are listed together."""
_TOGETHER = 3
"""Rows that move above which they are named without the number of their row."""


@dataclass(frozen=True)
class Missing:
    """Measurements that would determine a weak direction.

    Attributes
    ----------
    variations : components of one column; any of them suffices
    sigma : standard deviation of the leading scalar with as many synthetic rows as there are now
    """

    variations: tuple[Variation, ...]
    sigma: float

    @property
    def words(self) -> str:
        """What to vary, ``turn `motions.a_q` about x or y``."""
        first = self.variations[0]
        parts = " or ".join(v.part for v in self.variations if v.part)
        name = f"`{first.name}`"
        if first.entity >= 0:
            how = f"turned about {parts}" if parts else "turned"
            if first.kind == "spread":
                how = f"spread wider along {parts}" if parts else "spread wider"
            text = f"more rows of `{first.table}` with {name} {how}"
        elif first.time:
            text = f"{name} over a longer time"
        elif first.kind == "turn":
            text = f"{name} turned about {parts}" if parts else f"{name} at other angles"
            if parts.startswith("["):
                text = f"{name}{parts} at other angles"
        elif "in all rows" in first.now:
            text = f"other values of {name}" + (f" along {parts}" if parts else "")
        else:
            text = f"{name} over a wider range" + (f" along {parts}" if parts else "")
        return text + (f" (now {first.now})" if first.now else "")


@dataclass(frozen=True)
class WeakDirection:
    """A change of parameters that the data hardly determines, or not at all.

    Attributes
    ----------
    kind : ``gauge`` (the map as a whole, with no anchor), ``redundant`` (no data of the same kinds
        determines it: two parameters have one effect), ``unseen`` (other data of the same kinds
        determines it: `missing`)
    words : the parameters, in words
    names : the scalars or groups of scalars that move most
    leader : the leading scalar
    sigma : its standard deviation; infinite along a free direction
    missing : measurements that would determine it
    gauge : of a gauge ``translation``, ``rotation``, ``scale``
    seen : which part of a picture the measurements cover
    """

    kind: Literal["gauge", "redundant", "unseen"]
    words: str
    names: tuple[str, ...]
    leader: str
    sigma: float
    unit: str = ""
    missing: tuple[Missing, ...] = ()
    gauge: str = ""
    seen: str = ""

    @property
    def advice(self) -> str:
        """What to do about it."""
        if self.kind == "gauge":
            if self.gauge == "scale":
                return "measure one known distance, or give one a prior: no measurement has a scale"
            return "fix a pose or points as an anchor, or add an absolute measurement or a prior"
        if self.kind == "redundant":
            return (
                "remove or fix one of them, or give it a prior: no other data of these kinds tells "
                "them apart"
            )
        best = self.missing[0]
        text = f"missing: {best.words}"
        if math.isfinite(best.sigma):
            unit = f" {self.unit}" if self.unit else ""
            text += f"; as many rows again give `{self.leader}` +- {best.sigma:.2g}{unit}"
        others = [f"or {one.words}" for one in self.missing[1:]]
        return "; ".join([text, *others, *([self.seen] if self.seen else [])])

    def __str__(self) -> str:
        return f"{self.words}\n    {self.advice}"

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "kind": self.kind,
            "words": self.words,
            "parameters": list(self.names),
            "leader": self.leader,
            "sigma": self.sigma if math.isfinite(self.sigma) else None,
            "missing": [
                {
                    "column": one.variations[0].name,
                    "parts": [v.part for v in one.variations],
                    "words": one.words,
                    "sigma": one.sigma if math.isfinite(one.sigma) else None,
                }
                for one in self.missing
            ],
            "advice": self.advice,
        }


def weak_directions(
    model: Any, equations: NormalEquations, free: FreeDirections, units: dict[str, str]
) -> list[WeakDirection]:
    """Free and weak directions of a solved model, each with what would determine it.

    Parameters
    ----------
    equations : of the model's problem at its solution, with bounds held
    free : its free directions
    units : of the scalars, by name
    """
    search = _Search(model, equations, units)
    found = [search.judged_free(one) for one in free]
    values, vectors = np.linalg.eigh(equations.dense)
    weak = vectors[:, (values > equations.tolerance) & (values < _WEAK)]
    for direction, leader in _echelon(weak, search.is_shared) if weak.shape[1] else ():
        judged = search.judged(direction, leader, False)
        if judged is not None:
            found.append(judged)
    return found


_Trial = tuple[Variation, Floats]


class _Search:
    """Tries variations for the directions of one problem."""

    def __init__(self, model: Any, equations: NormalEquations, units: dict[str, str]) -> None:
        self.equations = equations
        self.names = equations.names
        self.units = units
        self._model = model
        self._tried: dict[float, list[_Trial]] = {}
        self._scale = equations.scale[equations.free]
        self._plain = equations.dense / self._scale[:, None] / self._scale
        self._groups = [plain_name(name) for name in self.names]
        rows = defaultdict(set)
        for name, group in zip(self.names, self._groups, strict=True):
            rows[group].add(name)
        self._many = {group for group, own in rows.items() if len(own) > MANY}

    @cached_property
    def is_shared(self) -> NDArray[np.bool_]:
        """(n,) whether a scalar belongs to the root or to one of few rows."""
        return np.array([group not in self._many for group in self._groups])

    @cached_property
    def _experiments(self) -> Experiments:
        kept = np.isin(self.equations.problem.free, self.equations.free)
        return Experiments(self._model, kept)

    def _trials(self, reach: float) -> list[_Trial]:
        """Every variation with the variances (n,) of all scalars once its rows are added."""
        if reach not in self._tried:
            found = self._tried[reach] = []
            for one in self._experiments.variations:
                if reach > 1 and (one.kind == "turn" or one.entity >= 0):
                    continue  # as far as before; new rows elsewhere are no larger range
                more = self._experiments.information(one, reach)
                if np.isfinite(more).all():
                    found.append((one, _variances(self._plain + more)))
        return self._tried[reach]

    @cached_property
    def _pictures(self) -> str:
        """What measured pairs of numbers cover, in words."""
        return "; ".join(self._experiments.pictures())

    @cached_property
    def _now(self) -> Floats:
        return _variances(self._plain)

    def judged_free(self, free: FreeDirection) -> WeakDirection:
        """A direction along which the cost does not change."""
        direction = free.vector / self._scale
        direction = direction / np.linalg.norm(direction)
        leader = int(np.argmax(np.abs(direction)))
        # A scale of plain numbers is a product of two of them, not the scale of a map.
        moved = [name for name, entry in zip(self.names, direction, strict=True) if entry]
        is_gauge = bool(free.gauge or free.residuals_change) and any(
            name[-2:] in (".x", ".y", ".z") for name in moved
        )
        found = self.judged(direction, leader, True, is_gauge)
        assert found is not None
        if found.kind == "redundant" and is_gauge:
            return replace(found, kind="gauge", words=free.words, gauge=free.gauge)
        return found

    def judged(
        self, direction: Floats, leader: int, is_free: bool, is_gauge: bool = False
    ) -> WeakDirection | None:
        """The direction with its words; None if it is not weak after all."""
        now = math.inf if is_free else math.sqrt(self._now[leader])
        unit = self.units.get(self.names[leader], "")
        reaches = [*_NEAR]
        lost = is_free or self._eigenvalue(direction) < _INDISTINCT
        if lost and not is_gauge and len(self.names) <= _SMALL:
            reaches += [(reach, _NEAR[-1][1]) for reach in _FAR]
        for reach, gain in reaches:
            trials = self._trials(reach)
            sigmas = [math.sqrt(variances[leader]) for _, variances in trials]
            best = min(sigmas, default=math.inf)
            if math.isfinite(best) and now >= gain * best:
                break
        else:
            if not lost:
                return None
            names = self._named(direction, None)
            words = _told_apart(names, is_free)
            return WeakDirection("redundant", words, names, self.names[leader], now, unit)
        names = self._named(direction, trials[int(np.argmin(sigmas))][1])
        missing: dict[tuple[str, str, bool], list[tuple[float, Variation]]] = {}
        for sigma, (one, _) in zip(sigmas, trials, strict=True):
            if sigma <= _AS_GOOD * best:
                key = (one.name, one.kind, "in all rows" in one.now)
                missing.setdefault(key, []).append((sigma, one))
        offers = tuple(
            Missing(tuple(v for _, v in part), min(sigma for sigma, _ in part))
            for part in missing.values()
        )
        words = _told_apart(names, is_free)
        return WeakDirection(
            "unseen",
            words,
            names,
            self.names[leader],
            now,
            unit,
            offers[:_NAMED],
            seen=self._pictures,
        )

    def _eigenvalue(self, direction: Floats) -> float:
        return float(direction @ self.equations.dense @ direction / (direction @ direction))

    def _named(self, direction: Floats, variances: Floats | None) -> tuple[str, ...]:
        """Scalars that move most, by collection where many rows move.

        Relative to the standard deviations that they would have if the direction was determined.
        """
        if variances is not None:
            direction = direction * self._scale / np.sqrt(variances)
        square = direction**2
        total = float(square.sum())
        count = Counter(
            group
            for group, part in zip(self._groups, square, strict=True)
            if part > _SHARE * total / MANY
        )
        share: dict[str, float] = defaultdict(float)
        for name, group, part in zip(self.names, self._groups, square, strict=True):
            share[group if count[group] > _TOGETHER else name] += float(part)
        wide = [name for name, part in share.items() if part > _SHARE * total]
        # Equal shares differ by rounding: those stay in the order of the parameters.
        wide.sort(key=lambda name: -round(share[name] / total, 3))
        return tuple(wide[:_NAMED])


def _variances(matrix: Floats) -> Floats:
    """Diagonal (n,) of the inverse of J'J; infinite where it does not exist."""
    diagonal = np.diag(matrix)
    known = diagonal > 0
    scale = 1 / np.sqrt(np.where(known, diagonal, 1.0))
    scaled = matrix * scale[:, None] * scale
    np.fill_diagonal(scaled, 1.0 + _RIDGE)
    # imported here: start-up time
    from scipy.linalg import solve_triangular

    try:
        factor = np.linalg.cholesky(scaled)
        inverse = solve_triangular(factor, np.eye(len(scaled)), lower=True, overwrite_b=True)
        variance = (inverse**2).sum(axis=0)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(scaled)
        variance = (vectors**2) @ (1 / np.maximum(values, _RIDGE))
    found: Floats = np.where(known & (variance < 1 / _FREE), variance * scale**2, np.inf)
    return found


def _echelon(basis: Floats, preferred: NDArray[np.bool_]) -> list[tuple[Floats, int]]:
    """Directions (n,) that span `basis`, each with a leading scalar that no other has."""
    # imported here: start-up time
    from scipy.linalg import qr

    weighted = basis * np.where(preferred, 10.0, 1.0)[:, None]
    leaders = qr(weighted.T, pivoting=True, mode="economic")[2][: basis.shape[1]]
    reduced = basis @ np.linalg.inv(basis[leaders])
    return [(reduced[:, k], int(leader)) for k, leader in enumerate(leaders)]


def plain_name(name: str) -> str:
    """Return the name of a scalar without the numbers of rows: that of all rows together."""
    return re.sub(r"\[\d+\](?=\.)", "", name)


def _told_apart(names: tuple[str, ...], is_free: bool) -> str:
    listed = [f"`{name}`" for name in names]
    if len(listed) == 1:
        return f"{listed[0]} is {'not' if is_free else 'hardly'} determined"
    text = f"{', '.join(listed[:-1])} and {listed[-1]}"
    return f"{text} {'cannot' if is_free else 'can hardly'} be told apart"
