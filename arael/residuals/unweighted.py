"""Residuals of a constraint without its loss, and without factors of data alone.

Kernels compute residuals after the loss. A constraint of the model is derived again without its
loss, from the text that was loaded, and evaluated by the interpreter. Imported files are read once
more.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.check.typed import Apply, Formula, Pack, Read, Typed
from arael.check.walk import postorder
from arael.compiled_model import CompiledModel
from arael.compiler.entities import model_state
from arael.compiler.groups import compile_constraint
from arael.compiler.reread import typed_model
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Group, Layout
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]


def unweighted(model: Any, number: int) -> tuple[Floats, Floats]:
    """Raw and whitened residuals (rows, m) of a group of a model, by its number.

    Raw residuals lack the loss and factors of data alone, whitened ones the loss.

    Raises
    ------
    AraelError
        E1037: the text of the model, or of a file that it imports, is not what was compiled.
    """
    compiled = model._compiled.layout.groups
    if number < len(compiled):
        return _of_model(model, number)
    raw, whitened = model.residuals.unweighted(model._problem().layout.groups[number].label)
    return raw, whitened


def _of_model(model: Any, number: int) -> tuple[Floats, Floats]:
    """Raw and whitened residuals of a constraint of the model's file, all active instances."""
    compiled = model._compiled
    # An entry is derived once: the compiled constraint that it was compared with does not change.
    if number not in compiled.plain:
        compiled.plain[number] = _plain(compiled, number)
    residuals = []
    for group in compiled.plain[number]:
        only = msgspec.structs.replace(compiled.layout, groups=(group,))
        alone = Problem(
            only,
            _Relaid(model._store, only),
            None,
            bindings={**(compiled.bindings or {}), **getattr(model._store, "bindings", {})},
        )
        residuals.append(alone.constraint_rows(0)[0])
    return residuals[0], residuals[1]


def _plain(compiled: CompiledModel, number: int) -> tuple[Group, Group]:
    """A constraint of the model's file without loss: as measured, and whitened."""
    layout = compiled.layout
    group = layout.groups[number]
    try:
        typed = typed_model(compiled)
    except AraelError:
        raise _changed(layout.source) from None
    functions = Functions(typed.functions)
    states = [model_state(site, functions) for site in typed.entities]
    single = layout.precision == "f32"
    if number >= len(typed.constraints):
        raise _changed(layout.source)
    site = typed.constraints[number]
    same = compile_constraint(site, states, single, functions).group
    if (same.label, same.tape, same.row_sums) != (group.label, group.tape, group.row_sums):
        raise _changed(layout.source)
    whitened = replace(site, loss=None, triplets="", crossed=())
    raw = replace(whitened, residual=tuple(_measured(part) for part in site.residual))
    plain = (
        compile_constraint(value, states, single, functions).group for value in (raw, whitened)
    )
    return next(plain), next(plain)


class _Relaid:
    """The data of a model under a layout with other constraints."""

    def __init__(self, store: Any, layout: Layout) -> None:
        self._store, self.layout = store, layout

    def __getattr__(self, name: str) -> Any:
        return getattr(self._store, name)


def _measured(value: Typed) -> Typed:
    """A typed residual without factors and divisors of data alone."""
    while isinstance(value, Apply) and value.name in ("mul", "div", "emul", "ediv"):
        left, right = value.args
        if _is_data(right) and left.type == value.type:
            value = left
        elif value.name in ("mul", "emul") and _is_data(left) and right.type == value.type:
            value = right
        else:
            break
    if isinstance(value, Apply) and value.name == "neg":
        return replace(value, args=tuple(_measured(part) for part in value.args))
    if isinstance(value, Pack):
        return replace(value, items=tuple(_measured(part) for part in value.items))
    return value


def _is_data(value: Typed) -> bool:
    return all(
        not isinstance(node, Formula) and (not isinstance(node, Read) or node.version == "data")
        for node in postorder([value])
    )


def _changed(source: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1037",
            f"the text of {source}, with the files that it imports, is not what was compiled",
            origin="residual_values",
            help=("raw residuals are derived from the text; load the model again",),
        )
    )
