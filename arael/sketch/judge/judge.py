"""The judge: what is free, redundant, impossible, and why."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import surely_independent
from arael.sketch.judge.conflicts import conflict, joints, smallest
from arael.sketch.judge.motions import Motion, Part, motions
from arael.sketch.judge.proof import proven, pulling
from arael.sketch.judge.rank import Rank
from arael.sketch.layout.layout import Layout, Linearisation
from arael.sketch.solve.breaking import broken_off
from arael.sketch.solve.solver import Solver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

Kind = Literal["helps", "partly", "redundant", "impossible", "here", "side"]

#: A residual above this part of the sketch's size is not rounding.
_OPEN = 1e-7
#: How far (of the size) geometry is moved to see whether a dependency is one of position only.
_NUDGE = 1e-3
#: Residuals that change by more than this part of the size on the way there do not follow.
_CHANGED = 1e-8
#: Members of a dependency have at least this part of its largest weight.
_MEMBER = 1e-7


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a constraint or dimension would do.

    Attributes
    ----------
    name : of it
    kind : ``helps``: takes a degree of freedom; ``partly``: fewer than it could; ``redundant``:
        follows from others; ``impossible``: contradicts others; ``here``: takes none, or fewer, in
        this position, but more when the geometry is moved a little; ``side``: its equations follow
        from others, which keep it on the other side: half a turn away
    members : what it depends on, itself among them: leaving any of them out makes room
    freedoms : how many degrees of freedom it takes
    most : how many it could take
    """

    name: str
    kind: Kind
    members: tuple[str, ...] = ()
    freedoms: int = 0
    most: int = 0


@dataclass(frozen=True, slots=True)
class Freedoms:
    """Degrees of freedom left.

    Attributes
    ----------
    total : of the sketch
    by_entity : how many independent ways each entity can move; 0: fully defined
    moves : for every number of the document whether it can move
    redundant : names of constraints and dimensions that hold nothing new
    safe : by how many times the smallest value taken for nonzero is above the largest taken for 0
    """

    total: int
    by_entity: dict[str, int]
    moves: NDArray[np.bool_]
    redundant: tuple[str, ...]
    safe: float


class Judge:
    """Verdicts on a sketch as it is laid out.

    Parameters
    ----------
    layout : of the document that is judged
    solver : for what has to be tried
    """

    def __init__(self, layout: Layout, solver: Solver) -> None:
        self.layout = layout
        self.document = layout.document
        self.solver = solver
        self._kept: tuple[int, Floats, Linearisation, Rank] | None = None

    def _rank(self, system: Linearisation, last: Ints | None = None) -> Rank:
        """The factor of a system, with directions of ellipses scaled to lengths."""
        layout = self.layout
        scale = np.ones(len(system.x))
        turned = np.isin(layout.unknowns[: len(scale)], layout.angles)
        if turned.any():
            at = np.searchsorted(layout.angles, layout.unknowns[: len(scale)][turned])
            scale[turned] = 1.0 / layout.levers[at]
        far = float(np.abs(self.document.values).max(initial=0.0))
        self._look()
        return Rank(system, last, scale, far / layout.size, self.solver.interruption)

    def _look(self) -> None:
        """Raise E1235 if what is judged for is to be broken off."""
        if self.solver.interrupted:
            raise broken_off()

    # --- verdicts ---------------------------------------------------------------------------

    def verdict(self, name: str) -> Verdict:
        """What a constraint or dimension does that is in the document, before it is solved."""
        return self.verdicts([name])[0]

    def verdicts(self, names: Sequence[str]) -> list[Verdict]:
        """Verdicts on several, each given everything that is not after it in `names`."""
        self.layout.gather()
        own = [self.layout.first_rows(name) for name in names]
        if all(own) and self._surely_help([row for one in own for row in one], of=names):
            return [
                Verdict(name, "helps", freedoms=len(one))
                for name, one in zip(names, own, strict=True)
            ]
        system = self.layout.linearisation()
        rows = [self.layout.rows_of(name) for name in names]
        rank = self._rank(system, np.concatenate([*rows, np.zeros(0, dtype=np.int64)]))
        return [
            self._blamed(
                self._one(name, own, system, rank) if len(own) else self._without_rows(name)
            )
            for name, own in zip(names, rows, strict=True)
        ]

    def _blamed(self, verdict: Verdict) -> Verdict:
        """With the joints that are to blame, where no equation is."""
        name = verdict.name
        if verdict.kind not in ("redundant", "impossible") or {*verdict.members} - {name}:
            return verdict

        def takes_freedom() -> bool:
            rows = self.layout.rows_of(name)
            rank = self._rank(self.layout.linearisation(), rows)
            return not all(rank.is_dependent(int(row)) for row in rows)

        if verdict.kind == "redundant":
            found = joints(self.layout, [name], takes_freedom)
        else:
            found = joints(self.layout, [name], lambda: self.solver.feasible([name]))
        self._look()
        return replace(verdict, members=(*found, name))

    def _surely_help(
        self,
        rows: Sequence[int],
        more: Sequence[tuple[Any, Any]] = (),
        of: Sequence[str] = (),
    ) -> bool:
        """Whether a few unknowns around some equations prove that they are independent.

        The factor of the whole sketch gives the same answer, in time that grows with the sketch.

        Parameters
        ----------
        rows : of the layout
        more : indices in the layout's `x` and entries of equations that it does not have
        of : records of these
        """
        layout = self.layout
        part = layout.part(of)
        if part is not None:
            return surely_independent(
                part.rows,
                part.gather(),
                part.local(rows),
                layout.equations[part.rows.row_of],
                more=[(np.searchsorted(part.columns, at), weights) for at, weights in more],
            )
        scales = None
        x = layout.gather()
        if len(layout.angles):
            scales = np.ones(len(x))
            scales[layout.angles] = 1.0 / layout.levers
        return surely_independent(layout.rows, x, rows, layout.equations, more=more, scales=scales)

    def _without_rows(self, name: str) -> Verdict:
        """Of a relation that has no equations: one of points, or one that does not act."""
        if name in self.layout.impossible:
            return Verdict(name, "impossible", (*self.layout.rivals(name), name))
        if name in self.layout.spare:
            return Verdict(name, "redundant", self.layout.tie_members(name))
        return Verdict(name, "helps")

    def _present(self) -> tuple[Linearisation, Rank]:
        """The factor of the whole sketch as it is, kept while nothing changes."""
        layout = self.layout
        here = layout.gather()
        kept = self._kept
        if kept is None or kept[0] != layout.version or not np.array_equal(kept[1], here):
            system = layout.linearisation()
            kept = self._kept = (layout.version, here.copy(), system, self._rank(system))
        return kept[2], kept[3]

    def tie_verdict(self, name: str, a: int, b: int) -> Verdict:
        """What making two points one would do, before it is done.

        Parameters
        ----------
        name : that the relation will have
        a, b : offsets of the x of the points in the document's values
        """
        layout, values = self.layout, self.document.values
        layout.refresh()
        if layout.same(a, b):
            return Verdict(name, "redundant", (*layout.places.between(a, b), name))
        gaps = (float(values[a] - values[b]), float(values[a + 1] - values[b + 1]))
        return self._of_points(name, ((a, 1.0), (b, -1.0)), gaps)

    def lock_verdict(self, name: str, at: int, place: Sequence[float]) -> Verdict:
        """What holding a point at a place would do, before it is done."""
        values = self.document.values
        gaps = (float(values[at] - place[0]), float(values[at + 1] - place[1]))
        return self._of_points(name, ((at, 1.0),), gaps)

    def _of_points(
        self, name: str, points: Sequence[tuple[int, float]], gaps: Sequence[float]
    ) -> Verdict:
        """Of two equations: the weighted sum of points, in x and y, is to change by -gaps."""
        layout = self.layout
        layout.refresh()
        more = []
        of = [layout.entity_at(at) for at, _ in points]
        for k in range(len(gaps)):
            uses = [(layout.use_of(at + k), weight) for at, weight in points]
            unknown = [one for one in uses if one[0] >= 0]
            more.append(([at for at, _ in unknown], [weight for _, weight in unknown]))
        if all(at for at, _ in more) and self._surely_help((), more, of):
            return Verdict(name, "helps", freedoms=len(gaps))
        system, rank = self._present()
        gained, contradicts = 0, False
        members: dict[str, None] = {}
        for k, gap in enumerate(gaps):
            ends = [(int(layout.column_of[at + k]), weight) for at, weight in points]
            free = [(column, weight) for column, weight in ends if column >= 0]
            if free:
                columns = np.array([column for column, _ in free], dtype=np.int64)
                weights = np.array([weight for _, weight in free])
                rows, factors, left = rank.combination(columns, weights)
                if left > rank.tolerance:
                    gained += 1
                    continue
                gap -= float(factors @ system.residuals[rows])
                members |= self._weighty(system, rows, factors)
            for (at, _), (column, _) in zip(points, ends, strict=True):
                if column < 0:
                    members |= dict.fromkeys(layout.holders_at(at))
            contradicts |= abs(gap) > _OPEN * layout.size
        if gained == len(gaps):
            return Verdict(name, "helps", freedoms=gained)
        if contradicts and not self._gaps_are_kept(points, gaps):
            return Verdict(name, "helps", freedoms=gained)  # a solve has to show
        named = (*self._named(members), name)
        kind: Kind = "impossible" if contradicts else "partly" if gained else "redundant"
        return Verdict(name, kind, named, gained, len(gaps))

    def _gaps_are_kept(self, points: Sequence[tuple[int, float]], gaps: Sequence[float]) -> bool:
        """Whether one of the gaps of `_of_points` that is open is the same all around."""
        layout = self.layout
        if np.abs(layout.linearisation().residuals).max(initial=0.0) > _OPEN * layout.size:
            return False

        def change(k: int, x: Floats) -> Floats:
            values = layout.values_at(layout.with_unknowns(x)) - self.document.values
            return np.array([sum(weight * values[at + k] for at, weight in points)])

        none = np.zeros(0, dtype=np.int64)
        return any(
            abs(gap) > _OPEN * layout.size
            and self._is_kept(none, partial(change, k), np.zeros(1)) is True
            for k, gap in enumerate(gaps)
        )

    def _weighty(self, system: Linearisation, rows: Ints, weights: Floats) -> dict[str, None]:
        top = float(np.abs(weights).max(initial=0.0))
        return {
            system.owner(row): None
            for row, weight in zip(rows.tolist(), weights.tolist(), strict=True)
            if abs(weight) > _MEMBER * top
        }

    def _one(self, name: str, rows: Ints, system: Linearisation, rank: Rank) -> Verdict:
        dependent = [int(row) for row in rows if rank.is_dependent(int(row))]
        gained = len(rows) - len(dependent)
        if not dependent:
            return Verdict(name, "helps", freedoms=gained)
        members: dict[str, None] = {}
        contradicts = False
        for row in dependent:
            others, weights = rank.dependency(row)
            gap = system.residuals[row] - float(weights @ system.residuals[others])
            contradicts |= abs(gap) > _OPEN * self.layout.size
            members |= self._weighty(system, others, weights)
        members.pop(name, None)
        named = (*self._named(members), name)
        hidden = self.layout.hidden_numbers(name)  # a place along a spline: found along with it
        gained, most = gained - hidden, len(rows) - hidden
        held = self._held_nearby(system, dependent)
        if held is False:
            return Verdict(name, "here", named, gained, most)
        if contradicts:
            others = np.setdiff1d(np.arange(len(system.residuals)), rows)
            left = np.abs(system.residuals[others]).max(initial=0.0)
            if held is None or left > _OPEN * self.layout.size:
                # Derivatives prove it where all else holds, and around there: a solve has to show.
                return Verdict(name, "helps", named, gained, most)
            # Trials that fail for another reason than a contradiction prove nothing: the
            # equations depend on each other, so there are others.
            fewest = smallest(named, name, self.solver.feasible)
            self._look()
            return Verdict(name, "impossible", fewest if len(fewest) > 1 else named, gained, most)
        if not gained and self.layout.is_turned(name):
            return Verdict(name, "side", named, gained, most)
        return Verdict(name, "partly" if gained else "redundant", named, gained, most)

    def _named(self, members: dict[str, None]) -> list[str]:
        """Constraints and dimensions among the owners of rows; entities' own rows are not named."""
        document = self.document
        return [one for one in members if one in document.constraints or one in document.dimensions]

    def _held_nearby(self, system: Linearisation, dependent: Sequence[int]) -> bool | None:
        """Whether equations that follow from the others here do so elsewhere.

        Those that do not follow have another residual once the geometry is moved a little. All
        other equations hold there, also those of the same record: where it is not satisfied, its
        equations may be independent of what they follow from where it is. None: no place nearby
        was found, although something can move.
        """
        before = system.residuals[dependent]
        out = system.rows[dependent]
        return self._is_kept(
            out, lambda x: self.layout.linearisation(x).residuals[dependent], before
        )

    def _is_kept(self, out: Ints, of: Callable[[Floats], Floats], before: Floats) -> bool | None:
        """Whether lengths stay as they are where all but some rows hold, as of `_held_nearby`."""
        known = None
        for moved in self._nearby(out):
            known = True
            if np.abs(of(moved) - before).max(initial=0.0) > _CHANGED * self.layout.size:
                return False
        return known

    def _nearby(self, out: Ints) -> Iterator[Floats]:
        """Unknowns near to the present ones that solve all but some rows, up to three times.

        The sketch is nudged along its free directions, in three random ways, and solved again.
        Where nothing is free to move, that is where it is.

        Parameters
        ----------
        out : rows of the layout that are left out
        """
        start = self.layout.linearisation(without=out)
        basis = self._rank(start).null_basis()
        if basis.shape[1] == 0:
            yield start.x
            return
        random = np.random.default_rng(len(start.x))
        for _ in range(3):
            step = basis @ random.standard_normal(basis.shape[1])
            step *= _NUDGE * self.layout.size / (np.abs(step).max() or 1.0)
            moved = self.solver.solved_from(start.x + step, without=out)
            self._look()
            if moved is not None:
                yield moved

    def _independent_nearby(self, names: Sequence[str]) -> list[str]:
        """Names not all of whose rows are dependent, once the geometry without them is moved."""
        out = np.array([row for name in names for row in self.layout.first_rows(name)], np.int64)
        for moved in self._nearby(out):
            system = self.layout.linearisation(moved)
            rows = [self.layout.rows_of(name) for name in names]
            rank = self._rank(system, last=np.concatenate(rows))
            found = [
                name
                for name, own in zip(names, rows, strict=True)
                if not all(rank.is_dependent(int(row)) for row in own)
            ]
            if found:
                return found
        return []

    def conflict(self, cause: str = "") -> tuple[tuple[str, ...], bool]:
        """A smallest set of constraints and dimensions without a common solution; if it is proven.

        As `arael.sketch.judge.conflicts.conflict`. Without a proof none was found, that is all.
        """
        layout, solver = self.layout, self.solver
        members = conflict(layout, solver, cause)
        if not members:
            return (), False
        if layout.impossible.keys() & set(members) or proven(solver, members):
            return members, True
        others = pulling(solver, layout.connected(cause or members[-1]))
        if cause and others:  # without it all held
            others = (*(name for name in others if name != cause), cause)
        if others and proven(solver, others):
            return others, True
        return members, False

    def standing(self, redundant: Sequence[str], seconds: float = 0.5) -> list[Verdict]:
        """What is wrong with the sketch as it is: what is ``impossible``, ``redundant``, ``here``.

        Edits are refused before they contradict; contradictions come with files that were written
        or changed elsewhere. One is reported for each connected part, with its members. What is
        ``partly`` redundant holds something and is left out. Members of what is redundant are
        known by `verdicts`.

        Parameters
        ----------
        redundant : names that `freedoms` found
        seconds : for the search of smallest contradictions; after that the equations that do not
            hold are named instead
        """
        found = [
            Verdict(name, "impossible", members)
            for members in self._contradictions(seconds)
            for name in members
        ]
        self._look()  # trials that were broken off prove nothing
        known = {one.name for one in found}
        names = [name for name in redundant if name not in known]
        if not names:
            return found
        system = self.layout.linearisation()
        rows = [self.layout.rows_of(name) for name in names]
        rank = self._rank(system, np.concatenate(rows))
        kinds: dict[str, Kind] = {}
        for name, own in zip(names, rows, strict=True):
            if all(rank.is_dependent(int(row)) for row in own):  # true of ties: they have none
                kinds[name] = "redundant"
        equations = [name for name in kinds if len(self.layout.rows_of(name))]
        # More can move without all of them than without one: what is dependent then as well is
        # not so by position only, and need not be looked at by itself.
        for name in self._independent_nearby(equations) if equations else ():
            if self._held_nearby(system, self.layout.rows_of(name).tolist()) is False:
                kinds[name] = "here"
        return found + [Verdict(name, kind) for name, kind in kinds.items()]

    def _contradictions(self, seconds: float) -> list[tuple[str, ...]]:
        """Sets of constraints and dimensions that cannot hold together, without common members."""
        layout = self.layout
        if layout.impossible:  # no trial can be solved
            together: dict[str, None] = {}
            for name in layout.impossible:
                together |= dict.fromkeys((*layout.rivals(name), name))
            return [tuple(together)]
        found: list[tuple[str, ...]] = []
        until = time.monotonic() + seconds
        looked_at: set[str] = set()
        for name in self.solver.left_open():
            self._look()
            if name in looked_at:
                continue
            part = self._named(dict.fromkeys(layout.connected(name) or (name,)))
            looked_at.update(part)
            if time.monotonic() > until:
                found.append((name,))
            elif not self.solver.feasible(part):
                fewest = smallest(part, "", self.solver.feasible, until)
                found.append((name,) if time.monotonic() > until else fewest)
        return found

    # --- freedoms ---------------------------------------------------------------------------

    def freedoms(self) -> Freedoms:
        """Degrees of freedom of the sketch and of its entities."""
        system = self.layout.linearisation()
        rank = self._rank(system)
        names = list(self.document.entities)
        counts = rank.freedoms_of(self._columns(system))
        redundant = dict.fromkeys(sorted(self.layout.spare))
        follow = Counter(system.owner(row) for row in rank.dependent)
        for name, count in follow.items():
            # What keeps an independent equation holds something.
            if count == len(self.layout.rows_of(name)):
                redundant[name] = None
        return Freedoms(
            rank.free,
            dict(zip(names, counts, strict=True)),
            np.append(rank.moving(), False)[self.layout.column_of[:-1]],
            tuple(self._named(redundant)),
            rank.gap,
        )

    def free(self) -> list[Motion]:
        """What still moves, in words; as many motions as there are degrees of freedom."""
        system = self.layout.linearisation()
        rank = self._rank(system)
        found: list[Motion] = []
        for columns, basis in rank.parts(self._columns(system)):
            inside = np.full(len(system.x) + 1, -1, dtype=np.int64)
            inside[columns] = np.arange(len(columns))
            local = inside[self.layout.column_of]  # the last element, -1, for what is fixed
            entities = tuple(
                entity.name
                for entity in self.document.entities.values()
                if (local[entity.at : entity.at + entity.size] >= 0).any()
            )
            found += motions(self.document, Part(entities, local, basis))
        return found

    def _columns(self, system: Linearisation) -> list[Ints]:
        """Columns of every entity that are not fixed."""
        found = []
        for entity in self.document.entities.values():
            columns = self.layout.column_of[entity.at : entity.at + entity.size]
            found.append(np.unique(columns[columns >= 0]))
        return found

    def why(self, name: str) -> tuple[str, ...]:
        """Constraints and dimensions that act on an entity, or on one of its points."""
        system = self.layout.linearisation()
        entity_name, _, point = name.partition(".")
        entity = self.document.entity(entity_name)
        at, size = (self.document.point_at(name), 2) if point else (entity.at, entity.size)
        columns = np.unique(self.layout.column_of[at : at + size])
        near = np.isin(system.indices, columns[columns >= 0])
        row_of = np.repeat(np.arange(len(system.residuals)), np.diff(system.indptr))
        touching = {system.owner(row): None for row in np.unique(row_of[near])}
        for one in self.document.constraints.values():
            if any(name in (arg, arg.partition(".")[0]) for arg in one.args):
                touching[one.name] = None
        return tuple(self._named(touching))

    def sensitivity(self, dimension: str) -> dict[str, float]:
        """How far each entity moves per unit of a dimension: its fastest number.

        By the least motion that follows the dimension and keeps everything else.
        """
        system = self.layout.linearisation()
        rows = self.layout.rows_of(dimension)
        rank = self._rank(system, last=rows)
        right = np.zeros(len(system.residuals))
        right[rows] = -self.layout.unit_of(dimension)
        step = rank.least_norm(right)
        moved = {}
        for entity, columns in zip(
            self.document.entities.values(), self._columns(system), strict=True
        ):
            if len(columns):
                moved[entity.name] = float(np.abs(step[columns]).max())
        return moved
