"""Second attempts: after the first ones, alone, on another worker than the one that failed."""

from __future__ import annotations

from typing import Any

from arael.distributed.retries import Failed, Going
from arael.distributed.work import Task
from tests.optional import needs

pytestmark = needs("Dask")


class Workers:
    """The part of a client that says which workers there are."""

    def __init__(self, *names: str) -> None:
        self.names = names

    def scheduler_info(self, n_workers: int) -> dict[str, Any]:
        assert n_workers == -1  # all of them
        return {"workers": {f"tcp://{n}": {"nanny": f"tcp://nanny-{n}"} for n in self.names}}


def failed(**where: str) -> Failed:
    found = Failed()
    for name, place in where.items():
        found.add(Task(name, name, "key"), place)
    return found


def placed(one: Failed, client: Any, *busy: str) -> list[tuple[str, str | None]]:
    going = [Going([], 2, None, name) for name in busy]
    return [(task.name, worker) for task, worker in one.placed(client, going)]


def test_a_problem_goes_to_another_worker_than_the_one_that_was_restarted() -> None:
    one = failed(p="tcp://nanny-a")
    assert placed(one, Workers("a", "b")) == [("p", "tcp://b")]
    assert not one


def test_a_problem_that_failed_without_ending_its_worker_goes_to_another() -> None:
    assert placed(failed(p="tcp://b"), Workers("a", "b", "c")) == [("p", "tcp://a")]


def test_a_problem_waits_for_another_worker_that_is_busy() -> None:
    one = failed(p="tcp://a")
    assert placed(one, Workers("a", "b"), "tcp://b") == []
    assert placed(one, Workers("a", "b")) == [("p", "tcp://b")]


def test_no_worker_gets_two_problems() -> None:
    one = failed(p="tcp://a", q="tcp://b", r="tcp://b")
    assert placed(one, Workers("a", "b")) == [("p", "tcp://b"), ("q", "tcp://a")]
    assert placed(one, Workers("a", "b"), "tcp://a") == []
    assert placed(one, Workers("a", "b"), "tcp://b") == [("r", "tcp://a")]


def test_the_only_worker_is_tried_again() -> None:
    assert placed(failed(p="tcp://nanny-a"), Workers("a")) == [("p", "tcp://a")]


def test_without_workers_one_problem_waits_for_the_next_that_joins() -> None:
    one = failed(p="tcp://nanny-a", q="tcp://nanny-a")
    assert placed(one, Workers()) == [("p", None)]
    assert bool(one)
