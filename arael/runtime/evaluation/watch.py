"""Which data of a problem has changed since it was gathered."""

from __future__ import annotations

from typing import Any

from arael.runtime.layout import Group, Layout
from arael.runtime.store.access import StoreLike
from arael.runtime.store.fingerprint import fingerprint


class Watch:
    """Remembers what was in the columns that the groups of a layout read.

    Python holds views of a model's memory and writes through them without telling, so what may have
    been written to is looked at. It costs about a twentieth of gathering it anew.
    """

    def __init__(self, layout: Layout) -> None:
        readers: dict[tuple[str, str], set[int]] = {}
        for number, group in enumerate(layout.groups):
            for place in places_of(group):
                readers.setdefault(place, set()).add(number)
        self._tables: dict[str, list[tuple[str, tuple[int, ...]]]] = {}
        for (table, column), groups in readers.items():
            self._tables.setdefault(table, []).append((column, tuple(sorted(groups))))
        self._seen: dict[tuple[str, str], Any] = {}

    def changed(self, store: StoreLike) -> set[int]:
        """Numbers of the groups whose data has changed since the last time; at first all."""
        found: set[int] = set()
        for path, columns in self._tables.items():
            table = store.tables[path]
            version = table.data_version
            if version is not None:
                if self._seen.get((path, "")) != version:
                    self._seen[path, ""] = version
                    for _, groups in columns:
                        found.update(groups)
                continue
            for column, groups in columns:
                if column.endswith("?"):
                    now = fingerprint(table.present(column[:-1]))
                else:
                    now = fingerprint(table.column(column))
                if self._seen.get((path, column)) != now:
                    self._seen[path, column] = now
                    found.update(groups)
        return found

    def same_table(self, path: str, other: Watch) -> bool:
        """Whether a table whose data is counted was the same when `other` last looked."""
        now = self._seen.get((path, ""))
        return now is not None and other._seen.get((path, "")) == now

    def copy(self) -> Watch:
        """Return one that remembers the same."""
        other = object.__new__(Watch)
        other._tables, other._seen = self._tables, dict(self._seen)
        return other


def places_of(group: Group) -> set[tuple[str, str]]:
    """Table and column of everything that a group's data is prepared from."""
    return {(group.slots[raw.slot].table, raw.column) for raw in group.raw}
