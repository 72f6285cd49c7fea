"""How a solution changes with what it was computed from: the implicit function theorem.

At a solution ``g(x, d) = J'r = 0``, so that ``dx/dd = -H^-1 dg/dd`` with ``H = dg/dx``. For one
scalar q(x, d) a single solve gives the derivatives by all data (the adjoint method; A. Griewank and
A. Walther, "Evaluating derivatives", 2008, chapter 15):

    H v = dq/dx,    dq/dd = (dq/dd at constant x) - v' dg/dd

``dg/dd`` is exact. H is that of Gauss-Newton, ``J'J``, or exact: then conjugate gradients with the
factor of ``J'J`` as preconditioner, which take as many steps as the second-order terms matter.
What is held (fixed, frozen, on an active bound) counts as data: there ``v = 0``, and the derivative
by it is ``dq/dx_k - (H v)_k``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arael.analysis.adjoint import by_tangent, code_products, gradient_products, in_system
from arael.analysis.freedom import refuse_free_directions
from arael.analysis.normal import NormalEquations
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

_TOLERANCE = 1e-12
"""Residual of the exact system, in the norm of the preconditioner, relative to the right side."""
_MOST = 500
"""Most steps of conjugate gradients: none of the gallery takes more than 40."""


class Quick(Protocol):
    """A factor of J'J that is there already, as long as it is (`arael.session_factor`)."""

    def solved(self, right: Floats) -> Floats | None:
        """(size,) product with the inverse; None if there is no factor now."""


class ImplicitSystem:
    """The linear system of a solution, factorised.

    Parameters
    ----------
    problem : at its solution
    quick : its factor, if there is one with nothing free and no bounds

    Raises
    ------
    SolveError
        E1008: directions are free; they are named.
    """

    def __init__(self, problem: Problem, quick: Quick | None = None) -> None:
        self.problem = problem
        self._quick = quick
        if quick is None:
            refuse_free_directions(self.equations)

    @cached_property
    def equations(self) -> NormalEquations:
        """J'J, scaled, without what is on an active bound."""
        return NormalEquations(self.problem, hold_bounds=True)

    @cached_property
    def free(self) -> NDArray[np.int64]:
        """Scalars of the system that the solution determines."""
        return self.problem.free if self._quick is not None else self.equations.free

    @cached_property
    def names(self) -> list[str]:
        """(size,) names of the scalars of the system."""
        return self.problem.structure.system.names()

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Numbers of the scalars that the solution determines, by name."""
        return {self.names[k]: int(k) for k in self.free}

    @property
    def on_bound(self) -> dict[str, str]:
        """Names of the scalars on an active bound, each with the bound in words."""
        return {} if self._quick is not None else self.equations.on_bound

    def solved(self, right: Floats) -> Floats:
        """(size,) or (size, k) ``(J'J)^-1 right`` over what is free; zero elsewhere."""
        whole = np.zeros_like(right)
        whole[self.free] = right[self.free]
        if self._quick is not None:
            found = self._quick.solved(whole)
            if found is not None:
                found[self._held] = 0
                return found
            self._quick = None  # the session was used for something else
        scale = self.equations.scale if right.ndim == 1 else self.equations.scale[:, None]
        found = np.asarray(self.equations.solver.solved(whole * scale)) * scale
        found[self._held] = 0
        return found

    @cached_property
    def _held(self) -> NDArray[np.bool_]:
        held = np.ones(self.problem.size, dtype=bool)
        held[self.free] = False
        return held

    def hessian_product(self, v: Floats) -> Floats:
        """(size,) ``H v`` with the exact Hessian of half the cost, over the whole system."""
        found = gradient_products(self.problem, v, columns=())
        steps = by_tangent(self.problem, found.states)
        return in_system(self.problem, steps) + code_products(self.problem, v)

    def adjoint(self, right: Floats, exact: bool) -> Floats:
        """(size,) the v of ``H v = right`` over what is free.

        Raises
        ------
        AraelError
            E1060: with the exact H, where it is not positive definite.
        """
        if not exact:
            return self.solved(right)
        target = np.where(self._held, 0.0, right)
        return conjugate_gradients(self._free_product, self.solved, target, self._not_convex)

    def _free_product(self, v: Floats) -> Floats:
        return np.where(self._held, 0.0, self.hessian_product(v))

    def _not_convex(self) -> AraelError:
        return AraelError(
            Diagnostic(
                "E1060",
                "the exact Hessian is not positive definite here: this is no strict minimum",
                origin=self.problem.layout.name,
                help=(
                    "solve to convergence first; with `exact=False` the Hessian is that of "
                    "Gauss-Newton",
                ),
            )
        )


def conjugate_gradients(
    product: Callable[[Floats], Floats],
    preconditioned: Callable[[Floats], Floats],
    right: Floats,
    failure: Callable[[], AraelError],
) -> Floats:
    """Solution of ``product(x) = right``; raises `failure()` where it is not positive definite."""
    found = np.zeros_like(right)
    residual = right.copy()
    direction = ahead = preconditioned(residual)
    size = start = float(residual @ ahead)
    if not start > 0:
        return found
    best = size
    for _ in range(_MOST):
        image = product(direction)
        curvature = float(direction @ image)
        if not curvature > 0:
            raise failure()
        step = size / curvature
        found = found + step * direction
        residual = residual - step * image
        ahead = preconditioned(residual)
        before, size = size, float(residual @ ahead)
        if size <= _TOLERANCE**2 * start:
            return found
        best = min(best, size)
        direction = ahead + max(size, 0.0) / before * direction
    if best <= 1e-16 * start:  # rounding of the products
        return found
    raise failure()
