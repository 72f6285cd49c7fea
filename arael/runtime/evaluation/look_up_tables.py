"""Tables that look-ups read: coefficients between the rows of a collection, interval by interval.

The record of an interval is what a kernel needs for a value within it, in the order in which
`arael.compiler.look_ups` reads it: where the interval begins; where the table begins and ends, if
it is clamped; the coefficients of each interpolated scalar, lowest first; of a rotation, the turn
at which a product of turns begins, then of each factor its rotation vector and the coefficients of
the part of it that is turned by. Coefficients are computed in f64 from all data at once.

Where parameters are looked up, the coefficients are those of the weights of the rows, and the
table has the rows of each interval. The structure of a problem holds the rows that instances read
at its start; derivatives are those of these rows, whose polynomials go on beyond their interval. A
cost is that of the interval which the argument lies in. Once the accepted state leaves an interval,
`arael.runtime.nearness` makes the structure anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import comb, factorial
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group, LookUp
from arael.runtime.store.access import Array, Ints, StoreLike

if TYPE_CHECKING:
    from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Between = Callable[[Floats], Floats]
"""From values (n, order, width) of rows to coefficients (n, width, order), lowest first."""

# Steps between the rows of a B-spline may differ by this part of a step.
_EVEN = 1e-6
# Lanes have the number of an interval, and floats hold whole numbers up to this one.
_MAX_INTERVALS = {np.dtype(np.float32): 1 << 24, np.dtype(np.float64): 1 << 31}


@dataclass(frozen=True)
class LookUpTable:
    """The table of one look-up of a group, in the precision of its kernel.

    Attributes
    ----------
    first, clamp : as of the `LookUp`
    records : (intervals, record)
    starts, ends : (intervals,) where each begins and ends, ascending within an owner
    ranges : (intervals, 2) int32, first interval of the same owner, and the first of the next
    begin : (instances,) the first interval of the owner that each instance looks up in
    near : (intervals, order) int32 rows that values of parameters depend on; no columns for data
    interval_of : (rows,) int32 the interval in which a row is the one at `centre`, or -1
    uses : (uses, 2) int32 use of an entity in one of these rows, and which of them
    centre : the first of `uses` that is of the row at the centre, or -1
    """

    first: int
    clamp: bool
    records: Array
    starts: Array
    ends: Array
    ranges: NDArray[np.int32]
    begin: Ints
    near: NDArray[np.int32]
    interval_of: NDArray[np.int32]
    uses: NDArray[np.int32]
    centre: int = -1

    def intervals_at(self, arguments: Array) -> Ints:
        """(instances,) the interval that each argument lies in, the nearest if it is outside."""
        found = self.begin.copy()
        for first in np.unique(self.begin):
            mine = np.flatnonzero(self.begin == first)
            until = self.ranges[first, 1]
            at = np.searchsorted(self.starts[first:until], arguments[mine], side="right") - 1
            found[mine] = first + np.clip(at, 0, until - first - 1)
        return found

    def outside(self, arguments: Array) -> Ints:
        """Instances whose argument is outside of the table."""
        low, high = self.range_of(np.arange(len(arguments)))
        return np.flatnonzero((arguments < low) | (arguments > high))

    def range_of(self, instances: Ints) -> tuple[Array, Array]:
        """The first and the last argument of these instances that is in the table."""
        begin = self.begin[instances]
        return self.starts[begin], self.ends[self.ranges[begin, 1] - 1]

    def records_at(self, arguments: Array, rows: Array | None = None) -> Array:
        """(instances, record) the records for the arguments; NaN for those outside.

        Of parameters they are those of the intervals whose rows (instances, uses) are read.
        """
        if not len(arguments):
            return np.zeros((0, self.records.shape[1]), dtype=self.records.dtype)
        if rows is not None and self.centre >= 0:
            found = self.records[self.interval_of[rows[:, self.uses[self.centre, 0]]]]
        else:
            found = self.records[self.intervals_at(arguments)]
        if not self.clamp:
            found[self.outside(arguments)] = np.nan
        found[np.isnan(arguments)] = np.nan
        return found


def check_inside(problem: Problem, number: int) -> None:
    """Raise E1018 if a look-up of a group is outside of its table at the accepted state."""
    group, instances = problem.layout.groups[number], problem.instances[number]
    for one, table, arguments in zip(
        group.look_ups, instances.tables, problem.arguments(number), strict=True
    ):
        bad = np.zeros(0, np.int64) if one.clamp or not len(arguments) else table.outside(arguments)
        if not len(bad):
            continue
        low, high = (float(end[0]) for end in table.range_of(bad[:1]))
        others = f", as at {len(bad) - 1} other places" if len(bad) > 1 else ""
        raise SolveError(
            Diagnostic(
                "E1018",
                f"`{problem.instance_place(number, int(bad[0]))}`: "
                f"{float(arguments[bad[0]]):.12g} is outside of `{one.collection}`, which reaches "
                f"from {low:.12g} to {high:.12g}{others}",
                origin=one.where,
                notes=(f"`{group.label}` reads `{one.text}`",),
                help=(
                    "give rows that reach further, start nearer, or guard the constraint; with "
                    "the option `clamp` the value stays that at the nearest end",
                ),
            )
        )


def look_up_tables(
    store: StoreLike, group: Group, slot_rows: list[Ints], dtype: np.dtype[Any]
) -> list[LookUpTable]:
    """The tables of the look-ups of a group.

    Raises
    ------
    SolveError
        E1019: a collection does not have the rows for a look-up.
    """
    found: list[LookUpTable] = []
    same: dict[LookUp, LookUpTable] = {}  # those that differ in their argument alone
    for one in group.look_ups:
        what = structs.replace(one, first=0, where="", text="", rows=())
        if what not in same:
            same[what] = _Builder(store, group, one).table(slot_rows[one.slot], dtype)
        uses = [
            (number, one.rows.index(use.slot))
            for number, use in enumerate(group.uses)
            if use.slot in one.rows
        ]
        middle = (one.order - 1) // 2
        found.append(
            replace(
                same[what],
                first=one.first,
                uses=np.array(uses, dtype=np.int32).reshape(-1, 2),
                centre=next((number for number, (_, k) in enumerate(uses) if k == middle), -1),
            )
        )
    return found


class _Builder:
    """Builds the table of one look-up."""

    def __init__(self, store: StoreLike, group: Group, one: LookUp) -> None:
        self.store, self.group, self.one = store, group, one
        table = store.tables[one.collection]
        self.key = np.asarray(table.column(one.key), dtype=np.float64)
        values = np.asarray(table.column(one.column or one.key), dtype=np.float64)
        self.values = values.reshape(len(self.key), one.width if one.column else 1)
        self.parents = np.asarray(table.parent_rows(), dtype=np.int64)

    def table(self, owners: Ints, dtype: np.dtype[Any]) -> LookUpTable:
        """The table, for instances with these owners of the rows."""
        one, k = self.one, self.one.order
        order = np.lexsort((self.key, self.parents))
        self._require_finite()
        key, parents, values = self.key[order], self.parents[order], self.values[order]
        size = self.store.tables[self.store.layout.table(one.collection).parent].size
        count = np.bincount(parents, minlength=size)
        least = k if one.spline else 2
        self._require_rows(owners, count, least)
        self._require_order(order, key, parents)
        # First rows of the owners, and the intervals of each: between rows, or around them.
        first = np.cumsum(count) - count
        lost = k - 1 if one.spline else 1
        intervals = np.maximum(count - lost, 0)
        begin = np.cumsum(intervals) - intervals
        owner = np.repeat(np.arange(size), intervals)
        local = np.arange(len(owner)) - begin[owner]
        # The row at the start of each interval, and the rows that its value depends on.
        at = first[owner] + local + ((k - 1) // 2 if one.spline else 0)
        window = at[:, None] + np.arange(k) - (k - 1) // 2
        window = np.clip(window, first[owner, None], (first + count)[owner, None] - 1)
        if one.spline:
            step = self._steps(order, key, first, count, owners)[owner]
            start = key[at] - (k % 2) * step / 2
            end = start + step
            between = _spline(step, k)
        else:
            start, end = key[at], key[at + 1]
            between = _line(end - start) if k == 2 else _cubic(key[window])
        columns = [start[:, None]]
        if one.clamp and len(owner):
            last = (begin + intervals - 1)[owner]
            columns += [start[begin[owner], None], end[last, None]]
        if len(owner):
            columns += self._coefficients(values[window], between)
            records = np.concatenate(columns, axis=1)
        else:
            records = np.zeros((0, one.record))
        if len(owner) > _MAX_INTERVALS[dtype]:
            raise self._error(
                f"`{one.collection}` has {len(owner)} intervals, more than a look-up in "
                f"{'f32' if dtype == np.float32 else 'f64'} can number",
                "let the root compute in f64, or leave rows out",
            )
        ranges = np.stack([begin[owner], (begin + intervals)[owner]], axis=1)
        interval_of = np.full(len(key), -1, dtype=np.int32)
        interval_of[order[at]] = np.arange(len(owner))
        return LookUpTable(
            one.first,
            one.clamp,
            np.ascontiguousarray(records, dtype=dtype),
            np.ascontiguousarray(start, dtype=dtype),
            np.ascontiguousarray(end, dtype=dtype),
            np.ascontiguousarray(ranges, dtype=np.int32),
            begin[owners],
            np.ascontiguousarray(order[window] if one.rows else window[:, :0], dtype=np.int32),
            interval_of,
            np.zeros((0, 2), dtype=np.int32),
        )

    def _coefficients(self, rows: Floats, between: Between) -> list[Floats]:
        """Columns of the records, from values (n, order, width) of rows."""
        one, n = self.one, len(rows)
        weights = np.broadcast_to(np.eye(one.order), (n, one.order, one.order))
        if one.value == "weights":
            return [between(weights).reshape(n, -1)]
        moved = rows[:, :, : one.moved]
        if one.value == "wrapped":
            moved = np.unwrap(moved, axis=1)
        found = [between(moved).reshape(n, -1)]
        if not one.turned:
            return found
        q = rows[:, :, -4:] / np.linalg.norm(rows[:, :, -4:], axis=2, keepdims=True)
        found.append(q[:, 0])
        # Of each row the weight as a polynomial, then the sums of those from each row on.
        cumulative = np.cumsum(between(weights)[:, ::-1], axis=1)[:, ::-1]
        for j in range(1, one.order):
            axis = _rotation_vector(_quotient(q[:, j - 1], q[:, j]))
            if one.order == 2:
                found.append(axis * cumulative[:, 1, 1:])
            else:
                found += [axis, cumulative[:, j]]
        return found

    # --- what a table must have -----------------------------------------------------------------

    def _require_finite(self) -> None:
        bad = np.flatnonzero(~np.isfinite(self.key))
        if len(bad):
            raise self._error(
                f"`{self._row(bad[0])}.{self.one.key}` is {self.key[bad[0]]}",
                "a key is a finite number: give one, or remove the row",
            )

    def _require_rows(self, owners: Ints, count: Ints, least: int) -> None:
        few = owners[count[owners] < least] if len(owners) else owners
        if len(few):
            named = self.store.tables[self.store.layout.table(self.one.collection).parent]
            name = ".".join(n for n in (named.row_name(int(few[0])), self._field) if n)
            have = int(count[few[0]])
            raise self._error(
                f"`{name}` has {have} row{'s' * (have != 1)}, fewer than the {least} of this "
                "look-up",
                "give more rows, or guard the constraint so that it does not act there",
            )

    def _require_order(self, order: Ints, key: Floats, parents: Ints) -> None:
        same = np.flatnonzero((np.diff(key) == 0) & (np.diff(parents) == 0))
        if len(same):
            a, b = sorted((int(order[same[0]]), int(order[same[0] + 1])))
            raise self._error(
                f"`{self._row(a)}` and `{self._row(b)}` have the same key, "
                f"`{self.one.key}` = {key[same[0]]:.12g}",
                "rows that are looked up have different keys: remove one of them",
            )

    def _steps(self, order: Ints, key: Floats, first: Ints, count: Ints, owners: Ints) -> Floats:
        """(owners,) step between the rows of a B-spline, which are evenly spaced."""
        if not len(key):
            return np.zeros(len(count))
        last = np.maximum(first + count - 1, first)
        inside = np.minimum(np.stack([first, last]), len(key) - 1)
        step = (key[inside[1]] - key[inside[0]]) / np.maximum(count - 1, 1)
        for owner in np.unique(owners):
            rows = key[first[owner] : last[owner] + 1]
            off = np.abs(np.diff(rows) - step[owner]) > _EVEN * step[owner]
            if off.any():
                at = int(np.argmax(off))
                place = self._row(int(order[first[owner] + at + 1]))
                raise self._error(
                    f"`{place}` is {rows[at + 1] - rows[at]:.12g} after the row before it, where "
                    f"rows are {step[owner]:.12g} apart on average",
                    "the control points of a B-spline are evenly spaced; `linear` and `cubic` "
                    "take any spacing",
                )
        return np.asarray(step)

    @property
    def _field(self) -> str:
        return self.store.layout.table(self.one.collection).field

    def _row(self, row: int) -> str:
        return str(self.store.tables[self.one.collection].row_name(int(row)))

    def _error(self, message: str, help_: str) -> SolveError:
        one = self.one
        return SolveError(
            Diagnostic(
                "E1019",
                message,
                origin=one.where,
                notes=(f"`{self.group.label}` reads `{one.text}`",),
                help=(help_,),
            )
        )


def _line(h: Floats) -> Between:
    """On the lines between two rows, which are `h` (n,) apart."""
    return lambda rows: np.stack([rows[:, 0], (rows[:, 1] - rows[:, 0]) / h[:, None]], axis=-1)


def _cubic(t: Floats) -> Between:
    """Cubic Hermite interpolation, from the keys (n, 4) around an interval.

    The slope at a row is that of the parabola through it and its neighbours (Bessel's tangents),
    for evenly spaced rows that of Catmull and Rom; at the ends, where the neighbour is the row
    itself, that of the interval.
    """
    before, h, after = np.diff(t, axis=1).T[..., None]

    def slope(step: Floats, difference: Floats, inner: Floats) -> Floats:
        part = np.where(step > 0, h / (step + h), 0)
        return np.asarray(inner + part * (difference / np.where(step > 0, step, 1) - inner))

    def between(rows: Floats) -> Floats:
        p, q = rows[:, 1], rows[:, 2]
        inner = (q - p) / h
        m0 = slope(before, p - rows[:, 0], inner)
        m1 = slope(after, rows[:, 3] - q, inner)
        square, cube = (3 * inner - 2 * m0 - m1) / h, (m0 + m1 - 2 * inner) / h**2
        return np.stack([p, m0, square, cube], axis=-1)

    return between


def _spline(step: Floats, k: int) -> Between:
    """Uniform B-spline of order k, whose control points are `step` (n,) apart."""
    weights, powers = _uniform_weights(k), step[:, None, None] ** np.arange(k)
    return lambda rows: np.einsum("nkc,kd->ncd", rows, weights) / powers


def _uniform_weights(k: int) -> Floats:
    """(k, k) of the control points of a uniform B-spline of order k, by powers of u in [0, 1).

    Qin, General matrix representations for B-splines (2000), as in Sommer et al. (2020), eq. 7.
    """
    found = np.zeros((k, k))
    for s in range(k):
        for n in range(k):
            total = sum(
                (-1) ** (j - s) * comb(k, j - s) * float(k - 1 - j) ** (k - 1 - n)
                for j in range(s, k)
            )
            found[s, n] = comb(k - 1, n) / factorial(k - 1) * total
    return found


def _quotient(p: Floats, q: Floats) -> Floats:
    """p* q of unit quaternions (n, 4), with a positive scalar part."""
    w = np.sum(p * q, axis=1)
    v = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
    found = np.concatenate([w[:, None], v], axis=1)
    return np.where(w[:, None] < 0, -found, found)


def _rotation_vector(q: Floats) -> Floats:
    """Rotation vectors (n, 3) of unit quaternions with a positive scalar part."""
    sine = np.linalg.norm(q[:, 1:], axis=1)
    small = sine < 1e-9
    factor = np.where(small, 2.0, 2 * np.arctan2(sine, q[:, 0]) / np.where(small, 1.0, sine))
    return factor[:, None] * q[:, 1:]
