"""Kill workers at random points of a solve in parts.

``python -m tests.distributed.parts.faults 100`` does so a hundred times. Each run must give the attempts and the parameters of the run that nothing happened
to, bit by bit.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from arael.distributed import solve

from .problems import PROBLEMS, arrays_of, with_arrays

# The grid takes eight attempts of several rounds each, so that kills fall on all of them.
NAME, PARTS = "grid", 4


@dataclass
class Count:
    """What became of the runs."""

    runs: int = 0
    hit: int = 0
    equal: int = 0


def once(model: Any, arrays: dict[str, Any], client: Any) -> tuple[Any, Any]:
    """Solve a fresh instance: its attempts and its parameters."""
    found = solve(with_arrays(model, arrays), partition=PARTS, client=client)
    return found.result.history[["cost", "trial_cost", "accepted"]].copy(), found.result.x


def kill_one(client: Any, delay: float, generator: random.Random, hit: list[bool]) -> None:
    """Kill one of the workers after a delay."""
    pids = list(client.run(os.getpid).values())
    victim = generator.choice(pids)

    def strike() -> None:
        time.sleep(delay)
        hit.append(True)
        os.kill(victim, signal.SIGKILL)

    threading.Thread(target=strike, daemon=True).start()


def kills(runs: int, client: Any, workers: int, seed: int = 0) -> Count:
    """Solve `runs` times, each with a worker killed at a random time."""
    generator = random.Random(seed)
    model = PROBLEMS[NAME]()
    arrays = arrays_of(model)
    attempts, x = once(model, arrays, client)
    began = time.perf_counter()
    once(model, arrays, client)
    seconds = time.perf_counter() - began
    count = Count()
    for _ in range(runs):
        client.wait_for_workers(workers, timeout=60)
        hit: list[bool] = []
        kill_one(client, generator.uniform(0, seconds), generator, hit)
        found, values = once(model, arrays, client)
        count.runs += 1
        count.hit += bool(hit)
        count.equal += np.array_equal(found, attempts) and np.array_equal(values, x)
        while not hit:
            time.sleep(0.01)
        time.sleep(0.2)  # the nanny notices, and starts another
    return count


def main(runs: int, workers: int = 2) -> None:
    """Print what became of `runs` runs."""
    # imported here: an optional part
    import distributed

    with (
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address=":0",
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        began = time.perf_counter()
        count = kills(runs, client, workers)
        print(
            f"{count.runs} runs, {count.hit} with a kill before the end, {count.equal} equal to "
            f"the undisturbed run bit by bit; {time.perf_counter() - began:.0f} s"
        )
        sys.exit(count.equal != count.runs)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
