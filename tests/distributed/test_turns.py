"""Short problems go several to a task, long ones one by one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.distributed import turns
from arael.distributed.turns import MOST, SECONDS, sizes
from arael.distributed.work import Row
from tests.optional import needs


def ended(seconds: float, status: str = "converged") -> Row:
    return Row("0.npz", "0.npz", status, seconds={"read": 0.25 * seconds, "solve": 0.75 * seconds})


@pytest.mark.parametrize("count", [1, 2, 7, 58, 1000])
@pytest.mark.parametrize("workers", [1, 2, 16])
@pytest.mark.parametrize("seconds", [0.0, 1e-4, 0.05, 3.0])
def test_every_problem_is_in_one_task(count: int, workers: int, seconds: float) -> None:
    found = sizes(count, workers, [ended(seconds)])
    assert sum(found) == count
    assert min(found) >= 1
    assert max(found) <= MOST


def test_a_task_is_as_long_as_wanted_and_the_last_are_short() -> None:
    found = sizes(100, 2, [ended(0.05), ended(0.04), ended(9.0)])
    assert found[0] == int(SECONDS / 0.05)
    assert found == sorted(found, reverse=True)
    assert found[-2:] == [1, 1]


def test_long_problems_and_unknown_ones_go_one_by_one() -> None:
    assert sizes(5, 2, [ended(2 * SECONDS)]) == [1] * 5
    assert sizes(5, 2, [ended(1e-3, "failed")]) == [1] * 5


@needs("Dask")
def test_tasks_on_a_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from arael.distributed import connect
    from arael.distributed import map as solve_all

    for k in range(60):
        points = [{"x": x, "y": k * x + 1} for x in range(4)]
        (tmp_path / f"{k}.json").write_text(json.dumps({"a": 0, "data": points}))
    (tmp_path / "bad.json").write_text("{")
    submitted: list[int] = []
    monkeypatch.setattr(turns, "SECONDS", 1e6)  # however long the first ones take
    with connect(workers=2) as client:
        whole: Any = client.map

        def count(solve: Any, hashes: Any, groups: Any, *rest: Any, **named: Any) -> Any:
            submitted.extend(map(len, groups))
            return whole(solve, hashes, groups, *rest, **named)

        monkeypatch.setattr(client, "map", count)
        rows = [
            future.result()
            for future in solve_all(arael.load("linear"), [tmp_path / "*.json"], client)
        ]
    assert sum(submitted) == len(rows) == 61
    assert submitted[:2] == [1, 1]
    assert submitted[2] == 15  # of 59 for two workers
    assert sorted(row.name for row in rows if row.status == "failed") == ["bad.json"]
    assert {row.attempts for row in rows if row.status != "failed"} == {1}
