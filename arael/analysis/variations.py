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

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arael.analysis.jacobian import Jacobian, jacobian
from arael.analysis.scalars import tangent_units
from arael.geometry.quaternions import quat_conjugate, quat_exp, quat_log, quat_product
from arael.runtime.layout import Column

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_TURN = 0.7
"""Largest turn of a rotation [rad]: far enough from the identity for all axes, less than a quarter
turn, so that what is seen stays in front."""
_WIDER = 2.0
"""Range of varied numbers relative to the present one."""
_LONGER = 3.0
"""Time span relative to the present one."""
_NARROW = 0.1
"""Range relative to the size of the numbers below which they count as constant."""
_SHIFT = 0.5
"""Change of numbers that are constant, relative to their size."""
_ROUNDS = 8
"""Gauss-Newton steps that make rows consistent; angles up to `_TURN` take five."""
_FAR_ROUNDS = 15
"""The same for points that are sought across a whole picture."""
_TURNED = 0.1
"""Turn that counts as much as the whole range of a number when rows are made consistent: numbers
are corrected rather than rotations, which would be another variation."""
_ROUNDING = 1e-9
"""Part of the information of new rows that counts as rounding, once their parameters are
eliminated."""
_SAME = 1e-9
_STEP = 1e-6
MOST = 80
"""Most variations that are tried; each costs a linearisation and a factorisation."""
_TIMES = ("t", "time", "times", "stamp", "timestamp", "dt", "duration")

Kind = Literal["turn", "spread"]


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
    """

    def __init__(self, model: Any, kept: NDArray[np.bool_]) -> None:
        self._model = model.copy()
        self._problem = self._model._problem()
        self._kept = np.flatnonzero(kept)
        self.layout = self._problem.layout
        self.store = self._model._store
        self._base = jacobian(self._problem)

    @cached_property
    def variations(self) -> tuple[Variation, ...]:
        """All variations of data that enters derivatives, and of parameters of collections."""
        found = [one for one in self._of_data() if one.name not in self.measured]
        return (*found, *self._of_parameters())[:MOST]

    @cached_property
    def measured(self) -> dict[str, tuple[str, str]]:
        """Columns that change residuals but no derivative: measured values; (table, column)."""
        return {f"{t}.{c}": (t, c) for t, c in self._columns if self._role(t, c) == "measured"}

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
            own.column(c) for t, c in self._columns if t == table and self._role(t, c) == "varied"
        ]

    def prediction_rows(
        self,
        table: str,
        sources: Ints,
        measured: Column,
        values: Floats,
        moved: Column,
        tolerance: float,
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Derivatives of predictions at rows that predict given values.

        Parameters
        ----------
        table : the collection of the rows
        sources : (n,) rows that are copied
        measured, values : column of what is measured, and what shall be predicted (n, 2)
        moved : column that is moved until it is

        Returns
        -------
        (n, 2, k) derivatives by the kept scalars; (n,) whether the values are predicted.
        """
        model = self._model.copy()
        trial = Experiments(model, np.isin(np.arange(len(self._base.names)), self._kept))
        trial._take_rows(table, sources, measured.path, values)
        groups = list(self.layout.readers[table, measured.path])
        trial._correct(groups, [(table, moved.path)], _FAR_ROUNDS)
        problem = trial._model._problem()
        rows = jacobian(problem)
        found = np.zeros(len(sources), dtype=bool)
        slopes = np.zeros((len(sources), 2, len(self._kept)))
        ends = np.cumsum([0, *(len(active) for active in problem.structure.active)])
        live = trial.store.tables[table].column(measured.path)
        weights = []
        for k in range(2):
            live[:, k] += 1.0
            weights.append(trial._residuals(groups))
            live[:, k] -= 1.0
        at, residuals = trial._residuals(groups)
        whole = np.zeros((len(sources), residuals.shape[1], 2))
        for k in range(2):
            whole[at, :, k] = residuals - weights[k][1]
        good = np.zeros(len(sources), dtype=bool)
        good[at] = np.abs(residuals).max(axis=1) < tolerance
        for number in groups:
            mine = np.flatnonzero(
                (rows.constraint >= ends[number]) & (rows.constraint < ends[number + 1])
            )
            m = self.layout.groups[number].residuals
            if m != 2 or not len(mine):
                continue
            row = problem.structure.active[number][rows.constraint[mine][::m] - ends[number]]
            offset = 2 * groups.index(number)
            weight = whole[row, offset : offset + 2]
            own = rows.matrix[mine][:, self._kept].toarray().reshape(len(row), 2, -1)
            usable = good[row] & np.isfinite(own).all(axis=(1, 2))
            usable &= np.abs(np.linalg.det(weight)) > 0
            row, own, weight = row[usable], own[usable], weight[usable]
            slopes[row] = np.linalg.solve(weight, own)
            found[row] = True
        return slopes, found

    def _take_rows(self, table: str, sources: Ints, measured: str, values: Floats) -> None:
        """Replace the rows of a collection by copies of some, with other measured values."""
        own = self.store.tables[table]
        columns: dict[str, Any] = {}
        for column in self.layout.table(table).columns:
            if column.role == "ref":
                columns[column.path] = np.asarray(own.target_rows(column.path))[sources]
            elif column.role == "data":
                columns[column.path] = np.asarray(own.column(column.path))[sources].copy()
        columns[measured] = values
        nested = bool(self.layout.table(table).parent)
        parents = np.asarray(own.parent_rows())[sources] if nested else None
        own.clear()
        own.extend(len(sources), parents, **columns)

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
            for index in range(_components(self.layout.table(table).column(column))):
                values[...] = self._varied(table, column, index, saved, 0.1)
                roles.add(self._effect(jacobian(self._model._problem())))
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
            time = path.rpartition(".")[2].lower() in _TIMES or column.unit == "s"
            for index in range(_components(column)):
                kind = _kind(column, index)
                part = _part(column, index)
                now = _coverage(column, values, index, kind)
                yield Variation(table, path, part, kind, index, -1, now, time)

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

    def _varied(self, table: str, path: str, index: int, values: Floats, share: float) -> Floats:
        """The values of a column, one component of which is varied."""
        column = self.layout.table(table).column(path)
        found = np.array(values, dtype=np.float64)
        pattern = share * _pattern(len(found))
        if _kind(column, index) == "turn":
            pattern /= max(share, 1.0)
            start = _rotation(column)
            if start is None:
                part = found if found.ndim == 1 else found[:, index]
                part += _TURN * pattern
                return found
            axis = np.zeros((len(found), 3))
            axis[:, index - start] = _TURN * pattern
            turned = quat_product(quat_exp(axis), found[:, start : start + 4])
            found[:, start : start + 4] = turned
            return found
        flat = found.reshape(len(found), -1)
        time = path.rpartition(".")[2].lower() in _TIMES or column.unit == "s"
        flat[:, index] = _spread(flat, index, pattern, share, time)
        return found

    # --- information ---------------------------------------------------------------------------

    def information(self, variation: Variation, reach: float = 1.0) -> Floats:
        """J'J (n, n) of the constraints that read what is varied, over the kept scalars.

        Parameters
        ----------
        reach : factor of the range of numbers; turns are the same
        """
        tables = self.store.tables
        saved = {key: tables[key[0]].column(key[1]).copy() for key in self._columns}
        before = self._model.serialize()
        try:
            groups = self._apply(variation, reach)
            self._make_consistent(variation, groups)
            return self._information(variation, groups)
        finally:
            for (table, path), values in saved.items():
                tables[table].column(path)[...] = values
            self._model.deserialize(before)

    def _apply(self, variation: Variation, reach: float) -> list[int]:
        """Vary the data or the parameters; the groups that read them."""
        if variation.entity < 0:
            values = self.store.tables[variation.table].column(variation.column)
            values[...] = self._varied(
                variation.table, variation.column, variation.index, values, reach
            )
            return list(self.layout.readers[variation.table, variation.column])
        problem = self._model._problem()
        entity = self.layout.entities[variation.entity]
        first = problem.structure.system.blocks[variation.entity].first
        rows = np.flatnonzero(first >= 0)
        size = _TURN
        if variation.kind == "spread":
            size = reach * self._size(variation, rows)
        step = np.zeros(problem.size)
        step[first[rows] + variation.index] = size * _pattern(len(rows))
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
            return _scale_of(part)
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
                and self._role(*c) == "varied"
            ]  # fmt: skip
            if free and len(own):
                self._correct(own, free)

    def _correct(
        self, groups: list[int], columns: list[tuple[str, str]], rounds: int = _ROUNDS
    ) -> None:
        """Gauss-Newton steps of least length, each row for itself, in the scales of the columns."""
        entries = []
        for table, path in columns:
            column = self.layout.table(table).column(path)
            values = np.asarray(self.store.tables[table].column(path), dtype=np.float64)
            for index in range(_components(column)):
                scale = _TURNED
                if _kind(column, index) == "spread":
                    scale = _scale_of(values.reshape(len(values), -1)[:, _flat_places(column)])
                entries.append((table, path, index, scale))
        for _ in range(rounds):
            at, residuals = self._residuals(groups)
            if not len(at) or np.abs(residuals).max(initial=0.0) < _SAME:
                return
            slopes = np.zeros((*residuals.shape, len(entries)))
            for k, (table, path, index, scale) in enumerate(entries):
                live = self.store.tables[table].column(path)
                saved = live.copy()
                step = np.full(len(saved), _STEP * scale)
                live[...] = self._moved(table, path, index, saved, step)
                slopes[..., k] = (self._residuals(groups)[1] - residuals) / _STEP
                live[...] = saved
            finite = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(residuals).all(axis=1)
            inverse = np.linalg.pinv(slopes[finite], rcond=1e-8)
            steps = -(inverse @ residuals[finite][..., None])[..., 0]
            for k, (table, path, index, scale) in enumerate(entries):
                live = self.store.tables[table].column(path)
                step = np.zeros(len(live))
                step[at[finite]] = scale * steps[:, k]
                live[...] = self._moved(table, path, index, live.copy(), step)

    def _moved(self, table: str, path: str, index: int, values: Floats, step: Floats) -> Floats:
        """Values of a column, one component of which is moved by `step` (rows,)."""
        column = self.layout.table(table).column(path)
        found = np.array(values, dtype=np.float64)
        start = _rotation(column)
        if start is not None and index >= start:
            axis = np.zeros((len(found), 3))
            axis[:, index - start] = step
            found[:, start : start + 4] = quat_product(quat_exp(axis), found[:, start : start + 4])
            return found
        found.reshape(len(found), -1)[:, index] += step
        return found

    def _residuals(self, groups: list[int]) -> tuple[Ints, Floats]:
        """Rows of the table of the groups, and the residuals of all groups at each (rows, m)."""
        problem = self._model._problem()
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
        problem = self._model._problem()
        rows = jacobian(problem)
        labels = {self.layout.groups[g].label for g in groups}
        used = np.isin(rows.label_of, [k for k, one in enumerate(rows.labels) if one in labels])
        entries = np.repeat(np.arange(len(rows)), np.diff(rows.matrix.indptr))
        used[entries[~np.isfinite(rows.matrix.data)]] = False
        used &= np.isfinite(rows.residuals)
        matrix = rows.matrix[np.flatnonzero(used)][:, self._kept]
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
        found: NDArray[np.bool_] = own[problem.free][self._kept]
        return found


def _eliminated(matrix: Floats, own: NDArray[np.bool_]) -> Floats:
    """The information on other scalars when those of `own` are new unknowns: Schur complement."""
    found = np.zeros_like(matrix)
    rest = ~own
    inner = matrix[np.ix_(own, own)]
    scale = 1 / np.sqrt(np.where(np.diag(inner) > 0, np.diag(inner), 1.0))
    inverse = np.linalg.pinv(inner * scale[:, None] * scale, rcond=1e-12, hermitian=True)
    cross = matrix[np.ix_(rest, own)] * scale
    outer = matrix[np.ix_(rest, rest)]
    unit = 1 / np.sqrt(np.where(np.diag(outer) > 0, np.diag(outer), 1.0))
    left = (outer - cross @ inverse @ cross.T) * unit[:, None] * unit
    # What is left by rounding is no information.
    values, vectors = np.linalg.eigh(left)
    values[values < _ROUNDING] = 0
    found[np.ix_(rest, rest)] = (vectors * values) @ vectors.T / unit[:, None] / unit
    return found


# --- columns ------------------------------------------------------------------------------------


def _rotation(column: Column) -> int | None:
    """Place of the quaternion in a column; None if it has none."""
    kind = column.type.split()[0]
    return {"quat": 0, "quaternion": 0, "transform": 3, "similarity": 3}.get(kind)


def _components(column: Column) -> int:
    """Number of components that are varied: three of a rotation."""
    size = math.prod(column.shape)
    return size if _rotation(column) is None else size - 1


def _flat_places(column: Column) -> slice:
    start = _rotation(column)
    return slice(None) if start is None else slice(0, start)


def _kind(column: Column, index: int) -> Kind:
    start = _rotation(column)
    if start is not None:
        return "turn" if start <= index < start + 3 else "spread"
    return "turn" if column.unit == "rad" or column.type.startswith("angle") else "spread"


def _part(column: Column, index: int) -> str:
    start = _rotation(column)
    if start is not None:
        return "xyz"[index - start] if start <= index < start + 3 else "xyzs"[min(index, 3)]
    if not column.shape:
        return ""
    return "xyz"[index] if column.shape[0] <= 3 else f"[{index}]"


def _pattern(count: int) -> Floats:
    """Numbers from -1 to 1 that fill the interval evenly, without a period (golden ratio)."""
    found: Floats = 2 * np.modf(0.5 + 0.6180339887498949 * np.arange(count))[0] - 1
    return found


def _scale_of(values: Floats) -> float:
    """Natural size of a change: the widest half range of components, or their size, or 1."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 1.0
    wide = float((np.nanmax(values, axis=0) - np.nanmin(values, axis=0)).max()) / 2
    size = float(np.abs(finite).max())
    if wide > _NARROW * size / 2:
        return wide
    return _SHIFT * size or 1.0


def _spread(flat: Floats, index: int, pattern: Floats, share: float, time: bool) -> Floats:
    """One component (n,) of values (n, k) over a wider range."""
    values = flat[:, index]
    low, high = float(values.min()), float(values.max())
    wider = 1 + share * ((_LONGER if time else _WIDER) - 1)
    if time and high > low:
        return np.asarray(low + wider * (values - low))
    scale = _scale_of(flat)
    if high - low > _NARROW * max(abs(low), abs(high), scale if flat.shape[1] > 1 else 0.0):
        middle = low if low >= 0 else high if high <= 0 else (low + high) / 2
        return np.asarray(middle + wider * (values - middle))
    return np.asarray(values + scale * pattern)


def _coverage(column: Column, values: Floats, index: int, kind: Kind) -> str:
    """What the rows cover at present, in words."""
    unit = f" {column.unit}" if column.unit else ""
    start = _rotation(column)
    if start is not None and kind == "turn":
        return _turns(values[:, start : start + 4])
    part = values.reshape(len(values), -1)[:, index]
    low, high = float(part.min()), float(part.max())
    if high - low <= 1e-9 * max(abs(low), abs(high), 1e-300):
        return f"{low + 0.0:.4g}{unit} in all rows"
    return f"{low:.4g} to {high:.4g}{unit}"


def _turns(quaternions: Floats) -> str:
    """The axes about which rotations differ."""
    first = quaternions[:1]
    apart = quat_log(quat_product(quat_conjugate(np.broadcast_to(first, quaternions.shape)),
                                  quaternions))  # fmt: skip
    whole = quat_log(quaternions)
    vectors = apart if np.linalg.norm(apart) < np.linalg.norm(whole) else whole
    values, axes = np.linalg.eigh(vectors.T @ vectors / len(vectors))
    angles = np.sqrt(np.maximum(values, 0.0))
    if angles[2] < 1e-3:
        return "no turn"
    wide = [k for k in (2, 1, 0) if angles[k] > 0.05 * angles[2]]
    if len(wide) == 1:
        return f"turns about one axis, {_axis(axes[:, 2])}"
    if len(wide) == 2:
        return f"no turn about {_axis(axes[:, 0])}"
    return f"turns of {np.degrees(angles[0]):.2g} to {np.degrees(angles[2]):.2g} deg"


def _axis(axis: Floats) -> str:
    at = int(np.argmax(np.abs(axis)))
    if abs(axis[at]) > 0.99:
        return "xyz"[at]
    axis = axis * np.sign(axis[at])
    return "(" + ", ".join(f"{value:.2f}" for value in axis) + ")"
