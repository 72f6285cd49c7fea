"""A layout follows its document: what changed is taken in, once for all changes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, cast

import numpy as np

from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.document.history import RecordChange
from arael.sketch.document.records import Constraint, Dimension, Entity
from arael.sketch.expressions.dependencies import amounts_of
from arael.sketch.layout import following
from arael.sketch.layout.laid import Laid, same_numbers
from arael.sketch.layout.laying import Laying
from arael.sketch.layout.operands import operands

#: Kinds of entities with equations or guards of their own.
_WITH_ROWS = ("circle", "arc", "ellipse", "earc")

_LAID = ("entities", "constraints", "dimensions")


class Upkeep(Laying):
    """Only the records that changes touch are laid out anew."""

    def __init__(self, document: Document) -> None:
        super().__init__(document)
        for table in _LAID:
            for name in getattr(document, table):
                self._pending[(table, name)] = None
        document.watchers.append(self._changed)

    def detach(self) -> None:
        """Stop following the document."""
        self.document.watchers.remove(self._changed)

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
            elif record is old or (table == "entities" and same_numbers(old, record)):
                if laid is not None and record is not None:
                    laid.record = record
            elif laid is not None and self._set_value(laid, record):
                anew.add(name)
                self._touch((name,))
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
        for _, name in changed:
            before = self._laid.get(name)
            self._touch((name, *(before.names if before is not None else ())))
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
        if any(table == "entities" for table, _ in changed):
            self._drawn += 1
            self._live = np.flatnonzero(self._root[: len(values)] >= 0)
        return set(lay)

    def _touch(self, names: Iterable[str]) -> None:
        if self._touched is not None:
            self._touched |= dict.fromkeys(names)

    # --- records --------------------------------------------------------------------------

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

    # --- entities -------------------------------------------------------------------------

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
