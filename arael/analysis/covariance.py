"""Covariance of the solution: marginal, cross, conditional, relative; without forming the inverse.

``C = 2 H^-1 = (J'J)^-1``, the inverse of the information of all measurements, for whitened
residuals. One query is a few solves with the factor; all marginals at once are a selected inverse
(`arael.runtime.linear.selected`). See S. Kay, "Fundamentals of Statistical Signal Processing:
Estimation Theory" (1993), ch. 3 (the Cramer-Rao bound), for its interpretation.
"""

from __future__ import annotations

import re
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.analysis.cost_table import cost_table
from arael.analysis.datum import Datum, bases_of, scalars_to_hold
from arael.analysis.freedom import FreeDirection, FreeDirections, refuse_free_directions
from arael.analysis.normal import NormalEquations
from arael.analysis.scalars import scalar_names_within, tangent_units
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import public
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.displayed import Displayed
from arael.display.measured import measured
from arael.display.sheet import Sheet
from arael.geometry import ellipsoid
from arael.runtime.constrained.active import acting_rows
from arael.runtime.linear.compiled import SparseSolver
from arael.runtime.linear.selected import SelectedInverse
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# A row of the model: a ref (`poses[3]` of the Python face), its name, or (path of the table, row);
# the model itself for the parameters of its root; or a list of such.
Where = Any

SCALES = ("known", "residual")
GAUGES = ("fixed", "free")

MOST_SHOWN = 50
"""Most scalars whose standard errors a notebook shows."""
MOST_CORRELATED = 8
"""Most scalars whose correlations it shows too."""

_KEPT = 300
"""Number of cached columns of the inverse."""

_INDEX = re.compile(r"\[\d+\]")


class Marginals(Protocol):
    """A factor of J'J that is there already, as long as it is (`arael.session_factor`)."""

    def marginal(self, scalars: Ints) -> Floats | None:
        """(k, k) block of the inverse for scalars of the system; None if there is no factor now."""


@dataclass(frozen=True, repr=False)
class Marginal(Displayed):
    """A marginal covariance with the names of its scalars; a table in notebooks and for rich.

    Attributes
    ----------
    names, units : (k,) of the scalars
    matrix : (k, k)
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    matrix: Floats

    @property
    def sigma(self) -> Floats:
        """(k,) standard errors."""
        return np.sqrt(np.diag(self.matrix))

    @property
    def correlation(self) -> Floats:
        """(k, k) correlations; NaN of scalars without variance."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.matrix / np.outer(self.sigma, self.sigma))

    def __repr__(self) -> str:
        return f"<Marginal covariance of {', '.join(self.names)}>"

    def _sheet(self) -> Sheet:
        spread = [measured(None, sigma)[1] for sigma in self.sigma.tolist()]
        cells = [[f"{rho:.3f}" for rho in row] for row in self.correlation]
        rows = [row for row in zip(self.names, spread, self.units, *cells, strict=True)]
        head = ("parameter", "standard error", "unit", *self.names)
        return Sheet("marginal covariance: standard errors and correlations", head, rows)


class Covariance(Displayed):
    """Covariance of all free scalars, at the values of the model when it was created.

    Fixed parameters and parameters on an active bound have no variance: the solution does not
    change with the measurements there. A `where` is a ref (``path.landmarks[4]``), the name of a
    row or of a parameter (``"poses[3]"``, ``"poses[3].pos"``), or a pair (path of the table, row);
    the model itself for the parameters of its root; or a list of these, whose scalars follow in
    its order.
    Entry (i, j) is in the unit of scalar i times that of scalar j (`units`); rotations are in
    radians of the parameter's own tangent: Euler angles directly, others by a rotation vector.

    Parameters
    ----------
    problem : at its current values
    scale : ``"known"``: residuals are whitened by known standard deviations. ``"residual"``: they
        are not, or only ratios of these are known: all covariances are multiplied by the reduced
        chi-square ``cost / (residuals - parameters)``, the estimated variance of a residual
        (G. Seber and C. Wild, "Nonlinear regression", 1989, section 2.1.2).
    gauge : ``"fixed"``: free directions are an error. ``"free"``: the covariance under inner
        constraints, of the least trace of all that differ by free directions
        (`arael.analysis.datum`); `in_datum` transforms it to another datum
    factor : of the problem at its values, with nothing free and no bounds, or None

    Attributes
    ----------
    factor : by which ``(J'J)^-1`` is multiplied
    free_directions : directions in which the covariance is that of a datum; none if it is fixed
    exact_directions : number of independent rows that hold exactly and act (`require`)
    units : (n,) unit of each, as the model declares it (``m``, ``rad``), "" without one; of a
        transform the translation has the declared unit, the rotation is in radians

    Raises
    ------
    SolveError
        E1008: the system is singular; the free directions are named.
    AraelError
        E1035: an unknown scale, or no degrees of freedom to estimate it from.
    """

    def __init__(
        self,
        problem: Problem,
        scale: str = "known",
        gauge: str = "fixed",
        factor: Marginals | None = None,
    ) -> None:
        check_scale(scale)
        if not isinstance(gauge, str) or gauge not in GAUGES:
            raise wrong_argument("covariance", "gauge", '"fixed" or "free"', gauge)
        if problem.layout.required and gauge == "free":
            raise wrong_argument(
                "covariance", "gauge", '"fixed" in a model with `require`', gauge,
                "fix as many coordinates as there are free directions",
            )  # fmt: skip
        self._problem = problem
        self._columns: dict[int, Floats] = {}
        self._datum: Datum | None = None
        self._quick = factor
        self.free_directions: list[FreeDirection] = []
        self.exact_directions = 0
        self.factor = 1.0
        if factor is not None:
            return  # it has no free directions, and all else can wait
        # Factorised here, so that a singular system is reported at once.
        if gauge == "free":
            self._take_datum(FreeDirections(self._equations))
        else:
            refuse_free_directions(self._equations)
            self._solver = self._equations.solver
            if problem.layout.required:
                self._datum = self._on_surface()
        if scale != "known":
            known = len(self.free_directions) + self.exact_directions
            self.factor = residual_variance(problem, len(self.names) - known)

    @cached_property
    def _equations(self) -> NormalEquations:
        return NormalEquations(self._problem, hold_bounds=True)

    @cached_property
    def _solver(self) -> SparseSolver:
        return self._equations.solver

    @cached_property
    def _moves(self) -> Floats:
        """(size,) 1 for scalars that move in the sparse system, 0 for those that it holds."""
        found = np.zeros(self._problem.size)
        found[self._equations.free] = 1
        return found

    @property
    def on_bound(self) -> dict[str, str]:
        """Parameters excluded because they are on an active bound, each with the bound in words."""
        return self._equations.on_bound

    @property
    def names(self) -> list[str]:
        """(n,) names of the scalars."""
        return self._equations.names

    @cached_property
    def _number(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    def _take_datum(self, directions: FreeDirections) -> None:
        equations = self._equations
        if not directions:
            self._solver = equations.solver
            return
        self.free_directions = list(directions)
        null, others = bases_of(directions)
        held = equations.free[scalars_to_hold(null, equations.scale[equations.free])]
        self._moves[held] = 0
        self._solver = equations.factorised(held)
        self._datum = Datum.inner(self._base, null, others)

    def _on_surface(self) -> Datum:
        """What the rows that act take from the covariance of the sparse system.

        With A of these rows and the covariance C of the system, whose matrix contains their
        squares, ``C - C A' (A C A')^+ C A``: that on the surface of the rows (J. Nocedal, S.
        Wright, "Numerical Optimization", 2nd ed., 2006, (16.16)). It does not depend on the
        weights of the squares. Dependent rows count once.
        """
        equations = self._equations
        matrix = acting_rows(self._problem, bounds=False).matrix()[:, equations.free]
        spread = self._base(matrix.T)
        lengths = np.sqrt(np.maximum((matrix.T * spread).sum(axis=0), 1e-300))
        inner = (matrix @ spread) / lengths[:, None] / lengths[None, :]
        middle = np.linalg.pinv(inner, rcond=1e-10, hermitian=True)
        self.exact_directions = int(np.linalg.matrix_rank(inner, tol=1e-10, hermitian=True))
        right = spread / lengths
        return Datum(np.zeros((len(self.names), 0)), -right @ middle, right)

    def in_datum(self, where: Where) -> Covariance:
        """The covariance in the datum of some parameters, of one of ``gauge="free"``.

        Exactly as many scalars as there are free directions become exact: those are the fixed
        coordinates of the datum, and their variance is 0. More of them have inner constraints:
        their least trace, as for some control points of a network.

        Raises
        ------
        AraelError
            E1009: they do not determine the free directions, or nothing is free.
        """
        chosen = self._scalars(where)
        datum = None if self._datum is None else self._datum.transformed(self._base, chosen)
        if datum is None:
            raise AraelError(_no_datum(where, chosen, self.free_directions))
        found = copy(self)
        found._datum, found._columns = datum, {}
        found.__dict__.pop("matrix", None)
        return found

    @cached_property
    def units(self) -> list[str]:
        """Unit of each scalar."""
        found: list[str] = []
        system = self._problem.structure.system
        for entity, blocks in zip(self._problem.layout.entities, system.blocks, strict=True):
            own = tangent_units(self._problem.layout, entity)
            found += own * int(np.count_nonzero(blocks.first >= 0))
        return [found[scalar] for scalar in self._equations.free]

    @cached_property
    def matrix(self) -> Floats:
        """(n, n) the full dense covariance, for at most a few thousand scalars."""
        return self._solve(np.eye(len(self.names)))

    @cached_property
    def _selected(self) -> SelectedInverse:
        return SelectedInverse(self._solver)

    def sigma(self) -> Floats:
        """(n,) standard deviation of each scalar, in its unit; all in one sweep."""
        whole = self._selected.diagonal() * self._equations.scale**2 * self._moves
        variance = whole[self._equations.free]
        if self._datum is not None:
            variance = variance + (self._datum.left * self._datum.right).sum(axis=1)
        found: Floats = np.sqrt(np.maximum(variance, 0) * self.factor)
        return found

    @public
    def marginal(self, where: Where) -> Floats:
        """(k, k) marginal covariance of an entity or of one parameter; of a list, jointly."""
        if self._quick is not None:
            scalars = self._scalars_of_row(where)
            quick = None if scalars is None else self._quick.marginal(scalars)
            if quick is not None:
                return quick
        found = self._scalars(where)
        return self._block(found, found)

    def marginals(self, path: str) -> Floats:
        """Marginal covariances (rows, k, k) of a whole collection, in one sweep.

        Fixed rows have zeros.

        Parameters
        ----------
        path : of a collection (``"landmarks"``) or of a parameter in it (``"poses.pos"``)
        """
        entity, first, tangents = self._entity(path)
        scale = self._equations.scale
        found = np.zeros((len(first), len(tangents), len(tangents)))
        rows = np.flatnonzero(first >= 0)
        blocks = self._selected.diagonal_blocks(first[rows], entity.tangent)
        units = scale[first[rows, None] + np.arange(entity.tangent)]
        scalars = first[rows, None] + np.arange(entity.tangent)
        moves = self._moves[scalars]
        blocks *= (units * moves)[:, :, None] * (units * moves)[:, None, :]
        if self._datum is not None:
            number = np.full(self._problem.size, -1)
            number[self._equations.free] = np.arange(len(self.names))
            at = number[scalars]
            left, right = (
                np.where(at[:, :, None] >= 0, one[at], 0.0)
                for one in (self._datum.left, self._datum.right)
            )
            blocks += left @ np.swapaxes(right, 1, 2)
        found[rows] = blocks[:, tangents[:, None], tangents] * self.factor
        return found

    def correlation(self, where: Where | None = None) -> Floats:
        """(k, k) correlations ``C_ij / sqrt(C_ii C_jj)`` within `where`; None: of all scalars."""
        covariance = self.matrix if where is None else self.marginal(where)
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):  # NaN where rows hold a scalar exactly
            found: Floats = covariance / (sigma[:, None] * sigma[None, :])
        return found

    def table(self, where: Where) -> Marginal:
        """The marginal covariance of `where` as a table: standard errors and correlations."""
        found = self._scalars(where)
        names, units = ([of[k] for k in found] for of in (self.names, self.units))
        return Marginal(tuple(names), tuple(units), self.marginal(where))

    def names_of(self, where: Where) -> list[str]:
        """(k,) names of the scalars within `where`, in the order of `marginal`."""
        return [self.names[k] for k in self._scalars(where)]

    @public
    def cross(self, a: Where, b: Where) -> Floats:
        """(k, l) covariance between the scalars of `a` and those of `b`."""
        return self._block(self._scalars(a), self._scalars(b))

    @public
    def conditional(self, a: Where, given: Where | None = None) -> Floats:
        """(k, k) covariance of `a` given `given`; None: given all other parameters.

        ``C_aa - C_ab C_bb^-1 C_ba``. The difference from the marginal is the part of the
        uncertainty of `a` that is due to `given`.
        """
        mine = self._scalars(a)
        if given is None and self._problem.layout.required:
            every = self.matrix
            rest = np.setdiff1d(np.arange(len(self.names)), mine)
            back = np.linalg.pinv(every[np.ix_(rest, rest)], hermitian=True)
            cross = every[np.ix_(mine, rest)]
            exact: Floats = every[np.ix_(mine, mine)] - cross @ back @ cross.T
            return exact
        if given is None:
            unit = self._equations.scale[self._equations.free][mine]
            scaled = self._equations.matrix[mine][:, mine].toarray()
            found: Floats = np.linalg.inv(scaled) * unit[:, None] * unit[None, :]
            return found * self.factor
        known = self._scalars(given)
        if set(mine.tolist()) & set(known.tolist()):
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{_shown(a)}` cannot be conditioned on `{_shown(given)}`: they overlap",
                    origin="covariance",
                    help=("condition on other parameters",),
                )
            )
        both = self._block(np.concatenate([mine, known]), np.concatenate([mine, known]))
        k = len(mine)
        return both[:k, :k] - both[:k, k:] @ np.linalg.solve(both[k:, k:], both[k:, :k])

    @public
    def relative(self, a: Where, b: Where) -> Floats:
        """(k, k) covariance of the difference a - b: ``C_aa - C_ab - C_ba + C_bb``.

        For the scalars with the same name in both (``pos.x``): a landmark relative to a pose is the
        difference of their positions. Common uncertainty, such as the position of the whole map,
        cancels. Fixed, frozen and bound parameters are exact: their variances and covariances are
        zero.
        """
        of_a, of_b = self._members(a), self._members(b)
        common = [name for name in of_a if name in of_b]
        if not common:
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{_shown(a)}` and `{_shown(b)}` have no parameter of the same name",
                    origin="covariance",
                    notes=(f"they have {', '.join(of_a)} and {', '.join(of_b)}",),
                )
            )
        i = np.array([of_a[name] for name in common])
        j = np.array([of_b[name] for name in common])
        cross = self._with_exact(i, j)
        return self._with_exact(i, i) - cross - cross.T + self._with_exact(j, j)

    def ellipsoid(self, where: Where, relative_to: Where | None = None) -> tuple[Floats, Floats]:
        """One-sigma ellipsoid of `where`, or of its difference from `relative_to`.

        Returns
        -------
        semi_axes : (k,) descending, in the unit of the parameter
        directions : (k, k) unit vectors along them as columns
        """
        if relative_to is None:
            return ellipsoid(self.marginal(where))
        return ellipsoid(self.relative(where, relative_to))

    def __repr__(self) -> str:
        held = f", {len(self.on_bound)} more on bounds" if self.on_bound else ""
        return f"<Covariance of {len(self.names)} parameters{held}>"

    def _sheet(self) -> Sheet:
        count = len(self.names)
        head, rows = ["parameter", "standard error", "unit"], []
        if count <= MOST_SHOWN:
            spread = [measured(None, sigma)[1] for sigma in self.sigma().tolist()]
            columns = [self.names, spread, self.units]
            if 1 < count <= MOST_CORRELATED:
                head += self.names
                columns += [[f"{rho:.3f}" for rho in row] for row in self.correlation()]
            rows = list(zip(*columns, strict=True))
        notes = [f"{name} is on {text}" for name, text in self.on_bound.items()]
        return Sheet(repr(self).strip("<>"), head, rows, notes)

    # --- entries -------------------------------------------------------------------------------

    def _base(self, right: Floats) -> Floats:
        """(n, k) product with the covariance of the sparse system, whose held scalars are exact."""
        equations = self._equations
        unit = (equations.scale * self._moves)[:, None]
        whole = np.zeros((self._problem.size, right.shape[1]))
        whole[equations.free] = right
        found: Floats = (np.asarray(self._solver.solved(whole * unit)) * unit)[equations.free]
        return found

    def _solve(self, right: Floats) -> Floats:
        found = self._base(right)
        if self._datum is not None:
            found = found + self._datum.left @ (self._datum.right.T @ right)
        return found * self.factor

    def _block(self, a: Ints, b: Ints) -> Floats:
        if "matrix" in self.__dict__:
            return self.matrix[np.ix_(a, b)]
        missing = [int(i) for i in b if int(i) not in self._columns]
        if missing:
            unit = np.zeros((len(self.names), len(missing)))
            unit[missing, np.arange(len(missing))] = 1
            solved = self._solve(unit)
            if len(self._columns) + len(missing) > _KEPT:
                kept = {int(i): self._columns[int(i)] for i in b if int(i) in self._columns}
                self._columns = kept
            self._columns |= {i: solved[:, k] for k, i in enumerate(missing)}
        return np.stack([self._columns[int(i)][a] for i in b], axis=1)

    def _with_exact(self, a: Ints, b: Ints) -> Floats:
        """`_block` with zeros for the number -1, an exact parameter."""
        found = np.zeros((len(a), len(b)))
        i, j = np.flatnonzero(a >= 0), np.flatnonzero(b >= 0)
        if len(i) and len(j):
            found[np.ix_(i, j)] = self._block(a[i], b[j])
        return found

    def _members(self, where: Where) -> dict[str, int]:
        """Names within `where` of all its scalars, and their columns; -1 for exact ones."""
        name = self._name(where)
        names = scalar_names_within(self._problem, name)
        if not names:
            return self._local_names(where)  # refuses it
        head = f"{name}." if name else ""
        return {
            full.removeprefix(head) if full != name else "": self._number.get(full, -1)
            for full in names
        }

    def _name(self, where: Where) -> str:
        if isinstance(where, str):
            return where
        if isinstance(where, tuple):
            if (
                len(where) != 2
                or not isinstance(where[0], str)
                or not isinstance(where[1], int | np.integer)
            ):
                raise _no_place(where)
            path, row = where
        elif not hasattr(where, "_handle"):
            if not hasattr(where, "_store"):
                raise _no_place(where)
            return ""  # the model: its root
        else:
            path, row = where._table.layout.path, where._table.row_of(where._handle)
        return str(self._problem.store.tables[path].row_name(row)) if path else ""

    def _scalars(self, where: Where) -> Ints:
        if isinstance(where, list):
            every = [self._scalars(one) for one in where]
            if not every:
                raise _no_place(where)
            joined = np.concatenate(every)
            if len(set(joined.tolist())) < len(joined):
                raise AraelError(
                    Diagnostic(
                        "E1009",
                        f"{_shown(where)} name a parameter twice",
                        origin="covariance",
                        help=("leave out what another entry contains",),
                    )
                )
            return joined
        return np.array(list(self._local_names(where).values()), dtype=np.int64)

    def _scalars_of_row(self, where: Where) -> Ints | None:
        """Scalars of the system in a row, by its ref or (path, row); None if it takes names."""
        if hasattr(where, "_handle"):
            path, row = where._table.layout.path, int(where._table.row_of(where._handle))
        elif isinstance(where, tuple) and [type(one) for one in where] == [str, int]:
            path, row = where
        else:
            return None
        system = self._problem.structure.system
        found = []
        for entity, blocks in zip(system.layout.entities, system.blocks, strict=True):
            if entity.table.startswith(f"{path}."):
                return None  # rows within the row
            if entity.table == path and 0 <= row < len(blocks.first) and blocks.first[row] >= 0:
                free = np.flatnonzero(blocks.free[row])
                found.append(blocks.first[row] + free)
        every = np.concatenate(found) if path and found else np.zeros(0, dtype=np.int64)
        return every if len(every) else None

    def _local_names(self, where: Where) -> dict[str, int]:
        """Names within `where` of its scalars, and their columns."""
        name = self._name(where)
        if not name:
            entities = self._problem.layout.entities
            own = {e.prefix + t for e in entities if not e.table for t in e.tangent_names}
            found = {n: i for n, i in self._number.items() if n in own}
        elif name in self._number:
            found = {"": self._number[name]}
        else:
            head = f"{name}."
            found = {n[len(head) :]: i for n, i in self._number.items() if n.startswith(head)}
        if not found:  # the components of a vector of more than three numbers: k[0], k[1], ...
            found = {
                n[len(name) :]: i
                for n, i in self._number.items()
                if n.startswith(f"{name}[") and _INDEX.fullmatch(n, len(name))
            }
        if not found:
            bounds = [
                f"`{full}` is on {text}"
                for full, text in self.on_bound.items()
                if full == name or full.startswith(f"{name}.")
            ]
            raise AraelError(
                Diagnostic(
                    "E1009",
                    f"`{name}` is not solved for, so it has no covariance",
                    origin="covariance",
                    notes=tuple(bounds),
                    help=("it is fixed, frozen or absent, or the name is misspelt",)
                    if not bounds
                    else ("a parameter on an active bound is exact; widen the bound to free it",),
                )
            )
        return found

    def _entity(self, path: str) -> tuple[Any, Ints, Ints]:
        """The entity at a path, the first scalar of its rows, and the requested tangents."""
        if not isinstance(path, str):
            raise _no_place(path)
        layout = self._problem.layout
        for number, entity in enumerate(layout.entities):
            first = self._problem.structure.system.blocks[number].first
            place = f"{entity.table}.{entity.prefix}" if entity.table else entity.prefix
            if path == place.rstrip("."):
                return entity, first, np.arange(entity.tangent)
            meant: list[int] = []
            for use in entity.params:
                full = f"{entity.table}.{use.column}" if entity.table else use.column
                if path == full or full.startswith(f"{path}."):
                    meant += range(use.tangent_start, use.tangent_start + use.tangent)
            if meant:
                return entity, first, np.array(meant)
        known = [f"{e.table}.{e.prefix}".rstrip(".") for e in layout.entities if e.table]
        raise AraelError(
            Diagnostic(
                "E1009",
                f"`{path}` holds no parameters, so it has no covariance",
                origin="covariance",
                help=(f"there are {', '.join(known)}",) if known else (),
            )
        )


def _no_place(where: object) -> AraelError:
    expected = "a row, the model, the name of a field, or a list of them"
    return wrong_argument("covariance", "where", expected, where, "write `model.poses[3]`")


def _no_datum(where: Where, chosen: Ints, directions: list[FreeDirection]) -> Diagnostic:
    if not directions:
        return Diagnostic(
            "E1009",
            "this covariance has no free directions, so it does not depend on a datum",
            origin="covariance",
            help=('take `covariance(gauge="free")` of a model without fixed coordinates',),
        )
    return Diagnostic(
        "E1009",
        f"{_shown(where)} ({len(chosen)} scalars) determine{'s' * (not isinstance(where, list))} "
        f"not all of the {len(directions)} free directions",
        origin="covariance",
        notes=tuple(f"free direction: {one.words}" for one in directions),
        help=("name parameters that all of them move",),
    )


def covariance(problem: Problem, scale: str = "known", gauge: str = "fixed") -> Covariance:
    """Covariance of all free scalars; see `Covariance`."""
    return Covariance(problem, scale, gauge)


def check_scale(scale: str) -> None:
    """Raise E1035 unless `scale` is one of `SCALES`."""
    if not isinstance(scale, str) or scale not in SCALES:
        raise AraelError(
            Diagnostic(
                "E1035",
                f"unknown scale {scale!r:.40}",
                origin="covariance",
                help=('write `"known"` for whitened residuals, `"residual"` for others',),
            )
        )


def residual_variance(problem: Problem, parameters: int) -> float:
    """Variance of a residual, from the scatter of all."""
    table = cost_table(problem)
    count = sum(table.residuals.values())
    if count <= parameters:
        raise AraelError(
            Diagnostic(
                "E1035",
                f"{count} residuals and {parameters} parameters: the scatter of the residuals is "
                "not known",
                origin="covariance",
                help=("add measurements, or whiten the residuals by known standard deviations",),
            )
        )
    return float(table.total / (count - parameters))


def _shown(where: Where) -> str:
    if isinstance(where, list):
        return ", ".join(f"`{_shown(one)}`" for one in where)
    return where if isinstance(where, str) else str(getattr(where, "name", where))
