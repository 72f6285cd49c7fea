"""Records of a document as JSON for pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from arael.sketch.document.document import TABLES, Document
from arael.sketch.document.records import Group
from arael.sketch.server.differences import Difference


def plain(record: Any) -> dict[str, Any]:
    """A record with all its fields; entities with the place of their numbers."""
    if isinstance(record, Group):  # its options are a read-only mapping
        return {
            "name": record.name,
            "kind": record.kind,
            "sources": record.sources,
            "results": record.results,
            "owned": record.owned,
            "options": dict(record.options),
        }
    found: dict[str, Any] = msgspec.to_builtins(record)
    return found


def snapshot(document: Document, revision: int, settings: Mapping[str, Any]) -> dict[str, Any]:
    """The whole document, as a message."""
    tables = {table: [plain(one) for one in getattr(document, table).values()] for table in TABLES}
    return {
        "type": "snapshot",
        "revision": revision,
        "unit": document.unit,
        "document": tables,
        "values": document.values.tolist(),
        "settings": dict(settings),
    }


def change(
    found: Difference, numbers: Any, *, revision: int, since: int, by: str, title: str
) -> dict[str, Any]:
    """What changed, as a message.

    Parameters
    ----------
    numbers : (n,) all numbers of the later moment
    """
    message: dict[str, Any] = {
        "type": "change",
        "revision": revision,
        "from": since,
        "by": by,
        "title": title,
        "put": {table: [plain(one) for one in records] for table, records in found.put.items()},
        "removed": found.removed,
        "offsets": found.offsets.tolist(),
        "numbers": numbers[found.offsets].tolist(),
        "size": len(numbers),
    }
    if found.order:
        message["order"] = found.order
    if found.settings:  # counters of names and the unit; null: taken out
        message["settings"] = found.settings
    if "unit" in found.settings:
        message["unit"] = found.settings["unit"]
    return message
