"""Synthetic measurements: the constraints of a problem at other data, and what these determine.

A variation changes one component of one column in all rows: rotations are turned, numbers are
spread over a wider range. Columns of data are varied in place, as if the same rows were measured
again elsewhere. Parameters of a collection (the pose of each view) are varied as if as many new
rows were added, whose parameters are unknown too and are eliminated.

Measured values that do not enter the derivatives need no change. Where a row has none (both
motions of a hand-eye equation enter), or a loss weighs residuals, the other data of the row is
corrected by Gauss-Newton steps until its residuals vanish, so that the rows are consistent.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.jacobian import Jacobian, jacobian
from arael.analysis.scalars import tangent_units
from arael.analysis.varied_columns import (
    TURN,
    Kind,
    VariedComponent,
    components_of,
    pattern,
    scale_of,
)
from arael.runtime.layout import Column

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_ROUNDS = 8
"""Gauss-Newton steps that make rows consistent; angles up to `TURN` take five."""
_TURNED = 0.1
"""Turn that counts as much as the whole range of a number when rows are made consistent: numbers
are corrected rather than rotations, which would be another variation."""
_RIDGE = 1e-12
_ROUNDING = 1e-9
"""Part of the information of new rows that counts as rounding, once their parameters are
eliminated."""
_SAME = 1e-9
_STEP = 1e-6
MOST = 80
"""Most variations that are tried; each costs a linearisation and a factorisation."""


@dataclass(frozen=True)
class Variation:
    """A change of one component of a column in all rows.

    Attributes
    ----------
    table : the collection, ``motions``
    column : the column, ``a_q``
    part : component, ``x`` or ``[3]``; "" of a single number
    kind : ``turn`` of a rotation or an angle, ``spread`` of other numbers
    index : number of the component: of the rotation vector or the column; of a parameter its scalar
        in the tangent of the entity
    entity : of a parameter, the number of its entity; -1 for data
    now : what the data covers at present, in words
    time : whether the column is a time
    """

    table: str
    column: str
    part: str
    kind: Kind
    index: int
    entity: int = -1
    now: str = ""
    time: bool = False

    @property
    def name(self) -> str:
        """The varied column, ``motions.a_q``."""
        return f"{self.table}.{self.column}"


class Experiments:
    """The problem of a model at varied data.

    Parameters
    ----------
    model : a solved instance; it is not changed
    kept : (n,) bool, free scalars of the problem that count (those not on a bound)

    Attributes
    ----------
    model : the copy of the instance that is varied
    store, layout : its data and its layout
    """

    def __init__(self, model: Any, kept: NDArray[np.bool_]) -> None:
        self.model = model.copy()
        self._problem = self.model._problem()
        self.kept = kept
        self.layout = self._problem.layout
        self.store = self.model._store
        self._base = jacobian(self._problem)

    @cached_property
    def variations(self) -> tuple[Variation, ...]:
        """All variations of data that enters derivatives, and of parameters of collections."""
        found = [one for one in self._of_data() if self._roles[one.table, one.column] == "varied"]
        return (*found, *self._of_parameters())[:MOST]

    @cached_property
    def measured(self) -> dict[str, tuple[str, str]]:
        """Columns that change residuals but no derivative: measured values; (table, column)."""
        return {f"{t}.{c}": (t, c) for (t, c), role in self._roles.items() if role == "measured"}

    def pixels(self) -> Iterator[tuple[str, str]]:
        """Measured pairs of coordinates in pixels: table and column."""
        for table, path in self.measured.values():
            column = self.layout.table(table).column(path)
            if column.shape == (2,) and (column.unit == "px" or "pix" in path or path == "uv"):
                yield table, path

    def pictures(self) -> list[str]:
        """What measured pixels cover, in words."""
        found = []
        for table, path in self.pixels():
            values = np.asarray(self.store.tables[table].column(path))
            low, high = values.min(axis=0), values.max(axis=0)
            found.append(
                f"`{table}.{path}` is now seen from {low[0]:.4g} to {high[0]:.4g} in x and from "
                f"{low[1]:.4g} to {high[1]:.4g} in y"
            )
        return found

    def varied(self, table: str) -> list[Column]:
        """Columns of a collection that enter derivatives."""
        own = self.layout.table(table)
        return [
            own.column(c) for (t, c), role in self._roles.items() if (t, role) == (table, "varied")
        ]

    @cached_property
    def _roles(self) -> dict[tuple[str, str], str]:
        """Role of each column; see `_role`."""
        return {key: self._role(*key) for key in self._columns}

    @cached_property
    def _columns(self) -> list[tuple[str, str]]:
        """Columns of numbers that constraints read, without those of the root and matrices."""
        found = []
        order = {
            (table.path, column.path): (number, k)
            for number, table in enumerate(self.layout.tables)
            for k, column in enumerate(table.columns)
        }
        # In the order of the declarations: that of readers depends on how they were compiled.
        for table, column in sorted(self.layout.readers, key=lambda key: order.get(key, (0, 0))):
            if not table or column.endswith("?") or "#" in column or table.endswith("/rows"):
                continue
            own = self.layout.table(table).column(column)
            plain = own.role == "data" and own.kind == "real" and len(own.shape) < 2
            if plain and self.store.tables[table].size:
                found.append((table, column))
        return found

    def _role(self, table: str, column: str) -> str:
        """What a column does: ``measured``, ``weight`` (scales whole rows), or ``varied``."""
        values = self.store.tables[table].column(column)
        saved = values.copy()
        try:
            roles = set()
            for one in components_of(self.layout.table(table).column(column)):
                values[...] = one.varied(saved, 0.1)
                roles.add(self._effect(jacobian(self.model._problem())))
                values[...] = saved
        finally:
            values[...] = saved
        return "varied" if "varied" in roles else "weight" if "weight" in roles else "measured"

    def _effect(self, rows: Jacobian) -> str:
        before, after = self._base.matrix, rows.matrix
        if before.shape != after.shape:
            return "varied"
        off = abs(after - before)
        if not off.nnz or off.max() <= _SAME * abs(before).max():
            return "measured"
        # A weight scales the residuals of an instance and their derivatives alike.
        a, b = self._base.residuals, rows.residuals
        factor = np.where(a != 0, b / np.where(a != 0, a, 1.0), 1.0)
        scaled = before.multiply(factor[:, None]).tocsr()
        off = abs(after - scaled)
        return "weight" if off.max() <= 1e-6 * abs(before).max() else "varied"

    # --- variations ----------------------------------------------------------------------------

    def _of_data(self) -> Iterator[Variation]:
        for table, path in self._columns:
            column = self.layout.table(table).column(path)
            values = np.asarray(self.store.tables[table].column(path), dtype=np.float64)
            for one in components_of(column):
                now = one.coverage(values)
                yield Variation(table, path, one.part, one.kind, one.index, -1, now, one.is_time)

    def _of_parameters(self) -> Iterator[Variation]:
        system = self._problem.structure.system
        for number, (entity, blocks) in enumerate(
            zip(self.layout.entities, system.blocks, strict=True)
        ):
            if not entity.table or np.count_nonzero(blocks.first >= 0) < 2:
                continue
            units = tangent_units(self.layout, entity)
            for use in entity.params:
                for k in range(use.tangent_start, use.tangent_start + use.tangent):
                    name = entity.prefix + entity.tangent_names[k]
                    kind: Kind = "turn" if units[k] == "rad" else "spread"
                    path = entity.prefix + use.column
                    part = name.removeprefix(path).lstrip(".")
                    column, _, last = part.rpartition(".")
                    full = f"{path}.{column}" if column else path
                    yield Variation(entity.table, full, last, kind, k, number)

    # --- information ---------------------------------------------------------------------------

    def information(self, variation: Variation, reach: float = 1.0) -> Floats:
        """J'J (n, n) of the constraints that read what is varied, over the kept scalars.

        Parameters
        ----------
        reach : factor of the range of numbers; turns are the same
        """
        tables = self.store.tables
        saved = {key: tables[key[0]].column(key[1]).copy() for key in self._columns}
        before = self.model.serialize()
        try:
            groups = self._apply(variation, reach)
            self._make_consistent(variation, groups)
            return self._information(variation, groups)
        finally:
            for (table, path), values in saved.items():
                tables[table].column(path)[...] = values
            self.model.deserialize(before)

    def _apply(self, variation: Variation, reach: float) -> list[int]:
        """Vary the data or the parameters; the groups that read them."""
        if variation.entity < 0:
            values = self.store.tables[variation.table].column(variation.column)
            column = self.layout.table(variation.table).column(variation.column)
            values[...] = components_of(column)[variation.index].varied(values, reach)
            return list(self.layout.readers[variation.table, variation.column])
        problem = self.model._problem()
        entity = self.layout.entities[variation.entity]
        first = problem.structure.system.blocks[variation.entity].first
        rows = np.flatnonzero(first >= 0)
        size = TURN
        if variation.kind == "spread":
            size = reach * self._size(variation, rows)
        step = np.zeros(problem.size)
        step[first[rows] + variation.index] = size * pattern(len(rows))
        problem.evaluation.moved_by(step)
        problem.write_back()
        return [
            number
            for number, group in enumerate(self.layout.groups)
            if any(use.entity == variation.entity for use in group.uses) and entity.table
        ]

    def _size(self, variation: Variation, rows: Ints) -> float:
        """Natural change of a parameter: the spread of its values, or half their size."""
        entity = self.layout.entities[variation.entity]
        state = np.asarray(self._problem.states[variation.entity], dtype=np.float64)[rows]
        for use in entity.params:
            if not use.tangent_start <= variation.index < use.tangent_start + use.tangent:
                continue
            width = 3 if use.kind in ("transform", "similarity") else use.stored
            part = state[:, use.stored_start : use.stored_start + width]
            return scale_of(part)
        return 1.0

    def _make_consistent(self, variation: Variation, groups: list[int]) -> None:
        """Correct other data of the rows until residuals vanish, where derivatives need it."""
        for table in {self.layout.groups[g].table for g in groups}:
            own = [g for g in groups if self.layout.groups[g].table == table]
            lossy = any(self.layout.groups[g].loss_text for g in own)
            known = [c for c in self.measured.values() if c[0] == table]
            if known and not lossy:
                continue
            varied = (variation.table, variation.column)
            free = known or [
                c
                for c in self._columns
                if c[0] == table and c != varied and self.layout.readers[c][0] in own
                and self._roles[c] == "varied"
            ]  # fmt: skip
            if free and len(own):
                self.correct(own, free)

    def correct(
        self, groups: list[int], columns: list[tuple[str, str]], rounds: int = _ROUNDS
    ) -> None:
        """Move data of each row until the residuals of the row vanish.

        By Gauss-Newton steps of least length, in the scales of the columns.

        Parameters
        ----------
        groups : constraints of one collection
        columns : of this collection, which are moved
        """
        entries: list[tuple[Any, VariedComponent, float]] = []
        for table, path in columns:
            live = self.store.tables[table].column(path)
            for one in components_of(self.layout.table(table).column(path)):
                scale = _TURNED if one.kind == "turn" else one.scale(np.asarray(live))
                entries.append((live, one, scale))
        for _ in range(rounds):
            at, residuals = self.residuals(groups)
            if not len(at) or np.abs(residuals).max(initial=0.0) < _SAME:
                return
            slopes = np.zeros((*residuals.shape, len(entries)))
            for k, (live, one, scale) in enumerate(entries):
                saved = live.copy()
                live[...] = one.moved(saved, np.full(len(saved), _STEP * scale))
                slopes[..., k] = (self.residuals(groups)[1] - residuals) / _STEP
                live[...] = saved
            finite = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(residuals).all(axis=1)
            inverse = np.linalg.pinv(slopes[finite], rcond=1e-8)
            steps = -(inverse @ residuals[finite][..., None])[..., 0]
            for k, (live, one, scale) in enumerate(entries):
                step = np.zeros(len(live))
                step[at[finite]] = scale * steps[:, k]
                live[...] = one.moved(live.copy(), step)

    def residuals(self, groups: list[int]) -> tuple[Ints, Floats]:
        """Rows of the table of the groups, and the residuals of all groups at each (rows, m)."""
        problem = self.model._problem()
        size = self.store.tables[self.layout.groups[groups[0]].table].size
        parts, seen = [], np.zeros(size, dtype=bool)
        for number in groups:
            residuals, acting, active = problem.constraint_rows(number)
            whole = np.zeros((size, residuals.shape[1]))
            whole[active[acting]] = residuals[acting]
            seen[active[acting]] = True
            parts.append(whole)
        return np.flatnonzero(seen), np.concatenate(parts, axis=1)[seen]

    def _information(self, variation: Variation, groups: list[int]) -> Floats:
        problem = self.model._problem()
        rows = jacobian(problem)
        labels = {self.layout.groups[g].label for g in groups}
        used = np.isin(rows.label_of, [k for k, one in enumerate(rows.labels) if one in labels])
        entries = np.repeat(np.arange(len(rows)), np.diff(rows.matrix.indptr))
        used[entries[~np.isfinite(rows.matrix.data)]] = False
        used &= np.isfinite(rows.residuals)
        matrix = rows.matrix[np.flatnonzero(used)][:, np.flatnonzero(self.kept)]
        found: Floats = (matrix.T @ matrix).toarray()
        if variation.entity < 0:
            return found
        return _eliminated(found, self._own_scalars(variation.table))

    def _own_scalars(self, table: str) -> NDArray[np.bool_]:
        """(n,) which of the kept scalars are parameters of the rows of a collection."""
        problem = self._problem
        own = np.zeros(problem.size, dtype=bool)
        for entity, blocks in zip(
            self.layout.entities, problem.structure.system.blocks, strict=True
        ):
            if entity.table == table or entity.table.startswith(f"{table}."):
                first = blocks.first[blocks.first >= 0]
                own[(first[:, None] + np.arange(entity.tangent)).ravel()] = True
        found: NDArray[np.bool_] = own[problem.free][self.kept]
        return found


def _eliminated(matrix: Floats, own: NDArray[np.bool_]) -> Floats:
    """The information on other scalars when those of `own` are new unknowns: Schur complement."""
    # imported here: start-up time
    from scipy.linalg import solve_triangular

    found = np.zeros_like(matrix)
    rest = ~own
    scale = _scale(matrix)
    scaled = matrix * scale[:, None] * scale
    inner, outer = scaled[np.ix_(own, own)], scaled[np.ix_(rest, rest)]
    half = solve_triangular(_root(inner), scaled[np.ix_(own, rest)], lower=True)
    # What is left by rounding is no information.
    values, vectors = np.linalg.eigh(outer - half.T @ half)
    values[values < _ROUNDING] = 0
    unit = 1 / scale[rest]
    found[np.ix_(rest, rest)] = (vectors * values) @ vectors.T * unit[:, None] * unit
    return found


def _root(matrix: Floats) -> Floats:
    """Cholesky factor, with a small diagonal for what the matrix does not determine."""
    ridge = _RIDGE
    while True:
        try:
            return np.asarray(np.linalg.cholesky(matrix + ridge * np.eye(len(matrix))))
        except np.linalg.LinAlgError:
            ridge *= 10


def _scale(matrix: Floats) -> Floats:
    """Factors that make the diagonal 1; 1 where it is 0."""
    diagonal = np.diag(matrix)
    return np.asarray(1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
