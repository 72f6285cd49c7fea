"""``python -m benchmarks.questions``: what questions to a solution take, beside an iteration.

Sensitivities: the derivatives of one scalar by all data, of pose graphs, after the solve: with the
factor that is there, and with one to be made. Certificates: reading the model, the minimum of
the chordal twin, the factorisation that decides. An iteration is a linearisation, a factorisation,
a solve and a cost, of the solve before. Medians, of one process and one thread.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import statistics  # noqa: E402
import time  # noqa: E402
from collections.abc import Callable, Iterator  # noqa: E402
from typing import Any  # noqa: E402

import arael  # noqa: E402
from arael.solution import Solution  # noqa: E402
from benchmarks.cases import DATA  # noqa: E402
from benchmarks.measure import table  # noqa: E402

REPEATS = 5
SENSITIVITIES = (
    ("pose_graph_3d/sphere2500.g2o", "poses[1200].t.x"),
    ("pose_graph_2d/M3500.g2o", "poses[1200].t.x"),
)
CERTIFICATES = (
    "pose_graph_3d/tinyGrid3D.g2o",
    "pose_graph_3d/smallGrid3D.g2o",
    "pose_graph_3d/sphere2500.g2o",
    "pose_graph_3d/parking-garage.g2o",
    "pose_graph_2d/intel.g2o",
    "pose_graph_2d/M3500.g2o",
)


def solved(kind: str, name: str) -> tuple[Any, Any, float]:
    """A solved model of a public file, the result, and the milliseconds of an iteration."""
    model: Any = arael.load(kind)()
    model.read(DATA / name)
    result = model.solve()
    phases = ("linearise", "factor", "first_factor", "solve", "cost")
    seconds = sum(result.timing[phase] for phase in phases)
    return model, result, 1e3 * seconds / max(result.iterations, 1)


def median(action: Callable[[], Any]) -> float:
    """Milliseconds that an action takes, after a first time."""
    action()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        action()
        times.append(1e3 * (time.perf_counter() - began))
    return statistics.median(times)


def sensitivities() -> Iterator[list[str]]:
    """A row for each problem."""
    for name, of in SENSITIVITIES:
        model, result, iteration = solved(name.partition("/")[0], name)
        solution = Solution(model, result.frozen)
        warm = median(lambda solution=solution, of=of: solution.sensitivity(of))
        cold = median(
            lambda model=model, result=result, of=of: Solution(model, result.frozen).sensitivity(of)
        )
        count = sum(one.size for one in solution.sensitivity(of).values())
        yield [name, f"{count}", *(f"{t:.3g}" for t in (iteration, warm, cold))]


def certificates() -> Iterator[list[str]]:
    """A row for each file."""
    for name in CERTIFICATES:
        model, result, iteration = solved(name.partition("/")[0], name)
        _ = result.certificate  # reads and checks the text
        result.__dict__.pop("certified")
        found = result.certificate
        parts = (1e3 * found.seconds[key] for key in ("read", "minimise", "factorise"))
        del model
        yield [name, str(found), f"{iteration:.3g}", *(f"{t:.3g}" for t in parts)]


def main() -> None:
    """Print both tables."""
    head = ["problem", "numbers", "iteration [ms]", "all data [ms]", "and a factor [ms]"]
    print("\n".join(table(head, list(sensitivities()))), end="\n\n")
    head = ["file", "certificate", "iteration [ms]", "read", "minimise", "factorise [ms]"]
    print("\n".join(table(head, list(certificates()))))


if __name__ == "__main__":
    main()
