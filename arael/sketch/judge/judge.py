"""The judge: what is free, redundant, impossible, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.sketch.judge.motions import Motion, Part, motions
from arael.sketch.judge.rank import Rank
from arael.sketch.layout.layout import Layout, Linearisation
from arael.sketch.solve.solver import Solver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

Kind = Literal["helps", "partly", "redundant", "impossible", "here"]

#: A residual above this part of the sketch's size is not rounding.
_OPEN = 1e-7
#: How far (of the size) geometry is moved to see whether a dependency is one of position only.
_NUDGE = 1e-3
#: Members of a dependency have at least this part of its largest weight.
_MEMBER = 1e-7


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a constraint or dimension would do.

    Attributes
    ----------
    name : of it
    kind : ``helps``: takes a degree of freedom; ``partly``: fewer than it could; ``redundant``:
        follows from others; ``impossible``: contradicts others; ``here``: takes none in this
        position, but does when the geometry is moved a little
    members : what it depends on, itself among them: leaving any of them out makes room
    freedoms : how many degrees of freedom it takes
    """

    name: str
    kind: Kind
    members: tuple[str, ...] = ()
    freedoms: int = 0


@dataclass(frozen=True, slots=True)
class Freedoms:
    """Degrees of freedom left.

    Attributes
    ----------
    total : of the sketch
    by_entity : how many independent ways each entity can move; 0: fully defined
    redundant : names of constraints and dimensions that hold nothing new
    safe : by how many times the smallest value taken for nonzero is above the largest taken for 0
    """

    total: int
    by_entity: dict[str, int]
    redundant: tuple[str, ...]
    safe: float


class Judge:
    """Verdicts on a sketch as it is laid out.

    Parameters
    ----------
    layout : of the document that is judged
    solver : for what has to be tried: contradictions, positions that are not special
    """

    def __init__(self, layout: Layout, solver: Solver) -> None:
        self.layout = layout
        self.solver = solver
        self.document = layout.document

    # --- verdicts ---------------------------------------------------------------------------

    def verdict(self, name: str) -> Verdict:
        """What a constraint or dimension does that is in the document, before it is solved."""
        return self.verdicts([name])[0]

    def verdicts(self, names: Sequence[str]) -> list[Verdict]:
        """Verdicts on several, each given everything that is not after it in `names`."""
        spare = self.layout.spare
        system = self.layout.linearisation()
        rows = {name: np.asarray(self.layout.rows_of(name), dtype=np.int64) for name in names}
        new = np.concatenate([*rows.values(), np.zeros(0, dtype=np.int64)])
        if not len(new):
            return [self._alias_verdict(name, spare) for name in names]
        rank = Rank(system, last=new)
        found = []
        for name in names:
            if not len(rows[name]):
                found.append(self._alias_verdict(name, spare))
                continue
            found.append(self._one(name, rows[name], system, rank))
        return found

    def _alias_verdict(self, name: str, spare: set[str]) -> Verdict:
        """Of a relation that has no rows: a tie of points, or something that does not act."""
        if name in spare:
            return Verdict(name, "redundant", self.layout.tie_members(name))
        return Verdict(name, "helps")

    def _one(self, name: str, rows: Ints, system: Linearisation, rank: Rank) -> Verdict:
        dependent = [int(row) for row in rows if rank.is_dependent(int(row))]
        gained = len(rows) - len(dependent)
        if not dependent:
            return Verdict(name, "helps", freedoms=gained)
        members: dict[str, None] = {}
        size = self.layout.size
        contradicts = False
        for row in dependent:
            others, weights = rank.dependency(row)
            gap = system.residuals[row] - float(weights @ system.residuals[others])
            contradicts |= abs(gap) > _OPEN * size
            top = float(np.abs(weights).max(initial=0.0))
            for other, weight in zip(others.tolist(), weights.tolist(), strict=True):
                if abs(weight) > _MEMBER * top:
                    members[system.owners[other]] = None
        members.pop(name, None)
        named = (*self._named(members), name)
        if self._only_here(name, len(dependent)):
            return Verdict(name, "here", named, gained)
        if contradicts:
            return Verdict(name, "impossible", named, gained)
        return Verdict(name, "partly" if gained else "redundant", named, gained)

    def _named(self, members: dict[str, None]) -> list[str]:
        """Constraints and dimensions among the owners of rows; entities' own rows are not named."""
        document = self.document
        return [one for one in members if one in document.constraints or one in document.dimensions]

    def _only_here(self, name: str, dependent: int) -> bool:
        """Whether the rows are independent once the geometry is moved a little.

        The sketch without `name` is nudged along its free directions, in three random ways, and
        solved again.
        """
        start = self.layout.linearisation(without=name)
        basis = Rank(start).null_basis()
        if basis.shape[1] == 0:
            return False
        random = np.random.default_rng(len(start.x))
        for _ in range(3):
            step = basis @ random.standard_normal(basis.shape[1])
            step *= _NUDGE * self.layout.size / (np.abs(step).max() or 1.0)
            x = self.solver.solved_from(start.x + step, without=name)
            if x is None:
                continue
            system = self.layout.linearisation(x)
            rows = np.asarray(self.layout.rows_of(name), dtype=np.int64)
            rank = Rank(system, last=rows)
            if sum(rank.is_dependent(int(row)) for row in rows) < dependent:
                return True
        return False

    def conflict(self, cause: str = "") -> tuple[str, ...]:
        """A smallest set of constraints and dimensions that cannot hold together.

        Each member is proven by leaving it out: the others can be solved then. Empty if all can
        be solved together after all.

        Parameters
        ----------
        cause : a member for sure, if it is one: what was changed last
        """
        names = self.solver.open_candidates(cause)
        if self.solver.feasible(names):
            names = self.layout.connected(cause)
            if self.solver.feasible(names):
                return ()
        kept = [name for name in names if name != cause]
        if cause:
            kept.append(cause)
        # From the oldest to the newest, so that what was changed last stays.
        for name in list(kept):
            rest = [one for one in kept if one != name]
            if not self.solver.feasible(rest):
                kept = rest
        return tuple(kept)

    # --- freedoms ---------------------------------------------------------------------------

    def freedoms(self) -> Freedoms:
        """Degrees of freedom of the sketch and of its entities."""
        system = self.layout.linearisation(ranges=False)
        rank = Rank(system)
        names = list(self.document.entities)
        counts = rank.freedoms_of(self._columns())
        by_entity = dict(zip(names, counts, strict=True))
        redundant = dict.fromkeys(self.layout.spare)
        for row in rank.dependent:
            redundant[system.owners[row]] = None
        return Freedoms(rank.free, by_entity, tuple(self._named(redundant)), rank.gap)

    def free(self) -> list[Motion]:
        """What still moves, in words; as many motions as there are degrees of freedom."""
        system = self.layout.linearisation(ranges=False)
        rank = Rank(system)
        column_of = self.layout.column_of
        found: list[Motion] = []
        for columns, basis in rank.parts(self._columns()):
            inside = np.full(len(system.x) + 1, -1, dtype=np.int64)
            inside[columns] = np.arange(len(columns))
            local = inside[column_of]  # the last element, -1, for what is fixed
            entities = tuple(
                entity.name
                for entity in self.document.entities.values()
                if (local[entity.at : entity.at + entity.size] >= 0).any()
            )
            found += motions(self.document, Part(entities, local, basis))
        return found

    def _columns(self) -> list[Ints]:
        """Columns of every entity that are not fixed."""
        column_of = self.layout.column_of
        found = []
        for entity in self.document.entities.values():
            columns = column_of[entity.at : entity.at + entity.size]
            found.append(np.unique(columns[columns >= 0]))
        return found

    def why(self, name: str) -> tuple[str, ...]:
        """Constraints and dimensions that hold an entity, a point or one of its numbers.

        Those whose removal alone would give it freedom, then those that act on it.
        """
        columns = np.unique(self.layout.columns_of(name))
        columns = columns[columns >= 0]
        system = self.layout.linearisation()
        touching: dict[str, None] = {}
        near = np.isin(system.indices, columns)
        row_of = np.repeat(np.arange(len(system.owners)), np.diff(system.indptr))
        for row in np.unique(row_of[near]):
            touching[system.owners[row]] = None
        return tuple(self._named(touching))

    def sensitivity(self, dimension: str) -> dict[str, float]:
        """How far each entity moves per unit of a dimension: its fastest number.

        By the least motion that follows the dimension and keeps everything else.
        """
        system = self.layout.linearisation()
        rows = np.asarray(self.layout.rows_of(dimension), dtype=np.int64)
        residuals = np.zeros(len(system.residuals))
        residuals[rows] = -self.layout.unit_of(dimension)
        step = Rank(system).least_norm(residuals)
        column_of = self.layout.column_of
        moved = {}
        for entity in self.document.entities.values():
            columns = column_of[entity.at : entity.at + entity.size]
            columns = columns[columns >= 0]
            if len(columns):
                moved[entity.name] = float(np.abs(step[columns]).max())
        return moved
