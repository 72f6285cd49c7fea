"""Compiled models on real workers: by hash, without a compiler, refused without a vouched hash."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.distributed import compiled, contents
from tests.distributed.environments import change, hide_compiler, workers_without_compiler
from tests.optional import needs

pytestmark = needs("Dask")

MODEL = """
root Only : f64 { param a: real; target: real
    constraint near { a - target }
    constraint far { 1e-3 * exp(a / 8) } }
"""


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    from arael.distributed import connect

    with connect(workers=2) as found:
        yield found


@pytest.fixture
def without_compiler(client: Any, tmp_path: Path) -> Iterator[Path]:
    """Empty the search path and the cache of both workers; the cache."""
    cache = tmp_path / "cache"
    with workers_without_compiler(client, cache):
        yield cache


def solved(kind: Any, client: Any, folder: Path, count: int = 8) -> list[Any]:
    from arael.distributed import map as solve_all

    folder.mkdir()
    for k in range(count):
        points = [{"x": x, "y": k * x + 1} for x in range(4)]
        data = {"a": 0, "target": k} if kind.layout.root == "Only" else {"data": points}
        (folder / f"{k}.json").write_text(json.dumps({"a": 0, **data}))
    return [future.result() for future in solve_all(kind, [folder / "*.json"], client)]


def test_compiled_kernels_are_solved_on_two_workers(client: Any, tmp_path: Path) -> None:
    rows = solved(arael.load("linear"), client, tmp_path / "data")
    assert {row.kernels for row in rows} == {"shipped"}
    assert {row.worker for row in rows} == set(client.run(os.getpid))
    alone = arael.load("linear")()
    alone.read(tmp_path / "data" / "5.json")
    alone.solve()
    by_name = {row.name: row for row in rows}
    assert by_name["5.json"].parameters == {"a": alone.a, "b": alone.b}


def test_workers_without_a_compiler_get_kernels_by_hash(
    client: Any, without_compiler: Path, tmp_path: Path
) -> None:
    client.run(compiled.loaded.cache_clear)
    rows = solved(arael.load("linear"), client, tmp_path / "data")
    assert {(row.kernels, row.interpreted) for row in rows} == {("shipped", "")}
    assert all(row.converged for row in rows)
    modules = [path for path in without_compiler.rglob("*") if path.suffix in (".so", ".pyd")]
    assert len(modules) == 1  # what was sent, once for both


def test_where_no_process_has_a_compiler_rows_have_the_reason(
    client: Any, without_compiler: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide_compiler(monkeypatch, tmp_path / "own")
    with warnings.catch_warnings(action="ignore"):
        kind = arael.loads(MODEL)
    rows = solved(kind, client, tmp_path / "data", 2)
    assert {row.kernels for row in rows} == {"interpreted"}
    assert {row.interpreted for row in rows} == {"neither it nor a worker like it has a C compiler"}
    assert all(row.converged for row in rows)


@pytest.mark.slow
def test_a_worker_with_a_compiler_compiles_for_the_others(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = client.run(os.getpid)
    cache = str(tmp_path / "cache")
    before = client.run(change, PATH="", CC=None, ARAEL_CACHE_DIR=cache + "1", workers=[one])
    before |= client.run(change, ARAEL_CACHE_DIR=cache + "2", workers=[other])
    hide_compiler(monkeypatch, tmp_path / "own")
    try:
        with warnings.catch_warnings(action="ignore"):
            kind = arael.loads(MODEL)
        assert kind.compiled.kernels is None
        rows = solved(kind, client, tmp_path / "data")
    finally:
        for worker, variables in before.items():
            client.run(change, **variables, workers=[worker])
    assert {(row.kernels, row.interpreted) for row in rows} == {("shipped", "")}
    assert {row.worker for row in rows} == {one, other}


def test_a_hash_that_was_not_vouched_for_is_refused_by_the_worker(client: Any) -> None:
    from arael.distributed.groups import solve_group
    from arael.distributed.work import Settings, Task

    tasks = [Task(f"{k}", "absent", "key") for k in range(2)]
    for some in (tasks, tasks[:1]):
        future = client.submit(solve_group, "2" * 64, some, Settings(), 1, pure=False)
        rows = future.result()
        assert [row.status for row in rows] == ["failed"] * len(some)
        assert all("E0883" in row.message for row in rows)


def test_content_that_does_not_fit_its_hash_does_not_arrive(client: Any) -> None:
    from arael.distributed.arrival import Arrival

    vouched = "3" * 64
    try:
        with pytest.raises(AraelError, match="E0883"):
            client.register_plugin(Arrival(vouched, b"something else"), name="false")
        assert not any(client.run(lambda: vouched in contents.ARRIVED).values())
    finally:
        client.unregister_worker_plugin("false")
