"""Residuals of one constraint, row by row: as measured, whitened, and after the loss.

Kernels compute residuals after the loss alone. The other two come from the text of the model: its
constraint is derived again without the loss, and without factors that depend on data alone, and
evaluated by the interpreter.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.layout import Layout
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class ResidualValues:
    """Residuals of the instances of one constraint that act, in the order of its rows.

    Attributes
    ----------
    label : of the constraint, ``Sat.pseudorange``
    rows : (n,) the row of each instance, ``sats[3]``
    raw : (n, m) without factors of data alone at the front or the end of the residual, ``1 /
        sigma`` of ``(predicted - measured) / sigma``: in the unit of the measurement
    whitened : (n, m) as the model writes it, before the loss
    robust : (n, m) after the loss, as the solver sums their squares; `whitened` without one
    """

    label: str
    rows: tuple[str, ...]
    raw: Floats
    whitened: Floats
    robust: Floats = field()

    @property
    def cost(self) -> Floats:
        """(n,) cost of each instance."""
        return np.asarray((self.robust**2).sum(axis=1))

    @property
    def weight(self) -> Floats:
        """(n,) share of its squared residual that each instance costs: 1 without a loss."""
        square = (self.whitened**2).sum(axis=1)
        return np.where(square > 0, self.cost / np.where(square > 0, square, 1.0), 1.0)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        n, m = self.robust.shape
        return f"<residuals of {self.label}: {n} instances of {m}>"


def residual_values(model: Any, label: str) -> ResidualValues:
    """Residuals of the constraint `label` of a model at its current values.

    Raises
    ------
    AraelError
        E1037: no such constraint, or its text is no longer there to be read.
    """
    problem: Problem = model._problem()
    numbers = [k for k, group in enumerate(problem.layout.groups) if group.label == label]
    if not numbers:
        known = list(dict.fromkeys(group.label for group in problem.layout.groups))
        near = closest(label, known)
        help_ = f"did you mean `{near[0]}`?" if near else f"there are {', '.join(known)}"
        raise _wrong(f"there is no constraint `{label}`", help_)
    compiled = len(model._compiled.layout.groups)
    parts = []
    for number in numbers:
        acting = np.flatnonzero(problem.evaluation.acting(number))
        robust = np.asarray(problem.evaluation.group_rows(number)[0][acting], dtype=np.float64)
        if number < compiled:
            raw, whitened = _of_model(model, number)
        else:
            raw, whitened = model.residuals.unweighted(label)
        rows = tuple(problem.instance_place(number, int(row)) for row in acting)
        if problem.layout.groups[number].table.endswith("/rows"):  # added at run time
            rows = tuple(f"row {problem.structure.active[number][row]}" for row in acting)
        parts.append((rows, raw[acting], whitened[acting], robust))
    rows_, *arrays = zip(*parts, strict=True)
    return ResidualValues(
        label,
        tuple(row for part in rows_ for row in part),
        *(np.concatenate(part).astype(np.float64) for part in arrays),
    )


def _of_model(model: Any, number: int) -> tuple[Floats, Floats]:
    """Raw and whitened residuals of a constraint of the model's file, all active instances."""
    from arael.compiler import compiler
    from arael.compiler.entities import model_state
    from arael.compiler.groups import compile_constraint
    from arael.compiler.imports import Imports
    from arael.compiler.scalar_programs import Functions
    from arael.diagnostics.records import Findings
    from arael.syntax.files import read_source

    layout = model._compiled.layout
    group = layout.groups[number]
    try:
        tree = compiler.syntax(read_source(layout.source))
        typed = compiler.types(tree, Findings(), layout.root, Imports())
    except AraelError:
        raise _changed(layout.source) from None
    functions = Functions(typed.functions)
    states = [model_state(site, functions) for site in typed.entities]
    single = layout.precision == "f32"
    if number >= len(typed.constraints):
        raise _changed(layout.source)
    site = typed.constraints[number]
    same = compile_constraint(site, states, single, functions).group
    if same.label != group.label or same.tape != group.tape:
        raise _changed(layout.source)
    whitened = replace(site, loss=None, triplets="", crossed=())
    raw = replace(whitened, residual=tuple(_measured(part) for part in site.residual))
    found = []
    for one in (raw, whitened):
        plain = compile_constraint(one, states, single, functions).group
        only = msgspec.structs.replace(layout, groups=(plain,))
        alone = Problem(
            only,
            _Relaid(model._store, only),
            None,
            bindings={**(model._compiled.bindings or {}), **getattr(model._store, "bindings", {})},
        )
        found.append(np.asarray(alone.evaluation.group_rows(0)[0], dtype=np.float64))
    return found[0], found[1]


class _Relaid:
    """The data of a model under a layout with other constraints."""

    def __init__(self, store: Any, layout: Layout) -> None:
        self._store, self.layout = store, layout

    def __getattr__(self, name: str) -> Any:
        return getattr(self._store, name)


def _measured(value: Any) -> Any:
    """A typed residual without factors and divisors of data alone."""
    from arael.check.typed import Apply, Pack

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


def _is_data(value: Any) -> bool:
    from arael.check.typed import Formula, Read
    from arael.check.walk import postorder

    return all(
        not isinstance(node, Formula) and (not isinstance(node, Read) or node.version == "data")
        for node in postorder([value])
    )


def _changed(source: str) -> AraelError:
    return _wrong(
        f"the text of the model, {source}, is not what was compiled",
        "raw residuals are derived from the text; load the model again",
    )


def _wrong(message: str, advice: str) -> AraelError:
    return AraelError(Diagnostic("E1037", message, origin="residual_values", help=(advice,)))
