"""The table of outcomes."""

from __future__ import annotations

import csv
import importlib.util
import json
from pathlib import Path

import pytest

from arael.distributed.table import write_table
from arael.distributed.work import Row
from tests.optional import needs

ROWS = [
    Row("b.json", "/data/b.json", "failed", message="not a model\nline two", attempts=2),
    Row(
        "a.json",
        "/data/a.json",
        "converged",
        converged=True,
        cost=0.25,
        iterations=7,
        parameters={"a": 1.5, "p.x": None},
        sigmas={"a": 0.125},
        seconds={"read": 0.5, "solve": 0.25},
        worker="tcp://one",
        kernels="shipped",
        together=3,
    ),
]


@needs("pyarrow")
def test_the_parquet_table_has_a_typed_column_for_each_field(tmp_path: Path) -> None:
    from pyarrow import parquet

    path = write_table(ROWS, tmp_path)
    assert path.name == "table.parquet"
    table = parquet.read_table(path)
    assert table.column_names == list(Row.__struct_fields__)
    kinds = {field.name: str(field.type) for field in table.schema}
    assert kinds["cost"] == "double"
    assert kinds["iterations"] == kinds["together"] == "int64"
    assert kinds["converged"] == "bool"
    assert kinds["sigmas"].startswith("map<string, double")
    first, second = table.to_pylist()
    assert (first["name"], second["name"]) == ("a.json", "b.json")
    assert first["parameters"] == [("a", 1.5), ("p.x", None)]
    assert first["seconds"] == [("read", 0.5), ("solve", 0.25)]
    assert (first["cost"], first["iterations"], first["together"]) == (0.25, 7, 3)
    assert second["cost"] is None
    assert second["message"] == "not a model\nline two"
    assert second["attempts"] == 2


def test_without_pyarrow_the_table_is_csv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pyarrow" else find(name)
    )
    path = write_table(ROWS, tmp_path)
    assert path.name == "table.csv"
    with path.open(newline="") as file:
        first, second = csv.DictReader(file)
    assert list(first) == list(Row.__struct_fields__)
    assert (first["name"], first["cost"], first["iterations"]) == ("a.json", "0.25", "7")
    assert json.loads(first["parameters"]) == {"a": 1.5, "p.x": None}
    assert json.loads(first["sigmas"]) == {"a": 0.125}
    assert (second["cost"], second["converged"]) == ("", "False")
    assert second["message"] == "not a model\nline two"
