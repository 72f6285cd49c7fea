"""Whether a solution is the global optimum, by the matrix of its multipliers.

At a stationary X of ``tr(X Q X')`` with orthonormal rotations, ``X (Q - Lambda) = 0``. For any X'
that obeys the constraints, ``f(X') = tr(Lambda) + tr(X' S X''')`` with ``S = Q - Lambda``: if S is
positive semidefinite, ``tr(Lambda) = f(X)`` is a lower bound of all costs, and X is the global
optimum (Lagrangian duality; D. Rosen et al., "SE-Sync", IJRR 2019; L. Carlone et al., "Lagrangian
duality in 3D SLAM", IROS 2015). One sparse factorisation of S with a small shift of the rotations'
diagonal decides it: ``S + sigma >= 0`` bounds all costs by ``tr(Lambda) - sigma d m`` for m
rotations. Otherwise an eigenvector of a negative eigenvalue is a direction of descent that leaves X
in one more dimension; the Riemannian staircase takes it (N. Boumal, V. Voroninski and A. Bandeira,
"The non-convex Burer-Monteiro approach works on smooth semidefinite programs", NeurIPS 2016).
Where data stand on both sides of rotations, `relaxation` has the bound.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from arael.certificates.problem import ChordalProblem, chordal_problem
from arael.certificates.two_sided import TwoSidedProblem
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.linear.compiled import SparseSolver
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Chordal: TypeAlias = ChordalProblem | TwoSidedProblem

TOLERANCE = 1e-6
"""Largest gap of a global optimum, relative to the cost."""
_CLEAR = 1e-3
"""Gap, relative to the cost, above which a negative eigenvalue is asked for: a smaller one may be
that of a minimum that is not exact."""
_LEAST = 1e-12
"""Least shift, relative to the largest diagonal entry: above the rounding of a factorisation."""
_ROUNDS = 30
_RANKS = 8


@dataclass(frozen=True)
class Certificate(Displayed):
    """What is known of the global optimum.

    Attributes
    ----------
    verdict : ``"global"``, ``"within"`` or ``"not certified"``
    cost, bound : of the solution, and a lower bound of all costs: of the model, or of its twin
    gap : their difference relative to the cost; NaN if not certified
    twin : whether both are of the chordal twin of the model, whose own errors are not chordal or
        not the same in all directions
    optimum : cost of the minimum of the twin next to the solution; `cost` of a model without twin
    eigenvalue : estimate of the least eigenvalue of S, in the metric of the rotations; 0 if it is
        not negative
    seconds : reading the model, making the matrix, the verdict
    """

    verdict: str
    cost: float
    bound: float
    gap: float
    twin: bool
    optimum: float
    eigenvalue: float
    seconds: dict[str, float] = field(default_factory=dict, compare=False)
    direction: Floats | None = field(default=None, repr=False, compare=False)
    point: Floats | None = field(default=None, repr=False, compare=False)

    @property
    def certified(self) -> bool:
        """Whether a direction of descent is excluded."""
        return self.verdict != "not certified"

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "verdict": self.verdict,
            "text": str(self),
            "cost": self.cost,
            "bound": self.bound,
            "gap": None if np.isnan(self.gap) else self.gap,
            "twin": self.twin,
            "optimum": self.optimum,
            "seconds": dict(self.seconds),
        }

    @property
    def sentence(self) -> str:
        """The verdict with what it is of."""
        return f"certificate: {self}"

    def _sheet(self) -> Sheet:
        rows = [
            ("cost", f"{self.cost:.8g}"),
            ("lower bound of all costs", f"{self.bound:.8g}"),
            ("cost of the minimum", f"{self.optimum:.8g}"),
        ]
        return Sheet(self.sentence, ("", ""), rows)

    def __str__(self) -> str:
        if self.verdict == "global":
            text = f"global (to within {max(self.gap, TOLERANCE):.0g})"
        elif self.verdict == "within":
            text = f"within {_percent(self.gap)} %"
        else:
            text = "not certified: a direction of descent leaves this optimum"
        return f"{text}, of the chordal twin of the model" if self.twin else text


def _percent(gap: float) -> str:
    return f"{100 * gap:.2g}" if gap < 0.99 else f"{100 * gap:.0f}"


def certify(compiled: Any, problem: Problem) -> tuple[Certificate, Chordal]:
    """The certificate of the present values of a model, and its chordal problem.

    Raises
    ------
    AraelError
        E1061: there is none of this model.
    """
    began = time.perf_counter()
    chordal = chordal_problem(compiled, problem)
    read = time.perf_counter()
    start = chordal.values()
    cost = chordal.cost(start)
    x = chordal.minimised(start)
    optimum = chordal.cost(x)
    made = time.perf_counter()
    scale = chordal.scale(optimum)
    bound, eigenvalue, direction = _bound(chordal, x, optimum, scale)
    gap = (cost - bound) / max(cost, scale)
    done = time.perf_counter()
    seconds = {"read": read - began, "minimise": made - read, "factorise": done - made}
    if direction is not None:
        verdict, gap = "not certified", float("nan")
    else:
        verdict, gap = "global" if gap <= TOLERANCE else "within", max(gap, 0.0)
    found = Certificate(
        verdict,
        cost,
        bound,
        gap,
        not chordal.exact,
        optimum,
        eigenvalue,
        seconds,
        direction,
        x,
    )
    return found, chordal


def _bound(
    chordal: Chordal, x: Floats, optimum: float, scale: float
) -> tuple[float, float, Floats | None]:
    """A lower bound of all costs, the least eigenvalue of S, and a direction of descent.

    The last two where the minimum x is clearly not the lowest, else 0 and None.
    """
    if isinstance(chordal, TwoSidedProblem):
        found = chordal.bound(x, 0.5 * TOLERANCE * scale)
        value = min(found.value, optimum)
        if optimum - value <= _CLEAR * scale:
            return value, 0.0, None
        return value, found.eigenvalue, found.relaxed
    multipliers, s = chordal.multipliers(x)
    shift, solver = _definite(chordal, s, scale)
    m, d = len(chordal.frames.rotations), chordal.frames.d
    eigenvalue, direction = 0.0, None
    if shift * d * m > _CLEAR * scale:
        eigenvalue, direction = _least(chordal, s, solver)
    return (
        float(np.trace(multipliers, axis1=1, axis2=2).sum()) - shift * d * m,
        eigenvalue,
        direction,
    )


def _definite(chordal: ChordalProblem, s: Any, scale: float) -> tuple[float, SparseSolver]:
    """The least shift tried with which S is positive definite, and its factor."""
    m, d = len(chordal.frames.rotations), chordal.frames.d
    largest = float(np.abs(s.diagonal()).max())
    shift = max(0.5 * TOLERANCE * scale / (d * m), _LEAST * largest)
    ones = np.zeros(s.shape[0])
    ones[chordal.manifold.columns.ravel()] = 1
    while True:
        solver = chordal.matrix.factorised(s, shift * ones)
        if solver is not None:
            return shift, solver
        shift *= 4


def _least(chordal: ChordalProblem, s: Any, solver: SparseSolver) -> tuple[float, Floats | None]:
    """The least eigenvalue of S relative to the rotations, and its vector, if it is negative."""
    rng = np.random.default_rng(0)
    ones = np.zeros(s.shape[0])
    ones[chordal.manifold.columns.ravel()] = 1
    basis = rng.standard_normal((s.shape[0], 4 + chordal.frames.d))
    for _ in range(_ROUNDS):
        basis = np.linalg.qr(np.asarray(solver.solved(basis * ones[:, None])))[0]
    small, metric = basis.T @ (s @ basis), basis.T @ (ones[:, None] * basis)
    values, vectors = np.linalg.eig(np.linalg.solve(metric, small))
    k = int(np.argmin(values.real))
    if values.real[k] >= 0:
        return 0.0, None
    return float(values.real[k]), basis @ vectors.real[:, k]


def climbed(chordal: Chordal, certificate: Certificate) -> Floats:
    """A lower minimum (d, size), from a certificate that names a direction.

    By the staircase; of a `TwoSidedProblem` from the rotations nearest to its relaxation.
    """
    d = chordal.frames.d
    y, v = certificate.point, certificate.direction
    assert y is not None
    if isinstance(chordal, TwoSidedProblem):
        assert v is not None
        return chordal.minimised(chordal.rounded(v))
    for _ in range(_RANKS):
        if v is None:
            break
        y = chordal.minimised(_left(chordal, y, v))
        s = chordal.multipliers(y)[1]
        scale = chordal.scale(chordal.cost(y))
        shift, solver = _definite(chordal, s, scale)
        v = None
        if shift * d * len(chordal.frames.rotations) > _CLEAR * scale:
            v = _least(chordal, s, solver)[1]
    return chordal.minimised(_rounded(chordal, y))


def _left(chordal: ChordalProblem, y: Floats, v: Floats) -> Floats:
    """A point of lower cost in one more dimension, along v."""
    cost = chordal.cost(y)
    length = 1.0 / np.abs(v).max()
    wide = np.vstack([y, np.zeros(y.shape[1])])
    while length * np.abs(v).max() > 1e-9:
        trial = wide.copy()
        trial[-1] = length * v
        trial = chordal.manifold.nearest(trial)
        if chordal.cost(trial) < cost:
            return trial
        length /= 2
    return wide


def _rounded(chordal: ChordalProblem, y: Floats) -> Floats:
    """The nearest rotations of d dimensions to a point of more."""
    d = chordal.frames.d
    u, sizes, vt = np.linalg.svd(y[:, chordal.manifold.columns.ravel()], full_matrices=False)
    del sizes, vt
    x = u[:, :d].T @ y
    blocks = x[:, chordal.manifold.columns].transpose(1, 0, 2)
    if (np.linalg.det(blocks) < 0).sum() * 2 > len(blocks):
        x[-1] = -x[-1]
        blocks = x[:, chordal.manifold.columns].transpose(1, 0, 2)
    u, _, vt = np.linalg.svd(blocks)
    sign = np.ones((len(u), d))
    sign[:, -1] = np.linalg.det(u @ vt)
    x[:, chordal.manifold.columns] = ((u * sign[:, None, :]) @ vt).transpose(1, 0, 2)
    return x
