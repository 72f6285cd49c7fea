"""Whether a drawing fulfils its rules: residuals as lengths, in NumPy, by one formula for all.

No system is believed: the largest residual of its answer stands beside its time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.sketch.sketches import Rule, Sketch


@dataclass(frozen=True)
class State:
    """Where a system put everything.

    Attributes
    ----------
    points, radii : (n, 2) and (k,), in a sketch's order
    apart : largest distance between ends that the sketch has as one point
    """

    points: np.ndarray
    radii: np.ndarray
    apart: float = 0.0


def state(sketch: Sketch, said: Mapping[str, Any]) -> State:
    """What a system reports: ``points`` and ``radii``, or numbers of its entities.

    Numbers of entities, flat: ``lines`` x1 y1 x2 y2; ``circles`` cx cy r; ``arcs`` cx cy sx sy ex
    ey r.
    """
    if "points" in said:
        points = np.array(said["points"], float).reshape(-1, 2)
        return State(points, np.array(said["radii"], float))
    lines = np.array(said["lines"], float).reshape(-1, 4)
    circles = np.array(said["circles"], float).reshape(-1, 3)
    arcs = np.array(said["arcs"], float).reshape(-1, 7)
    owners = [*sketch.lines, *((c,) for c in sketch.circles), *sketch.arcs]
    names = np.concatenate([np.array(owner, int) for owner in owners])
    places = np.vstack([*(row.reshape(-1, 2) for row in lines), circles[:, :2],
                        *(row[:6].reshape(-1, 2) for row in arcs)])  # fmt: skip
    points = np.full_like(sketch.points, np.nan)
    points[names[::-1]] = places[::-1]  # the first that names a point is it
    gaps = np.linalg.norm(places - points[names], axis=1)
    ends = places[len(places) - 3 * len(arcs) :].reshape(-1, 3, 2)
    off = [np.linalg.norm(e[1:] - e[0], axis=1) - row[6] for e, row in zip(ends, arcs, strict=True)]
    apart = max(gaps.max(initial=0.0), np.abs(off).max(initial=0.0))
    return State(points, circles[:, 2], float(apart))


def residuals(sketch: Sketch, found: State, rules: Sequence[Rule] | None = None) -> np.ndarray:
    """Every equation's residual as a length; of the sketch's rules unless others are given."""
    points, radii = found.points, found.radii
    kinds: dict[str, list[Rule]] = {}
    for rule in sketch.rules if rules is None else rules:
        kinds.setdefault(rule.kind, []).append(rule)
    parts = [np.array([found.apart])]
    if sketch.arcs:
        ends = points[np.array(sketch.arcs)]
        parts.append(_norm(ends[:, 1] - ends[:, 0]) - _norm(ends[:, 2] - ends[:, 0]))
    for kind, same in kinds.items():
        of = np.array([rule.of for rule in same]).T
        values = np.array([rule.values for rule in same], float)
        parts.append(_OF[kind](sketch, points, radii, of, values).ravel())
    return np.concatenate(parts)


def largest(sketch: Sketch, found: State, rules: Sequence[Rule] | None = None) -> float:
    """The largest residual; infinite where a number is missing or not finite."""
    every = np.abs(residuals(sketch, found, rules))
    return float(every.max()) if np.isfinite(every).all() else float("inf")


def moved(before: np.ndarray, after: np.ndarray) -> float:
    """The largest distance by which a point differs."""
    return float(_norm(after - before).max())


def _norm(vectors: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.hypot(vectors[..., 0], vectors[..., 1])
    return found


def _along(sketch: Sketch, points: np.ndarray, lines: np.ndarray) -> np.ndarray:
    ends = points[np.array(sketch.lines)[lines]]
    along: np.ndarray = ends[:, 1] - ends[:, 0]
    return along


def _arc_radius(sketch: Sketch, points: np.ndarray, arcs: np.ndarray) -> np.ndarray:
    ends = points[np.array(sketch.arcs)[arcs]]
    return _norm(ends[:, 1] - ends[:, 0])


def _tangent(sketch: Sketch, points: np.ndarray, of: np.ndarray) -> np.ndarray:
    lines, arcs = np.array(sketch.lines)[of[0]], np.array(sketch.arcs)[of[1]]
    shared = [
        next(iter(set(a) & set(b)))
        for a, b in zip(lines.tolist(), arcs[:, 1:].tolist(), strict=True)
    ]
    along = _along(sketch, points, of[0])
    arm = points[np.array(shared)] - points[arcs[:, 0]]
    found: np.ndarray = (along * arm).sum(axis=1) / _norm(along)
    return found


_Residual = Callable[[Sketch, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
_OF: Mapping[str, _Residual] = {
    "lock": lambda s, p, r, of, v: p[of[0]] - v,
    "horizontal": lambda s, p, r, of, v: _along(s, p, of[0])[:, 1],
    "vertical": lambda s, p, r, of, v: _along(s, p, of[0])[:, 0],
    "length": lambda s, p, r, of, v: _norm(_along(s, p, of[0])) - v[:, 0],
    "distance": lambda s, p, r, of, v: _norm(p[of[1]] - p[of[0]]) - v[:, 0],
    "equal": lambda s, p, r, of, v: _norm(_along(s, p, of[0])) - _norm(_along(s, p, of[1])),
    "radius": lambda s, p, r, of, v: r[of[0]] - v[:, 0],
    "equal_radius": lambda s, p, r, of, v: r[of[0]] - r[of[1]],
    "arc_radius": lambda s, p, r, of, v: _arc_radius(s, p, of[0]) - v[:, 0],
    "equal_arcs": lambda s, p, r, of, v: _arc_radius(s, p, of[0]) - _arc_radius(s, p, of[1]),
    "tangent": lambda s, p, r, of, v: _tangent(s, p, of),
}
