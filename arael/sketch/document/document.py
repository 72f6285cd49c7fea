"""A sketch as data: records by name, numbers in one array, every change undoable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.sketch.document.handles import point_offsets, split_handle
from arael.sketch.document.history import (
    Change,
    History,
    RecordChange,
    SettingChange,
    SizeChange,
    Transaction,
    ValuesChange,
)
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.records import (
    Constraint,
    Dimension,
    Entity,
    Group,
    Parameter,
    Record,
)
from arael.sketch.document.transacting import Transacting

Watcher = Callable[[RecordChange, bool], None]
_R = TypeVar("_R", Entity, Constraint, Dimension, Parameter, Group)

TABLES = ("entities", "constraints", "dimensions", "parameters", "groups")


class Document:
    """Entities, constraints, dimensions, parameters and groups of a sketch, and their history.

    Changes are made inside of `transaction`, each of which is one step of undo; a transaction that
    is left by an exception is taken back as a whole. After undo a document is bit-identical to
    what it was: records, their order, numbers, counters of names.

    Attributes
    ----------
    entities, constraints, dimensions, parameters, groups : records by name, in the order they were
        made
    values : all numbers in use, read-only; change them by `set_values`
    moves : how often numbers were changed; while it stays, they are the same
    history : `History`
    unit : of lengths: ``mm``, ``cm``, ``m``, ``in``
    watchers : called with every `RecordChange` and whether it is taken back, after it was made
    """

    def __init__(self) -> None:
        self._tables: dict[str, dict[str, Any]] = {table: {} for table in TABLES}
        # Views of what is never replaced: they are read many times in every edit.
        self.entities: Mapping[str, Entity] = MappingProxyType(self._tables["entities"])
        self.constraints: Mapping[str, Constraint] = MappingProxyType(self._tables["constraints"])
        self.dimensions: Mapping[str, Dimension] = MappingProxyType(self._tables["dimensions"])
        self.parameters: Mapping[str, Parameter] = MappingProxyType(self._tables["parameters"])
        self.groups: Mapping[str, Group] = MappingProxyType(self._tables["groups"])
        self.moves = 0
        self._numbers = np.zeros(64)
        self._resize(0)
        self._settings: dict[str, Any] = {"unit": "mm"}
        self._open: Transaction | None = None
        self.history = History()
        self.watchers: list[Watcher] = []

    # --- reading ----------------------------------------------------------------------------

    @property
    def settings(self) -> Mapping[str, Any]:
        """The unit and the counters of names."""
        return MappingProxyType(self._settings)

    @property
    def unit(self) -> str:
        """Unit of lengths."""
        return str(self._settings["unit"])

    def numbers_of(self, name: str) -> NDArray[np.float64]:
        """Numbers of an entity, read-only; KeyError if there is none of this name."""
        entity = self.entities[name]
        return self.values[entity.at : entity.at + entity.size]

    def find(self, name: str) -> Record | None:
        """The record of any table with a name, None if there is none."""
        return next((t[name] for t in self._tables.values() if name in t), None)

    def entity(self, name: str) -> Entity:
        """An entity by name.

        Raises
        ------
        AraelError
            E1201: there is none; those of the same kind are named.
        """
        found = self.entities.get(name)
        if found is None:
            raise AraelError(
                Diagnostic("E1201", f"no entity `{name}` in the sketch", help=(self._like(name),))
            )
        return found

    def _like(self, name: str) -> str:
        prefix = name.rstrip("0123456789")
        same = [other for other in self.entities if other.rstrip("0123456789") == prefix]
        if not same:
            return "`list` shows what there is"
        return f"there {'is' if len(same) == 1 else 'are'} {', '.join(same[:8])}" + (
            f" and {len(same) - 8} more" if len(same) > 8 else ""
        )

    def point_at(self, handle: str) -> int:
        """Offset in `values` of the x of a point: ``L0.p1``, ``A0.center``, ``P0``.

        Raises
        ------
        AraelError
            E1201: no such entity; E1202: the entity has no such point.
        """
        parts = split_handle(handle)
        entity = self.entity(parts.name if parts else handle)
        points = point_offsets(entity)
        point = (parts.point if parts else "") or ("pos" if entity.kind == "point" else "")
        if point not in points:
            near = closest(point, points)
            have = ", ".join(f"`{entity.name}.{p}`" for p in list(points)[:6])
            raise AraelError(
                Diagnostic(
                    "E1202",
                    f"`{handle}` is not a point: `{entity.name}` is "
                    f"{'an' if entity.kind[0] in 'aeiou' else 'a'} {entity.kind}",
                    help=(
                        f"did you mean `{entity.name}.{near[0]}`?" if near else f"it has {have}",
                    ),
                )
            )
        return points[point]

    # --- transactions -----------------------------------------------------------------------

    def transaction(self, label: str) -> Transacting:
        """One step of undo; inside another one, a part of it.

        An exception takes back what was changed since it began.
        """
        return Transacting(self, label)

    def begin(self, label: str) -> tuple[Transaction, bool]:
        """The step of undo that is open now, and whether it began just now; for `Transacting`."""
        if self._open is not None:
            return self._open, False
        self._open = Transaction(label)
        return self._open, True

    def end(self, made: Transaction, since: int, *, whole: bool, failed: bool) -> None:
        """End a step of undo, or a part of one; for `Transacting`.

        Parameters
        ----------
        since : changes from this one on are the part's
        whole : whether it is the step itself
        failed : take back what was changed
        """
        try:
            if failed:
                for change in reversed(made.changes[since:]):
                    self.apply(change, backwards=True)
                del made.changes[since:]
        finally:
            if whole:
                self._open = None
        if whole and made.changes and not failed:
            self.history.add(made)

    @property
    def open_transaction(self) -> Transaction | None:
        """The step of undo that is being made, or None."""
        return self._open

    @property
    def is_changing(self) -> bool:
        """Whether a transaction is open."""
        return self._open is not None

    def undo(self) -> str | None:
        """Take the last transaction back; its label, or None if there was none."""
        found = self.history.undo(self)
        return found.label if found else None

    def redo(self) -> str | None:
        """Make a transaction that was taken back again; its label, or None."""
        found = self.history.redo(self)
        return found.label if found else None

    def apply(self, change: Change, backwards: bool = False) -> None:
        """Make one recorded change, or take it back; for `History`."""
        if isinstance(change, ValuesChange):
            self._numbers[change.offsets] = change.old if backwards else change.new
            self.moves += 1
        elif isinstance(change, SizeChange):
            size = change.old if backwards else change.new
            self._reserve(size)
            self._numbers[min(size, self._size) : max(size, self._size)] = 0.0
            self._resize(size)
        elif isinstance(change, SettingChange):
            value = change.old if backwards else change.new
            if value is None:
                self._settings.pop(change.key, None)
            else:
                self._settings[change.key] = value
        else:
            self._apply_record(change, backwards)

    def _apply_record(self, change: RecordChange, backwards: bool) -> None:
        table = self._tables[change.table]
        record = change.old if backwards else change.new
        if record is None:
            del table[change.key]
        else:
            table[change.key] = record
            if change.order is not None:
                ordered = {key: table[key] for key in change.order}
                table.clear()
                table.update(ordered)
        for watcher in self.watchers:
            watcher(change, backwards)

    def _make(self, change: Change) -> None:
        if self._open is None:
            raise RuntimeError("a document is changed inside of `transaction` only")
        self.apply(change)
        self._open.changes.append(change)

    # --- changes ----------------------------------------------------------------------------

    def next_name(self, prefix: str) -> str:
        """The next name with a prefix (``L4``), which is then taken for good."""
        key = f"counter:{prefix}"
        number = int(self._settings.get(key, 0))
        self._make(SettingChange(key, self._settings.get(key), number + 1))
        return f"{prefix}{number}"

    def take_name(self, name: str, prefix: str) -> None:
        """Let `next_name` go on behind a name, if it has this prefix (``L4``)."""
        if name.rstrip("0123456789") == prefix:
            number = int(name[len(prefix) :]) + 1
            self.set_setting(
                f"counter:{prefix}", max(number, int(self._settings.get(f"counter:{prefix}", 0)))
            )

    def add_entity(self, kind: str, numbers: ArrayLike, *, name: str = "", **flags: Any) -> Entity:
        """A new entity with its numbers (see `kinds.ENTITIES`; splines: x, y of every pole).

        Parameters
        ----------
        name : empty for the next free one
        flags : ``construction``, ``quiet``, ``style``, ``text``, ``clockwise``
        """
        given = np.asarray(numbers, dtype=np.float64).ravel()
        expected = ENTITIES[kind]
        if expected.poles:
            if len(given) % 2 or len(given) < 2 * expected.poles:
                raise ValueError(f"a {kind} has at least {expected.poles} poles")
        elif len(given) != len(expected.values):
            raise ValueError(f"a {kind} has {len(expected.values)} numbers, not {len(given)}")
        if not np.isfinite(given).all():
            raise ValueError(f"the numbers of a {kind} are finite")
        entity = Entity(
            name or self.next_name(expected.prefix), kind, self._size, len(given), **flags
        )
        self._make(SizeChange(self._size, self._size + len(given)))
        self.set_values(np.arange(entity.at, entity.at + entity.size), given)
        return self.put("entities", entity)

    def put(self, table: str, record: _R) -> _R:
        """A new record, or a new version of one, under its name."""
        old = self._tables[table].get(record.name)
        if old != record:
            self._make(RecordChange(table, record.name, old, record))
        return record

    def remove(self, table: str, name: str) -> None:
        """Take a record out; what refers to it is the caller's to remove before.

        The numbers of an entity stay where they are until the sketch is saved and loaded.
        """
        old = self._tables[table][name]
        self._make(RecordChange(table, name, old, None, tuple(self._tables[table])))

    def rename(self, table: str, name: str, record: _R) -> None:
        """Put a record in the place of the one called `name`, under its own name."""
        keys = tuple(record.name if key == name else key for key in self._tables[table])
        self.remove(table, name)
        self._make(RecordChange(table, record.name, None, record, keys))

    def set_values(self, offsets: Sequence[int] | NDArray[Any], numbers: ArrayLike) -> None:
        """Change numbers; those that stay as they are are not recorded.

        Raises
        ------
        ValueError
            if one is not finite
        """
        at = np.asarray(offsets, dtype=np.int64)
        new = np.asarray(numbers, dtype=np.float64)
        if not np.isfinite(new).all():
            raise ValueError("the numbers of a sketch are finite")
        old = self._numbers[at]
        moved = np.flatnonzero(old.view(np.int64) != new.view(np.int64))
        if len(moved):
            self._make(ValuesChange(at[moved], old[moved].copy(), new[moved].copy()))

    def replace_values(
        self, offsets: NDArray[np.int64], old: NDArray[np.float64], new: NDArray[np.float64]
    ) -> None:
        """Change numbers from what they are known to be, `old`; the arrays are kept.

        All are finite, none is at two places, and each differs from what it was.
        """
        self._make(ValuesChange(offsets, old, new))

    def set_setting(self, key: str, value: Any) -> None:
        """Change a setting, ``unit``."""
        if self._settings.get(key) != value:
            self._make(SettingChange(key, self._settings.get(key), value))

    def _resize(self, size: int) -> None:
        self._size = size
        self.moves += 1
        self.values: NDArray[np.float64] = self._numbers[:size]
        self.values.flags.writeable = False

    def _reserve(self, size: int) -> None:
        if size > len(self._numbers):
            grown = np.zeros(max(size, 2 * len(self._numbers)))
            grown[: self._size] = self._numbers[: self._size]
            self._numbers = grown
