"""A model instance: its data from Python."""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Self

from arael import solving  # here, so that a first solve does not wait for imports
from arael.compiled_model import CompiledModel
from arael.diagnostics.frames import public, user_frames
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.face.blocks import block_at, block_between
from arael.face.collection import Collection, fill
from arael.face.fields import Fields, summary
from arael.face.ref import Ref, Refs
from arael.runtime.layout import LayoutPass
from arael.runtime.store import Store
from arael.runtime.store.schema import Nested
from arael.session import Session

__all__ = ["Model", "Ref", "Refs"]

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from arael.analysis.cost_table import CostTable
    from arael.analysis.covariance import Covariance
    from arael.analysis.diagnosis import Diagnosis
    from arael.analysis.freedom import FreeDirections
    from arael.analysis.gradients import GradientChecks
    from arael.analysis.jacobian import Jacobian
    from arael.analysis.next_data import NextData
    from arael.analysis.profile import Profile
    from arael.analysis.projection import Projection
    from arael.analysis.report import Report
    from arael.analysis.residual_values import ResidualValues
    from arael.analysis.verdict import Verdict
    from arael.certificates.certificate import Certificate
    from arael.config import LmConfig
    from arael.online.result import UpdateResult
    from arael.plot.map import View
    from arael.plot.problem import What
    from arael.residuals.code import CodeResidual, CodeUpdate
    from arael.residuals.collection import Residuals
    from arael.result import Result
    from arael.runtime.problem import Problem
    from arael.schedule import Pass
    from arael.solution import Solution
    from arael.tangent_problem import TangentProblem


class Model(Displayed, Fields):
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

    _compiled: CompiledModel
    _store: Store
    _residuals: Residuals | None
    _session: Session

    def __init__(self, compiled: CompiledModel, /, **values: Any) -> None:
        self._begin(compiled)
        for name, value in values.items():
            member = self._member(name)
            if isinstance(member, Nested):
                fill(Collection(self._store.tables[member.table.path]), value, name)
            else:
                self._set(member, value)

    def _begin(self, compiled: CompiledModel) -> None:
        """Set up an instance without data but defaults."""
        store = Store(compiled.layout)
        store.kernels, store.bindings = compiled.kernels, compiled.bindings
        store.model = weakref.ref(self)
        object.__setattr__(self, "_compiled", compiled)
        object.__setattr__(self, "_store", store)
        object.__setattr__(self, "_residuals", None)
        object.__setattr__(self, "_session", Session())
        object.__setattr__(self, "_table", store.root)
        object.__setattr__(self, "_group", store.root.fields)

    def _rows(self) -> int:
        return 0

    def _get(self, member: Any) -> Any:
        if isinstance(member, Nested):
            return Collection(self._store.tables[member.table.path])
        return super()._get(member)

    # --- copies ------------------------------------------------------------------------------

    def copy(self) -> Self:
        """An independent copy of data, flags and runtime residuals.

        Refs of one are not valid in the other: take ``copy.poses[ref.row]``. `copy.copy`,
        `copy.deepcopy` and `pickle` make such copies too; pickle stores the text of the model,
        which is compiled again where the cache does not have it.
        """
        # imported here: start-up time
        from arael.copying import copied

        found: Self = copied(self)
        return found

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError(
            f"cannot pickle `{self._compiled.layout.name}`, a model that was not loaded from a "
            "text; load it with `arael.load` or `arael.loads`"
        )

    def read(
        self,
        path: str | os.PathLike[str],
        format: str | None = None,
        *,
        information: float | tuple[float, float] | None = None,
    ) -> None:
        """Replace the data by that of a file (see `arael.io.read`); earlier refs become stale."""
        # imported here: start-up time
        from arael import io

        __tracebackhide__ = True
        with user_frames:
            io.read(self, path, format, information=information)

    def write(self, path: str | os.PathLike[str], format: str | None = None) -> None:
        """Write the data to a file atomically (see `arael.io.write`)."""
        # imported here: start-up time
        from arael import io

        __tracebackhide__ = True
        with user_frames:
            io.write(self, path, format)

    # --- solving -----------------------------------------------------------------------------

    @property
    def residuals(self) -> Residuals:
        """Residual equations added at run time; see `arael.runtime_residual`."""
        if self._residuals is None:
            # imported here: start-up time
            from arael.residuals.collection import Residuals

            object.__setattr__(self, "_residuals", Residuals(self))
            self._store.residuals = self._residuals
        assert self._residuals is not None
        return self._residuals

    def add_residuals(
        self,
        function: Any,
        parameters: Iterable[Any],
        size: int = 1,
        *,
        data: Mapping[str, Any] | None = None,
        jacobian: Callable[..., Any] | bool | None = None,
        coordinates: str = "tangent",
        loss: str | None = None,
        name: str | None = None,
        kind: str = "cost",
    ) -> CodeResidual:
        """Add residuals that a function evaluates, for all instances at once.

        ``function(*values, **data)`` gets for each parameter an array (n, ...) of its values, in
        f64 and in the form of ``.value`` (a scalar parameter (n,), a quaternion (n, 4)), and the
        columns of `data` by name. It returns residuals (n, size), or
        ``(residuals, jacobians)`` with an array (n, size, dim) for each parameter. Axes of length 1
        may be left out.

        Parameters
        ----------
        function : a Python function (NumPy, numba, JAX, PyTorch), or a C function pointer (ctypes,
            numba ``cfunc``, cffi, capsule), which is called without the GIL:
            ``int f(int64_t n, const double **parameters, const double **data, double *residuals,
            double **jacobians)``
        parameters : parameters of the model: ``model.poses.pos``, ``model.poses[rows].pos``, which
            has one row for each instance, or ``model.poses[3].pos`` and ``model.scale``, which all
            instances share
        size : number of residuals of an instance
        data : arrays whose first axis counts instances, or single numbers
        jacobian : a function of the same arguments that returns the Jacobians, called at
            linearisations only; of a C function False: it writes none
        coordinates : what Jacobians are derivatives by: ``"tangent"``, the step of the parameter
            (docs/conventions.md), or ``"ambient"``, its stored scalars
        loss : robust loss of the residuals of an instance, as in a model file: ``"huber(1.5)"``
        name : in cost tables, reports and messages; by default that of the function
        kind : ``"cost"``: squares are added to the cost. ``"equal"``: all are zero at a solution;
            ``"at_least"``: none is negative there, as `require` of a model (docs/constraints.md)

        Returns
        -------
        The residuals; ``model.residuals.remove(name)`` removes them.

        Notes
        -----
        Without Jacobians these are central differences on the tangent, two calls of the function
        for each tangent scalar; reports mention them. A third result adds terms to the Hessian of
        the cost that Gauss-Newton leaves out: triplets ``(instance, row, column, value)``, or
        symmetric matrices (n, k, k), over the tangent scalars of all parameters in their order.

        Raises
        ------
        AraelError
            E0760, E0770: arguments that do not fit. Later, from whatever evaluates the function:
            E0771 it raised, E0772 it returned the wrong shape, type, or a Jacobian that is not
            finite.
        """
        # imported here: start-up time
        from arael.residuals.code import CodeResidual, named

        label = named(function, name, self.residuals)
        code = CodeResidual(
            self, function, parameters, size, data, jacobian, coordinates, loss, label, kind
        )
        return self.residuals.add_code(code)

    def before_linearisation(
        self, function: Callable[..., Any], parameters: Iterable[Any] = (), name: str | None = None
    ) -> CodeUpdate:
        """Call ``function(*values)`` before each linearisation, to update what residuals read.

        It gets the values of `parameters` at the accepted state, and may change data with
        `CodeResidual.set_data` or variables of its own that functions of `add_residuals` read, for
        example matches of points. The cost is evaluated again afterwards, so that it may rise.

        Raises
        ------
        AraelError
            E0770: arguments that do not fit; while solving E0771: the function raised.
        """
        # imported here: start-up time
        from arael.residuals.code import CodeUpdate, named

        label = named(function, name, self.residuals)
        return self.residuals.add_update(CodeUpdate(self, function, parameters, label))

    def marginalise(
        self, rows: Any, *, first_estimates: bool = True, name: str = "prior"
    ) -> CodeResidual | None:
        """Remove rows and keep their information as a prior on the parameters beside them.

        Constraints that read a row that leaves are linearised, its parameters are eliminated, and
        what remains becomes a dense residual ``r + J (x boxminus x0)`` on the parameters that stay.
        Rows nested in those that leave and rows without parameters that refer to them
        (observations) leave too; optional refs to them become null. Earlier priors of what leaves
        become part of the new one, so that the cost of a step of a window is constant.

        Parameters
        ----------
        rows : refs or choices of rows, or a list of them: ``model.poses[0]``, ``model.poses[:5]``
        first_estimates : linearise parameters that earlier priors contain where those were
            linearised. False linearises everything at the present values, which gives
            information about directions that no measurement observes (docs/windows.md)
        name : of the prior, with a number if it is taken

        Returns
        -------
        The prior, residuals by own code; None if nothing that stays was connected. Its `function`
        is an `arael.windows.prior.Prior`. All priors are in ``model.residuals.priors``.

        Raises
        ------
        AraelError
            E0709 a ref is stale; E0780 not rows of this model; E0781 something that stays refers to
            a row that leaves; E0782 a prior is not possible; E1040 the model is being solved. The
            model is then unchanged.
        """
        # imported here: start-up time
        from arael.windows.marginalisation import marginalise

        return marginalise(self, rows, first_estimates, name)

    marginalize = marginalise

    def _saved_priors(self) -> Any:
        # imported here: start-up time
        from arael.windows import saved

        return saved.dump(self._store)

    def _checked_priors(self, store: Store, given: Any, name: str) -> Any:
        # imported here: start-up time
        from arael.windows import saved

        return saved.read(store, given, name)

    def _restore_priors(self, found: Any) -> None:
        # imported here: start-up time
        from arael.windows import saved

        saved.restore(self._store, found)

    def solve(
        self,
        config: LmConfig | None = None,
        solver: str = "auto",
        passes: str | Pass | LayoutPass | Iterable[str | Pass | LayoutPass] | None = None,
        **settings: Any,
    ) -> Result:
        """Minimise the cost and store the solution; see `arael.solving.solve`."""
        __tracebackhide__ = True
        with user_frames:
            return solving.solve(self, config, solver, passes, **settings)

    def _solution(self, result: Result) -> Solution:
        """What a result of this model is asked by; see `arael.Result.sensitivity`."""
        # imported here: start-up time
        from arael.solution import solution_of

        return solution_of(self, result)

    def _certificate(self, result: Result) -> Certificate:
        """See `arael.Result.certificate`."""
        # imported here: start-up time
        from arael.solution import certified

        return certified(self, result)[0]

    def _escaped(self, result: Result, settings: Mapping[str, Any]) -> Result:
        """See `arael.Result.escape`."""
        # imported here: start-up time
        from arael.solution import escaped

        return escaped(self, result, settings)

    def update(
        self,
        *,
        tolerance: float | None = None,
        max_seconds: float | None = None,
        freeze: str | Iterable[str] = (),
    ) -> UpdateResult:
        """Take in what has changed since the last update; newest estimates in a short time.

        Rows that were appended or removed, other values, data and flags are found by comparison, as
        a solve does. A factor is kept from update to update: what lies above a change is eliminated
        anew, and parameters are linearised anew where their residuals are off by more than the
        tolerance. The page *Online* says when to use which of `update` and `solve`.

        Parameters
        ----------
        tolerance : as a part of the root mean square of residuals; by default 1e-5. With 0 it is
            one Gauss-Newton step of the whole problem from the present values
        max_seconds : no further step begins after that time; what is left is for the next update
        freeze : as of `solve`

        Returns
        -------
        UpdateResult
            What moved, and how much was computed. What `update` does not support, and a step that
            raises the cost, is solved in full: ``full`` is set, and ``reason`` says why.

        Raises
        ------
        SolveError, AraelError
            As `solve` does without passes.
        """
        # imported here: start-up time
        from arael.online.update import TOLERANCE, update

        return update(
            self,
            tolerance=TOLERANCE if tolerance is None else tolerance,
            max_seconds=max_seconds,
            freeze=freeze,
        )

    def marginal(self, row: Ref) -> NDArray[np.float64]:
        """Marginal covariance (k, k) of the parameters of a row, over their tangent scalars.

        After `update` from its factor, which takes microseconds for the newest rows: at the
        linearisation points, which are within the tolerance of the estimates. Otherwise
        ``covariance().marginal(row)``. Fixed parameters have zeros.

        Raises
        ------
        SolveError
            E1008: directions are free; they are named.
        AraelError
            E0709 the ref is stale; E1009 the row has no parameters.
        """
        # imported here: start-up time
        from arael.online.marginal import marginal

        return marginal(self, row)

    def prepare(
        self,
        solver: str = "auto",
        passes: str | Pass | LayoutPass | Iterable[str | Pass | LayoutPass] | None = None,
        **settings: Any,
    ) -> None:
        """Build the problem, so that the next solve begins at once.

        For programs whose first solve must not take longer than the following ones. No value
        changes, and edits between this call and the solve count as usual. See
        `arael.preparation.prepare`.
        """
        # imported here: start-up time
        from arael.preparation import prepare

        prepare(self, solver, passes, **settings)

    def plot(self, what: What = "auto", view: View = "auto") -> Figure:
        """Draw the model at its current values.

        Needs matplotlib (E0860); `arael solve --plot` also draws the history of a solve.

        Parameters
        ----------
        what : ``map``: places of rows (vectors of two or three numbers and transforms), paths,
            links, and ellipses of two sigmas where the problem is determined; ``residuals``:
            whitened, by constraint, with the weights of losses; ``hessian``: its pattern; ``auto``:
            the first of these that the model has
        view : of the map: ``xy``, ``xz``, ``yz``, ``3d``; ``auto`` shows most

        Raises
        ------
        AraelError
            E0828: an unknown `what` or `view`, or no such picture of this model.
        """
        # imported here: start-up time
        from arael.plot.problem import model_figure

        return model_figure(self, self._compiled.layout, what, view, self._compiled.layout.root)

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

    def problem(self) -> TangentProblem:
        """Cost, residuals and derivatives for minimisers and samplers of one's own.

        Independent of later changes of this model until `TangentProblem.write_back`.
        """
        # imported here: start-up time
        from arael.tangent_problem import TangentProblem

        self._store.check_complete()
        return TangentProblem(solving.problem_of(self))

    @property
    def session(self) -> Session:
        """Data reused by the next solve; ``release()`` frees it."""
        return self._session

    def cost(self) -> float:
        """Sum of squared residuals at the current values."""
        return self._problem().cost()

    def cost_table(self) -> CostTable:
        """Cost of each constraint by label, 0 without active instances."""
        # imported here: start-up time
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
        found: NDArray[np.float64]
        if isinstance(a, str):
            found = block_at(self._store, a, b)
        else:
            found = block_between(self._store, a, a if b is None else b)
        return found

    def residual_values(self, label: str) -> ResidualValues:
        """Residuals of one constraint, row by row: raw, whitened, and after the loss.

        Parameters
        ----------
        label : of the constraint, ``"Sat.pseudorange"``, or of a residual added at run time

        Raises
        ------
        AraelError
            E1037: no such constraint, or a file that the model imports was changed before the
            first call for this constraint.
        """
        # imported here: start-up time
        from arael.analysis.residual_values import residual_values
        from arael.residuals.unweighted import unweighted

        return residual_values(self._problem(), label, partial(unweighted, self))

    def jacobian(self) -> Jacobian:
        """Jacobian at the current values, by rows."""
        # imported here: start-up time
        from arael.analysis.jacobian import jacobian

        return jacobian(self._problem())

    @public
    def covariance(self, scale: str = "known", gauge: str = "fixed") -> Covariance:
        """Covariance of the solution: marginal, cross, conditional, relative.

        Parameters
        ----------
        scale : ``"known"`` if residuals are whitened by known standard deviations; ``"residual"``
            multiplies by the reduced chi-square, where these are not known
        gauge : ``"fixed"``: the data, or fixed parameters, determine the place of the map.
            ``"free"``: inner constraints, whose covariance has the least trace;
            `Covariance.in_datum` transforms it to another datum

        Raises
        ------
        SolveError
            E1008: directions are free, with the gauge fixed; they are named.
        AraelError
            E1035: an unknown scale, or no more residuals than parameters.
        """
        # imported here: start-up time
        from arael.analysis.covariance import Covariance
        from arael.session_factor import session_factor

        problem = self._problem()
        usual = [str(x) for x in (scale, gauge)] == ["known", "fixed"]
        usual = usual and not problem.layout.required
        return Covariance(problem, scale, gauge, session_factor(self, problem) if usual else None)

    @public
    def report(self, scale: str = "known") -> Report:
        """Report on the current values: standard errors, correlations, chi-square, suspicions.

        Parameters
        ----------
        scale : as of `covariance`
        """
        # imported here: start-up time
        from arael.analysis.report import report

        return report(self._problem(), scale)

    @public
    def profile(self, name: str, level: float = 0.95, scale: str = "known") -> Profile:
        """Confidence interval of a scalar by profile likelihood; the model keeps its values.

        The interval holds all values for which the best values of all other parameters raise the
        cost by no more than the quantile of chi-square with one degree of freedom, or with
        ``scale="residual"`` by the squared quantile of Student's t times the reduced chi-square.
        Unlike ``value +- k sigma`` it needs no symmetry.

        Parameters
        ----------
        name : of a scalar, as in `parameter_names`; not of a rotation
        level : probability that the interval holds the true value

        Raises
        ------
        AraelError
            E1036: no such scalar or level, or a lower cost was found on the way.
        """
        # imported here: start-up time
        from arael.analysis.profile import profile

        return profile(self, name, level, scale)

    def free_directions(self) -> FreeDirections:
        """Directions that do not change the cost, in words; empty if there are none.

        Most of them change no residual. Where residuals are vectors that turn with the map, only
        the cost stays (`FreeDirection.residuals_change`). In a small problem at a minimum, the
        second derivatives of the cost are asked too.
        """
        # imported here: start-up time
        from arael.analysis.freedom import FreeDirections
        from arael.analysis.normal import NormalEquations

        return FreeDirections(NormalEquations(self._problem()), second_order=True)

    def check_gradients(self) -> GradientChecks:
        """Compare derivatives with central differences at the current values, by constraint."""
        # imported here: start-up time
        from arael.analysis.gradients import check_gradients

        return check_gradients(self._problem())

    @public
    def diagnose(self) -> Diagnosis:
        """Report why a solve does not converge or where its result is poor.

        Evaluated at the current values: the start before a solve, the solution after it. Print it,
        or iterate over its `findings`.
        """
        # imported here: start-up time
        from arael.analysis.diagnosis import diagnose

        return diagnose(self._problem())

    def verdict(self) -> Verdict:
        """Judge a solved model: what its data determines, what is missing, what is suspicious.

        How each parameter is determined and by which constraints; weak and free directions, with
        the motion or view that would determine them; residuals that are not white, suspicious
        groups, and the size of the noise. Evaluated at the current values.
        """
        # imported here: start-up time
        from arael.analysis.verdict import verdict

        return verdict(self)

    def projection_uncertainty(
        self, size: tuple[float, float] | None = None
    ) -> tuple[Projection, ...]:
        """Uncertainty of projection over the picture of each camera of a solved calibration.

        For models with a column of measured pixels, ``pixel: vec2 [px]``, and one of points on a
        target. The pose of the target in each view is accounted for, as in mrcal.

        Parameters
        ----------
        size : width and height of the pictures; None: as if what was measured lay symmetric in them

        Raises
        ------
        AraelError
            E0791: no such columns.
        """
        # imported here: start-up time
        from arael.analysis.projection import projection_uncertainty

        return projection_uncertainty(self, size)

    def next_data(
        self,
        count: int,
        candidates: Mapping[str, Any],
        collection: str,
        of: str | Iterable[str] | None = None,
        criterion: str = "d",
    ) -> NextData:
        """Choose the candidates for the next measurements that lower the uncertainty most.

        Parameters
        ----------
        count : how many to choose
        candidates : columns of the candidates by name, as for ``extend``; measured values that no
            derivative depends on may be left out
        collection : the collection of the root that they would be rows of
        of : parameters or rows whose uncertainty counts; None: those of the root and of
            collections of at most eight rows, or all
        criterion : ``"d"`` for the determinant of their covariance, ``"a"`` for its trace relative
            to the present variances

        Raises
        ------
        AraelError
            E0790: no such collection or parameter, or candidates with parameters of their own;
            E0701-E0710 for candidates that do not fit the declarations of the model.
        """
        # imported here: start-up time
        from arael.analysis.next_data import next_data

        wanted = of if of is None or isinstance(of, str) else list(of)
        return next_data(self, count, candidates, collection, wanted, criterion)

    def parameter_names(self) -> list[str]:
        """Name of every free tangent scalar (``poses[3].ea.z``), in the order of the system."""
        return self._problem().parameter_names()

    def _problem(self) -> Problem:
        self._store.check_complete()
        return solving.problem_of(self)

    def _sheet(self) -> Sheet:
        # imported here: start-up time
        from arael.face.sheets import model_sheet

        layout = self._compiled.layout
        return model_sheet(self, f"{layout.root} ({layout.source})")

    def __repr__(self) -> str:
        layout = self._compiled.layout
        return f"<{layout.root} of {layout.source}: {summary(self, 10)}>"
