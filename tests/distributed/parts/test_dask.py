"""Parts on the workers of a Dask cluster, and what happens when some of it dies."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.model_warnings import InterpretedWarning
from arael.diagnostics.records import AraelError
from arael.distributed import compiled, contents, solve
from arael.distributed.parts import executors, requests, team
from arael.distributed.parts.executors import OnDask
from arael.distributed.parts.requests import PartRecipe
from arael.distributed.parts.solve import prepare, run
from arael.distributed.parts.stations import LOST, Remote, ask_directly
from tests.distributed.environments import hide_compiler, workers_without_compiler
from tests.optional import needs, require

from .faults import Cluster, kills
from .problems import GRID, PROBLEMS, arrays_of, with_arrays
from .test_components import assert_components_equal
from .test_equal import BOUNDED

pytestmark = needs("Dask")


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    distributed = require("Dask")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


def test_a_cluster_makes_the_attempts_of_one_machine(client: Any) -> None:
    model = PROBLEMS["loop"]()
    other = with_arrays(model, arrays_of(model))
    found = solve(model, partition=3, client=client)
    result = other.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)
    np.testing.assert_allclose(
        found.covariance().marginal("poses", 30),
        other.covariance().marginal(("poses", 30)),
        rtol=1e-5,
        atol=1e-8,
    )


@pytest.mark.parametrize("name", BOUNDED)
def test_bounds_hold_on_workers(client: Any, name: str) -> None:
    model = BOUNDED[name]()
    other = with_arrays(model, arrays_of(model))
    found = solve(model, partition=3, client=client)
    result = other.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)
    row = 3
    collection = {"bundle": "points", "loop": "poses", "grid": "nodes"}[name]
    np.testing.assert_allclose(
        found.covariance().marginal(collection, row),
        other.covariance().marginal((collection, row)),
        rtol=1e-5,
        atol=1e-8,
    )


def test_components_on_a_cluster_are_solved_as_on_one_machine(client: Any) -> None:
    model = PROBLEMS["fleet"]()
    other = with_arrays(model, arrays_of(model))
    found = solve(model, partition=3, client=client)
    assert_components_equal(found, other.solve(solver="sparse"))
    for row in (0, 2, 7):
        np.testing.assert_allclose(
            found.covariance().marginal("poses", row),
            other.covariance().marginal(("poses", row)),
            rtol=1e-6,
            atol=1e-15,
        )


def test_workers_without_kernels_interpret_the_model_and_say_so(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arrays = arrays_of(PROBLEMS["grid"]())
    hide_compiler(monkeypatch, tmp_path / "own")
    with warnings.catch_warnings(action="ignore"):  # of this process, which has none either
        kind = arael.loads(GRID, name="other_grid.arael")
    model, other = (with_arrays(kind(), arrays) for _ in range(2))
    with (
        workers_without_compiler(client, tmp_path / "cache"),
        pytest.warns(InterpretedWarning, match=r"worker .*: neither it nor a worker like it"),
    ):
        found = solve(model, partition=2, client=client)
    result = other.solve(solver="sparse")
    assert found.result.iterations == result.iterations
    assert found.result.cost == pytest.approx(result.cost, rel=1e-9)


def test_workers_of_a_model_that_is_to_be_interpreted_do_not_warn(client: Any) -> None:
    model = PROBLEMS["grid"]()
    with warnings.catch_warnings(action="error", category=InterpretedWarning):
        assert solve(model, partition=2, client=client).result.converged


def tampered(vouched: str) -> None:
    """Change what has arrived at this worker."""
    contents.ARRIVED[vouched] += b"changed"
    compiled.loaded.cache_clear()


def part_of(model: Any, name: str) -> PartRecipe:
    prepared = prepare(model._compiled, arrays_of(model), 2, None)
    return PartRecipe("vouched", 0, name, prepared.shares[0], None, prepared.arrays[0])


def test_workers_run_only_models_whose_hash_the_client_vouches_for(client: Any) -> None:
    model = PROBLEMS["grid"]()
    vouched = OnDask(client).ship(model._compiled)
    instances = client.submit(requests.describe, part_of(model, vouched), pure=False).result()[0]
    assert instances > 0
    requested = client.submit(requests.describe, replace(part_of(model, "0" * 64), run="other"))
    with pytest.raises(AraelError, match=r"E0883.*no content of this hash"):
        requested.result()
    client.run(tampered, vouched)
    requested = client.submit(requests.describe, replace(part_of(model, vouched), run="third"))
    with pytest.raises(AraelError, match=r"E0883.*changed after its arrival"):
        requested.result()
    # It is sent again by the next solve.
    found = solve(model, partition=2, client=client)
    assert found.result.converged


@pytest.mark.parametrize("name", ["grid", "fleet"])
def test_a_killed_worker_changes_nothing(name: str, tmp_path: Path) -> None:
    count = kills(2, tmp_path / "cluster", seed=5, name=name)
    assert count.equal == count.runs == 2


@pytest.mark.slow
def test_a_solve_goes_on_from_its_checkpoint_when_the_scheduler_dies(tmp_path: Path) -> None:
    model = PROBLEMS["grid"]()
    arrays = arrays_of(model)
    alone = with_arrays(model, arrays).solve(solver="sparse")
    checkpoint = tmp_path / "state.npz"
    cluster = Cluster(tmp_path / "one")
    seen = []

    def observe(record: Any) -> None:
        seen.append(record)
        if len(seen) == 4:
            cluster.scheduler.kill()

    try:
        with pytest.raises(AraelError) as caught:
            solve(
                with_arrays(model, arrays),
                partition=3,
                scheduler=cluster.address,
                checkpoint=checkpoint,
                observer=observe,
            )
    finally:
        cluster.close()
    assert caught.value.diagnostics[0].code == "E0898"
    assert "--resume" in str(caught.value)
    found = solve(
        with_arrays(model, arrays), partition=3, workers=0, checkpoint=checkpoint, resume=True
    )
    assert found.result.cost == pytest.approx(alone.cost, rel=1e-9)
    assert found.result.history["cost"][0] == pytest.approx(seen[-1]["trial_cost"], rel=1e-12)


def test_parts_and_boundary_share_a_worker_of_several_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    distributed = require("Dask")
    monkeypatch.setattr(team, "_SMALL", 0)
    threads: set[str] = set()
    cost = requests.cost

    def noted(*args: Any) -> float:
        threads.add(threading.current_thread().name)
        time.sleep(0.02)
        return cost(*args)

    monkeypatch.setattr(requests, "cost", noted)
    model = PROBLEMS["grid"]()
    other = with_arrays(model, arrays_of(model))
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0"
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        found = solve(model, partition=3, client=client)
    assert found.result.iterations == other.solve(solver="sparse").iterations
    assert len(threads) == 2


def test_no_scheduler_is_a_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.distributed.parts.api.PATIENCE", 1.0)
    model = PROBLEMS["grid"]()
    with pytest.raises(AraelError) as caught:
        solve(model, partition=2, scheduler="tcp://127.0.0.1:9")
    assert caught.value.diagnostics[0].code == "E0881"


def test_workers_out_of_reach_are_asked_through_the_scheduler(
    client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = client.direct_to_workers
    try:
        ask_directly(client)
        assert client.direct_to_workers
        client.direct_to_workers = False
        monkeypatch.setattr(client, "rpc", lambda address: client.scheduler)
        monkeypatch.setattr(client.scheduler, "identity", unreachable, raising=False)
        monkeypatch.setattr(
            "arael.distributed.parts.stations.present_workers", lambda: {"tcp://10.0.0.1:1"}
        )
        ask_directly(client)
        assert not client.direct_to_workers
    finally:
        client.direct_to_workers = before


async def unreachable() -> None:
    """No route to the worker."""
    raise OSError("no route to host")


def asked(client: Any) -> str:
    """What a solve that cannot go on reports."""
    with pytest.raises(AraelError) as caught:
        solve(PROBLEMS["grid"](), partition=2, client=client)
    assert caught.value.diagnostics[0].code == "E0898"
    return str(caught.value)


def test_a_worker_that_dies_while_the_model_is_sent_is_left_out(
    client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, sent = client.run, client.register_plugin
    lost = [OSError("Stream is closed")]

    def run_with_one_lost(function: Any, **how: Any) -> Any:
        return asked(function, **how) | {"tcp://127.0.0.1:9": OSError("Stream is closed")}

    def lost_at_first(*args: Any, **how: Any) -> Any:
        if lost:
            raise lost.pop()
        return sent(*args, **how)

    monkeypatch.setattr(client, "run", run_with_one_lost)
    monkeypatch.setattr(client, "register_plugin", lost_at_first)
    assert len(OnDask(client).ship(PROBLEMS["grid"]()._compiled)) == 64


def test_a_worker_that_dies_before_it_is_asked_is_replaced(
    client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    submit, lost = client.submit, []

    def lost_at_first(function: Any, *args: Any, **how: Any) -> Any:
        future = submit(function, *args, **how)
        if not lost:
            lost.append(how["workers"][0])
            monkeypatch.setattr(future, "result", gone)
        return future

    monkeypatch.setattr(client, "submit", lost_at_first)
    executor = OnDask(client)
    homes = {executor.source(part).address for part in (0, 1, 2)}
    assert lost and not homes & set(lost)


def gone(timeout: float) -> Any:
    """Fail as a future of an actor whose worker died does."""
    raise RuntimeError("Worker holding Actor was lost")


def test_a_cluster_without_workers_is_a_message(
    client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(executors, "present_workers", set)
    monkeypatch.setattr(executors, "_PATIENCE", 0.2)
    assert "no worker for 0.2 s" in asked(client)


def test_a_part_whose_workers_are_lost_again_and_again_is_a_message(
    client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = (LOST, OSError("the connection was reset"))
    monkeypatch.setattr(Remote, "wait", lambda self, pending: lost)
    monkeypatch.setattr(executors, "_SUSPECT", 0.0)
    text = asked(client)
    assert "several workers died with the same part" in text
    assert "the connection was reset" in text


def test_an_error_of_a_file_on_a_worker_is_that_error(client: Any, tmp_path: Path) -> None:
    model = PROBLEMS["grid"]()
    model.write(tmp_path / "grid.npz")
    prepared = prepare(model._compiled, tmp_path / "grid.npz", 2, None)
    (tmp_path / "grid.npz").write_bytes(b"PK and nothing")
    with pytest.raises(AraelError, match="E0711"):
        run(prepared, OnDask(client))
