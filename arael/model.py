"""A model instance: its data from Python."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol

from arael import solving  # here, so that a first solve does not wait for imports
from arael.face.collection import Collection, fill
from arael.face.fields import Fields, summary
from arael.face.ref import Ref, Refs
from arael.runtime.layout import Layout, LayoutPass
from arael.runtime.store import Store
from arael.runtime.store.schema import Nested
from arael.session import Session

__all__ = ["Compiled", "Model", "Ref", "Refs"]

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from arael.analysis.cost_table import CostTable
    from arael.analysis.covariance import Covariance
    from arael.analysis.diagnosis import Diagnosis
    from arael.analysis.freedom import FreeDirections
    from arael.analysis.gradients import GradientCheck
    from arael.analysis.jacobian import Jacobian
    from arael.config import LmConfig
    from arael.residuals.collection import Residuals
    from arael.result import Result
    from arael.runtime.problem import Problem
    from arael.schedule import Pass


class Compiled(Protocol):
    """The parts of a compiled model that a model instance uses."""

    @property
    def layout(self) -> Layout:
        """Tables, parameters, constraints."""


class Model(Fields):
    """An instance of a compiled model: the root's fields are attributes.

    Parameters
    ----------
    compiled : the compiled model
    **values : data of the root by field name; collections as lists of dicts

    Raises
    ------
    AraelError
        E0701-E0710 for values that do not fit the declarations of the model.

    Notes
    -----
    A field with the name of a method is accessed as ``model["name"]``. Fields of the root without a
    default may be set at any time before solving.
    """

    _compiled: Compiled
    _store: Store
    _residuals: Residuals | None
    _session: Session

    def __init__(self, compiled: Compiled, /, **values: Any) -> None:
        store = Store(compiled.layout)
        store.kernels = getattr(compiled, "kernels", None)
        store.bindings = getattr(compiled, "bindings", None) or {}
        object.__setattr__(self, "_compiled", compiled)
        object.__setattr__(self, "_store", store)
        object.__setattr__(self, "_residuals", None)
        object.__setattr__(self, "_session", Session())
        object.__setattr__(self, "_table", store.root)
        object.__setattr__(self, "_group", store.root.fields)
        for name, value in values.items():
            member = self._member(name)
            if isinstance(member, Nested):
                fill(Collection(store.tables[member.table.path]), value, name)
            else:
                self._set(member, value)

    def _rows(self) -> int:
        return 0

    def _get(self, member: Any) -> Any:
        if isinstance(member, Nested):
            return Collection(self._store.tables[member.table.path])
        return super()._get(member)

    def read(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Replace the data by that of a file (see `arael.io.read`); earlier refs become stale."""
        from arael import io

        io.read(self, path, format)

    def write(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Write the data to a file atomically (see `arael.io.write`)."""
        from arael import io

        io.write(self, path, format)

    # --- solving -----------------------------------------------------------------------------

    @property
    def residuals(self) -> Residuals:
        """Residual equations added at run time; see `arael.runtime_residual`."""
        if self._residuals is None:
            from arael.residuals.collection import Residuals

            object.__setattr__(self, "_residuals", Residuals(self))
            self._store.residuals = self._residuals
        assert self._residuals is not None
        return self._residuals

    def solve(
        self,
        config: LmConfig | None = None,
        solver: str = "auto",
        passes: str | Pass | LayoutPass | Iterable[str | Pass | LayoutPass] | None = None,
        **settings: Any,
    ) -> Result:
        """Minimise the cost and store the solution; see `arael.solving.solve`."""
        return solving.solve(self, config, solver, passes, **settings)

    def serialize(self) -> NDArray[np.float64]:
        """Values of all free parameters, as one vector of stored scalars.

        In the order of `Result.x`, f64: a quaternion has four of them, though its tangent has
        three. Fixed and frozen parameters are omitted, unless only a part of an entity is fixed.
        """
        return self._problem().x

    def deserialize(self, x: Any) -> None:
        """Set the parameters from a vector of `serialize`, or `Result.x`.

        Raises
        ------
        AraelError
            E0704 wrong length; E0705 not finite; E0721 not a rotation. The model is then unchanged.
        """
        self._problem().put(x)

    @property
    def session(self) -> Session:
        """Data reused by the next solve; ``release()`` frees it."""
        return self._session

    def cost(self) -> float:
        """Sum of squared residuals at the current values."""
        return self._problem().cost()

    def cost_table(self) -> CostTable:
        """Cost of each constraint by label, 0 without active instances."""
        from arael.analysis.cost_table import cost_table

        return cost_table(self._problem())

    def gradient(self) -> NDArray[np.float64]:
        """Gradient 2 J'r at the current values, one entry per free tangent scalar."""
        return self._problem().gradient()

    def hessian(self) -> NDArray[np.float64]:
        """Dense Gauss-Newton Hessian 2 J'J at the current values, over free tangent scalars."""
        return self._problem().hessian()

    def hessian_block(self, a: Any, b: Any = None) -> NDArray[np.float64]:
        """Blocks of ``hessian()``, f64: sums over all constraints.

        Parameters
        ----------
        a : a row (``path.poses[3]``, or the model itself for the root's parameters), or the path of
            a named block (``"poses.hb_pose"``)
        b : the second row; by default `a` itself. For a named block: the number of the row that has
            it, by default all rows.

        Returns
        -------
        (k, l), the tangent scalars of `a` by those of `b` in order of declaration, zeros for fixed
        ones; (n, k, l) for a named block of all n rows. Named blocks can also be read as fields:
        ``path.poses[3].hb_pose``, ``path.poses.hb_pose``, and ``path.hbt`` for triplets, a SciPy
        COO array of the pairs assigned to it.

        Raises
        ------
        AraelError
            E0701 no such block; E1009 a row has no parameters.
        """
        from arael.face.blocks import block_at, block_between

        found: NDArray[np.float64]
        if isinstance(a, str):
            found = block_at(self._store, a, b)
        else:
            found = block_between(self._store, a, a if b is None else b)
        return found

    def jacobian(self) -> Jacobian:
        """Jacobian at the current values, by rows."""
        from arael.analysis.jacobian import jacobian

        return jacobian(self._problem())

    def covariance(self) -> Covariance:
        """Covariance of the solution: marginal, cross, conditional, relative.

        Raises
        ------
        SolveError
            E1008: the system is singular; the free directions are named.
        """
        from arael.analysis.covariance import covariance

        return covariance(self._problem())

    def free_directions(self) -> FreeDirections:
        """Directions that change no residual, in words; empty if there are none."""
        from arael.analysis.freedom import FreeDirections
        from arael.analysis.normal import NormalEquations

        return FreeDirections(NormalEquations(self._problem()))

    def check_gradients(self) -> list[GradientCheck]:
        """Compare derivatives with central differences at the current values, by constraint."""
        from arael.analysis.gradients import check_gradients

        return check_gradients(self._problem())

    def diagnose(self) -> Diagnosis:
        """Report why a solve does not converge or where its result is poor.

        Evaluated at the current values: the start before a solve, the solution after it. Print it,
        or iterate over its `findings`.
        """
        from arael.analysis.diagnosis import diagnose

        return diagnose(self._problem())

    def parameter_names(self) -> list[str]:
        """Name of every free tangent scalar (``poses[3].ea.z``), in the order of the system."""
        return self._problem().parameter_names()

    def _problem(self) -> Problem:
        self._store.check_complete()
        return solving.problem_of(self)

    def __repr__(self) -> str:
        layout = self._compiled.layout
        return f"<{layout.root} of {layout.source}: {summary(self, 10)}>"
