"""The data of model instances, from which copies are made, in this process and through pickle."""

from __future__ import annotations

from typing import Any

from arael.runtime.store import Store

State = tuple[dict[str, Any], dict[str, Any], Any]
"""Rows of each table, its flags for new rows, and the runtime residuals."""


def copied(model: Any) -> Any:
    """An independent copy: data, flags and runtime residuals; refs of one are not of the other."""
    kind: Any = type(model)
    found = kind.__new__(kind)
    found._begin(model._compiled)
    restore(found, state_of(model))
    return found


def state_of(model: Any) -> State:
    """A copy of all data of a model."""
    store: Store = model._store
    with store.use.lock:
        return _state(store, model._residuals)


def _state(store: Store, residuals: Any) -> State:
    rows = {path: table.snapshot() for path, table in store.tables.items()}
    flags = {
        path: (dict(table.optimize_new), dict(table.components_new))
        for path, table in store.tables.items()
    }
    return rows, flags, None if residuals is None else residuals.state()


def restore(model: Any, state: State) -> None:
    """Set all data of a new instance to that of `state`, which must not be used again."""
    rows, flags, residuals = state
    for path, table in model._store.tables.items():
        table.restore(rows[path])
        table.optimize_new, table.components_new = flags[path]
    if residuals is not None:
        model.residuals.restore(residuals)
