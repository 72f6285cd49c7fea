"""Standard deviations of priors that come from data: they must be positive."""

from __future__ import annotations

import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group, columns_of
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.store.access import Ints, StoreLike, gather_all, outputs
from arael.runtime.system import row_name


def check_sigmas(
    store: StoreLike, group: Group, active: Ints, rows: list[Ints], natives: NativeTable
) -> None:
    """Check the standard deviations of a prior in all rows on which it acts.

    Parameters
    ----------
    active : (n,) rows of the group's table
    rows : per slot, the rows that they read

    Raises
    ------
    SolveError
        E1016 for the first that is zero, negative or NaN: a negative one would act as its
        absolute value.
    """
    if group.sigma is None or not len(active):
        return
    inputs = gather_all(store, group.slots, rows, columns_of(group.sigma_raw))
    for found in outputs(group.sigma, inputs, len(active), natives):
        bad = ~(found > 0)
        if not bad.any():
            continue
        k = int(np.argmax(bad))
        place = row_name(store, group.table, int(active[k])) or store.layout.root
        raise SolveError(
            Diagnostic(
                "E1016",
                f"`{place}`: the sigma of the prior `{group.label}` is {found[k]:g}",
                origin=group.where,
                help=(
                    "a standard deviation is positive; `when` guards a prior that some rows do not "
                    "have, `fixed` in the data holds a parameter",
                ),
            )
        )
