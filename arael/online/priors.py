"""Priors of windows as residual blocks of an engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Layout, ParamUse

Floats = NDArray[np.float64]
Params = Mapping[tuple[str, str], tuple[int, ParamUse]]


def only_priors(model: Any) -> Mapping[str, Any] | None:
    """Priors of a model, by name; None if it has other residuals of run time."""
    residuals = getattr(model, "_residuals", None)
    if residuals is None:
        return {}
    found: Mapping[str, Any] = residuals.priors
    if len(residuals) or residuals.updates or len(found) != len(residuals.code):
        return None
    return found


def params_of(layout: Layout) -> Params:
    """Entity and use of each parameter, by table and column."""
    return {
        (entity.table, use.column): (number, use)
        for number, entity in enumerate(layout.entities)
        for use in entity.params
    }


class PriorBlock:
    """Jacobian and residuals of a prior at states of variables.

    Parameters
    ----------
    code : the residual by own code that a marginalisation added

    Attributes
    ----------
    rows : entity, table and handle of each variable
    """

    def __init__(self, layout: Layout, params: Params, code: Any) -> None:
        self.prior = code.function
        places: dict[tuple[int, str, int], int] = {}
        found: list[tuple[int, ParamUse]] = []
        for path, column, handle in code.keys:
            entity, use = params[path, column]
            found.append((places.setdefault((entity, path, handle), len(places)), use))
        self.rows = list(places)
        widths = [layout.entities[entity].tangent for entity, _, _ in self.rows]
        starts = np.cumsum([0, *widths])
        self._width = int(starts[-1]) + 1
        self._parts = [
            (k, slice(use.stored_start, use.stored_start + use.stored)) for k, use in found
        ]
        self._columns = [
            slice(
                int(starts[k]) + use.tangent_start, int(starts[k]) + use.tangent_start + use.tangent
            )
            for k, use in found
        ]

    def __call__(self, states: Sequence[Floats]) -> Floats:
        """(rows, width + 1) Jacobian by all scalars of the variables, and residuals."""
        values = [states[k][None, part] for k, part in self._parts]
        residual, blocks = self.prior(*values, row=None)
        found = np.zeros((len(residual), self._width))
        for columns, block in zip(self._columns, blocks, strict=True):
            found[:, columns] = block[:, 0]
        found[:, -1] = residual
        return found
