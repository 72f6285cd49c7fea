"""Detects solved values that a CSV file, which holds one collection, would lose."""

from __future__ import annotations

import os
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.csv_reader import choose
from arael.runtime.layout import Layout

_SHOWN = 5


def lost_in_csv(layout: Layout, kept: str) -> list[str]:
    """Paths of the parameters that are not in a CSV file of the collection `kept`."""
    return [
        f"{entity.table}.{use.column}" if entity.table else use.column
        for entity in layout.entities
        if entity.table != kept
        for use in entity.params
        if use.tangent
    ]


def check_csv_output(instance: Any, layout: Layout, output: str) -> str:
    """Reject a CSV file that lacks solved values, unless it is named after a collection.

    Returns
    -------
    A note on the values that the file does not hold; "" if there are none.

    Raises
    ------
    AraelError
        E0856 if values would be lost, E0713 if the collection is ambiguous.
    """
    table = choose(instance._store, output, None)
    kept = table.layout.path
    lost = lost_in_csv(layout, kept)
    named = os.path.basename(output).removesuffix(".gz").rpartition(".")[0] == kept
    solved = any(entity.table == kept for entity in layout.entities if entity.params)
    if not lost or (named and solved):
        return f"{output} does not hold {_listed(lost)}" if lost else ""
    what = "which are solved for" if solved else f"and nothing in `{kept}` is solved for"
    advice = ["write .json or .npz, which hold the whole model"]
    if solved:
        advice.append(f"or name the file {kept}.csv to write `{kept}` alone")
    raise AraelError(
        Diagnostic(
            "E0856",
            f"a CSV file holds one collection, here `{kept}`: it would not hold {_listed(lost)}, "
            f"{what}",
            origin=output,
            help=tuple(advice),
        )
    )


def _listed(paths: list[str]) -> str:
    text = ", ".join(f"`{path}`" for path in paths[:_SHOWN])
    more = len(paths) - _SHOWN
    return f"{text} and {more} more" if more > 0 else text
