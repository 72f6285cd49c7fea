"""Free directions in words: changes of parameters that change no residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.analysis.gauges import find_gauges
from arael.analysis.normal import NormalEquations
from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError

Floats = NDArray[np.float64]

_SHOWN = 6
_STRONGEST = 4


@dataclass(frozen=True)
class FreeDirection:
    """A direction in which the cost does not change.

    Attributes
    ----------
    words : description
    vector : (n,) entry of each free scalar; a gauge is in the units of the model (all positions by
        1 m, all rotated by 1 rad), another direction has the largest entry 1
    gauge : ``"translation"``, ``"rotation"``, ``"scale"``, or "" for other directions
    """

    words: str
    vector: Floats
    gauge: str = ""

    def __str__(self) -> str:
        return self.words


class FreeDirections(list[FreeDirection]):
    """The free directions of a problem: gauge freedoms first, then others.

    Attributes
    ----------
    parameters : number of free scalars
    rank : of the Jacobian, `parameters` less the free directions
    """

    def __init__(self, equations: NormalEquations, basis: Floats | None = None) -> None:
        basis = equations.smallest()[1] if basis is None else basis
        self._model = equations.problem.layout.name
        self.parameters = len(equations.names)
        self.rank = self.parameters - basis.shape[1]
        super().__init__(_described(equations, basis) if basis.shape[1] else [])

    def __str__(self) -> str:
        if not self:
            return f"no free direction: rank {self.rank} of {self.parameters}"
        head = f"{len(self)} of {self.parameters} directions are free"
        return "\n".join([head, *(f"  {one.words}" for one in self[:_SHOWN]), *self._more()])

    def as_error(self) -> Diagnostic:
        """The directions for the message of a covariance."""
        notes = [f"free direction: {one.words}" for one in self[:_SHOWN]]
        gauges = any(one.gauge for one in self)
        return Diagnostic(
            "E1008",
            f"the system is singular: {len(self)} of {self.parameters} directions are free",
            origin=self._model,
            notes=(*notes, *(text.strip() for text in self._more())),
            help=(
                "fix one pose as an anchor, or give the map a prior or an absolute measurement"
                if gauges
                else "add measurements or a prior that determine them, or fix a parameter",
            ),
        )

    def _more(self) -> list[str]:
        more = len(self) - _SHOWN
        return [f"  and {more} more"] if more > 0 else []


def refuse_free_directions(equations: NormalEquations) -> None:
    """Raise SolveError (E1008) naming the free directions, if there are any."""
    directions = equations.smallest()[1]
    if directions.shape[1]:
        raise SolveError(FreeDirections(equations, directions).as_error())


def _described(equations: NormalEquations, basis: Floats) -> list[FreeDirection]:
    """Name each direction of the free space `basis` (n, f), orthonormal in scaled units."""
    scale = equations.scale[equations.free]
    moves = basis * scale[:, None]
    found = []
    rest = np.eye(basis.shape[1])
    for gauge in find_gauges(equations.problem, moves):
        found.append(FreeDirection(gauge.words, moves @ gauge.weights, gauge.kind))
        direction = rest.T @ gauge.weights
        # The rest of the free space, orthogonal to this direction.
        rest = rest @ _complement(direction)
    remaining = basis @ rest
    if remaining.shape[1]:
        found += _by_name(remaining, scale, equations.names)
    return found


def _complement(direction: Floats) -> Floats:
    """(k, k - 1) orthonormal basis of the complement of `direction` (k,)."""
    q: Floats = np.linalg.qr(direction[:, None], mode="complete")[0]
    return q[:, 1:]


def _by_name(basis: Floats, scale: Floats, names: list[str]) -> list[FreeDirection]:
    """Directions described by their largest entries, each with a different leading scalar."""
    from scipy.linalg import qr

    # The best conditioned choice of leaders, as in a reduced echelon form.
    leaders = qr(basis.T, pivoting=True, mode="economic")[2][: basis.shape[1]]
    reduced = basis @ np.linalg.inv(basis[leaders])
    found = []
    for k in np.argsort(leaders):
        column = reduced[:, k]
        weight = np.abs(column)
        order = [int(leaders[k]), *(int(i) for i in np.argsort(-weight, kind="stable"))]
        strong = [i for i in dict.fromkeys(order) if weight[i] > 0.02]
        vector = column * scale
        vector = vector / np.abs(vector).max()
        shown = sorted(strong[:_STRONGEST])
        vector *= np.sign(vector[shown[0]])
        if len(strong) == 1:
            words = f"`{names[strong[0]]}` alone"
        else:
            parts = [f"{vector[i]:+.3g} {names[i]}" for i in shown]
            more = len(strong) - _STRONGEST
            words = " ".join(parts) + (f" and {more} more together" if more > 0 else "")
        found.append(FreeDirection(words, vector))
    return found
