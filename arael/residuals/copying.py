"""The runtime residuals of a model instance as plain data, from which a copy is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.ref import Refs
from arael.residuals.expression import Definition, Expression, RuntimeResidual

Handles = dict[str, tuple[str, NDArray[np.int64]]]


@dataclass(frozen=True)
class Copied:
    """One residual or named expression; of entities the table and the handles."""

    text: str
    label: str
    parameters: dict[str, dict[str, Any]]
    data: dict[str, NDArray[Any]]
    entities: Handles
    loss: str | None = None
    when: str | None = None
    compiled: bool = False


@dataclass(frozen=True)
class State:
    """All runtime residuals of a model instance.

    Attributes
    ----------
    functions : arguments of each call of `Residuals.functions`
    definitions, residuals : in order
    """

    functions: tuple[tuple[str, dict[str, Any]], ...]
    definitions: tuple[Copied, ...]
    residuals: tuple[Copied, ...]


def state_of(residuals: Any) -> State:
    """Copy texts, values, data and handles."""
    return State(
        residuals._functions.calls,
        tuple(_copied(one) for one in residuals.definitions.values()),
        tuple(_copied(one, residuals.is_compiled(one)) for one in residuals.values()),
    )


def _copied(one: Expression, compiled: bool = False) -> Copied:
    handles = {
        name: (refs._table.layout.path, refs._handles.copy()) for name, refs in one.entities.items()
    }
    loss, when = (one.loss, one.when) if isinstance(one, RuntimeResidual) else (None, None)
    data = {name: values.copy() for name, values in one._data.items()}
    return Copied(one.text, one.label, one.parameters.given(), data, handles, loss, when, compiled)


def restore(residuals: Any, state: State) -> None:
    """Add everything to the empty collection of a copy, whose rows are there."""
    for text, bind in state.functions:
        residuals.functions(text, bind)
    tables = residuals._model._store.tables

    def entities(one: Copied) -> dict[str, Refs]:
        return {name: Refs(tables[path], at.copy()) for name, (path, at) in one.entities.items()}

    definitions = [
        Definition(one.text, one.label, None, one.data, entities(one)) for one in state.definitions
    ]
    found = [
        RuntimeResidual(
            one.text, one.label, one.parameters, one.data, entities(one), one.loss, one.when
        )
        for one in state.residuals
    ]
    residuals._add_all(definitions, found)
    compiled = [one.label for one in state.residuals if one.compiled]
    if compiled:
        residuals.compile(*compiled)
