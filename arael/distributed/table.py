"""The table of outcomes: Parquet, or CSV where pyarrow is absent."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
from collections.abc import Sequence
from pathlib import Path

import msgspec

from arael.distributed.work import Row
from arael.io.files import write_whole


def write_table(rows: Sequence[Row], folder: Path) -> Path:
    """Write the rows, by name, as ``table.parquet`` or ``table.csv``; return its path.

    In Parquet `parameters`, `sigmas` and `seconds` are lists of names and values; in CSV, JSON.
    """
    ordered = sorted(rows, key=lambda row: row.name)
    if importlib.util.find_spec("pyarrow") is not None:
        return _parquet(ordered, folder / "table.parquet")
    plain = [msgspec.to_builtins(row) for row in ordered]
    text = io.StringIO()
    writer = csv.writer(text)
    names = Row.__struct_fields__
    writer.writerow(names)
    for row in plain:
        cells = (row[name] for name in names)
        writer.writerow([json.dumps(c) if isinstance(c, dict) else c for c in cells])
    path = folder / "table.csv"
    write_whole(path, lambda file: file.write(text.getvalue().encode()))
    return path


def _parquet(rows: Sequence[Row], path: Path) -> Path:
    # imported here: start-up time
    import pyarrow
    from pyarrow import parquet

    numbers = pyarrow.map_(pyarrow.string(), pyarrow.float64())
    kinds = {"str": pyarrow.string(), "bool": pyarrow.bool_(), "int": pyarrow.int64()}
    types = [
        (name, numbers if kind.startswith("dict") else kinds.get(kind, pyarrow.float64()))
        for name, kind in Row.__annotations__.items()
    ]
    columns = [
        pyarrow.array(
            [list(v.items()) if isinstance(v := getattr(row, name), dict) else v for row in rows],
            type=kind,
        )
        for name, kind in types
    ]
    table = pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(types))
    write_whole(path, lambda file: parquet.write_table(table, file))
    return path
