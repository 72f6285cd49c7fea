"""Which data of a problem has changed since it was gathered."""

from __future__ import annotations

from operator import eq
from typing import Any

from arael.runtime.layout import Layout
from arael.runtime.store.access import StoreLike
from arael.runtime.store.compiled import fingerprints


class Watch:
    """Remembers what was in the columns that the groups of a layout read.

    Python holds views of a model's memory and writes through them without telling, so what may have
    been written to is looked at. It costs about a twentieth of gathering it anew.
    """

    def __init__(self, layout: Layout) -> None:
        self._tables = layout.read_columns
        # By table: the version of its data if that is counted, else what was in its columns.
        self._seen: dict[str, Any] = {}

    def changed(self, store: StoreLike) -> set[int]:
        """Numbers of the groups whose data has changed since the last time; at first all."""
        found: set[int] = set()
        for path, (columns, optionals, readers) in self._tables.items():
            table = store.tables[path]
            before, now = self._seen.get(path), table.data_version
            if now is None:
                contents = table.columns(columns)
                if optionals:
                    contents = [*contents, *map(table.present, optionals)]
                now = fingerprints(contents)
            if now == before:
                continue
            self._seen[path] = now
            if isinstance(now, list) and isinstance(before, list):
                same = list(map(eq, now, before))
            else:
                same = [False] * len(readers)
            for groups, as_before in zip(readers, same, strict=True):
                if not as_before:
                    found.update(groups)
        return found

    def same_table(self, path: str, other: Watch) -> bool:
        """Whether a table whose data is counted was the same when `other` last looked."""
        now = self._seen.get(path)
        return now is not None and not isinstance(now, list) and other._seen.get(path) == now

    def copy(self) -> Watch:
        """Return one that remembers the same."""
        other = object.__new__(Watch)
        other._tables, other._seen = self._tables, dict(self._seen)
        return other
