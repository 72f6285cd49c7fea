"""A model instance: its data from Python."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol

from arael import solving  # here, so that a first solve does not wait for imports
from arael.face.collection import Collection, fill
from arael.face.fields import Fields, summary
from arael.face.ref import Ref, Refs
from arael.runtime.layout import Layout
from arael.runtime.layout import Pass as LayoutPass
from arael.runtime.store import Store
from arael.runtime.store.schema import Nested
from arael.session import Session

__all__ = ["Compiled", "Model", "Ref", "Refs"]

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from arael.config import LmConfig
    from arael.diagnose.cost_table import CostTable
    from arael.diagnose.covariance import Covariance
    from arael.diagnose.diagnosis import Diagnosis
    from arael.diagnose.freedom import FreeDirections
    from arael.diagnose.gradients import GradientCheck
    from arael.diagnose.jacobian import Jacobian
    from arael.residuals.collection import Residuals
    from arael.result import Result
    from arael.runtime.problem import Problem
    from arael.schedule import Pass


class Compiled(Protocol):
    """What a model instance needs of a compiled model."""

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
        E0701-E0710 for values that do not fit what the model declares.

    Notes
    -----
    A field named like a method here is reached as ``model["name"]``. Fields of the root without a
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
        """Replace the data by that of a file (see `arael.io.read`); earlier refs are stale then."""
        from arael import io

        io.read(self, path, format)

    def write(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Write the data to a file, whole or not at all (see `arael.io.write`)."""
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
        """Minimise the cost and take the solution over; see `arael.solving.solve`."""
        return solving.solve(self, config, solver, passes, **settings)

    def serialize(self) -> NDArray[np.float64]:
        """Values of all parameters that are solved for, as one vector of stored scalars.

        In the order of `Result.x`, f64: a quaternion has four of them though three are solved for.
        What is fixed or not to be optimised is left out, unless it is an entity in part.
        """
        return self._problem().x

    def deserialize(self, x: Any) -> None:
        """Put a vector of `serialize`, or `Result.x`, back into the parameters.

        Raises
        ------
        AraelError
            E0704 it has another length; E0705 not finite; E0721 not a rotation. The model is as
            it was then.
        """
        self._problem().put(x)

    @property
    def session(self) -> Session:
        """What the last solve left for the next; ``release()`` lets go of it."""
        return self._session

    def cost(self) -> float:
        """Sum of squared residuals at the present values."""
        return self._problem().cost()

    def cost_table(self) -> CostTable:
        """Cost of each constraint by label, 0 where none acts."""
        from arael.diagnose.cost_table import cost_table

        return cost_table(self._problem())

    def gradient(self) -> NDArray[np.float64]:
        """Gradient 2 J'r at the present values, one entry per scalar that moves."""
        return self._problem().gradient()

    def hessian(self) -> NDArray[np.float64]:
        """Gauss-Newton Hessian 2 J'J at the present values, dense, over the scalars that move."""
        return self._problem().hessian()

    def hessian_block(self, a: Any, b: Any = None) -> NDArray[np.float64]:
        """Blocks of ``hessian()``, f64, as they stand there: the sum over all constraints.

        Parameters
        ----------
        a : a row (``path.poses[3]``, or the model itself for the root's parameters), or the path of
            a named block (``"poses.hb_pose"``)
        b : another row, to couple with; left out, `a` itself. Of a named block: the number of the
            row that holds it, or left out, all rows.

        Returns
        -------
        (k, l), the tangent scalars of `a` by those of `b` in order of declaration, zeros where they
        do not move; (n, k, l) of a named block of all n rows. Blocks that the model names are read
        as fields too: ``path.poses[3].hb_pose``, ``path.poses.hb_pose``, and ``path.hbt`` for
        triplets, a SciPy COO array of the pairs that go there.

        Raises
        ------
        AraelError
            E0701 there is no such block; E1009 a row has no parameters.
        """
        from arael.face.blocks import block_at, block_between

        found: NDArray[np.float64]
        if isinstance(a, str):
            found = block_at(self._store, a, b)
        else:
            found = block_between(self._store, a, a if b is None else b)
        return found

    def jacobian(self) -> Jacobian:
        """Jacobian at the present values, by rows."""
        from arael.diagnose.jacobian import jacobian

        return jacobian(self._problem())

    def covariance(self) -> Covariance:
        """Covariance of the solution: marginal, cross, conditional, relative.

        Raises
        ------
        SolveError
            E1008: the system is singular; the free directions are named.
        """
        from arael.diagnose.covariance import covariance

        return covariance(self._problem())

    def free_directions(self) -> FreeDirections:
        """What can change without any residual noticing, in words; empty if nothing can."""
        from arael.diagnose.freedom import FreeDirections
        from arael.diagnose.normal import NormalEquations

        return FreeDirections(NormalEquations(self._problem()))

    def check_gradients(self) -> list[GradientCheck]:
        """Derivatives against central differences at the present values, by constraint."""
        from arael.diagnose.gradients import check_gradients

        return check_gradients(self._problem())

    def diagnose(self) -> Diagnosis:
        """Everything that tells why a solve does not converge or where its result is poor.

        Looks at the present values: before a solve at its start, after it at its end. Print it, or
        go through its `findings`.
        """
        from arael.diagnose.diagnosis import diagnose

        return diagnose(self._problem())

    def parameter_names(self) -> list[str]:
        """Name of every scalar that moves (``poses[3].ea.z``), in order of the system."""
        return self._problem().parameter_names()

    def _problem(self) -> Problem:
        self._store.check_complete()
        return solving.problem_of(self)

    def __repr__(self) -> str:
        layout = self._compiled.layout
        return f"<{layout.root} of {layout.source}: {summary(self, 10)}>"
