"""Free directions in words: changes of parameters that do not change the cost.

Most change no residual, and are the null space of J'J. Others turn residuals that are vectors, and
are found as symmetries of the cost (`symmetries`), or, in small problems, by the second derivatives
of the cost at a minimum (`second_order`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.analysis.gauges import find_gauges
from arael.analysis.normal import NormalEquations
from arael.analysis.second_order import flat_directions
from arael.analysis.symmetries import symmetries
from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError

Floats = NDArray[np.float64]

_SHOWN = 6
_STRONGEST = 4
_SAME = 1e-3
"""Part of a unit vector outside a space up to which it is taken to lie in it: rounding and stiff
problems blur the null space of J'J."""
_FASTEST = 3
"""Greatest change of residuals relative to their size, per radian: 1 for vectors, 2 for tensors."""
_APART = 0.1
"""Sine of the angle above which a direction is another one."""


@dataclass(frozen=True)
class FreeDirection:
    """A direction in which the cost does not change.

    Attributes
    ----------
    words : description
    vector : (n,) entry of each free scalar; a gauge is in the units of the model (all positions by
        1 m, all rotated by 1 rad), another direction has the largest entry 1
    gauge : ``"translation"``, ``"rotation"``, ``"scale"``, or "" for other directions
    residuals_change : whether residuals change, as vectors that turn with the map do, and only the
        cost does not: the direction is not in the null space of the Jacobian
    """

    words: str
    vector: Floats
    gauge: str = ""
    residuals_change: bool = False

    def __str__(self) -> str:
        return self.words


class FreeDirections(list[FreeDirection]):
    """The free directions of a problem: gauge freedoms first, then others.

    Parameters
    ----------
    basis : (n, f) free directions of J'J in scaled units; by default those of `equations`
    second_order : whether to ask the second derivatives too, in a small problem at a minimum

    Attributes
    ----------
    parameters : number of free scalars
    rank : `parameters` less the free directions. The rank of the Jacobian, unless residuals change
        along some of them
    """

    def __init__(
        self,
        equations: NormalEquations,
        basis: Floats | None = None,
        second_order: bool = False,
    ) -> None:
        basis = equations.smallest()[1] if basis is None else basis
        self._model = equations.problem.layout.name
        self.parameters = len(equations.free)
        # Derivatives of the cost alone say nothing where rows hold exactly.
        second_order = second_order and not equations.problem.layout.required
        super().__init__(_described(equations, basis, second_order))
        self.rank = self.parameters - len(self)

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
                self._datum()
                if gauges
                else "add measurements or a prior that determine them, or fix a parameter",
            ),
        )

    def _datum(self) -> str:
        """What determines a map that is free as a whole."""
        turns = sum(one.gauge == "rotation" and one.residuals_change for one in self)
        if not turns:
            return "fix one pose as an anchor, or give the map a prior or an absolute measurement"
        points = (
            "a point, two coordinates of another and one of a third"
            if turns == 3
            else "a point and a coordinate of another"
            if turns == 1
            else "coordinates of several points"
        )
        return (
            f"fix as many coordinates as there are free directions ({points}), or ask for "
            '`covariance(gauge="free")`'
        )

    def _more(self) -> list[str]:
        more = len(self) - _SHOWN
        return [f"  and {more} more"] if more > 0 else []


def refuse_free_directions(equations: NormalEquations) -> None:
    """Raise SolveError (E1008) naming the free directions, if there are any."""
    found = FreeDirections(equations)
    if found:
        raise SolveError(found.as_error())


def _described(
    equations: NormalEquations, basis: Floats, second_order: bool
) -> list[FreeDirection]:
    """Name each direction of the free space `basis` (n, f), orthonormal in scaled units."""
    scale = equations.scale[equations.free]
    found: list[FreeDirection] = []
    known = np.zeros((len(scale), 0))
    if not equations.problem.layout.required:
        found, known = _symmetric(equations, basis, scale)
    rest = _beyond(basis, known)
    moves = rest * scale[:, None]
    left = np.eye(rest.shape[1])
    for gauge in find_gauges(equations.problem, moves) if rest.shape[1] else ():
        found.append(FreeDirection(gauge.words, moves @ gauge.weights, gauge.kind))
        # The rest of the free space, orthogonal to this direction.
        left = left @ _complement(left.T @ gauge.weights)
    remaining = rest @ left
    if remaining.shape[1]:
        found += _by_name(remaining, scale, equations.names)
    if second_order:
        flat = flat_directions(equations, basis)
        flat = _beyond(flat, np.column_stack([known, rest]))
        found += [
            FreeDirection(f"{one.words} (to second order)", one.vector, "", True)
            for one in (_by_name(flat, scale, equations.names) if flat.shape[1] else ())
        ]
    return found


def _symmetric(
    equations: NormalEquations, basis: Floats, scale: Floats
) -> tuple[list[FreeDirection], Floats]:
    """The symmetries of the cost, and an orthonormal basis of them in scaled units."""
    found: list[FreeDirection] = []
    known = np.zeros((len(scale), 0))
    for one in symmetries(equations.problem, equations.free, scale, equations.newton_step):
        direction = one.vector / scale
        size = float(np.linalg.norm(direction))
        direction /= size
        changes = bool(np.linalg.norm(direction - basis @ (basis.T @ direction)) > _SAME)
        new = direction - known @ (known.T @ direction)
        length = float(np.linalg.norm(new))
        if length < _SAME:
            continue
        if changes:
            # Residuals turn and scale with the map, so they change by no more than their size.
            change = size**2 * float(direction @ (equations.matrix @ direction))
            if change > (_FASTEST * one.rate) ** 2 * equations.problem.cost():
                continue
        if not one.kind or (not changes and np.count_nonzero(one.vector) <= 1):
            continue  # named by what moves
        known = np.column_stack([known, new / length])
        found.append(FreeDirection(one.words, one.vector, one.kind, changes))
    return found, known


def _beyond(basis: Floats, known: Floats) -> Floats:
    """Orthonormal basis of what `basis`, orthonormal, has beyond `known`, orthonormal."""
    if not known.shape[1] or not basis.shape[1]:
        return basis
    u, s, _ = np.linalg.svd(basis - known @ (known.T @ basis), full_matrices=False)
    found: Floats = u[:, s > _APART]
    return found


def _complement(direction: Floats) -> Floats:
    """(k, k - 1) orthonormal basis of the complement of `direction` (k,)."""
    q: Floats = np.linalg.qr(direction[:, None], mode="complete")[0]
    return q[:, 1:]


def _by_name(basis: Floats, scale: Floats, names: list[str]) -> list[FreeDirection]:
    """Directions described by their largest entries, each with a different leading scalar."""
    # imported here: start-up time
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
