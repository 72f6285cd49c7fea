"""The runtime residuals of a model instance as plain data, from which a copy is made."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.parameter import Parameter
from arael.face.ref import Refs
from arael.residuals.code import CodeResidual, CodeUpdate
from arael.residuals.code_arguments import Argument
from arael.residuals.expression import Definition, Expression, RuntimeResidual
from arael.residuals.messages import error

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
class CopiedCode:
    """Residuals by own code, or (size 0) a function called before linearisations.

    `parameters` are table, column and handles, None for the root's.
    """

    label: str
    function: Any
    parameters: tuple[tuple[str, str, NDArray[np.int64] | None], ...]
    size: int = 0
    data: dict[str, NDArray[Any]] = field(default_factory=dict)
    jacobian: Any = None
    coordinates: str = "tangent"
    loss: str | None = None
    kind: str = "cost"

    def __getstate__(self) -> dict[str, Any]:
        """What pickle stores; functions are stored by their names."""
        for function in (self.function, self.jacobian):
            try:
                pickle.dumps(function)
            except Exception as failure:
                raise error(
                    "E0773",
                    f"cannot pickle the function of `{self.label}`: {failure}",
                    "pickle",
                    "define it at the top of a module; Python pickles functions by their names",
                ) from None
        return dict(self.__dict__)


@dataclass(frozen=True)
class State:
    """All runtime residuals of a model instance.

    Attributes
    ----------
    functions : arguments of each call of `Residuals.functions`
    definitions, residuals : in order
    codes : those by own code, and functions called before linearisations
    """

    functions: tuple[tuple[str, dict[str, Any]], ...]
    definitions: tuple[Copied, ...]
    residuals: tuple[Copied, ...]
    codes: tuple[CopiedCode, ...] = ()


def state_of(residuals: Any) -> State:
    """Copy texts, values, data and handles."""
    return State(
        residuals._functions.calls,
        tuple(_copied(source) for source in residuals.definitions.values()),
        tuple(_copied(source, residuals.is_compiled(source)) for source in residuals.values()),
        (
            *(_copied_code(source) for source in residuals.code.values()),
            *(_copied_update(source) for source in residuals.updates.values()),
        ),
    )


def _copied_code(code: CodeResidual) -> CopiedCode:
    data = {name: values.copy() for name, values in code._data.items()}
    return CopiedCode(
        code.label,
        code.function,
        _places(code.arguments),
        code.size,
        data,
        code.jacobian,
        code.coordinates,
        code.loss,
        code.kind,
    )


def _copied_update(update: CodeUpdate) -> CopiedCode:
    return CopiedCode(update.label, update.function, _places(update.arguments))


def _places(
    arguments: Sequence[Argument],
) -> tuple[tuple[str, str, NDArray[np.int64] | None], ...]:
    return tuple(
        (a.table, a.column, None if a.refs is None else a.refs._handles.copy()) for a in arguments
    )


def _copied(expression: Expression, compiled: bool = False) -> Copied:
    handles = {
        name: (refs._table.layout.path, refs._handles.copy())
        for name, refs in expression.entities.items()
    }
    loss, when = (
        (expression.loss, expression.when)
        if isinstance(expression, RuntimeResidual)
        else (None, None)
    )
    data = {name: values.copy() for name, values in expression._data.items()}
    return Copied(
        expression.text,
        expression.label,
        expression.parameters.given(),
        data,
        handles,
        loss,
        when,
        compiled,
    )


def restore(residuals: Any, state: State) -> None:
    """Add everything to the empty collection of a copy, whose rows are there."""
    for text, bind in state.functions:
        residuals.functions(text, bind)
    tables = residuals._model._store.tables

    def entities(copied: Copied) -> dict[str, Refs]:
        return {name: Refs(tables[path], at.copy()) for name, (path, at) in copied.entities.items()}

    definitions = [
        Definition(copied.text, copied.label, None, copied.data, entities(copied))
        for copied in state.definitions
    ]
    copies = [
        RuntimeResidual(
            copied.text,
            copied.label,
            copied.parameters,
            copied.data,
            entities(copied),
            copied.loss,
            copied.when,
        )
        for copied in state.residuals
    ]
    residuals._add_all(definitions, copies)
    compiled = [copied.label for copied in state.residuals if copied.compiled]
    if compiled:
        residuals.compile(*compiled)
    for code in state.codes:
        _restore_code(residuals, code, tables)


def _restore_code(residuals: Any, copied: CopiedCode, tables: Any) -> None:
    model = residuals._model
    parameters = []
    for path, column, handles in copied.parameters:
        table = tables[path]
        rows = 0 if handles is None else table.rows_of(handles)
        parameters.append(Parameter(table, column, partial(_same, rows)))
    if not copied.size:
        residuals.add_update(CodeUpdate(model, copied.function, parameters, copied.label))
        return
    residuals.add_code(
        CodeResidual(
            model,
            copied.function,
            parameters,
            copied.size,
            copied.data,
            copied.jacobian,
            copied.coordinates,
            copied.loss,
            copied.label,
            copied.kind,
        )
    )


def _same(rows: Any) -> Any:
    return rows
