"""Values of live expressions after an edit; what has none any more is marked, and keeps its last.

Which records are live is followed by a watcher of the document, so that sketches of literals cost
nothing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.history import RecordChange
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.measures import measured
from arael.sketch.document.records import Amount, Dimension, Parameter
from arael.sketch.expressions.dependencies import (
    amounts_of,
    is_live,
    ordered,
    reads,
    reads_geometry,
)
from arael.sketch.expressions.evaluation import number, require_quantity
from arael.sketch.expressions.reading import literal
from arael.sketch.expressions.scope import DocumentScope

_ROUNDING = 1e-11
"""Relative change of a value that reads geometry below which it counts as the same."""


class _Live:
    """Names of a document's records with live expressions, in the order of evaluation."""

    def __init__(self, document: Document) -> None:
        self.names: dict[str, None] = {}
        self.stale = True
        self.order: list[str] = []
        self.moving: set[str] = set()
        self.cycles: list[list[str]] = []
        for table in (document.parameters, document.dimensions):
            for record in table.values():
                if is_live(record):
                    self.names[record.name] = None
        document.watchers.append(self.watch)

    def watch(self, change: RecordChange, backwards: bool) -> None:
        """Follow a change of a record."""
        if change.table == "entities":
            self.stale = True
            return
        if change.table not in ("parameters", "dimensions"):
            return
        self.stale = True
        record: Any = change.old if backwards else change.new
        if record is not None and is_live(record):
            self.names[change.key] = None
        else:
            self.names.pop(change.key, None)

    def sort(self, document: Document) -> None:
        """Bring `order`, `cycles` and `moving` up to date."""
        self.order, self.cycles = ordered(document, self.names)
        self.moving = set()
        for name in self.order:
            record = _record(document, name)
            if reads_geometry(document, record) or any(
                one in self.moving for one in reads(document, record)
            ):
                self.moving.add(name)


_LIVE: WeakKeyDictionary[Document, _Live] = WeakKeyDictionary()


def refresh(document: Document) -> list[str]:
    """Work out the live expressions of a document, inside of a transaction.

    Returns
    -------
    Names of the parameters and dimensions that have another value or state now.
    """
    live = _LIVE.get(document)
    if live is None:
        live = _LIVE[document] = _Live(document)
    if not live.names:
        return []
    stale = live.stale
    if stale:
        live.sort(document)
    scope = DocumentScope(document, _measure(document))
    changed = []
    for cycle in live.cycles:
        reason = f"it reads itself: {' -> '.join(cycle[:8])}"
        changed += [name for name in cycle[:-1] if _mark(document, name, reason)]
    for name in live.order:
        if (stale or name in live.moving) and _update(document, name, scope, live.moving):
            changed.append(name)
    live.stale = False
    return changed


def follows_geometry(document: Document, name: str) -> bool:
    """Whether a parameter or dimension reads geometry, by itself or through others."""
    live = _LIVE.get(document)
    if live is None or live.stale:
        live = live or _LIVE.setdefault(document, _Live(document))
        live.sort(document)
    return name in live.moving


def _record(document: Document, name: str) -> Dimension | Parameter:
    found = document.parameters.get(name) or document.dimensions.get(name)
    assert found is not None
    return found


def _measure(document: Document) -> Any:
    return lambda d: measured(document, d.kind, d.args, d.mode)


def _update(document: Document, name: str, scope: DocumentScope, moving: set[str]) -> bool:
    record = _record(document, name)
    lost = [one for one in reads(document, record) if _record(document, one).broken]
    if lost:
        return _mark(document, name, f"it reads `{lost[0]}`, which has no value")
    fields: dict[str, Any] = {"broken": ""}
    for field, amount in amounts_of(record):
        if literal(amount.text) is not None:
            continue
        try:
            value = number(amount.text, scope)
            if isinstance(record, Dimension):
                require_quantity(amount.text, DIMENSIONS[record.kind].quantity)
        except AraelError as error:
            return _mark(document, name, error.diagnostics[0].message)
        # signs of distances and angles are kept as sides
        if isinstance(record, Dimension) and DIMENSIONS[record.kind].signed:
            value = abs(value)
        # geometry is solved to rounding: smaller changes are none
        close = _ROUNDING * max(abs(value), abs(amount.number)) if name in moving else 0.0
        if abs(value - amount.number) > close:
            fields[field] = Amount(amount.text, value)
    new = replace(record, **fields)
    if new == record:
        return False
    _put(document, new)
    return True


def _mark(document: Document, name: str, reason: str) -> bool:
    record = _record(document, name)
    if record.broken == reason:
        return False
    _put(document, replace(record, broken=reason))
    return True


def _put(document: Document, record: Dimension | Parameter) -> None:
    if isinstance(record, Dimension):
        document.put("dimensions", record)
    else:
        document.put("parameters", record)
