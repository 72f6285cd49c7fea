"""Copies of model instances, in this process and through pickle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from arael.residuals.copying import restore as restore_residuals
from arael.residuals.copying import state_of as residual_state
from arael.runtime.store import Store

if TYPE_CHECKING:
    from arael.loading import Recipe
    from arael.model import Model

M = TypeVar("M", bound="Model")
State = tuple[dict[str, Any], dict[str, dict[str, bool]], Any]
"""Rows of each table, its flags for new rows, and the runtime residuals."""


def copied(model: M) -> M:
    """An independent copy: data, flags and runtime residuals; refs of one are not of the other."""
    found = type(model).__new__(type(model))
    found._begin(model._compiled)
    with model._store.use.lock:
        restore(found, state_of(model))
    return found


def state_of(model: Model) -> State:
    """A copy of all data of a model."""
    store: Store = model._store
    rows = {path: table.snapshot() for path, table in store.tables.items()}
    flags = {path: dict(table.optimize_new) for path, table in store.tables.items()}
    residuals = None if model._residuals is None else residual_state(model._residuals)
    return rows, flags, residuals


def restore(model: Model, state: State) -> None:
    """Set all data of a new instance to that of `state`, which must not be used again."""
    rows, flags, residuals = state
    for path, table in model._store.tables.items():
        table.restore(rows[path])
        table.optimize_new = flags[path]
    if residuals is not None:
        restore_residuals(model.residuals, residuals)


def reduced(model: Model) -> tuple[Any, ...]:
    """What pickle stores of a model: its text, bound functions and data, no machine code.

    Raises
    ------
    TypeError
        The model was not loaded from a text.
    """
    compiled = model._compiled
    recipe = getattr(compiled, "recipe", None)
    if recipe is None and compiled.layout.tables[1:]:
        raise TypeError(
            f"cannot pickle `{compiled.layout.name}`, a model that was not loaded from a text; "
            "load it with `arael.load` or `arael.loads`"
        )
    functions = dict(getattr(compiled, "functions", None) or {})
    with model._store.use.lock:
        state = state_of(model)
    return _unpickled, (recipe, compiled.layout.name, compiled.layout.precision, functions, state)


def _unpickled(
    recipe: Recipe | None, name: str, precision: Any, functions: Mapping[str, Any], state: State
) -> Model:
    if recipe is None:
        from arael.residuals.face import runtime_model

        model = runtime_model(precision=precision, name=name)
    else:
        from arael.loading import loads

        kind: Any = loads(
            recipe.text,
            name=recipe.name,
            precision=recipe.precision,
            root=recipe.root,
            interpret=recipe.interpret,
            functions=functions,
        )
        model = kind.__new__(kind)
        model._begin(kind.compiled)
    restore(model, state)
    return model
