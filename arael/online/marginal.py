"""The covariance of one row, from the factor of an online solve where there is one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.ref import Ref
from arael.online.priors import only_priors
from arael.online.tracker import Tracker
from arael.session import session_of


def marginal(model: Any, row: Ref) -> NDArray[np.float64]:
    """Marginal covariance of the parameters of a row; see `Model.marginal`."""
    tracker = session_of(model).online
    if isinstance(row, Ref) and isinstance(tracker, Tracker):
        table = row._table
        if (
            tracker.is_current(only_priors(model) or {})
            and tracker.store.tables.get(table.layout.path) is table
        ):
            found = tracker.marginal(table.layout.path, table.row_of(row._handle))
            if found is not None:
                return found
    whole: NDArray[np.float64] = model.covariance().marginal(row)
    return whole
