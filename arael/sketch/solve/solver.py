"""The solver of a sketch: levels, sides, continuation, what a failure leaves open."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.compiled import Interruption
from arael.runtime.levels.compiled import Levels
from arael.runtime.levels.follow import follow
from arael.sketch.document.records import Entity
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.part import Part
from arael.sketch.solve.extents import COLLAPSED, Extents
from arael.sketch.solve.outcome import Outcome
from arael.sketch.solve.search import Search
from arael.sketch.solve.tolerances import TOLERANCE, Tolerances
from arael.sketch.solve.turning import Turning
from arael.sketch.solve.turning_back import turned_back

Array = NDArray[np.float64]

#: How much cheaper it is to move a slack than the geometry.
SLACK_SCALE = 64.0
#: Equations that change by a smaller share of what moves hold nothing: they are as good as solved
#: wherever the geometry is, and what is left of their derivatives is rounding.
VANISHED = TOLERANCE
#: A value that changes by more than this share of itself, or by more radians, is approached.
FAR, FAR_TURN = 0.3, 1.0
#: A parameter of a spline's piece this near to 0 or 1 is at the end of the piece; where a solve
#: fails, this near.
AT_KNOT, NEAR_KNOT = 1e-9, 0.1
#: Pieces of splines that points may pass in one solve.
MOST_KNOTS = 8
#: An equation that a deletion leaves open is open by more than so many tolerances.
_BY_FAR = 1e3
#: The way to a new value is given up where no step this small succeeds.
SMALLEST_STEP = 1.0 / 256.0
#: The shortest part of a frame of a drag, and the longest in which lines may pass each other.
SMALLEST_PART, PASSING_PART = 1.0 / 512.0, 1.0 / 64.0
#: The part of a frame that is left out where points would leap; and by how many times the way of
#: the cursor they come nearer to it where they do not.
LEFT_OUT, MOST_GAIN = 1.0 / 16.0, 4.0


#: Unknowns of a search in a trial: a contradiction takes many trials.
MOST_IN_TRIAL = 24

#: Ends of solves that a search goes on from. Those that creep towards a side, or a singular state,
#: end at a number of steps.
_UNSOLVED = ("side", "stalled", "step_limit")

_NONE: Mapping[str, float] = MappingProxyType({})


class _Equations(NamedTuple):
    """What is solved together: all of a layout, or a part of it."""

    of: Layout | Part
    levels: Levels
    tolerances: Tolerances


class Solver:
    """Solves the equations of a layout and writes what it finds into the document.

    A failure leaves the document as it was. Factors and analyses are kept from solve to solve.

    Parameters
    ----------
    layout : of the document

    Attributes
    ----------
    layout
    levels : the solver by levels of the layout's rows
    interruption : requests to break off; also of those who judge
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._levels: Levels | None = None
        self._tolerances: Tolerances | None = None
        self._key: tuple[Any, ...] = ()
        self._version = -1
        self._levers = np.zeros(0)  # for which angles are scaled
        self._part: _Equations | None = None  # of the part that was solved last
        self._trial: tuple[tuple[int, bytes], Levels] | None = None
        self._extents: tuple[int, Extents] | None = None  # by the layout's `drawn`
        self.interruption = Interruption()
        self._question: object | None = None  # what is asked about the document, if it may end
        self._broken: object | None = None  # the step of undo or question that was to be broken off

    # --- breaking off -----------------------------------------------------------------------

    def interrupt(self) -> None:
        """Break off the document's transaction or the question in progress, from any thread.

        The solve or verdict at work ends before its next step, and all further ones of the
        transaction do not begin: nothing of them is written. Without a transaction or question
        nothing is broken off.
        """
        broken = self._work
        if broken is not None:
            self._broken = broken
            self.interruption.request()

    @property
    def _work(self) -> object | None:
        """What can be broken off; trials of a question are transactions of their own."""
        return self._question or self.layout.document.open_transaction

    @contextmanager
    def question(self) -> Iterator[None]:
        """What is asked, or done in several edits, can be broken off as a whole: E1235."""
        outer = self._question
        self._question = outer or object()
        try:
            yield
        finally:
            self._question = outer
            if outer is None:
                _ = self.interrupted  # withdraws a request that came for this question

    @property
    def interrupted(self) -> bool:
        """Whether the transaction or question in progress is to be broken off."""
        if not self.interruption.requested:
            return False
        if self._broken is self._work:
            return True
        # That has ended.
        self._broken = None
        self.interruption.withdraw()
        return False

    # --- after an edit ----------------------------------------------------------------------

    def solve(self, touched: Iterable[str] | None = None) -> Outcome:
        """Bring the geometry to where all equations hold.

        Components whose equations hold already keep their numbers bit by bit.

        Parameters
        ----------
        touched : not needed: what holds is recognised by its residuals
        """
        if self.interrupted:
            return Outcome("interrupted", fraction=0.0)
        alone = self._by_part()
        if alone is not None:
            return alone
        found, last = self._once()
        share = found.fraction
        moved: dict[str, None] = {}
        for _ in range(MOST_KNOTS):
            # A point on a spline has come to the end of a piece: on the next one it may go on.
            crossed = {} if found.solved or self.interrupted else self.layout.cross_knots()
            if not crossed:
                break
            moved |= dict.fromkeys(crossed)
            share = min(share + 2.0 * SMALLEST_STEP, 1.0)
            found, last = self._once(last, share, crossed)
            share += (1.0 - share) * found.fraction
        if found.solved:
            self.layout.settled()
        else:
            self.layout.cross_back(moved)
        if found.status in _UNSOLVED and not self.layout.impossible:
            return self.searched() or found
        return found

    def searched(self) -> Outcome | None:
        """A solution where the steps of least norm lead to none, written; None if none is found."""
        layout = self.layout
        x = layout.gather().copy()
        self.prepare(x)
        taken = layout.take_changes()
        found = Search(self, x).solution()
        if found is None:
            layout.return_changes(taken)
            return None
        outcome = self.written(found, Outcome("solved"))
        layout.renew_guards(found)  # places that were joined may have begun on another side
        layout.settled()
        return outcome

    def _by_part(self) -> Outcome | None:
        """Solve what hangs together with what changed; None, and nothing done, if that fails.

        All else holds already. Whatever is special about a solve is left to that of everything.
        """
        layout = self.layout
        part = None if layout.impossible else layout.part()
        if part is None:
            return None
        x = part.gather()
        if not (part.guards.evaluate(x) > 0.0).all():
            return None
        if self._part is None or self._part.of is not part:
            levels = self._new_levels(None, of=part)
            self._part = _Equations(part, levels, Tolerances(part))
        changes = layout.take_changes()
        found = None if changes else self._held(x, self._part)
        if found is None and all(map(part.changed, changes)):
            found = self._solved(x, changes, self._part)
            if found.solved:
                x = self._turned_back(part, part.gather(), x, changes)
        if found is None or not found.solved:
            layout.return_changes(changes)
            return None
        if layout.document.is_changing:
            moved = part.scatter(x)
        else:
            with layout.document.transaction("solve"):
                moved = part.scatter(x)
        layout.settled()
        return found.having_moved(moved)

    def guarded(self, x: Array, active: NDArray[np.bool_] | None = None) -> bool:
        """Solve in place on the sides of `x`, some rows or all; whether that is done."""
        return self._newton(x, active).solved

    def _once(
        self, last: Array | None = None, share: float = 0.0, crossed: Mapping[str, float] = _NONE
    ) -> tuple[Outcome, Array]:
        """Solve with the pieces of splines as they are; and where it ended, (n,).

        Parameters
        ----------
        last : where to go on, after a share of the way to changed values
        crossed : records whose piece of a spline is another one since, and their parameter
        """
        layout = self.layout
        x = layout.gather().copy()
        if last is not None and len(last) == len(x):
            x[:] = last
            for name, t in crossed.items():
                x[layout.hidden_at(name)] = t
        if layout.impossible:
            names = tuple(layout.impossible)
            return Outcome("stalled", row=names[0], open=names, fraction=0.0), x
        edited = self._version != layout.version
        self.prepare(x)
        layout.approach_turned(x)
        taken = layout.take_changes()
        changes = {key: (old + share * (new - old), new) for key, (old, new) in taken.items()}
        held = None if changes else self._held(x)
        if held is not None:
            return self.written(x, held), x
        start = x.copy()
        found = self._solved(x, changes)
        if found.status == "side" and found.guard in layout.document.entities:
            # Guards of arcs are those of when they were laid out.
            layout.renew_sides()
            x[:] = start
            found = self._solved(x, changes)
        if found.status == "side" and layout.differs(start):
            # Places that were joined begin far from where they were: curves may be turned inside
            # out at the start, and sides there are not those that are to be kept.
            x[:] = start
            refused, found = found, self._newton(x, guarded=False)
            # What was not joined has no reason to turn over.
            over = layout.turned_over(start, x) if found.solved else ""
            if over:
                found = replace(refused, guard=over)
        if not found.solved:
            layout.return_changes(taken)
            layout.note_parameters(x, NEAR_KNOT)
            return found, x
        x = self._turned_back(layout, start, x, changes)
        outcome = self.written(x, found)
        if edited:  # places that were joined may have begun on another side
            layout.renew_guards(x)
        return outcome, x

    def _solved(
        self,
        x: Array,
        changes: dict[tuple[str, int], tuple[float, float]],
        system: _Equations | None = None,
    ) -> Outcome:
        """Solve in place; values that are far from their old ones are approached.

        Parameters
        ----------
        system : a part; all equations without
        """
        layout = self.layout
        of, levels, tolerances = system or self._everything
        low, high = layout.bounds if of is layout else (None, None)

        def newton() -> Outcome:
            return self._newton(x, system=system)

        parts = layout.parts_of(changes, FAR, FAR_TURN)
        start = x.copy()
        if not parts:
            near = newton()
            if near.solved or not changes:
                return near
            x[:] = start
        elif of.rows.holds(x, tolerances.at(x)):
            return newton()  # the geometry was changed along with the values
        # The start solves the old values at most up to the tolerance, and what is new not at all.
        layout.set_share(changes, 0.0)
        before = newton()
        if not before.solved:
            layout.set_share(changes, 1.0)
            x[:] = start
            return newton()
        parts = max(parts, 1)
        part = 0

        def set_data(share: float) -> None:
            layout.set_share(changes, (part + share) / parts)

        def may_pass(guard: int) -> bool:
            # An arc may grow past half a turn, where the guard of its sweep changes its sign.
            return of.struct_of_guard(guard) == "SweepGuard"

        for part in range(parts):  # noqa: B007 - read by set_data
            found = follow(
                levels,
                x,
                set_data,
                tolerances.at(x),
                first=0.25 if parts == 1 else 1.0,
                least=SMALLEST_STEP,
                low=low,
                high=high,
                may_pass=may_pass,
            )
            if not found.solved:
                break
        layout.set_share(changes, 1.0)
        share = (part + found.fraction) / parts
        return self.named(found, x, tolerances.at(x), share, of=of)

    @staticmethod
    def _turned_back(
        of: Layout | Part, before: Array, x: Array, changes: Mapping[tuple[str, int], object]
    ) -> Array:
        """See `turned_back`: where new lengths have been solved for."""
        layout = of if isinstance(of, Layout) else of.layout
        if not changes or not layout.are_lengths(changes):
            return x
        return turned_back(of, of.line_ends(), before, x)

    def _held(self, x: Array, system: _Equations | None = None) -> Outcome | None:
        """The outcome at `x` where all equations hold, None where a solve has something to do.

        Most edits of a drawing that is made to measure only say what holds already: nothing of
        their structure need be analysed, which takes longer than all else.
        """
        if system is None and self.layout.has_hidden:  # these are brought within bounds first
            return None
        of, _, tolerances = system or self._everything
        row, residual, share = of.rows.worst(x, tolerances.at(x))
        if not share <= 1.0:
            return None
        return Outcome("solved", (), residual, of.owner[row] if row >= 0 else "")

    def holds(self, tolerance: float) -> bool:
        """Whether no residual is larger, where the document is."""
        residuals = self.layout.rows.evaluate(self.layout.gather().copy())
        return bool(np.abs(residuals).max(initial=0.0) <= tolerance)

    def without_sides(self) -> tuple[Array, str] | None:
        """A solution if sides need not be kept: numbers of the document, and what turns over.

        None: none was found. An empty name: all sides are kept where it ends.
        """
        layout = self.layout
        x = layout.gather().copy()
        self.prepare(x)
        if layout.impossible or not self._newton(x, guarded=False).solved:
            return None
        over = np.flatnonzero(~(layout.guards.evaluate(x) > 0.0))
        names = (layout.guard_owner[row] for row in over.tolist())
        return layout.values_at(x), next((name for name in names if name), "")

    def left_open(self) -> list[str]:
        """Records whose equations do not hold where the document is, by far more than rounding."""
        part = self.layout.part()
        of = part or self.layout
        x = of.gather().copy()
        if part is None:
            self.prepare(x)
        tolerances = Tolerances(part) if part is not None else self.tolerances
        excess = np.abs(of.rows.evaluate(x)) / tolerances.at(x)
        rows = np.flatnonzero(~(excess <= _BY_FAR))
        return list(dict.fromkeys(of.owner[row] for row in rows if of.owner[row]))

    def _newton(
        self,
        x: Array,
        active: NDArray[np.bool_] | None = None,
        guarded: bool = True,
        system: _Equations | None = None,
    ) -> Outcome:
        """Solve in place from `x`, by levels; a part alone, or all equations."""
        layout = self.layout
        if system is not None:
            tolerance = system.tolerances.at(x)
            return self.named(system.levels.solve(x, tolerance), x, tolerance, of=system.of)
        # Trials have analyses of their own: that of the sketch is kept.
        levels = self.levels
        if not guarded:
            levels = self._new_levels(self.levels.scales, guarded=False)
        elif active is not None:
            key = (layout.version, active.tobytes())
            if self._trial is None or self._trial[0] != key:
                trial = self._new_levels(levels.scales)
                self._trial = (key, trial)
            levels = self._trial[1]
        tolerance = self.tolerances.at(x)
        low, high = layout.bounds
        found = levels.solve(x, tolerance, active=active, low=low, high=high)
        return self.named(found, x, tolerance)

    def named(
        self,
        found: Any,
        x: Array,
        tolerance: Array,
        fraction: float = 0.0,
        converged: bool = True,
        of: Layout | Part | None = None,
    ) -> Outcome:
        """An outcome of levels in terms of the document."""
        layout = of or self.layout
        row = layout.owner[found.row] if 0 <= found.row < len(layout.owner) else ""
        guard = layout.guard_owner[found.guard] if found.guard >= 0 else ""
        open_: tuple[str, ...] = ()
        if not found.solved:
            excess = np.abs(layout.rows.evaluate(x)) / tolerance
            rows = np.flatnonzero(~(excess <= 1.0))
            rows = rows[np.argsort(-excess[rows])]
            open_ = tuple(dict.fromkeys(layout.owner[k] for k in rows if layout.owner[k]))
        return Outcome(
            found.status,
            (),
            float(found.largest),
            row,
            open_,
            guard,
            found.steps,
            1.0 if found.solved else fraction,
            getattr(found, "soft", 0.0),
            converged,
        )

    def written(self, x: Array, found: Outcome) -> Outcome:
        """Into the document, in one step."""
        layout, document = self.layout, self.layout.document
        layout.note_parameters(x, AT_KNOT)
        if document.is_changing:
            moved = layout.scatter(x)
        else:
            with document.transaction("solve"):
                moved = layout.scatter(x)
        return found.having_moved(moved) if moved else found

    # --- what is kept -----------------------------------------------------------------------

    def prepare(self, x: Array) -> None:
        """Levels and tolerances of the layout's present structure."""
        layout = self.layout
        angles = layout.angles
        if self._version == layout.version and self._tolerances is not None and not len(angles):
            return
        slacks = layout.slacks
        if len(angles) or len(self._levers):
            levers = layout.levers
            same = len(levers) == len(self._levers)
            if not same or not np.all(np.abs(np.log2(levers / self._levers)) < 1.0):
                self._levers = levers
        key = (layout.rows.n, self._levers.tobytes(), angles.tobytes(), slacks.tobytes())
        if self._levels is None or self._key != key:
            scales = None
            if len(angles) or len(slacks):
                scales = np.ones(layout.rows.n)
                scales[angles] = 1.0 / self._levers
                # Slacks follow the geometry, not the reverse.
                scales[slacks] = SLACK_SCALE
            self._levels = self._new_levels(scales)
            self._key = key
            self._tolerances = None
        if self._tolerances is None or self._version != layout.version:
            self._tolerances = Tolerances(layout)
            self._version = layout.version

    def _new_levels(
        self, scales: Array | None, guarded: bool = True, of: Layout | Part | None = None
    ) -> Levels:
        of = of or self.layout
        return Levels(
            of.rows,
            guards=of.guards if guarded else None,
            scales=scales,
            interruption=self.interruption,
            shortest=VANISHED,
        )

    @property
    def levels(self) -> Levels:
        """The solver by levels, prepared."""
        assert self._levels is not None
        return self._levels

    @property
    def _everything(self) -> _Equations:
        return _Equations(self.layout, self.levels, self.tolerances)

    @property
    def tolerances(self) -> Tolerances:
        """Of the rows, prepared."""
        assert self._tolerances is not None
        return self._tolerances

    # --- what the judge tries ---------------------------------------------------------------

    def solved_from(self, x: Array, without: NDArray[np.int64]) -> Array | None:
        """Unknowns by column that solve everything but some rows, from `x`; None if not found.

        The document is not changed.
        """
        layout = self.layout
        full = layout.with_unknowns(x)
        self.prepare(full)
        active = np.ones(layout.rows.m, dtype=bool)
        active[without] = False
        found = self._newton(full, active)
        return full[layout.unknowns] if found.solved else None

    def rows_of(self, names: Sequence[str]) -> NDArray[np.bool_]:
        """(m,) rows of constraints and dimensions, and of all entities."""
        layout = self.layout
        found = np.zeros(layout.rows.m, dtype=bool)
        for name in [*layout.document.entities, *names]:
            found[layout.first_rows(name)] = True
        return found

    def feasible(self, names: Sequence[str]) -> bool:
        """Whether these constraints and dimensions alone can be solved from where the sketch is.

        Equations of entities, coincidences and locks hold as well. Where an entity collapses,
        that is no solution.
        """
        layout = self.layout
        x = layout.gather().copy()
        if layout.impossible.keys() & set(names) or self.interrupted:
            return False
        self.prepare(x)
        document = layout.document
        active = self.rows_of(names)
        kept = {*document.entities, *names}
        start = x.copy()
        good = self._keeps_sides(x, active, kept)
        lost = self.collapsed(x)
        if good and not lost:
            return True
        if Search(self, start, names, MOST_IN_TRIAL).solution() is not None:
            return True
        lines = [one for one in lost if one.kind == "line"]
        for ways in self._turns(lines, names) if lines else ():
            # From across, the nearest solution is a line without length.
            x[:] = start
            for line, angle in ways:
                self._turn(x, line, angle)
            good = self._newton(x, active, guarded=False).solved and self._on_sides(x, kept)
            if good and not self.collapsed(x):
                return True
        return False

    def _turns(
        self, lost: Sequence[Entity], names: Sequence[str]
    ) -> Iterator[list[tuple[Entity, float]]]:
        """Lines and the angles by which they are turned, for trials in which lines collapse.

        First one of these by a right angle, to the left or right, then along with it the lines that
        it has a relation with, then all by different angles.
        """
        first, document = lost[0], self.layout.document
        others: dict[str, Entity] = {}
        for name in names:
            record = document.constraints.get(name) or document.dimensions.get(name)
            args = [arg.partition(".")[0] for arg in record.args] if record is not None else []
            if first.name in args:
                others |= {one: document.entities[one] for one in args if one != first.name}
        near = [one for one in others.values() if one.kind == "line"]
        right = 0.5 * np.pi
        for angle in (right, -right):
            yield [(first, angle)]
        for angle in (right, -right) if near else ():
            for other in (right, -right):
                yield [(first, angle), *((one, other) for one in near)]
        yield [(one, 1.2 + 0.7 * k) for k, one in enumerate(lost)]

    def _keeps_sides(self, x: Array, active: NDArray[np.bool_], kept: Set[str]) -> bool:
        """Solve in place on the sides of some records, from `x`; whether that is done."""
        start = x.copy()
        found = self._newton(x, active)
        if found.status != "side":
            return found.solved
        # A side may be that of a record that is left out, or changed on the way only: those of
        # the others have to be kept where it ends.
        x[:] = start
        return self._newton(x, active, guarded=False).solved and self._on_sides(x, kept)

    def _on_sides(self, x: Array, kept: Set[str]) -> bool:
        """Whether sides of some records are kept at `x`."""
        owners = zip(self.layout.guards.evaluate(x).tolist(), self.layout.guard_owner, strict=False)
        return all(side > 0.0 for side, owner in owners if owner in kept)

    def collapsed(self, x: Array) -> list[Entity]:
        """Entities that have an extent in the document and none at `x`."""
        layout = self.layout
        least = COLLAPSED * layout.size
        return self.extents.lost(layout.document.values, layout.values_at(x), least)

    @property
    def extents(self) -> Extents:
        """Of the document's entities, kept until any comes or goes."""
        layout = self.layout
        if self._extents is None or self._extents[0] != layout.drawn:
            self._extents = (layout.drawn, Extents(layout.document.entities.values()))
        return self._extents[1]

    def _turn(self, x: Array, line: Entity, angle: float) -> None:
        """Turn a line in `x` about the end of it that is fixed, else its middle."""
        layout = self.layout
        roots = [[layout.root_of(line.at + i + j) for j in (0, 1)] for i in (0, 2)]
        at = layout.values_at(x)[line.at : line.at + 4].reshape(2, 2)
        fixed = [place for place, own in zip(at, roots, strict=True) if min(own) < 0]
        pivot = fixed[0] if fixed else at.mean(axis=0)
        c, s = np.cos(angle), np.sin(angle)
        places = pivot + (at - pivot) @ np.array([[c, s], [-s, c]])
        for own, place in zip(roots, places, strict=True):
            if min(own) >= 0:
                x[own] = place

    def open_candidates(self, cause: str = "") -> tuple[str, ...]:
        """Constraints and dimensions among which a contradiction is to be looked for.

        Where the residuals are smallest in sum of squares, J' r = 0: those of a contradiction are
        not zero there.
        """
        layout = self.layout
        x = layout.gather().copy()
        impossible = tuple(layout.impossible)
        if impossible:
            return impossible
        self.prepare(x)
        found = self._newton(x)
        if found.solved:
            return (cause,) if cause else ()
        document = layout.document
        residuals = np.abs(layout.rows.evaluate(x))
        rows = np.flatnonzero(residuals > 1e-6 * residuals.max(initial=0.0))
        names = dict.fromkeys(layout.owner[row] for row in rows)
        if cause:
            names[cause] = None
        return tuple(
            name for name in names if name in document.constraints or name in document.dimensions
        )

    # --- dragging ---------------------------------------------------------------------------

    def drag(
        self, at: Sequence[int] | NDArray[Any], targets: ArrayLike, home: Array | None = None
    ) -> Outcome:
        """Pull points to places as far as the equations let them; the rest stays near `home`.

        Parameters
        ----------
        at : offsets in ``document.values`` of the x of the points
        targets : (k, 2) where to
        home : numbers of the document where everything was when the drag began; absent: now
        """
        session = Drag(self, at)
        if home is not None:
            session.home = self.layout.unknowns_at(home)
        return session.move(targets)


class Drag:
    """Points that follow the cursor, frame by frame.

    Parameters
    ----------
    solver : of the sketch; its factors are kept between frames
    at : offsets in ``document.values`` of the x of the points that are pulled: both ends of a line
        to move its body, centre, start and end of an arc

    Attributes
    ----------
    home : (n,) unknowns when it began, from which the rest moves as little as possible
    """

    def __init__(self, solver: Solver, at: Sequence[int] | NDArray[Any]) -> None:
        self.solver = solver
        layout = solver.layout
        self.home = layout.gather().copy()
        layout.renew_sides()
        self.began = layout.document.values.copy()
        self._cursor: dict[int, float] = {}  # where numbers were pulled to in the last frame
        self._turning: Turning | None = None
        self.points = np.asarray(at, dtype=np.int64).ravel()
        # lists: a frame has a few numbers, for which NumPy takes longer
        self._offsets: list[int] = np.column_stack([self.points, self.points + 1]).ravel().tolist()
        self._places: list[float] = self.began[self._offsets].tolist()

    def shift(self, dx: float, dy: float, seconds: float | None = None) -> Outcome:
        """All points to where they were when the drag began, moved by a vector."""
        if not (math.isfinite(dx) and math.isfinite(dy)):
            raise ValueError(f"expected a finite vector, found {dx}, {dy}")
        places = self._places.copy()
        for i in range(0, len(places), 2):
            places[i] += dx
            places[i + 1] += dy
        return self.pull(self._offsets, places, seconds)

    def move(self, targets: ArrayLike, seconds: float | None = None) -> Outcome:
        """One frame: points as near to `targets`, (k, 2), as the equations let them.

        The result is written into the document; where there is none, nothing is.

        Parameters
        ----------
        targets : (k, 2) places of the points
        seconds : time for the frame, after which the nearest state so far is taken: `converged` of
            the outcome is false, and another frame goes on from there
        """
        wanted = np.asarray(targets, dtype=np.float64).reshape(-1, 2)
        if wanted.shape != (len(self.points), 2) or not np.isfinite(wanted).all():
            raise ValueError(f"expected {len(self.points)} finite places, found {wanted.shape}")
        return self.pull(self._offsets, wanted.ravel().tolist(), seconds)

    def pull(
        self, offsets: Sequence[int], places: Sequence[float], seconds: float | None = None
    ) -> Outcome:
        """One frame: numbers of the document as near to `places` as the equations let them.

        Parameters
        ----------
        offsets : (k,) in ``document.values``: coordinates of points, or a radius
        places : (k,) what they are to be
        seconds : as of `move`
        """
        solver, layout = self.solver, self.solver.layout
        if solver.interrupted:
            return Outcome("interrupted", fraction=0.0)
        crossed = layout.cross_knots()
        outcome = self._pulled(offsets, places, seconds)
        if not outcome.solved:
            # Numbers are as before this frame: on the pieces that points came from.
            layout.cross_back(crossed)
        return outcome

    def _pulled(
        self, offsets: Sequence[int], places: Sequence[float], seconds: float | None
    ) -> Outcome:
        solver, layout = self.solver, self.solver.layout
        x = layout.gather().copy()
        if layout.impossible:
            names = tuple(layout.impossible)
            return Outcome("stalled", row=names[0], open=names, fraction=0.0)
        if len(x) != len(self.home):
            self.home = layout.unknowns_at(self.began)
        solver.prepare(x)
        tolerance = solver.tolerances.at(x)
        # by column, the first of those that coincide
        pulled: dict[int, tuple[float, float]] = {}
        for offset, place in zip(offsets, places, strict=True):
            if not layout.is_fixed(offset):
                last = self._cursor.get(offset, float(layout.document.values[offset]))
                pulled.setdefault(layout.root_of(offset), (last, place))
        self._cursor = dict(zip(offsets, places, strict=True))
        if not pulled:
            return Outcome("solved")
        columns = np.array(sorted(pulled), dtype=np.int64)
        way = np.array([pulled[column] for column in columns.tolist()])
        until = None if seconds is None else time.monotonic() + seconds
        start = x.copy()
        found = self._frame(x, columns, way[:, 1].copy(), tolerance, until)
        outcome = solver.named(found, x, tolerance, converged=found.converged)
        if not outcome.solved:
            return outcome
        now = layout.values_at(x)
        turned, passed = self._directions().change(layout.document.values, now)
        if not found.converged:
            self._cursor = {}  # the points lag behind it
        if turned or passed:
            outcome = self._along(x, start, columns, way, tolerance, until, outcome)
        return solver.written(x, outcome) if outcome.solved else outcome

    def _frame(
        self,
        x: Array,
        columns: NDArray[np.int64],
        places: Array,
        tolerance: Array,
        until: float | None,
    ) -> Any:
        """Pull unknowns to places, in `x`."""
        layout = self.solver.layout
        seconds = None if until is None else max(until - time.monotonic(), 0.0)
        return self.solver.levels.drag(
            x,
            columns,
            places,
            self.home,
            tolerance if len(tolerance) else TOLERANCE * layout.size,
            low=layout.low,
            high=layout.high,
            seconds=seconds,
        )

    def _along(
        self,
        x: Array,
        start: Array,
        columns: NDArray[np.int64],
        way: Array,
        tolerance: Array,
        until: float | None,
        whole: Outcome,
    ) -> Outcome:
        """A frame in parts, along the way of the cursor, because it turns lines far or over.

        The nearest place to a cursor that is far may be on another branch of the motion, to which
        nothing leads. Parts are halved until each looks continuous, or is as short as a frame of a
        slow cursor. Where the points would leap, a piece of the way is left out.

        Parameters
        ----------
        x : the result, in place
        start : unknowns before the frame
        way : (k, 2) the cursor's last and new place, by column
        whole : outcome of the frame in one part
        """
        solver, layout, turning = self.solver, self.solver.layout, self._directions()
        x[:] = start
        before = layout.values_at(x)
        done, step = 0.0, 0.5
        outcome = replace(whole, converged=False)
        while done < 1.0:
            if solver.interrupted:
                return Outcome("interrupted", fraction=0.0)
            if done > 0.0 and until is not None and time.monotonic() > until:
                self._cursor = {}  # the next frame goes on from there
                return replace(outcome, converged=False)
            share = min(done + step, 1.0)
            tried = x.copy()
            places = way[:, 0] + share * (way[:, 1] - way[:, 0])
            found = self._frame(tried, columns, places, tolerance, None)
            now = layout.values_at(tried)
            turned, passed = turning.change(before, now)
            smallest = step <= SMALLEST_PART
            near = not turned and (step <= PASSING_PART or not passed)
            if smallest and not near:
                # What turns is free to, unless that brings the points nearer than the part is long.
                gain = np.linalg.norm(x[columns] - places) - np.linalg.norm(tried[columns] - places)
                near = gain <= MOST_GAIN * step * np.linalg.norm(way[:, 1] - way[:, 0])
            if found.solved and near:
                x[:], before, done = tried, now, share
                outcome = solver.named(found, x, tolerance, converged=found.converged)
                step = min(2.0 * step, 0.5)
            elif smallest:
                done += LEFT_OUT
            else:
                step *= 0.5
        return outcome

    def _directions(self) -> Turning:
        """Lines that share places, as the drag began."""
        if self._turning is None:
            self._turning = Turning(self.solver.layout.document)
        return self._turning
