"""Many problems on a local cluster of worker processes."""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.diagnostics.records import AraelError
from tests.cli.conftest import Arael
from tests.optional import needs

pytestmark = needs("dask")

MODEL = """
root One : f64 {
    param a: real
    target: real
    constraint near { a - target }
}
"""


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    from arael.distributed import connect

    with connect(workers=2) as found:
        yield found


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    folder = tmp_path / "logs"
    folder.mkdir()
    for k in range(5):
        (folder / f"p{k}.json").write_text(json.dumps({"a": 0, "target": k}))
    return folder


def rows_of(client: Any, logs: Path, **options: Any) -> dict[str, Any]:
    from arael.distributed import map as solve_all

    kind = arael.loads(MODEL, interpret=True)
    found = solve_all(kind, [logs / "*"], client, **options)
    return {future.result().name: future.result() for future in found}


@pytest.mark.parametrize("group", [1, 2])
def test_each_file_is_solved_as_alone(client: Any, logs: Path, group: int) -> None:
    rows = rows_of(client, logs, group=group)
    assert [rows[f"p{k}.json"].parameters["a"] for k in range(5)] == pytest.approx(range(5))
    alone = arael.loads(MODEL, interpret=True)(a=0, target=3)
    result = alone.solve()
    assert rows["p3.json"].cost == result.cost
    assert rows["p3.json"].iterations == result.iterations
    assert rows["p3.json"].sigmas == {"a": pytest.approx(1.0)}
    assert {row.kernels for row in rows.values()} == {"interpreted"}
    assert rows["p3.json"].interpreted == "the model was loaded with interpret=True"


def test_a_failure_is_retried_once_and_listed(client: Any, logs: Path) -> None:
    (logs / "bad.json").write_text("{ bad")
    rows = rows_of(client, logs, group=3)
    assert rows["bad.json"].status == "failed"
    assert rows["bad.json"].attempts == 2
    assert "bad.json" in rows["bad.json"].message
    assert sum(row.converged for row in rows.values()) == 5


def test_resume_solves_only_what_is_missing(client: Any, logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    rows_of(client, logs, output=out)
    assert json.loads((out / "p4.json").read_text())["a"] == pytest.approx(4)
    (out / "rows" / "p1.json.json").unlink()
    (logs / "p2.json").write_text('{"a": 0, "target": 20}')
    (out / "p0.json").write_text("{")  # as after a loss of power
    kept = (out / "rows" / "p3.json.json").stat().st_mtime_ns
    rows = rows_of(client, logs, output=out, resume=True)
    assert rows["p2.json"].parameters["a"] == pytest.approx(20)
    assert (out / "rows" / "p1.json.json").exists()
    assert json.loads((out / "p0.json").read_text())["target"] == 0
    assert (out / "rows" / "p3.json.json").stat().st_mtime_ns == kept
    assert len(rows_of(client, logs, output=out, resume=True)) == 5  # nothing is missing


def test_a_problem_that_hangs_is_listed_and_the_rest_goes_on(client: Any, logs: Path) -> None:
    os.mkfifo(logs / "hang.json")  # no process writes to it: reading it never ends
    rows = rows_of(client, logs, time_limit=1.5, group=3)
    assert rows["hang.json"].status == "failed"
    assert rows["hang.json"].attempts == 2
    assert "took longer than 3.25 s" in rows["hang.json"].message
    # Those that went to the worker with it are solved alone, so that it takes none with it twice.
    assert sum(row.converged for row in rows.values()) == 5
    assert sum(row.attempts == 2 for row in rows.values()) == 3


def test_a_killed_worker_costs_one_retry(client: Any, logs: Path) -> None:
    pipe = logs / "slow.json"
    os.mkfifo(pipe)

    def kill_then_write() -> None:
        with open(pipe, "w"):  # opens when the worker reads
            # a second attempt finds a file, however soon it comes
            written = logs.parent / "written.json"
            written.write_text('{"a": 0, "target": 7}')
            written.replace(pipe)
            for pid in client.run(os.getpid).values():
                os.kill(pid, signal.SIGKILL)

    thread = threading.Thread(target=kill_then_write)
    thread.start()
    rows = rows_of(client, logs)
    thread.join()
    assert len(rows) == 6
    assert [rows[f"p{k}.json"].status for k in range(5)] == ["converged"] * 5
    assert rows["slow.json"].attempts == 2


def test_results_that_are_lost_with_their_worker_are_left_out() -> None:
    from arael.distributed.many import _gathered

    class Task:
        def __init__(self, key: str) -> None:
            self.key = key

        def result(self) -> list[str]:
            if self.key == "lost":
                raise RuntimeError("killed")
            return [self.key]

    class Client:
        def gather(self, tasks: list[Task]) -> list[Any]:
            return [task.result() for task in tasks]

    tasks: Any = [Task("a"), Task("b")]
    assert _gathered(Client(), tasks) == {"a": ["a"], "b": ["b"]}  # type: ignore[arg-type]
    tasks.insert(1, Task("lost"))
    assert _gathered(Client(), tasks) == {"a": ["a"], "b": ["b"]}  # type: ignore[arg-type]


def test_patterns_that_match_nothing_are_an_error(tmp_path: Path) -> None:
    from arael.distributed.many import files_of

    with pytest.raises(AraelError, match="E0885"):
        files_of([tmp_path / "*.npz"])


def test_the_command_writes_results_and_a_table(request: pytest.FixtureRequest, logs: Path) -> None:
    (logs / "bad.json").write_text("{ bad")
    (logs.parent / "m.arael").write_text(MODEL)
    args = ("solve", logs.parent / "m.arael", logs / "*.json", "--workers", "1", "--interpret")
    args += ("--group", "3")
    command: Arael = request.getfixturevalue("arael")
    done = command(*args, "-o", logs.parent / "out")
    assert done.code == 1, done.err
    assert "5 of 6 problems converged" in done.out
    assert "bad.json: failed (tried 2 times)" in done.out
    assert "without kernels: the model was loaded with interpret=True" in done.err
    why = "of groups were solved one after another: the root has parameters"
    assert f"note: 5 {why}" in done.err
    assert list((logs.parent / "out").glob("table.*"))


def test_groups_on_workers_are_solved_together(client: Any, logs: Path) -> None:
    from arael.distributed import map as solve_all

    text = "struct P { param x: real; k: real\n constraint c { x * x - k } }"
    kind = arael.loads(f"{text}\nroot All : f64 {{ ps: list of P }}", interpret=True)
    for k in range(5):
        (logs / f"p{k}.json").write_text(json.dumps({"ps": [{"x": 1, "k": k + 1}]}))
    found = [future.result() for future in solve_all(kind, [logs / "*"], client, group=5)]
    assert {row.together for row in found} == {5}
    assert len({row.worker for row in found}) == 1
    for row in found:
        assert row.parameters["ps[0].x"] ** 2 == pytest.approx(int(row.name[1]) + 1)


def test_options_of_many_problems_need_a_cluster(request: pytest.FixtureRequest) -> None:
    command: Arael = request.getfixturevalue("arael")
    done = command("solve", "linear", "x.json", "--resume")
    assert done.code == 2
    assert "add --workers or --scheduler" in done.err
