"""The numbered system of equations, for those who read all of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import components, extent, spread
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.measures import measured
from arael.sketch.document.records import Dimension
from arael.sketch.layout import quantities
from arael.sketch.layout.linearisation import Linearisation, Numbering
from arael.sketch.layout.numbers import Numbers
from arael.sketch.layout.plan import Plan


class System(Numbers):
    """Unknowns and equations without gaps, their names, and what hangs together."""

    # --- numbering ------------------------------------------------------------------------

    def _table(self) -> Numbering:
        """Numbering of unknowns and equations without gaps, for those who read the whole system."""
        self.refresh()
        table = self._numbering
        if table is None or table.version != self.version:
            table = self._numbering = self._numbered()
        return table

    def _numbered(self) -> Numbering:
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
        return Numbering(self.version, unknowns, column, column_of, rows, number, is_range, slacks)

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

    @property
    def slacks(self) -> NDArray[np.int64]:
        """Where in `x` slacks of ranges are."""
        self.refresh()
        if self._slacks is None or self._slacks[0] != self.version:
            found = [
                at + k
                for laid in map(self._laid.__getitem__, self._with_hidden)
                if isinstance(laid.record, Dimension)
                for at, size in self._hidden_blocks(laid)
                for k in range(size)
            ]
            self._slacks = (self.version, np.array(sorted(found), dtype=np.int64))
        return self._slacks[1]

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

    def hidden_numbers(self, name: str) -> int:
        """How many unknowns of its own a relation has."""
        laid = self._laid.get(name)
        if laid is None or isinstance(laid.record, Dimension):
            return 0
        return sum(size for _, size in self._hidden_blocks(laid))

    def is_turned(self, name: str) -> bool:
        """Whether a record is on the other side than it says, where the document is."""
        laid = self._laid.get(name)
        if laid is None:
            return False
        record = laid.record
        if isinstance(record, Dimension) and record.kind == "xangle" and record.value is not None:
            if self.document.entities[record.args[0]].kind != "line":
                return False
            # It has no guard: its line turns all the way.
            now = measured(self.document, record.kind, record.args)
            return abs(math.remainder(now - record.value.number, 360.0)) > 90.0
        if not laid.guards:
            return False
        return bool((self.guards.evaluate(self.gather())[laid.guards] < 0.0).any())

    def rows_of(self, name: str) -> NDArray[np.int64]:
        """Equations of a record: rows of `linearisation`."""
        table = self._table()
        return table.number[self.first_rows(name)]

    # --- names of unknowns ----------------------------------------------------------------

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

    def _number_name(self, offset: int) -> str:
        entity = self.document.entities[self._entity_at[offset]]
        for name, at in reversed(point_offsets(entity).items()):
            if offset - at in (0, 1):
                return f"{entity.name}.{name}.{'xy'[offset - at]}"
        return f"{entity.name}.{ENTITIES[entity.kind].values[offset - entity.at]}"

    def _members(self, offset: int) -> list[int]:
        """Offsets of the numbers that share a column with one."""
        root = self._root[offset]
        entity = self.document.entities[self._entity_at[offset]]
        for point in self._point_starts(entity):
            if offset - point in (0, 1):
                return [p + offset - point for p in self.places.members(point)]
        assert root >= 0
        return [offset]

    # --- sizes and units ------------------------------------------------------------------

    @property
    def size(self) -> float:
        """Extent of the drawing: its larger side, or the largest diameter; of a single place 1."""
        self.refresh()
        moves = self.document.moves
        if self._sized[:2] == (moves, self._drawn):
            return self._sized[2]
        if self._extent is None or self._extent[0] != self._drawn:
            at = (np.flatnonzero(self._axis == 1), np.flatnonzero(self._axis == 3))
            self._extent = (self._drawn, *at)
        _, points, lengths = self._extent
        found = extent(self.document.values, points, lengths) or 1.0 if len(points) else 1.0
        self._sized = (moves, self._drawn, found)
        return found

    def axes(self) -> NDArray[np.int8]:
        """What each element of `x` is: 1 an x, 2 a y, 3 another length, 4 an angle; 0 nothing."""
        self.refresh()
        found = np.zeros(len(self.x), dtype=np.int8)
        spread(self._axis, self._root, found)
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

    # --- the whole system -----------------------------------------------------------------

    def components(self) -> NDArray[np.int32]:
        """Number of the component by row, then by element of `x`: what hangs together by rows."""
        self.refresh()
        if self._components is None or self._components[0] != self.version:
            self._components = (self.version, components(self.rows))
        return self._components[1]

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
        entities = self.document.entities
        return [
            arg
            for arg in (record.args if record else ())
            if "." in arg or entities[arg].kind == "point"
        ]

    def linearisation(
        self,
        x: NDArray[np.float64] | None = None,
        *,
        without: Sequence[int] | NDArray[np.int64] = (),
        ranges: bool = True,
    ) -> Linearisation:
        """The whole system at the document's numbers, or at unknowns `x` by column.

        Parameters
        ----------
        without : rows of the layout that are left out
        ranges : with rows and slacks of ranges, which take no freedom
        """
        table = self._table()
        at = self.gather() if x is None else self.with_unknowns(x)
        residuals, entries = self.rows.jacobian(at)
        indptr, indices = self.rows.indptr, self.rows.indices
        keep = np.ones(len(table.rows), dtype=bool)
        if len(without):
            left_out = table.number[np.asarray(without, dtype=np.int64)]
            keep[left_out[left_out >= 0]] = False
        if not ranges:
            keep &= ~table.is_range
        rows = table.rows[keep]
        counts = np.diff(indptr)[rows]
        kept = np.zeros(self.rows.m, dtype=bool)
        kept[rows] = True
        entry = np.repeat(kept, np.diff(indptr))
        n = len(table.unknowns) - (0 if ranges else table.slacks)
        found = entries[entry]
        # Where an expression has no derivative (sqrt at 0), it is judged as one that is constant.
        found[~np.isfinite(found)] = 0.0
        return Linearisation(
            at[table.unknowns[:n]],
            residuals[rows],
            np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
            table.column[indices[entry]].astype(np.int32),
            found,
            rows,
            self.owner,
        )

    def with_unknowns(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """All of `x`, with unknowns given by column."""
        full = self.gather().copy()
        full[self.unknowns[: len(x)]] = x
        return full
