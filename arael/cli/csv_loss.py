"""Detects solved values that a file of one collection (CSV, Parquet, a trajectory) would lose."""

from __future__ import annotations

import os
from typing import Any

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.csv_reader import choose
from arael.runtime.layout import Layout

_SHOWN = 5
_WORDS = {"csv": "a CSV", "parquet": "a Parquet", "arrow": "an Arrow"}


def lost_in_csv(layout: Layout, kept: str) -> list[str]:
    """Paths of parameters that a file of the collection `kept` lacks; of all parameters for ""."""
    return [
        f"{entity.table}.{use.column}" if entity.table else use.column
        for entity in layout.entities
        if not kept or entity.table != kept
        for use in entity.params
        if use.tangent
    ]


def note_of_trajectory(
    instance: Any, layout: Layout, output: str, collection: str | None, fields: Any
) -> str:
    """Note on the solved values that a trajectory does not hold; "" if there are none."""
    # imported here: start-up time
    from arael.io import trajectory

    found = trajectory.find(instance._store, output, collection, fields)
    path = found.table.layout.path
    held = {f"{path}.{name}" for name in found.paths.values()}
    lost = [name for name in lost_in_csv(layout, "") if name not in held]
    return f"{output} does not hold {_listed(lost)}" if lost else ""


def check_csv_output(instance: Any, layout: Layout, output: str, format: str = "csv") -> str:
    """Reject a file of one collection that lacks solved values, unless it has the name of one.

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
        advice.append(f"or name the file {kept}.{format} to write `{kept}` alone")
    raise AraelError(
        Diagnostic(
            "E0856",
            f"{_WORDS[format]} file holds one collection, here `{kept}`: it would not hold "
            f"{_listed(lost)}, {what}",
            origin=output,
            help=tuple(advice),
        )
    )


def _listed(paths: list[str]) -> str:
    text = ", ".join(f"`{path}`" for path in paths[:_SHOWN])
    more = len(paths) - _SHOWN
    return f"{text} and {more} more" if more > 0 else text
