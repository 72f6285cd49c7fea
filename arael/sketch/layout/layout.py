"""A document as rows of the shipped model, kept up to date while the document changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.union_find import connected
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets, split_handle
from arael.sketch.document.history import RecordChange
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.records import Amount, Constraint, Dimension, Entity, Record
from arael.sketch.expressions.dependencies import amounts_of
from arael.sketch.expressions.gradient import Program
from arael.sketch.expressions.reading import literal
from arael.sketch.layout import following, model, quantities, relations
from arael.sketch.layout.columns import Columns
from arael.sketch.layout.operands import Operand, operands, sweep_of
from arael.sketch.layout.places import Places
from arael.sketch.layout.plan import Constant, Plan, Row, Sum, Use
from arael.sketch.layout.sides import side_of
from arael.sketch.layout.splines import pieces

#: Places of locks that differ by less than this share of the numbers are one.
LOCK_TOLERANCE = 1e-10

#: Kinds of entities with equations or guards of their own.
_WITH_ROWS = ("circle", "arc", "ellipse", "earc")

#: Structs whose `value` is an angle.
_ANGULAR = ("Angle", "XAngle", "Sweep", "AngleMeasure", "XAngleMeasure", "SweepMeasure")

_LAID = ("entities", "constraints", "dimensions")

#: A parameter this near to an end of a piece is the knot there, but for rounding.
_ON_KNOT = 1e-6


@dataclass(slots=True)
class Laid:
    """A record as it is laid out.

    Attributes
    ----------
    record : as it was then
    names : entities that it involves
    plan : what it contributes
    rows, sums, guards : first rows of its instances, in the order of the plan
    inputs : rows of quantities that its sums read
    hidden : first column of each of its hidden unknowns
    constants : offsets of its constants
    """

    record: Record
    names: tuple[str, ...]
    plan: Plan | None = None
    rows: list[int] = field(default_factory=list)
    sums: list[int] = field(default_factory=list)
    guards: list[int] = field(default_factory=list)
    inputs: list[int] = field(default_factory=list)
    hidden: list[int] = field(default_factory=list)
    constants: list[int] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Residuals and Jacobian of a sketch, without gaps.

    Attributes
    ----------
    x : (n,) unknowns
    residuals : (m,) lengths
    indptr, indices, entries : the Jacobian in CSR
    rows : (m,) rows of the layout
    names : of the record of each row of the layout, as the layout has them now
    """

    x: NDArray[np.float64]
    residuals: NDArray[np.float64]
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    entries: NDArray[np.float64]
    rows: NDArray[np.int64]
    names: list[str]

    @property
    def owners(self) -> list[str]:
        """Name of the record of each row: a constraint, a dimension, or an entity with equations.

        Valid until the layout changes.
        """
        return [self.names[row] for row in self.rows.tolist()]

    def owner(self, row: int) -> str:
        """The same of one row."""
        return self.names[int(self.rows[row])]


@dataclass(frozen=True, slots=True)
class _Table:
    """Numbering of unknowns and equations.

    Attributes
    ----------
    version : of the layout
    unknowns : index in `x` by column
    column : the reverse; -1 where nothing is unknown
    column_of : column by offset in the document's values
    rows : row of `rows` by equation
    number : the reverse
    is_range : by equation
    slacks : how many of the last columns are slacks of ranges
    """

    version: int
    unknowns: NDArray[np.int64]
    column: NDArray[np.int64]
    column_of: NDArray[np.int64]
    rows: NDArray[np.int64]
    number: NDArray[np.int64]
    is_range: NDArray[np.bool_]
    slacks: int


class Layout:
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
        self.document = document
        self.rows, self.guards = model.rows(), model.rows()
        self.x = np.zeros(0)
        self.low, self.high = np.zeros(0), np.zeros(0)
        self.places = Places()
        self.owner: list[str] = []
        self._is_equation = np.zeros(0, dtype=bool)  # by row: not empty, nor a quantity's
        self.guard_owner: list[str] = []
        self.version = 0
        self._columns = Columns()
        self._laid: dict[str, Laid] = {}
        self._users: dict[str, dict[str, None]] = {}
        self._on: dict[str, dict[str, int]] = {}
        self._pending: dict[tuple[str, str], None] = {}
        # By offset in the document's values:
        self._column = np.zeros(0, dtype=np.int64)  # its own column, -1 where nothing is
        self._root = np.zeros(0, dtype=np.int64)  # the column it is read from
        self._use = np.zeros(0, dtype=np.int64)  # what rows use: the same, or a constant
        self._axis = np.zeros(0, dtype=np.int8)  # what it is, see `axes`
        self._first = np.zeros(0, dtype=np.int64)  # offset of its entity's first number
        self._entity_at: list[str] = []
        # By column:
        self._source = np.zeros(0, dtype=np.int64)  # offset that gives its number, -1 without
        # What is fixed:
        self._holds: dict[int, dict[str, tuple[float, ...] | None]] = {}
        self._constants: dict[int, int] = {}  # offset of the constant by root column
        self._unused: list[int] = []  # constants that no row will use when all are laid out
        # Why a record cannot hold; by record and the point where it is held, -1 for its plan.
        self._impossible: dict[tuple[str, int], str] = {}
        self._seen = np.zeros(0)
        self._live = np.zeros(0, dtype=np.int64)
        self._with_hidden: dict[str, None] = {}
        self._with_turning: dict[str, None] = {}  # whose guards follow their values
        # Dimensions that follow geometry, by the parameters and dimensions they read.
        self._readers: dict[str, dict[str, None]] = {}
        self._stale: set[str] = set()  # those that have to be laid out anew
        self._changes: dict[tuple[str, int], tuple[float, float]] = {}
        self._numbering: _Table | None = None
        # Offsets of the x of all points, and of other lengths, of a version.
        self._extent: tuple[int, NDArray[np.int64], NDArray[np.int64]] | None = None
        # Pieces on which points are, of splines with several; where those are that are at an end.
        self._pieces: dict[str, int] = {}
        self._at_knots: dict[str, int] = {}
        self._turning: tuple[int, NDArray[np.int64]] | None = None
        self._angles: tuple[int, NDArray[np.int64], list[tuple[int, int]]] | None = None
        for table in _LAID:
            for name in getattr(document, table):
                self._pending[(table, name)] = None
        document.watchers.append(self._changed)

    def detach(self) -> None:
        """Stop following the document."""
        self.document.watchers.remove(self._changed)

    # --- names ------------------------------------------------------------------------------

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

    def users_of(self, handle: str) -> list[str]:
        """Names of the records that involve an entity, or that of a point's handle."""
        return list(self._users.get(handle.partition(".")[0], ()))

    def first_rows(self, name: str) -> list[int]:
        """Rows of `rows` that a record contributes, of its equations."""
        laid = self._laid.get(name)
        if laid is None:
            return []
        return [
            row + k
            for row in [*laid.rows, *laid.sums]
            for k in range(self.rows.tables[self.rows.struct(row)].residuals)
        ]

    def same(self, a: str | int, b: str | int) -> bool:
        """Whether two points, by handles or by offsets, are one place."""
        if isinstance(a, str) or isinstance(b, str):
            self.refresh()
        p = self.document.point_at(a) if isinstance(a, str) else a
        q = self.document.point_at(b) if isinstance(b, str) else b
        return p == q or bool(self._root[p] == self._root[q])

    def side_of(self, kind: str, args: tuple[str, ...], mode: str = "") -> int:
        """See `arael.sketch.layout.sides.side_of`."""
        return side_of(self.document, kind, args, mode)

    def is_fixed(self, offset: int) -> bool:
        """Whether a number of the document is a constant."""
        return bool(self._use[offset] < 0)

    def use_of(self, offset: int) -> int:
        """What rows use for a number of the document: an index in `x`, negative if it is fixed."""
        return int(self._use[offset])

    def columns_at(self, indices: NDArray[Any]) -> NDArray[np.int64]:
        """Columns of unknowns by their indices in `x`."""
        found: NDArray[np.int64] = self._table().column[indices]
        return found

    @staticmethod
    def fields(row: Row) -> dict[str, float]:
        """Data of a row as fields of its struct."""
        return _fields(row.data)

    def root_of(self, offset: int) -> int:
        """Index in `x` of a number of the document."""
        return int(self._root[offset])

    def entity_at(self, offset: int) -> str:
        """Name of the entity that a number of the document belongs to."""
        return self._entity_at[offset]

    def _members(self, offset: int) -> list[int]:
        """Offsets of the numbers that share a column with one."""
        root = self._root[offset]
        entity = self.document.entities[self._entity_at[offset]]
        for point in self._point_starts(entity):
            if offset - point in (0, 1):
                return [p + offset - point for p in self.places.members(point)]
        assert root >= 0
        return [offset]

    def _number_name(self, offset: int) -> str:
        entity = self.document.entities[self._entity_at[offset]]
        for name, at in reversed(point_offsets(entity).items()):
            if offset - at in (0, 1):
                return f"{entity.name}.{name}.{'xy'[offset - at]}"
        return f"{entity.name}.{ENTITIES[entity.kind].values[offset - entity.at]}"

    @staticmethod
    def _point_starts(entity: Entity) -> list[int]:
        kind = ENTITIES[entity.kind]
        if kind.poles:
            return list(range(entity.at, entity.at + entity.size, 2))
        return [entity.at + offset for _, offset in kind.points]

    # --- the system of equations ------------------------------------------------------------

    def _table(self) -> _Table:
        """Numbering of unknowns and equations without gaps, for those who read the whole system."""
        self.refresh()
        table = self._numbering
        if table is None or table.version != self.version:
            table = self._numbering = self._numbered()
        return table

    def _numbered(self) -> _Table:
        used = np.zeros(len(self.x), dtype=bool)
        root = self._root[: len(self.document.values)]
        use = self._use[: len(root)]
        used[use[(root >= 0) & (use >= 0)]] = True
        slack = np.zeros(len(self.x), dtype=bool)
        ranged: set[str] = set()
        for name in self._with_hidden:
            laid = self._laid[name]
            bounded = isinstance(laid.record, Dimension)
            for at, hidden in zip(laid.hidden, cast("Plan", laid.plan).hidden, strict=True):
                used[at : at + len(hidden.names)] = True
                slack[at : at + len(hidden.names)] = bounded
            if bounded:
                ranged.add(name)
        unknowns = np.concatenate([np.flatnonzero(used & ~slack), np.flatnonzero(used & slack)])
        column = np.full(len(self.x) + 1, -1, dtype=np.int64)
        column[unknowns] = np.arange(len(unknowns))
        column_of = np.append(np.where(use >= 0, column[np.maximum(root, -1)], -1), -1)
        rows = np.flatnonzero(self._is_equation[: self.rows.m])
        number = np.full(self.rows.m, -1, dtype=np.int64)
        number[rows] = np.arange(len(rows))
        is_range = np.zeros(len(rows), dtype=bool)
        for name in ranged:
            own = number[self.first_rows(name)]
            is_range[own[own >= 0]] = True
        slacks = int(np.count_nonzero(slack))
        return _Table(self.version, unknowns, column, column_of, rows, number, is_range, slacks)

    @property
    def unknowns(self) -> NDArray[np.int64]:
        """Indices in `x` that are unknown, by column; slacks of ranges are the last."""
        return self._table().unknowns

    @property
    def column_of(self) -> NDArray[np.int64]:
        """Column of every number of the document, -1 of fixed ones; the last element is -1."""
        return self._table().column_of

    def columns_of(self, name: str) -> NDArray[np.int64]:
        """Columns of an entity, a point, a number (``L0.p1.x``), or a record's hidden unknowns."""
        column_of = self.column_of
        entity = self.document.entities.get(name)
        if entity is not None:
            return column_of[entity.at : entity.at + entity.size]
        laid = self._laid.get(name)
        if laid is not None:
            numbers = [at + k for at, size in self._hidden_blocks(laid) for k in range(size)]
            return self._table().column[numbers]
        owner = self.document.entity(name.partition(".")[0])
        for offset in range(owner.at, owner.at + owner.size):
            if self._number_name(offset) == name:
                return column_of[offset : offset + 1]
        at = self.document.point_at(name)
        return column_of[at : at + 2]

    def rows_of(self, name: str) -> NDArray[np.int64]:
        """Equations of a record: rows of `linearisation`."""
        table = self._table()
        return table.number[self.first_rows(name)]

    def name_of(self, column: int) -> str:
        """Name of an unknown: ``L0.p1.x``, of a hidden one ``C3.contact.x``."""
        return self._name_at(int(self.unknowns[column]))

    def unknown_names(self) -> list[str]:
        """Names of all unknowns, by column."""
        return [self._name_at(int(at)) for at in self.unknowns]

    def _name_at(self, at: int) -> str:
        offset = int(self._source[at]) if at < len(self._source) else -1
        if offset >= 0:
            return self._number_name(min(self._members(offset)))
        for name in self._with_hidden:
            laid = self._laid[name]
            for hidden, (first, size) in zip(
                cast("Plan", laid.plan).hidden, self._hidden_blocks(laid), strict=True
            ):
                if first <= at < first + size:
                    return f"{name}.{hidden.names[at - first]}"
        return ""

    @staticmethod
    def _hidden_blocks(laid: Laid) -> list[tuple[int, int]]:
        hidden = laid.plan.hidden if laid.plan else []
        return [(at, len(one.names)) for at, one in zip(laid.hidden, hidden, strict=True)]

    @property
    def size(self) -> float:
        """Extent of the drawing: its larger side, or the largest diameter; of a single place 1."""
        self.refresh()
        values = self.document.values
        if self._extent is None or self._extent[0] != self.version:
            at = (np.flatnonzero(self._axis == 1), np.flatnonzero(self._axis == 3))
            self._extent = (self.version, *at)
        _, points, lengths = self._extent
        if not len(points):
            return 1.0
        x, y = values[points], values[points + 1]
        diameter = 2.0 * np.abs(values[lengths]).max(initial=0.0)
        return float(max(x.max() - x.min(), y.max() - y.min(), diameter)) or 1.0

    def axes(self) -> NDArray[np.int8]:
        """What each element of `x` is: 1 an x, 2 a y, 3 another length, 4 an angle; 0 nothing."""
        self.refresh()
        found = np.zeros(len(self.x), dtype=np.int8)
        at = np.flatnonzero(self._axis)
        found[self._root[at]] = self._axis[at]
        return found

    @property
    def angles(self) -> NDArray[np.int64]:
        """Where in `x` numbers without a unit are: directions of ellipses, places along splines."""
        self.refresh()
        if self._angles is None or self._angles[0] != self.version:
            spans: dict[int, tuple[int, int]] = {}
            for at in np.flatnonzero(self._axis == 4).tolist():
                spans[int(self._root[at])] = (at - 2, at - 1)
            for name in self._with_hidden:
                laid = self._laid[name]
                if cast("Plan", laid.plan).hidden[0].names == ("t",):
                    spline = self.document.entities[laid.record.args[1]]  # type: ignore[union-attr]
                    spans[laid.hidden[0]] = (spline.at, spline.at + spline.size)
            found = np.array(sorted(spans), dtype=np.int64)
            self._angles = (self.version, found, [spans[at] for at in found.tolist()])
        return self._angles[1]

    @property
    def levers(self) -> NDArray[np.float64]:
        """By what `angles` become lengths: diameters of ellipses, extents of splines."""
        self.angles  # noqa: B018 - up to date
        assert self._angles is not None
        values, found = self.document.values, []
        for start, end in self._angles[2]:
            numbers = values[start:end]
            if len(numbers) > 1:
                poles = numbers.reshape(-1, 2)
                # the same for a turned spline
                found.append(float(np.sqrt(np.square(poles - poles.mean(axis=0)).sum())))
            else:
                found.append(2.0 * abs(float(numbers[0])))
        return np.array([one or 1.0 for one in found])

    def unit_of(self, dimension: str) -> float:
        """What a row changes by when its dimension's value grows by 1 (degrees: by one)."""
        record = self.document.dimensions[dimension]
        laid = self._laid.get(dimension)
        unit = quantities.inner(record.kind, 1.0)
        if laid is None or laid.plan is None or not laid.plan.settings:
            return -unit
        setting = laid.plan.settings[0]
        if setting.which == "sums":
            return -setting.scale * unit
        x = self.gather()
        # Rows are linear in `value` only nearly: angles enter by their sines.
        row, field = laid.rows[setting.at], "value"
        now, step = self.rows.data(row, field), 1e-6 * setting.scale * unit
        before = self.rows.evaluate(x)[row]
        self.rows.set_data(row, field, now + step)
        after = self.rows.evaluate(x)[row]
        self.rows.set_data(row, field, now)
        return float(after - before) / 1e-6

    def components(self) -> NDArray[np.int32]:
        """Number of the component by row, then by element of `x`: what hangs together by rows."""
        m, n = self.rows.m, len(self.x)
        # Rows are the first nodes of a bipartite graph, elements of `x` the others.
        starts = np.full(m + n + 1, len(self.rows.indices), dtype=np.int64)
        starts[: m + 1] = self.rows.indptr
        nobody = np.zeros(0, dtype=np.int64)
        _, found = connected(
            starts,
            self.rows.indices.astype(np.int64) + m,
            nobody,
            nobody,
            np.zeros(m + n, dtype=np.uint8),
        )
        labels: NDArray[np.int32] = found
        return labels

    def connected(self, name: str) -> tuple[str, ...]:
        """Constraints and dimensions whose equations hang together with those of one."""
        table = self._table()
        if not len(table.rows):
            return ()
        label = self.components()
        labels = set(label[self.first_rows(name)].tolist())
        if not labels:
            labels = {
                int(label[self.rows.m + int(self._root[self.document.point_at(arg)])])
                for arg in self._arguments(name)
            }
        found = dict.fromkeys(self.owner[row] for row in table.rows if int(label[row]) in labels)
        document = self.document
        return tuple(
            one for one in found if one in document.constraints or one in document.dimensions
        )

    def _arguments(self, name: str) -> list[str]:
        record = self.document.constraints.get(name)
        return [arg for arg in (record.args if record else ()) if "." in arg or arg[0] == "P"]

    def linearisation(
        self,
        x: NDArray[np.float64] | None = None,
        *,
        without: str = "",
        ranges: bool = True,
    ) -> Linearisation:
        """The whole system at the document's numbers, or at unknowns `x` by column.

        Parameters
        ----------
        without : a record that is left out
        ranges : with rows and slacks of ranges, which take no freedom
        """
        table = self._table()
        at = self.gather() if x is None else self.with_unknowns(x)
        residuals, entries = self.rows.jacobian(at)
        indptr, indices = self.rows.indptr, self.rows.indices
        keep = np.ones(len(table.rows), dtype=bool)
        if without:
            keep[self.rows_of(without)] = False
        if not ranges:
            keep &= ~table.is_range
        rows = table.rows[keep]
        counts = np.diff(indptr)[rows]
        kept = np.zeros(self.rows.m, dtype=bool)
        kept[rows] = True
        entry = np.repeat(kept, np.diff(indptr))
        n = len(table.unknowns) - (0 if ranges else table.slacks)
        return Linearisation(
            at[table.unknowns[:n]],
            residuals[rows],
            np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
            table.column[indices[entry]].astype(np.int32),
            entries[entry],
            rows,
            self.owner,
        )

    def with_unknowns(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """All of `x`, with unknowns given by column."""
        full = self.gather().copy()
        full[self.unknowns[: len(x)]] = x
        return full

    # --- what plans ask ---------------------------------------------------------------------

    def lies_on(self, point: int, curve: str) -> bool:
        """Whether a `point_on` of its own holds a point on a curve."""
        return any(self.same(point, one) for one in self._on.get(curve, {}).values())

    # --- keeping up -------------------------------------------------------------------------

    def _changed(self, change: RecordChange, backwards: bool) -> None:
        if change.table in _LAID:
            self._pending[(change.table, change.key)] = None
        for reader in self._readers.get(change.key, ()):
            self._pending[("dimensions", reader)] = None
            self._stale.add(reader)

    @property
    def is_stale(self) -> bool:
        """Whether the document changed since `refresh`."""
        return bool(self._pending)

    def refresh(self) -> set[str]:
        """Take in what changed in the document; names of the records that were laid out anew."""
        if not self._pending:
            return set()
        pending, self._pending = self._pending, {}
        tables = {table: getattr(self.document, table) for table in _LAID}
        structural: list[tuple[str, str]] = []
        anew: set[str] = set()
        for table, name in pending:
            record = tables[table].get(name)
            laid = self._laid.get(name)
            old = laid.record if laid else None
            if name in self._stale and laid is not None and record is not None:
                structural.append((table, name))
            elif record is old or (table == "entities" and _same_numbers(old, record)):
                if laid is not None and record is not None:
                    laid.record = record
            elif laid is not None and self._set_value(laid, record):
                anew.add(name)
            else:
                structural.append((table, name))
        if structural:
            with self.rows.edit(), self.guards.edit():
                anew |= self._restructure(structural, tables)
        self._stale.clear()
        return anew

    def _restructure(
        self, changed: list[tuple[str, str]], tables: Mapping[str, Mapping[str, Any]]
    ) -> set[str]:
        self.version += 1
        dirty: dict[str, None] = {}
        # Fewer records first, then fewer entities; more entities before more records.
        for table, name in changed:
            laid = self._laid.get(name)
            if laid is not None and table != "entities":
                self._forget(laid, name, dirty)
        for table, name in changed:
            laid = self._laid.get(name)
            if laid is not None and table == "entities":
                self._remove_entity(laid, name)
        added = [(table, name) for table, name in changed if name in tables[table]]
        for table, name in added:
            if table == "entities":
                self._add_entity(tables[table][name])
                if tables[table][name].kind in _WITH_ROWS:
                    dirty[name] = None
        for table, name in added:
            if table != "entities":
                self._remember(tables[table][name], dirty)
        self._alias(dirty)
        for name in dirty:
            if name in self._laid:
                self._remove_rows(self._laid[name])
        lay = [name for name in dirty if name in self._laid]
        values = self.document.values
        for name in lay:
            self._lay(self._laid[name], values)
        for at in self._unused:
            self.rows.release_constant(at)
            self.guards.release_constant(at)
        self._unused.clear()
        self._live = np.flatnonzero(self._root[: len(values)] >= 0)
        return set(lay)

    def _grow(self) -> None:
        """More columns where they do not suffice, with some to spare."""
        if self._columns.count <= len(self.x):
            return
        old, count = len(self.x), max(64, 2 * self._columns.count)
        self.x = np.concatenate([self.x, np.zeros(count - old)])
        self.low = np.concatenate([self.low, np.full(count - old, -np.inf)])
        self.high = np.concatenate([self.high, np.full(count - old, np.inf)])
        self._source = np.concatenate([self._source, np.full(count - old, -1, dtype=np.int64)])
        self.rows.resize(count)
        self.guards.resize(count)

    # --- records ----------------------------------------------------------------------------

    def _remember(self, record: Constraint | Dimension, dirty: dict[str, None]) -> None:
        """Enter a record: who it involves, its ties and holds."""
        names = tuple(
            dict.fromkeys(parts.name for arg in record.args if (parts := split_handle(arg)))
        )
        self._laid[record.name] = Laid(record, names)
        if record.name not in self._stale:
            self._pieces.pop(record.name, None)
        for name in names:
            self._users.setdefault(name, {})[record.name] = None
        if isinstance(record, Dimension) and following.is_live(record):
            self._read(record)
        if not record.active:
            return
        dirty[record.name] = None
        if isinstance(record, Dimension):
            return
        args = operands(self.document, record.args)
        if record.kind in ("coincident", "concentric"):
            a, b = (arg.at for arg in args)
            weights = [len(self._users[arg.entity.name]) for arg in args]
            self.places.tie(record.name, a, b, (weights[0], weights[1]))
        elif record.kind == "lock":
            self._hold(args[0].at, record.name, record.numbers)
        elif record.kind == "fix":
            self._fix(args[0].entity, record.name)
        elif record.kind == "point_on":
            self._on.setdefault(args[1].entity.name, {})[record.name] = args[0].at
            self._touch_tangents(args, dirty)

    def _read(self, record: Dimension) -> None:
        """Note what an expression reads; the geometry that it follows is involved as well."""
        document = self.document
        for name in following.read_by(document, record):
            self._readers.setdefault(name, {})[record.name] = None
        laid = self._laid[record.name]
        entities = []
        for _, amount in amounts_of(record):
            program = following.program_of(document, record, amount.text)
            if program is not None:
                entities += [path.partition(".")[0] for path in program.geometry]
        laid.names = tuple(dict.fromkeys([*laid.names, *entities]))
        for name in laid.names:
            self._users.setdefault(name, {})[record.name] = None

    def _forget(self, laid: Laid, name: str, dirty: dict[str, None]) -> None:
        """Take a record out, with its rows, ties and holds."""
        self._remove_rows(laid)
        del self._laid[name]
        if name not in self._stale:
            self._pieces.pop(name, None)
        dirty.pop(name, None)
        self._impossible.pop((name, -1), None)
        for one in laid.names:
            self._users[one].pop(name, None)
        if isinstance(laid.record, Dimension) and following.is_live(laid.record):
            for readers in self._readers.values():
                readers.pop(name, None)
        record = laid.record
        if not isinstance(record, Constraint) or not record.active:
            return
        if record.kind in ("coincident", "concentric"):
            self.places.untie(name)
        elif record.kind in ("lock", "fix"):
            for at in [at for at, holds in self._holds.items() if name in holds]:
                self._release(at, name)
        elif record.kind == "point_on":
            for on in self._on.values():
                if on.pop(name, None) is not None:
                    break
            for one in laid.names:
                self._tangents_of(one, dirty)

    def _touch_tangents(self, args: list[Operand], dirty: dict[str, None]) -> None:
        for arg in args:
            self._tangents_of(arg.entity.name, dirty)

    def _tangents_of(self, entity: str, dirty: dict[str, None]) -> None:
        """Tangents of a curve are written otherwise where it holds a point of the other curve."""
        for user in self._users.get(entity, ()):
            laid = self._laid.get(user)
            if laid is None or not isinstance(laid.record, Constraint):
                continue
            if laid.record.kind == "tangent" and laid.record.active:
                dirty[user] = None

    def _hold(self, at: int, name: str, numbers: tuple[float, ...] | None) -> None:
        self._holds.setdefault(at, {})[name] = numbers
        self.places.touched.add(at)

    def _release(self, at: int, name: str) -> None:
        del self._holds[at][name]
        self._impossible.pop((name, at), None)
        if not self._holds[at]:
            del self._holds[at]
        self.places.touched.add(at)

    def _fix(self, entity: Entity, name: str) -> None:
        points = self._point_starts(entity)
        within = {point + k for point in points for k in (0, 1)}
        for point in points:
            self._hold(point, name, None)
        for offset in range(entity.at, entity.at + entity.size):
            if offset not in within:
                self._hold(offset, name, None)

    # --- entities ---------------------------------------------------------------------------

    def _add_entity(self, entity: Entity) -> None:
        size = entity.at + entity.size
        if size > len(self._root):
            more = max(size, 2 * len(self._root)) - len(self._root)
            for array in ("_column", "_root", "_use"):
                old = getattr(self, array)
                setattr(self, array, np.concatenate([old, np.full(more, -1, dtype=np.int64)]))
            self._axis = np.concatenate([self._axis, np.zeros(more, dtype=np.int8)])
            self._first = np.concatenate([self._first, np.zeros(more, dtype=np.int64)])
            self._entity_at += [""] * more
            self._seen = np.concatenate([self._seen, np.full(more, np.nan)])
        first = self._columns.take(entity.size)
        self._grow()
        block = slice(entity.at, entity.at + entity.size)
        own = np.arange(first, first + entity.size)
        self._column[block] = self._root[block] = self._use[block] = own
        self._source[own] = np.arange(entity.at, size)
        self._first[block] = entity.at
        self._axis[block] = 3
        points = self._point_starts(entity)
        for point in points:
            self._axis[point : point + 2] = 1, 2
        if entity.kind in ("ellipse", "earc"):
            self._axis[size - 1] = 4
        self._entity_at[block] = [entity.name] * entity.size
        self._seen[block] = self.document.values[block]
        self._laid[entity.name] = Laid(entity, (entity.name,))
        if entity.kind in _WITH_ROWS:
            self._users.setdefault(entity.name, {})[entity.name] = None

    def _remove_entity(self, laid: Laid, name: str) -> None:
        self._remove_rows(laid)
        entity = cast("Entity", laid.record)
        del self._laid[name]
        self._users.get(name, {}).pop(name, None)
        block = slice(entity.at, entity.at + entity.size)
        first = int(self._column[entity.at])
        self._source[first : first + entity.size] = -1
        for column in range(first, first + entity.size):
            self._drop_constant(column)
        self._columns.release(first, entity.size)
        self._column[block] = self._root[block] = self._use[block] = -1
        self._entity_at[block] = [""] * entity.size
        self._axis[block] = 0
        self._seen[block] = np.nan

    # --- aliases and constants --------------------------------------------------------------

    def _alias(self, dirty: dict[str, None]) -> None:
        """Columns and constants of what `places.touched` lists; users of what moved are dirty."""
        done: set[int] = set()
        touched, self.places.touched = self.places.touched, set()
        values = self.document.values
        for at in touched:
            if at in done or at >= len(self._root) or self._column[at] < 0:
                continue
            width = self._width(at)
            members = list(self.places.members(at)) if width == 2 else [at]
            done.update(members)
            self._settle(members, width, values, dirty)

    def _width(self, at: int) -> int:
        """2 for a point, 1 for another number."""
        entity = self.document.entities[self._entity_at[at]]
        return 2 if at in self._point_starts(entity) else 1

    def _settle(
        self, members: list[int], width: int, values: NDArray[np.float64], dirty: dict[str, None]
    ) -> None:
        place = self.places.of(members[0]) if width == 2 else None
        source = place.source if place else members[0]
        root = int(self._column[source])
        holds = [
            (name, at, numbers)
            for at in members
            for name, numbers in self._holds.get(at, {}).items()
        ]
        use, constant = root, None
        if holds:
            holds.sort(key=lambda one: (one[2] is None, one[0]))
            constant = self._held(holds, width, values)
            if root in self._constants:
                use = self._constants[root]
                self.rows.set_constant(use, constant)
                self.guards.set_constant(use, constant)
            else:
                use = self._constants[root] = self._take_constant(constant)
        else:
            self._drop_constant(root)
        for at in members:
            own = int(self._column[at])
            if own != root:
                self._drop_constant(own)
                self._source[own : own + width] = -1
            if self._use[at] != use or self._root[at] != root:
                self._dirty_users(self._entity_at[at], dirty)
            for k in range(width):
                self._root[at + k] = root + k
                self._use[at + k] = use if use < 0 else root + k
        for k in range(width):
            self._source[root + k] = source + k if constant is None else -1
            if constant is not None:
                self.x[root + k] = constant[k]

    def _dirty_users(self, entity: str, dirty: dict[str, None]) -> None:
        for user in self._users.get(entity, ()):
            laid = self._laid.get(user)
            if laid is None or not _acts(laid.record):
                continue
            dirty[user] = None
            if isinstance(laid.record, Constraint) and laid.record.kind == "point_on":
                # what else is in the point's place now lies on the curve, or no longer does
                self._tangents_of(laid.record.args[1], dirty)

    def _held(
        self,
        holds: list[tuple[str, int, tuple[float, ...] | None]],
        width: int,
        values: NDArray[np.float64],
    ) -> list[float]:
        """Where holds keep a place; those that contradict the first are impossible."""
        places = [
            list(numbers) if numbers is not None else values[at : at + width].tolist()
            for _, at, numbers in holds
        ]
        for (name, at, _), place in zip(holds, places, strict=True):
            self._impossible.pop((name, at), None)
            scale = max(map(abs, [*place, *places[0]]), default=0.0)
            if any(
                abs(a - b) > LOCK_TOLERANCE * scale for a, b in zip(place, places[0], strict=True)
            ):
                self._impossible[name, at] = f"`{holds[0][0]}` holds it at another place"
        return places[0]

    def _take_constant(self, numbers: Iterable[float]) -> int:
        values = list(numbers)
        at = int(self.rows.constant(values))
        also = int(self.guards.constant(values))
        if at != also:
            raise AssertionError("constants of rows and guards are numbered alike")
        return at

    def _drop_constant(self, column: int) -> None:
        at = self._constants.pop(column, None)
        if at is not None:
            self._unused.append(at)

    # --- rows -------------------------------------------------------------------------------

    def _plan(self, laid: Laid, values: NDArray[np.float64]) -> Plan:
        record = laid.record
        if isinstance(record, Entity):
            return _own_rows(record, values)
        if isinstance(record, Constraint):
            args = operands(self.document, record.args)
            plan = relations.plan_of(record, args, values, self)
            if plan.piece >= 0:
                self._pieces[record.name] = plan.piece
            return plan
        assert isinstance(record, Dimension)
        document = self.document

        def program(text: str) -> Program | None:
            return following.program_of(document, record, text)

        return quantities.plan_of(record, operands(document, record.args), values, program)

    def _lay(self, laid: Laid, values: NDArray[np.float64]) -> None:
        name = laid.record.name
        plan = laid.plan = self._plan(laid, values)
        self._impossible.pop((name, -1), None)
        if plan.impossible:
            self._impossible[name, -1] = plan.impossible
        for hidden in plan.hidden:
            size = len(hidden.names)
            at = self._columns.take(size)
            self._grow()
            laid.hidden.append(at)
            self.x[at : at + size] = hidden.start(values)
            self.low[at : at + size], self.high[at : at + size] = hidden.low, hidden.high
            self._with_hidden[name] = None
        for row in plan.rows:
            laid.rows.append(self._add(self.rows, self.owner, name, row, laid))
        for one in plan.sums:
            laid.sums.append(self._add_sum(name, one, laid))
        for row in plan.guards:
            laid.guards.append(self._add(self.guards, self.guard_owner, name, row, laid))
        if any(setting.which == "guards" for setting in plan.settings):
            self._with_turning[name] = None
        if isinstance(laid.record, Dimension) and laid.record.value is not None:
            self._approach(laid, laid.record, values)

    def _approach(self, laid: Laid, dimension: Dimension, values: NDArray[np.float64]) -> None:
        """A new value is approached from what the quantity is now."""
        plan = cast("Plan", laid.plan)
        if not plan.settings:
            return
        args = operands(self.document, dimension.args)
        now = quantities.measure(dimension.kind, args, values, dimension.side, dimension.mode)
        amount = cast("Amount", dimension.value)
        number = quantities.inner(dimension.kind, amount.number)
        for setting in plan.settings:
            old, new = (setting.scale * one + setting.shift for one in (now, number))
            if setting.which == "rows":
                self._changes["rows", laid.rows[setting.at]] = (old, new)
            elif setting.which == "sums":
                factor = plan.sums[setting.at].parts[0][1]
                self._changes["rows", laid.sums[setting.at]] = (old / factor, new / factor)
            else:
                self._changes["guards", laid.guards[setting.at]] = (old, new)

    def _uses(self, uses: Iterable[Use], laid: Laid) -> list[int]:
        found = []
        for use in uses:
            if isinstance(use, Constant):
                at = self._take_constant(use.numbers)
                laid.constants.append(at)
                found.append(at)
            elif use >= 0:
                found.append(int(self._use[use]))
            else:
                found.append(self._hidden_column(laid, -1 - use))
        return found

    @staticmethod
    def _hidden_column(laid: Laid, number: int) -> int:
        assert laid.plan is not None
        for at, hidden in zip(laid.hidden, laid.plan.hidden, strict=True):
            if number < len(hidden.names):
                return at + number
            number -= len(hidden.names)
        raise IndexError(number)

    def _add(
        self, rows: Any, owner: list[str], name: str, row: Row, laid: Laid, quantity: bool = False
    ) -> int:
        at: int = rows.add(
            row.struct, self._uses(row.uses, laid), _fields(row.data), quantity=quantity
        )
        if rows.m > len(owner):
            owner += [""] * (rows.m - len(owner))
        count = rows.tables[row.struct].residuals
        owner[at : at + count] = [name] * count
        if rows is self.rows:
            if rows.m > len(self._is_equation):
                more = np.zeros(rows.m, dtype=bool)
                self._is_equation = np.concatenate([self._is_equation, more])
            self._is_equation[at : at + count] = not quantity
        return at

    def _add_sum(self, name: str, one: Sum, laid: Laid) -> int:
        """A sum of rows: the first is the row, an expression subtracts the others."""
        (first, factor), *others = one.parts
        data = {**first.data, "weight": factor, "value": one.offset / factor}
        at = self._add(self.rows, self.owner, name, Row(first.struct, first.uses, data), laid)
        read = [row for row, _ in others]
        numbers = [-factor for _, factor in others]
        tape = model.linear(len(others)) if others else None
        if one.program is not None:
            document = self.document
            geometry = [following.property_row(document, path) for path in one.program.geometry]
            read += [row for row in geometry if row is not None]
            numbers += [one.scale]
            numbers += [following.number_of(document, name) for name in one.program.numbers]
            tape = following.with_program(len(others), one.program.tape, len(geometry))
        if tape is not None:
            inputs = [
                self._add(self.rows, self.owner, name, row, laid, quantity=True) for row in read
            ]
            laid.inputs += inputs
            self.rows.add_expression(at, tape, inputs, (), numbers)
        for use, coefficient in one.terms:
            column = self._uses((use,), laid)[0]
            self.rows.add_term(at, column, coefficient)
        return at

    def _remove_rows(self, laid: Laid) -> None:
        """Rows, hidden unknowns and constants of a record."""
        for which, rows in (("rows", [*laid.rows, *laid.sums]), ("guards", laid.guards)):
            for row in rows:
                self._changes.pop((which, row), None)
        for row in (*laid.rows, *laid.sums, *laid.inputs):
            count = self.rows.tables[self.rows.struct(row)].residuals
            self.rows.remove(row)
            self.owner[row : row + count] = [""] * count
            self._is_equation[row : row + count] = False
        for row in laid.guards:
            count = self.guards.tables[self.guards.struct(row)].residuals
            self.guards.remove(row)
            self.guard_owner[row : row + count] = [""] * count
        if laid.plan is not None:
            for at, hidden in zip(laid.hidden, laid.plan.hidden, strict=True):
                size = len(hidden.names)
                self.low[at : at + size], self.high[at : at + size] = -np.inf, np.inf
                self._columns.release(at, size)
        self._with_hidden.pop(laid.record.name, None)
        self._with_turning.pop(laid.record.name, None)
        for at in laid.constants:
            self.rows.release_constant(at)
            self.guards.release_constant(at)
        for numbers in (laid.rows, laid.sums, laid.inputs, laid.guards, laid.hidden):
            numbers.clear()
        laid.constants.clear()
        laid.plan = None

    def _set_value(self, laid: Laid, record: Record | None) -> bool:
        """Take in a dimension that differs in its numbers alone; whether it does."""
        old = laid.record
        if not isinstance(record, Dimension) or not isinstance(old, Dimension):
            return False
        if _shape(old) != _shape(record) or (laid.plan is None) != (not _acts(record)):
            return False
        laid.record = record
        if laid.plan is None:
            return True
        for setting in laid.plan.settings:
            amount = getattr(record, setting.amount)
            number = quantities.inner(record.kind, amount.number)
            value = setting.scale * number + setting.shift
            if setting.which == "rows":
                self._change("rows", laid.rows[setting.at], value)
            elif setting.which == "guards":
                self._change("guards", laid.guards[setting.at], value)
            else:
                factor = laid.plan.sums[setting.at].parts[0][1]
                self._change("rows", laid.sums[setting.at], value / factor)
        return True

    # --- numbers ----------------------------------------------------------------------------

    def gather(self) -> NDArray[np.float64]:
        """Unknowns from the document's numbers, after `refresh`; returns `x`, (n,).

        Where a number of a place was changed in the document, the place starts from there.
        """
        self.refresh()
        values = self.document.values
        live = self._live
        now = values[live]
        moved = live[now.view(np.int64) != self._seen[live].view(np.int64)]
        if len(moved):
            self._take_over(moved, values)
        columns = np.flatnonzero(self._source >= 0)
        self.x[columns] = values[self._source[columns]]
        return self.x

    def _take_over(self, moved: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Start from numbers that were changed in the document."""
        self._seen[moved] = values[moved]
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
        laid = self._laid[name]
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
        moved = self._moved(x)
        if not len(moved):
            return ()
        at = self._live[moved]
        new = x[self._root[at]]
        self.document.set_values(at, new)
        self._seen[at] = new
        return self._entities_at(at)

    def _entities_at(self, at: NDArray[np.int64]) -> tuple[str, ...]:
        """Entities of offsets into the document's values, ascending."""
        first = self._first[at]
        changed = np.flatnonzero(np.diff(first, prepend=-1))
        return tuple([self._entity_at[k] for k in first[changed].tolist()])

    def unknowns_at(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """`x` for other numbers of the document than it has now, (n,)."""
        found = self.gather().copy()
        columns = np.flatnonzero(self._source >= 0)
        found[columns] = values[self._source[columns]]
        return found

    # --- values that changed since the last solve -------------------------------------------

    def take_changes(self) -> dict[tuple[str, int], tuple[float, float]]:
        """Old and new ``value`` by (``rows`` or ``guards``, row), of what changed since last."""
        self.refresh()
        found, self._changes = self._changes, {}
        return {key: one for key, one in found.items() if one[0] != one[1]}

    def return_changes(self, changes: dict[tuple[str, int], tuple[float, float]]) -> None:
        """Changes that were not taken in after all count for the next solve."""
        for key, (old, new) in changes.items():
            self._changes[key] = (old, self._changes.get(key, (old, new))[1])

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

    def piece_of(self, name: str) -> int | None:
        """On which piece of a spline a `point_on` is to be; None: on the nearest."""
        return self._pieces.get(name)

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
        values = self.document.values.copy()
        values[self._live] = x[self._root[self._live]]
        for row in wrong.tolist():
            laid = self._laid[self.guard_owner[row]]
            if ("guards", row) not in self._changes:
                self._approach(laid, cast("Dimension", laid.record), values)

    def renew_sides(self) -> None:
        """Guards of arcs from how they are now: of less or of more than half a turn."""
        values = self.document.values
        for laid in self._laid.values():
            record = laid.record
            if isinstance(record, Entity) and record.kind in ("arc", "earc") and laid.guards:
                curve = Operand(record, "", record.at)
                side = 1.0 if sweep_of(values, curve) < np.pi else -1.0
                self.guards.set_data(laid.guards[-1], "side", side)

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

    @property
    def slacks(self) -> NDArray[np.int64]:
        """Where in `x` slacks of ranges are."""
        table = self._table()
        return table.unknowns[len(table.unknowns) - table.slacks :]

    def _change(self, which: str, row: int, value: float) -> None:
        rows = self.rows if which == "rows" else self.guards
        old = self._changes.get((which, row), (rows.data(row, "value"), 0.0))[0]
        self._changes[which, row] = (old, value)
        rows.set_data(row, "value", value)

    # --- checking ---------------------------------------------------------------------------

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
            if found != expected and not self._meets_at_knot(fresh, name):
                raise AssertionError(f"{name} is laid out as {found}, expected {expected}")

    def _meets_at_knot(self, other: Layout, name: str) -> bool:
        """Whether layouts differ by the piece of a spline only, for a point on the knot between.

        Either piece is right there: which one is taken is decided by rounding.
        """
        mine, theirs = self._pieces.get(name), other._pieces.get(name)
        if mine is None or theirs is None or abs(theirs - mine) != 1:
            return False
        t = float(self.x[self.hidden_at(name)])
        return abs(t - (1.0 if theirs > mine else 0.0)) <= _ON_KNOT

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


def _acts(record: Record) -> bool:
    return isinstance(record, Entity) or (
        isinstance(record, Constraint | Dimension) and record.active
    )


def _same_numbers(old: Record | None, new: Record | None) -> bool:
    """Whether two versions of an entity have the same kind and numbers."""
    if not isinstance(old, Entity) or not isinstance(new, Entity):
        return False
    return (old.kind, old.at, old.size) == (new.kind, new.at, new.size)


def _shape(dimension: Dimension) -> tuple[Any, ...]:
    """What a dimension's rows depend on but for its numbers."""
    value = dimension.value
    return (
        dimension.kind,
        dimension.args,
        dimension.value is None,
        # an expression is a program of its own; its number alone is not what it reads
        dimension.value.text if dimension.value and following.is_live(dimension) else "",
        # slacks start from the geometry when a bound changes
        dimension.low,
        dimension.high,
        dimension.derived,
        dimension.side,
        dimension.mode,
        dimension.active,
        # an expression may follow geometry, or other geometry than before
        None if value is None or literal(value.text) is not None else value.text,
        dimension.broken,
    )


def _fields(data: Mapping[str, Any]) -> dict[str, float]:
    """Fields of a struct by the names of their scalars."""
    found: dict[str, float] = {}
    for name, value in data.items():
        if isinstance(value, int | float):
            found[name] = float(value)
        else:
            found.update({f"{name}[{k}]": float(one) for k, one in enumerate(value)})
    return found


def _own_rows(entity: Entity, values: NDArray[np.float64]) -> Plan:
    """Equations of an arc: its ends are on it. Radii of round curves stay positive."""
    plan = Plan()
    curve = Operand(entity, "", entity.at)
    for radius in curve.ellipse[1:3] if curve.is_elliptic else curve.circle[1:]:
        if values[radius] > 0:
            plan.guard("ScalarValue", radius)
    if not curve.ends:
        return plan
    start, end = curve.ends
    if entity.kind == "arc":
        circle = curve.circle
        plan.add("PointOnCircle", start, *circle)
        plan.add("PointOnCircle", end, *circle)
    else:
        plan.add("PointOnEllipse", start, *curve.ellipse)
        plan.add("PointOnEllipse", end, *curve.ellipse)
    side = 1.0 if sweep_of(values, curve) < np.pi else -1.0
    plan.guard("SweepGuard", curve.center, start, end, side=side)
    return plan
