"""Rank of a sketch's equations: a `RankQR` with what the judge asks of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.components import graph_components
from arael.runtime.compiled import Interruption
from arael.runtime.orthogonal import RankQR
from arael.sketch.layout.layout import Linearisation
from arael.sketch.solve.breaking import breakable, broken_off

if TYPE_CHECKING:
    from scipy.sparse import csc_array, csr_array

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: An entity moves in a direction if its part of a unit free direction is at least this long.
_MOVES = 1e-7
#: A pivot below this part of the greatest is doubtful: the errors of what is eliminated after it
#: are larger by its inverse, and rows that follow from others may be taken for independent ones.
_DOUBTFUL = 0.01
#: By how much at least the length up to which pivots are left out grows from trial to trial.
_COARSER = 10.0
#: Residuals are lengths that follow the geometry: an equation is about as long as this unless its
#: derivatives cancel out, those of a point on a line that it is an end of.
_SHORTEST = 0.5
#: So many roundings of the largest coordinate, relative to the size, are taken for zero.
_ROUNDINGS = 64.0
#: Numbers of free directions that are looked at together.
_MOST_NUMBERS = 1 << 22


class Rank:
    """The factor of one linearisation.

    Parameters
    ----------
    system : rows and columns
    last : rows that are called dependent rather than others
    scale : (n,) of the unknowns: 1 for lengths, 1 / size for angles; None: all lengths
    rounded : largest coordinate over the size of the drawing: far from the origin, directions are
        differences of rounded numbers
    interruption : a request to break off: E1235
    """

    def __init__(
        self,
        system: Linearisation,
        last: Ints | None = None,
        scale: Floats | None = None,
        rounded: float = 1.0,
        interruption: Interruption | None = None,
    ) -> None:
        self.system = system
        self._interruption = interruption if interruption is not None else Interruption()
        m, n = len(system.residuals), len(system.x)
        priority = np.zeros(m, dtype=np.int32)
        if last is not None:
            priority[last] = 1 + np.arange(len(last), dtype=np.int32)
        tolerance = None
        if _ROUNDINGS * rounded > 20 * (m + n):  # the tolerance of RankQR by itself
            tolerance = _ROUNDINGS * rounded * float(np.finfo(float).eps)
        self._scale = np.ones(n) if scale is None else scale
        with breakable():
            self.factor = self._factor(priority, tolerance)
            self._limit = float(self.factor.tolerance)
            if self.factor.smallest_kept < _DOUBTFUL:
                self.factor = self._without_doubtful(priority)
            self.dependent: list[int] = self.factor.dependent.tolist()
        self._dependent = frozenset(self.dependent)
        self._basis: csc_array | None = None

    def _factor(self, priority: NDArray[np.int32], tolerance: float | None) -> RankQR:
        system = self.system
        m, n = len(system.residuals), len(system.x)
        found = RankQR(m, n, system.indptr, system.indices, priority, tolerance, self._interruption)
        found.factor(system.entries, self._scale, shortest=_SHORTEST)
        return found

    def _without_doubtful(self, priority: NDArray[np.int32]) -> RankQR:
        """The factor without pivots that are small only because of the order of elimination.

        A row within 1e-9 of the span of those before it is a pivot of that length. What makes it
        follow exactly may come later, a row with a multiplier of 1e-9, and is then independent up
        to 1e-16 / 1e-9: far above the tolerance. So rows of small pivots are left out, of larger
        ones from trial to trial. Right is the last trial in which all rows that are left out follow
        from the others within the first factor's tolerance; if there is none, small pivots are
        those of nearly dependent equations, and count.
        """
        best = coarse = self.factor
        while coarse.smallest_kept < _DOUBTFUL:
            coarse = self._factor(priority, _COARSER * coarse.smallest_kept)
            if self._follow(coarse):
                best = coarse
        return best

    def _follow(self, factor: RankQR) -> bool:
        """Whether rows without a pivot follow from those with one."""
        system = self.system
        # After exchanges by priority, a row without a pivot may be one that others follow from.
        rows: set[int] = set()
        for row in factor.dependent.tolist():
            rows |= {row, *factor.dependency(row).equations.tolist()}
        for row in rows:
            self._look()
            part = slice(system.indptr[row], system.indptr[row + 1])
            found = factor.dependency_of(system.indices[part], system.entries[part])
            if found.remainder > self._limit:
                return False
        return True

    def _look(self) -> None:
        if self._interruption.requested:
            raise broken_off()

    @property
    def free(self) -> int:
        """Number of free directions."""
        return int(self.factor.nullity)

    @property
    def gap(self) -> float:
        """How safe the rank is: smallest length taken for nonzero over the largest taken for 0."""
        return float(self.factor.gap)

    def is_dependent(self, row: int) -> bool:
        """Whether a row follows from others."""
        return row in self._dependent

    def dependency(self, row: int) -> tuple[Ints, Floats]:
        """Rows that a dependent row follows from, and their weights."""
        found = self.factor.dependency(row)
        return found.equations.astype(np.int64), found.factors

    def combination(self, columns: Ints, values: Floats) -> tuple[Ints, Floats, float]:
        """Rows whose combination is nearest to a row, their weights, and what is left of it."""
        found = self.factor.dependency_of(columns.astype(np.int32), values)
        return found.equations.astype(np.int64), found.factors, float(found.remainder)

    @property
    def tolerance(self) -> float:
        """What may be left of a row that follows from others."""
        return self._limit

    def least_norm(self, right: Floats) -> Floats:
        """The least step with ``J step = right`` on the independent rows."""
        step: Floats = self.factor.least_norm(right)
        return step

    def null_basis(self) -> csc_array:
        """(n, f) free directions as sparse columns: most of a large sketch rests in each."""
        # imported here: start-up time
        from scipy.sparse import csc_array

        if self._basis is None:
            with breakable():
                found = self.factor.null_vectors()
            shape = (found.size, len(found))
            self._basis = csc_array((found.values, found.at, found.start), shape=shape)
        return self._basis

    def _velocities(self) -> csr_array:
        """(n, f) free directions, of unit length where angles count as lengths, at any size."""
        found = self.null_basis().tocsr()
        found.data = found.data / np.repeat(self._scale, np.diff(found.indptr))
        return found

    def moving(self) -> NDArray[np.bool_]:
        """(n,) whether each unknown moves in a free direction."""
        moves = np.zeros(len(self._scale), dtype=bool)
        if self.free:
            basis = self.null_basis()
            far = np.abs(basis.data) > _MOVES * self._scale[basis.indices]
            moves[basis.indices[far]] = True
        return moves

    def freedoms_of(self, groups: Sequence[Ints]) -> list[int]:
        """In how many independent ways each group of columns moves."""
        counts = [0] * len(groups)
        if not self.free:
            return counts
        basis, moves = self._velocities(), self.moving()
        by_size: dict[int, list[int]] = {}
        for i, columns in enumerate(groups):
            if moves[columns].any():
                by_size.setdefault(len(columns), []).append(i)
        for size, members in by_size.items():
            rows = basis[np.concatenate([groups[i] for i in members])].tocoo()
            group, own = np.divmod(rows.row.astype(np.int64), size)
            # the directions in which a group moves are numbered within it
            key, number = np.unique(group * self.free + rows.col, return_inverse=True)
            first = np.searchsorted(key, np.arange(len(members)) * self.free)
            within = number - first[group]
            width = int(within.max(initial=0)) + 1
            step = max(1, _MOST_NUMBERS // (size * width))
            for start in range(0, len(members), step):
                self._look()
                here = (group >= start) & (group < start + step)
                some = members[start : start + step]
                parts = np.zeros((len(some), size, width))
                parts[group[here] - start, own[here], within[here]] = rows.data[here]
                squares = np.linalg.eigvalsh(parts @ parts.transpose(0, 2, 1))
                for i, ways in zip(some, (squares > _MOVES**2).sum(axis=1), strict=True):
                    counts[i] = int(ways)
        return counts

    def parts(self, groups: Iterable[Ints]) -> Iterator[tuple[Ints, Floats]]:
        """Connected parts that can move: their columns, and their free directions.

        Parameters
        ----------
        groups : columns that belong together besides those of an equation: those of an entity
        """
        if not self.free:
            return
        number = self._part_of(groups)
        basis = self.null_basis()
        # Every free direction is within one part.
        home = number[basis.indices[basis.indptr[:-1]]]
        columns_of, directions_of = _members(number), _members(home)
        for part, directions in directions_of.items():
            columns = columns_of[part]
            yield columns, basis[:, directions].tocsr()[columns].toarray()

    def _part_of(self, groups: Iterable[Ints]) -> Ints:
        """Number of the part of every column."""
        system = self.system
        starts: list[Ints] = []
        ends: list[Ints] = []
        for a, b in zip(system.indptr[:-1].tolist(), system.indptr[1:].tolist(), strict=True):
            if b > a:
                starts.append(np.full(b - a, system.indices[a], dtype=np.int64))
                ends.append(system.indices[a:b].astype(np.int64))
        for columns in groups:
            if len(columns):
                starts.append(np.full(len(columns), columns[0]))
                ends.append(columns)
        one = np.concatenate([*starts, np.zeros(0, dtype=np.int64)])
        other = np.concatenate([*ends, np.zeros(0, dtype=np.int64)])
        return graph_components(len(system.x), one, other)


def _members(number: Ints) -> dict[int, Ints]:
    """Places of every number, ascending."""
    order = np.argsort(number, kind="stable")
    values, first = np.unique(number[order], return_index=True)
    return dict(zip(values.tolist(), np.split(order, first[1:]), strict=True))
