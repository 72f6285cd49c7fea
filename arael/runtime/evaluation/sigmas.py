"""Standard deviations that come from data, of priors or by their name: they must be positive."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group, Raw, columns_of
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.store.access import Ints, StoreLike, gather, gather_all, outputs
from arael.runtime.system import row_name


def check_sigmas(
    store: StoreLike, group: Group, active: Ints, rows: list[Ints], natives: NativeTable
) -> None:
    """Check the standard deviations of a constraint in all rows on which it acts.

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
    if not len(active):
        return
    for raw in sigmas_read(group):
        _check_column(store, group, raw, rows)
    if group.sigma is None:
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


def sigmas_read(group: Group) -> list[Raw]:
    """Data that a group reads whose name says that it is a standard deviation."""
    return [raw for raw in group.raw if _SIGMA.search(raw.column)]


# The last name of a path: `sigma`, `range_sigma`, `sigma_range`.
_SIGMA = re.compile(r"(^|[._])sigma(_\w*)?$")


def _check_column(store: StoreLike, group: Group, raw: Raw, rows: list[Ints]) -> None:
    values = np.atleast_1d(gather(store, group.slots, rows, raw))
    bad = values <= 0
    if not bad.any():
        return
    k, path = int(np.argmax(bad)), group.slots[raw.slot].table
    field = raw.column if raw.component == 0 else f"{raw.column}[{raw.component}]"
    place = store.layout.root
    if path:
        table: Any = store.tables[path]
        row = int(rows[raw.slot][k])
        place = table.row_name(row)
        if table.layout.key:
            place += f" (`{table.layout.key}` {table.column(table.layout.key)[row]!r})"
    raise SolveError(
        Diagnostic(
            "E1016",
            f"`{field}` of {place} is {values[k]:g}: a standard deviation is positive",
            origin=group.where,
            help=(f"correct the data: `{group.label}` divides by it",),
        )
    )
