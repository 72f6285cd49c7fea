"""What changed between two moments of a document, by names, so that it can be made again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import TABLES, Document

#: A record is taken out after what refers to it, and put in after what it refers to.
_REMOVAL = ("groups", "dimensions", "constraints", "parameters", "entities")
_ADDITION = ("entities", "parameters", "constraints", "dimensions", "groups")


@dataclass(frozen=True, slots=True)
class Moment:
    """A document at one moment; records are shared with it, as they are immutable.

    Attributes
    ----------
    tables : records by name, by table
    values : (n,) all numbers
    settings : the unit and the counters of names
    """

    tables: Mapping[str, Mapping[str, Any]]
    values: NDArray[np.float64]
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, document: Document) -> Moment:
        """The document as it is now."""
        tables = {table: dict(getattr(document, table)) for table in TABLES}
        return cls(tables, document.values.copy(), dict(document.settings))


@dataclass(frozen=True, slots=True)
class Difference:
    """From one moment to a later one.

    Attributes
    ----------
    put : new records and new versions, by table
    removed : names, by table
    order : all names of a table, where removing and appending does not give it
    numbers : of entities that are new or have moved, by name
    offsets : (k,) in ``values``, of numbers that are new or have changed
    settings : new values of settings; None: taken out
    """

    put: dict[str, list[Any]] = field(default_factory=dict)
    removed: dict[str, list[str]] = field(default_factory=dict)
    order: dict[str, list[str]] = field(default_factory=dict)
    numbers: dict[str, list[float]] = field(default_factory=dict)
    offsets: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    settings: dict[str, Any] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(
            self.put
            or self.removed
            or self.order
            or self.numbers
            or len(self.offsets)
            or self.settings
        )


def difference(old: Moment, new: Moment) -> Difference:
    """What changed between two moments."""
    found = Difference(offsets=changed_offsets(old.values, new.values))
    for table in TABLES:
        _compare(table, old.tables[table], new.tables[table], found)
    moved = np.zeros(len(new.values) + 1, dtype=np.int64)
    moved[found.offsets + 1] = 1
    count = np.cumsum(moved)
    fresh = {one.name for one in found.put.get("entities", ())}
    entities = new.tables["entities"]
    if len(found.offsets) or fresh:
        for name, one in entities.items():
            if name in fresh or count[one.at + one.size] > count[one.at]:
                found.numbers[name] = new.values[one.at : one.at + one.size].tolist()
    keys = old.settings.keys() | new.settings.keys()
    for key in sorted(keys):
        if old.settings.get(key) != new.settings.get(key):
            found.settings[key] = new.settings.get(key)
    return found


def changed_offsets(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.int64]:
    """Offsets of numbers that are not bit by bit what they were, or are new."""
    same = min(len(old), len(new))
    differs = old[:same].view(np.int64) != new[:same].view(np.int64)
    moved: NDArray[np.int64] = differs.nonzero()[0]
    if len(new) > same:
        moved = np.concatenate([moved, np.arange(same, len(new))])
    return moved


def _compare(table: str, old: Mapping[str, Any], new: Mapping[str, Any], found: Difference) -> None:
    put = [one for name, one in new.items() if old.get(name) is not one]
    put = [one for one in put if old.get(one.name) != one]
    removed = [name for name in old if name not in new]
    if put:
        found.put[table] = put
    if removed:
        found.removed[table] = removed
    if len(old) == len(new) and not removed and not put and list(old) == list(new):
        return
    gone = set(removed)
    expected = [name for name in old if name not in gone]
    expected += [one.name for one in put if one.name not in old]
    if expected != list(new):
        found.order[table] = list(new)


def make(document: Document, change: Difference, label: str) -> None:
    """Make a change in a document; its numbers and records are then those of the later moment."""
    with document.transaction(label):
        fresh = {one.name: one for one in change.put.get("entities", ())}
        for table in _REMOVAL:
            known = getattr(document, table)
            gone = list(change.removed.get(table, ()))
            if table == "entities":  # another number of poles: the place of its numbers changes
                gone += [
                    name
                    for name, one in fresh.items()
                    if name in known
                    and (known[name].size, known[name].kind) != (one.size, one.kind)
                ]
            for name in gone:
                if name in known:
                    document.remove(table, name)
        for table in _ADDITION:
            for one in change.put.get(table, ()):
                if table == "entities":
                    _put_entity(document, one, change.numbers[one.name])
                else:
                    document.put(table, one)
        for name, numbers in change.numbers.items():
            one = document.entities[name]
            document.set_values(np.arange(one.at, one.at + one.size), numbers)
        for key, value in change.settings.items():
            document.set_setting(key, value)
        for table in _REMOVAL:
            if table in change.order:
                _arrange(document, table, change.order[table])


def _put_entity(document: Document, one: Any, numbers: list[float]) -> None:
    known = document.entities.get(one.name)
    if known is None:
        flags = {
            key: getattr(one, key)
            for key in ("construction", "quiet", "style", "text", "clockwise")
        }
        document.add_entity(one.kind, numbers, name=one.name, **flags)
        return
    document.put("entities", replace(one, at=known.at))


def _arrange(document: Document, table: str, names: list[str]) -> None:
    """Put records of a table into an order: those behind the first difference are put anew."""
    now = list(getattr(document, table))
    first = next((k for k, (a, b) in enumerate(zip(now, names, strict=True)) if a != b), len(now))
    for name in names[first:]:
        one = getattr(document, table)[name]
        document.remove(table, name)
        document.put(table, one)
