"""Numbers of the document as unknowns and back, and values that changed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import differs, gather, named, put, scattered
from arael.sketch.document.records import Dimension, Entity
from arael.sketch.layout.laid import Laid
from arael.sketch.layout.operands import Operand, operands, sweep_of
from arael.sketch.layout.plan import Plan
from arael.sketch.layout.splines import pieces
from arael.sketch.layout.upkeep import Upkeep

#: Structs whose `value` is an angle.
_ANGULAR = ("Angle", "XAngle", "Sweep", "AngleMeasure", "XAngleMeasure", "SweepMeasure")


class Numbers(Upkeep):
    """Unknowns from the document, solutions into it, and the way to new values."""

    def gather(self) -> NDArray[np.float64]:
        """Unknowns from the document's numbers, after `refresh`; returns `x`, (n,).

        Where a number of a place was changed in the document, the place starts from there.
        """
        self.refresh()
        if self._gathered == (self.document.moves, self.version):
            return self.x
        values = self.document.values
        live = self._live
        if differs(values, self._seen, live):
            now = values[live]
            moved = live[now.view(np.int64) != self._seen[live].view(np.int64)]
            self._take_over(moved, values)
            for name in list(self._unguarded):
                self._lay_anew(self._laid[name], values)
            self._renew_sides(moved, values)
        if not self.document.is_changing:
            self._amid_changes.clear()
        gather(values, self._source, self.x)
        self._gathered = (self.document.moves, self.version)
        return self.x

    def _take_over(self, moved: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Start from numbers that were changed in the document."""
        self._seen[moved] = values[moved]
        if self._touched is not None:
            self._touch(self._entities_at(moved))
        free = moved[self._use[moved] >= 0]
        self._source[self._root[free]] = free
        if len(free) < len(moved):
            # what `fix` holds is where the document has it
            nothing: dict[str, None] = {}
            for at in moved[self._use[moved] < 0]:
                for point in {int(at), int(at) - 1} & self._holds.keys():
                    width = self._width(point)
                    if int(at) < point + width and None in self._holds[point].values():
                        members = list(self.places.members(point)) if width == 2 else [point]
                        self._settle(members, width, values, nothing)
        self._restart(moved, values)

    def _restart(self, moved: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Start the hidden unknowns of what was moved anew."""
        if not self._with_hidden:
            return
        names = {self._entity_at[offset] for offset in moved}
        for name in list(self._with_hidden):
            laid = self._laid[name]
            if names.isdisjoint(laid.names):
                continue
            if name in self._pieces:
                self._renew_piece(name, values)
                continue
            assert laid.plan is not None
            for at, hidden in zip(laid.hidden, laid.plan.hidden, strict=True):
                self.x[at : at + len(hidden.names)] = hidden.start(values)

    def _renew_piece(self, name: str, values: NDArray[np.float64]) -> None:
        """A point on a spline that was moved is on the piece that is nearest now."""
        del self._pieces[name]
        self._lay_anew(self._laid[name], values)

    def _renew_sides(self, moved: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Choose sides anew that were chosen by numbers which are taken back, or changed again.

        A record is laid out by where things are: on which side, by how many half turns. What
        is taken back then are the numbers alone, if the record itself is as it was.
        """
        if not self._amid_changes:
            return
        users = {
            name: None for one in self._entities_at(moved) for name in self._users.get(one, {})
        }
        for name in users.keys() & self._amid_changes.keys():
            laid = self._laid[name]
            old = laid.plan
            if old is None:
                continue
            new = self._plan(laid, values)
            if (new.rows, new.sums, new.guards) != (old.rows, old.sums, old.guards):
                self._lay_anew(laid, values)

    def _lay_anew(self, laid: Laid, values: NDArray[np.float64]) -> None:
        self.version += 1
        with self.rows.edit(), self.guards.edit():
            self._remove_rows(laid)
            self._lay(laid, values)

    def differs(self, x: NDArray[np.float64]) -> bool:
        """Whether any number of the document is not that of the unknowns `x`, (n,)."""
        return len(self._moved(x)) > 0

    def turned_over(self, start: NDArray[np.float64], x: NDArray[np.float64]) -> str:
        """The record of a side that changed between `start` and `x` for no reason; empty: none.

        Reason enough is an entity of the record, or the record itself, one of whose numbers is not
        at `start` what it is in the document.
        """
        over = np.flatnonzero(
            (self.guards.evaluate(start) > 0.0) & ~(self.guards.evaluate(x) > 0.0)
        )
        if not len(over):
            return ""
        document = self.document
        moved = set(self._entities_at(self._live[self._moved(start)]))
        for name in dict.fromkeys(self.guard_owner[row] for row in over.tolist()):
            record = document.constraints.get(name) or document.dimensions.get(name)
            of = [name] if record is None else [one.partition(".")[0] for one in record.args]
            if name and moved.isdisjoint(of):
                return name
        return ""

    def _moved(self, x: NDArray[np.float64]) -> NDArray[np.int64]:
        new = x[self._root[self._live]]
        old = self.document.values[self._live]
        return np.flatnonzero(new.view(np.int64) != old.view(np.int64))

    def scatter(self, x: NDArray[np.float64]) -> tuple[str, ...]:
        """Solved unknowns, (n,), into the document: every alias gets the same bits.

        To be called inside of a transaction.

        Returns
        -------
        Entities whose numbers changed.
        """
        self.x[:] = x
        document = self.document
        at, old, new = scattered(x, self._root, document.values, self._live)
        if not len(at):
            return ()
        document.replace_values(at, old, new)
        put(self._seen, at, new)
        self._gathered = (document.moves, self.version)
        return named(at, self._first, self._entity_at)

    def scatter_numbers(
        self,
        at: NDArray[np.int64],
        new: NDArray[np.float64],
        columns: NDArray[np.int64],
        x: NDArray[np.float64],
    ) -> tuple[str, ...]:
        """As `scatter`, of a part.

        Parameters
        ----------
        at, new : (k,) numbers of the document, and what they become
        columns, x : (n,) the unknowns that they share, and their values
        """
        if not np.isfinite(x).all():
            raise ValueError("the numbers of a sketch are finite")
        document = self.document
        self.x[columns] = x
        old = document.values[at]
        moved = old.view(np.int64) != new.view(np.int64)
        if not moved.any():
            return ()
        at, new = at[moved], new[moved]
        document.replace_values(at, old[moved], new)
        put(self._seen, at, new)
        self._gathered = (document.moves, self.version)
        return self._entities_at(at)

    def _entities_at(self, at: NDArray[np.int64]) -> tuple[str, ...]:
        """Entities of offsets into the document's values, ascending."""
        return named(at, self._first, self._entity_at)

    def unknowns_at(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """`x` for other numbers of the document than it has now, (n,)."""
        found = self.gather().copy()
        gather(values, self._source, found)
        return found

    def values_at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The document's numbers for unknowns `x`, (n,)."""
        values = self.document.values.copy()
        values[self._live] = x[self._root[self._live]]
        return values

    # --- values that changed since the last solve -----------------------------------------

    def take_changes(self) -> dict[tuple[str, int], tuple[float, float]]:
        """Old and new ``value`` by (``rows`` or ``guards``, row), of what changed since last."""
        self.refresh()
        found, self._changes = self._changes, {}
        return {key: one for key, one in found.items() if one[0] != one[1]}

    def return_changes(self, changes: dict[tuple[str, int], tuple[float, float]]) -> None:
        """Changes that were not taken in after all count for the next solve."""
        for key, (old, new) in changes.items():
            self._changes[key] = (old, self._changes.get(key, (old, new))[1])

    def set_share(self, changes: dict[tuple[str, int], tuple[float, float]], share: float) -> None:
        """Set changed values to a share of the way from old to new."""
        for (which, row), (old, new) in changes.items():
            rows = self.rows if which == "rows" else self.guards
            rows.set_data(row, "value", new if share == 1.0 else old + share * (new - old))

    def parts_of(
        self, changes: dict[tuple[str, int], tuple[float, float]], share: float, turn: float
    ) -> int:
        """In how many parts changed values are approached; 0 where all are near.

        Parameters
        ----------
        share : values that change by a larger share of themselves are far
        turn : angles that change by more are far, and each part of the way is as long at most
        """
        parts = 0
        for (which, row), (old, new) in changes.items():
            way = abs(new - old)
            if which == "guards" or self.rows.struct(row) in _ANGULAR:
                if way > turn:
                    parts = max(parts, int(way / turn) + 1)
            elif way > share * max(abs(old), abs(new)):
                parts = max(parts, 1)
        return parts

    def are_lengths(self, changes: Iterable[tuple[str, int]]) -> bool:
        """Whether values that changed are of lengths alone."""
        return all(
            which == "rows" and self.rows.struct(row) not in _ANGULAR for which, row in changes
        )

    def approach_turned(self, x: NDArray[np.float64]) -> None:
        """Values whose geometry is more than 90 degrees off at `x` are approached from there.

        There the equation of an angle has another solution, half a turn away, which is nearer.
        """
        if self._turning is None or self._turning[0] != self.version:
            found = [
                laid.guards[setting.at]
                for laid in map(self._laid.__getitem__, self._with_turning)
                for setting in cast("Plan", laid.plan).settings
                if setting.which == "guards"
            ]
            self._turning = (self.version, np.array(found, dtype=np.int64))
        rows = self._turning[1]
        if not len(rows):
            return
        signs = self.guards.evaluate(x)
        wrong = rows[signs[rows] <= 0]
        if not len(wrong):
            return
        values = self.values_at(x)
        for row in wrong.tolist():
            laid = self._laid[self.guard_owner[row]]
            if ("guards", row) not in self._changes:
                self._approach(laid, cast("Dimension", laid.record), values)

    def renew_sides(self) -> None:
        """Guards of arcs from how they are now: of less or of more than half a turn."""
        values = self.document.values
        for laid in self._laid.values():
            record = laid.record
            if not isinstance(record, Entity) or not laid.guards:
                continue
            if self.guards.struct(laid.guards[-1]) == "SweepGuard":
                curve = Operand(record, "", record.at)
                side = 1.0 if sweep_of(values, curve) < np.pi else -1.0
                self.guards.set_data(laid.guards[-1], "side", side)

    def renew_guards(self, x: NDArray[np.float64]) -> None:
        """Lay out records by how they are at the accepted `x`, (n,), if guards fail or are missing.

        A guard fails where the solve began on another side; an arc whose radius was not positive
        has none.
        """
        failing = np.flatnonzero(~(self.guards.evaluate(x) > 0.0))
        owners = [self.guard_owner[row] for row in failing.tolist()]
        for name in dict.fromkeys([*owners, *self._unguarded]):
            if name:
                self._lay_anew(self._laid[name], self.document.values)

    # --- points on splines of several pieces ----------------------------------------------

    def note_parameters(self, x: NDArray[np.float64], within: float) -> None:
        """Which points on splines are as near to an end of their piece at `x`, (n,)."""
        self._at_knots = {}
        for name, piece in self._pieces.items():
            t = float(x[self._laid[name].hidden[0]])
            if t <= within or t >= 1.0 - within:
                self._at_knots[name] = piece + (1 if t > 0.5 else -1)

    def hidden_at(self, name: str) -> int:
        """Where in `x` the hidden unknowns of a record begin."""
        return self._laid[name].hidden[0]

    def cross_knots(self) -> dict[str, float]:
        """Lay points out on the neighbouring pieces that `note_parameters` found.

        Returns
        -------
        By record the parameter, 0 or 1, with which its point begins on the new piece.
        """
        found, self._at_knots = self._at_knots, {}
        crossed = {}
        for name, piece in found.items():
            record = self.document.constraints.get(name)
            if record is None:
                continue
            if 0 <= piece < pieces(operands(self.document, record.args)[1]):
                crossed[name] = 0.0 if piece > self._pieces[name] else 1.0
                self._pieces[name] = piece
                self._pending["constraints", name] = None
                self._stale.add(name)
        return crossed

    def cross_back(self, names: Iterable[str]) -> None:
        """Lay points out on the pieces that are nearest: where they crossed to had no solution.

        What `note_parameters` found there does not count any more.
        """
        self._at_knots = {}
        for name in names:
            self._pieces.pop(name, None)
            self._pending["constraints", name] = None
            self._stale.add(name)
