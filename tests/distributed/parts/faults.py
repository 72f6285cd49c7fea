"""Kill workers at random points of a solve in parts.

``python -m tests.distributed.parts.faults 100`` does so a hundred times. Each run must give the
attempts and the parameters of the run that nothing happened to, bit by bit.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from arael.distributed import solve
from arael.distributed.parts import team

from .problems import PROBLEMS, arrays_of, with_arrays

# The grid takes eight attempts of several rounds each, so that kills fall on all of them.
NAME, PARTS = "grid", 4
# Seconds that a process has to start: a machine that does other work takes its time.
PATIENCE = 300


class Cluster:
    """A scheduler and two workers as processes of their own."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True)
        self._folder = folder
        self.workers: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        where = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)]
        self.scheduler = self._start(["scheduler", "--no-dashboard", *where])
        until = time.monotonic() + PATIENCE
        while not (file.exists() and file.read_text()):
            assert time.monotonic() < until
            time.sleep(0.05)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(2):
            self.add_worker()

    def add_worker(self) -> None:
        """Start one more worker."""
        how = ["--no-nanny", "--nthreads", "1", "--no-dashboard"]
        self.workers.append(self._start(["worker", self.address, *how]))

    def kill_worker(self, number: int) -> None:
        """Kill one of the workers."""
        self.workers.pop(number).kill()

    def close(self) -> None:
        """End all processes."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()

    def _start(self, command: list[str]) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *command],
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


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


def kill_later(
    cluster: Cluster, delay: float, victim: int, ended: threading.Event, count: Count
) -> None:
    """Kill a worker after a delay; count it if the solve has not ended by then."""
    time.sleep(delay)
    count.hit += not ended.is_set()
    cluster.kill_worker(victim)


def kills(runs: int, folder: Path, seed: int = 0, name: str = NAME) -> Count:
    """Solve a problem `runs` times, each with one of two workers killed at a random time."""
    # imported here: an optional part
    import distributed

    generator = random.Random(seed)
    model = PROBLEMS[name]()
    arrays = arrays_of(model)
    cluster = Cluster(folder)
    count = Count()
    small = team._SMALL
    try:
        with distributed.Client(
            cluster.address, set_as_default=False, direct_to_workers=True
        ) as client:
            client.wait_for_workers(2, timeout=PATIENCE)
            attempts, x = once(model, arrays, client)
            began = time.perf_counter()
            once(model, arrays, client)
            seconds = time.perf_counter() - began
            for number in range(runs):
                # The boundary is solved in this process, and every other time on a worker.
                team._SMALL = small * (number % 2)
                client.wait_for_workers(2, timeout=PATIENCE)
                ended = threading.Event()
                delay, victim = generator.uniform(0, seconds), generator.randrange(2)

                strike = partial(kill_later, cluster, delay, victim, ended, count)
                thread = threading.Thread(target=strike)
                thread.start()
                found, values = once(model, arrays, client)
                ended.set()
                thread.join()
                count.runs += 1
                count.equal += np.array_equal(found, attempts) and np.array_equal(values, x)
                cluster.add_worker()
    finally:
        team._SMALL = small
        cluster.close()
    return count


def main(runs: int) -> int:
    """Print what became of `runs` runs; 0 if all are equal."""
    began = time.perf_counter()
    with TemporaryDirectory() as folder:
        count = kills(runs, Path(folder) / "cluster")
    print(
        f"{count.runs} runs, {count.hit} with a kill before the end, {count.equal} equal to "
        f"the undisturbed run bit by bit; {time.perf_counter() - began:.0f} s"
    )
    return int(count.equal != count.runs)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 10))
