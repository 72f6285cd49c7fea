"""A document as rows of the shipped model, kept up to date while the document changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import Document
from arael.sketch.document.records import Entity
from arael.sketch.layout.laid import scalars_of
from arael.sketch.layout.linearisation import Linearisation
from arael.sketch.layout.operands import operands
from arael.sketch.layout.part import Part
from arael.sketch.layout.plan import Row
from arael.sketch.layout.sides import side_of
from arael.sketch.layout.splines import nearest_on
from arael.sketch.layout.system import System

__all__ = ["Layout", "Linearisation"]

#: A point this near to a piece of a spline, of the sketch's size, is on it.
_ON_PIECE = 1e-7
#: Parts of at most so many records are solved by themselves, in drawings of so many times more.
MOST_IN_PART, LEAST_REST = 256, 4


class Layout(System):
    """The equations of a document.

    Unknowns are the columns of `x`; points that coincide share theirs, points that are locked are
    constants. The layout follows the document by `Document.watchers`; changes are taken in by
    `refresh`, once for all that were made, and only what they touch is laid out anew.

    Attributes
    ----------
    document
    rows : KernelRows with all equations
    guards : KernelRows whose residuals are to stay positive
    x : (n,) unknowns; those of fixed points too, which no row uses
    low, high : (n,) bounds of the unknowns
    places : classes of coincident points
    owner : name of the record per row of `rows`; empty where there is none
    guard_owner : the same of `guards`
    version : counts the structural changes
    """

    def __init__(self, document: Document) -> None:
        super().__init__(document)
        self._lines: tuple[int, NDArray[np.int64]] | None = None  # by `drawn`
        self._part: tuple[tuple[int, tuple[str, ...]], Part] | None = None

    # --- names ----------------------------------------------------------------------------

    @property
    def spare(self) -> set[str]:
        """Coincident and concentric constraints that close nothing new: redundant."""
        self.refresh()
        return self.places.spare

    @property
    def impossible(self) -> Mapping[str, str]:
        """Constraints that contradict by what they are, and why: locks of one place that differ."""
        return {name: why for (name, _), why in self._impossible.items()}

    def tie_members(self, name: str) -> tuple[str, ...]:
        """A spare tie, after the ties that join its points anyway."""
        self.refresh()
        return (*self.places.joining(name), name)

    def holders_at(self, point: int) -> list[str]:
        """Locks and fixes that hold the place of a point."""
        members = self.places.members(point)
        return list(dict.fromkeys(name for at in members for name in self._holds.get(at, ())))

    def rivals(self, name: str) -> list[str]:
        """What holds the places of a record's points, besides itself."""
        record = self.document.constraints.get(name)
        if record is None:
            return []
        points = [arg.at for arg in operands(self.document, record.args)]
        found = dict.fromkeys(one for at in points for one in self.holders_at(at))
        return [one for one in found if one != name]

    @property
    def drawn(self) -> int:
        """A count that grows when entities come or go."""
        return self._drawn

    def users_of(self, handle: str) -> list[str]:
        """Names of the records that involve an entity, or that of a point's handle."""
        return list(self._users.get(handle.partition(".")[0], ()))

    def same(self, a: str | int, b: str | int) -> bool:
        """Whether two points, by handles or by offsets, are one place."""
        if isinstance(a, str) or isinstance(b, str):
            self.refresh()
        p = self.document.point_at(a) if isinstance(a, str) else a
        q = self.document.point_at(b) if isinstance(b, str) else b
        return super().same(p, q)

    def side_of(self, kind: str, args: tuple[str, ...], mode: str = "") -> int:
        """See `arael.sketch.layout.sides.side_of`."""
        return side_of(self.document, kind, args, mode)

    @property
    def has_hidden(self) -> bool:
        """Whether there are unknowns that are no numbers of the document."""
        return bool(self._with_hidden)

    @property
    def bounds(self) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
        """`low` and `high`; None where no unknown has bounds, as hidden ones alone do."""
        return (self.low, self.high) if self._with_hidden else (None, None)

    def is_fixed(self, offset: int) -> bool:
        """Whether a number of the document is a constant."""
        return bool(self._use[offset] < 0)

    @property
    def equations(self) -> NDArray[np.bool_]:
        """(m,) which rows are equations: not empty, nor a quantity that others read."""
        return self._is_equation[: self.rows.m]

    def use_of(self, offset: int) -> int:
        """What rows use for a number of the document: an index in `x`, negative if it is fixed."""
        return int(self._use[offset])

    @staticmethod
    def fields(row: Row) -> dict[str, float]:
        """Data of a row as fields of its struct."""
        return scalars_of(row.data)

    def root_of(self, offset: int) -> int:
        """Index in `x` of a number of the document."""
        return int(self._root[offset])

    def entity_at(self, offset: int) -> str:
        """Name of the entity that a number of the document belongs to."""
        return self._entity_at[offset]

    # --- parts ----------------------------------------------------------------------------

    def settled(self) -> None:
        """All equations hold now: what changes from here on is what has to be solved."""
        self.gather()
        self._touched = {}

    def part(self, names: Sequence[str] = ()) -> Part | None:
        """All that hangs together with what changed since `settled`, or with any of `names`.

        None where that is not known, a large share of the drawing, or has unknowns of its own or
        directions: these are looked at with everything else.
        """
        self.gather()
        if self._touched is None:
            return None
        found = self._hanging_together([*self._touched, *names])
        if found is None:
            return None
        key = self.version, tuple(found)
        if self._part is None or self._part[0] != key:
            self._part = key, Part(self, key[1])
        return self._part[1]

    def _hanging_together(self, names: Sequence[str]) -> dict[str, None] | None:
        most = min(MOST_IN_PART, len(self._laid) // LEAST_REST)
        found: dict[str, None] = {}
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            laid = self._laid.get(name)
            if laid is None or name in found:
                continue
            found[name] = None
            record = laid.record
            if isinstance(record, Entity):
                if record.kind in ("ellipse", "earc"):
                    return None
                waiting += self._users.get(name, ())
            else:
                waiting += laid.names
            if len(found) > most or name in self._with_hidden or name in self._unguarded:
                return None
        return found

    def instances_of(self, names: Iterable[str]) -> tuple[list[int], list[int], list[int]]:
        """First rows of records: of equations, of guards, of the quantities that these read."""
        rows: list[int] = []
        guards: list[int] = []
        quantities: list[int] = []
        for laid in map(self._laid.__getitem__, names):
            rows += (*laid.rows, *laid.sums)
            guards += laid.guards
            quantities += laid.inputs
        return sorted(rows), sorted(guards), quantities

    def numbers_in(self, names: Iterable[str]) -> NDArray[np.int64]:
        """Offsets of the numbers of the entities among records, ascending."""
        records = (self._laid[name].record for name in names)
        entities = sorted((one.at, one.size) for one in records if isinstance(one, Entity))
        return np.array([at + k for at, size in entities for k in range(size)], dtype=np.int64)

    def held(self) -> NDArray[np.bool_]:
        """(n,) which elements of `x` are constants."""
        found = np.zeros(len(self.x), dtype=bool)
        found[self._root[self.held_numbers(self._live)]] = True
        return found

    def held_numbers(self, offsets: NDArray[np.int64]) -> NDArray[np.int64]:
        """Those numbers of the document that are constants."""
        return offsets[self._use[offsets] < 0]

    def struct_of_guard(self, guard: int) -> str:
        """Name of the struct that a row of `guards` begins."""
        return str(self.guards.struct(guard))

    def lines_in(self, names: Iterable[str] | None = None) -> NDArray[np.int64]:
        """Offsets of the first numbers of the lines among records; of all lines without."""
        if names is not None:
            records = (self._laid[name].record for name in names)
            lines = [one.at for one in records if isinstance(one, Entity) and one.kind == "line"]
            return np.array(lines, dtype=np.int64)
        if self._lines is None or self._lines[0] != self._drawn:
            lines = [one.at for one in self.document.entities.values() if one.kind == "line"]
            self._lines = (self._drawn, np.array(lines, dtype=np.int64))
        return self._lines[1]

    def line_ends(self) -> NDArray[np.int64]:
        """Where in `x` lines begin and end, (k, 4)."""
        return self.roots(self.lines_in()[:, None] + np.arange(4))

    def roots(self, offsets: NDArray[np.int64]) -> NDArray[np.int64]:
        """Index in `x` of numbers of the document."""
        return self._root[offsets]

    def axis_of(self, offsets: NDArray[np.int64]) -> NDArray[np.int8]:
        """What numbers of the document are, as of `axes`."""
        return self._axis[offsets]

    # --- checking -------------------------------------------------------------------------

    def check(self) -> None:
        """Compare with a layout of the same document that is made anew.

        Raises
        ------
        AssertionError
            with the first record that differs
        """
        fresh = Layout(self.document)
        fresh.detach()
        mine, other = self.signature(), fresh.signature()
        for name in [*other, *mine]:
            found, expected = mine.get(name), other.get(name)
            if found != expected and not self._is_on_both(fresh, name):
                raise AssertionError(f"{name} is laid out as {found}, expected {expected}")

    def _is_on_both(self, other: Layout, name: str) -> bool:
        """Whether layouts differ by the piece of a spline only, for a point that is on both.

        A point on a knot is on two pieces, and so is one where the spline crosses itself. Either
        is right: which one is nearest is decided by rounding.
        """
        mine, theirs = self._pieces.get(name), other._pieces.get(name)
        if mine is None or theirs is None or mine == theirs:
            return False
        point, curve = operands(self.document, self.document.constraints[name].args)
        x, y = self.document.values[point.at : point.at + 2].tolist()
        _, gap = nearest_on(self.document.values, curve, mine, (x, y))
        return gap <= _ON_PIECE * self.size

    def signature(self) -> dict[str, Any]:
        """What the layout says, independent of the numbers of columns and rows.

        By record its rows, each with struct, names of what it uses, and value; what is redundant
        and impossible.
        """
        self.gather()
        found: dict[str, Any] = {
            "redundant": sorted(self.spare),
            "impossible": sorted(self.impossible),
            "unknowns": sorted(self.unknown_names()),
        }
        for name, laid in self._laid.items():
            if laid.plan is None:
                continue
            found[name] = [
                (which, self._describe(rows, row))
                for which, rows, all_ in (
                    ("row", self.rows, laid.rows),
                    ("sum", self.rows, laid.sums),
                    ("input", self.rows, laid.inputs),
                    ("guard", self.guards, laid.guards),
                )
                for row in all_
            ]
        return found

    def _describe(self, rows: Any, row: int) -> tuple[Any, ...]:
        struct = rows.struct(row)
        table = rows.tables[struct]
        uses = [
            self._name_at(int(at)) if at >= 0 else rows.unknowns.values(int(at))[:width].tolist()
            for at, width in zip(rows.uses(row), table.widths, strict=True)
        ]
        value = rows.data(row, "value") if "value" in table.fields else 0.0
        # Values are compared but for rounding: those of sums are divided by their factors.
        return struct, tuple(uses), float(f"{value:.9g}")
