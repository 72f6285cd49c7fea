"""Repeated runs of one action, and what a peer in Python does in its process."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.sketch import sketches

WARM, LEAST, MOST = 2, 5, 201
"""Runs that do not count; no fewer and no more that do."""
PATIENCE = 5
"""After so many budgets no further run is begun, whatever their number."""


class AbsentError(Exception):
    """A task that a system does not have; the words say why."""


def repeated(budget: float, action: Callable[[int], object]) -> list[float]:
    """Seconds of runs of an action, which is given its turn, until the budget is spent.

    An action of which a part counts returns the seconds of that part.
    """
    began = time.perf_counter()
    turn = 0
    while turn < WARM and (turn == 0 or time.perf_counter() - began < budget):
        action(turn)
        turn += 1
    began = time.perf_counter()
    times: list[float] = []
    while len(times) < MOST:
        spent = time.perf_counter() - began
        if (spent > budget and len(times) >= LEAST) or spent > PATIENCE * budget:
            break
        start = time.perf_counter()
        part = action(turn)
        times.append(part if isinstance(part, float) else time.perf_counter() - start)
        turn += 1
    return times


Task = Callable[[sketches.Sketch, float], Mapping[str, Any]]


def main(tasks: Mapping[str, Task], name: str) -> None:
    """``TASK SKETCH SECONDS``: run a task, print what it found as the last line."""
    task, sketch, budget = sys.argv[1:4]
    if task not in tasks:
        print(json.dumps({"absent": f"no {task} in {name}"}))
        return
    try:
        found = dict(tasks[task](sketches.make(sketch), float(budget)))
    except AbsentError as reason:
        found = {"absent": str(reason)}
    print(json.dumps(found))
