"""Two built trees of arael, measured by turns: ``python benchmarks/beside.py OLD NEW``.

Each turn is a process of its own, which measures first solves (analysis of the structure included)
and later ones of public problems. The table gives the fastest of all turns, in milliseconds of the
processor, and the ratio new to old. Trees are folders that hold a package `arael` with its
extensions; `ARAEL_DATA` names the folder of public data.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TURNS = 5
RUNS = 3
PUBLIC = {
    "M3500": ("pose_graph_2d", "pose_graph_2d/M3500.g2o"),
    "sphere2500": ("pose_graph_3d", "pose_graph_3d/sphere2500.g2o"),
    "problem-49": ("bundle_adjustment", "bundle_adjustment/problem-49-7776-pre.txt"),
}


def main(old: str, new: str) -> None:
    """Measure by turns and print the table."""
    best: dict[str, dict[str, float]] = {old: {}, new: {}}
    for turn in range(TURNS):
        for tree in (old, new) if turn % 2 == 0 else (new, old):
            for what, seconds in _child(tree).items():
                best[tree][what] = min(seconds, best[tree].get(what, seconds))
    print(f"{'':<28}{'old [ms]':>10}{'new [ms]':>10}{'ratio':>8}")
    for what, seconds in best[old].items():
        other = best[new][what]
        print(f"{what:<28}{seconds * 1e3:>10.2f}{other * 1e3:>10.2f}{other / seconds:>8.3f}")


def _child(tree: str) -> dict[str, float]:
    single = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    env = {**os.environ, **single, "PYTHONPATH": tree}
    done = subprocess.run(
        [sys.executable, __file__], env=env, stdout=subprocess.PIPE, check=True, text=True
    )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def measure() -> dict[str, float]:
    """Seconds of the processor by what was done, in the tree that `arael` comes from."""
    import arael

    found: dict[str, float] = {}
    for name, make in _problems():
        for _ in range(RUNS):
            model = make()
            for what, iterations in (("first solve", 1), ("a later iteration", 10)):
                # Trees from before `reference` have that loop only.
                loop = getattr(arael.LmConfig, "reference", arael.LmConfig)
                config = loop(
                    max_iters=iterations,
                    min_iters=iterations,
                    patience=iterations,
                    abs_precision=0.0,
                    rel_precision=0.0,
                )
                began = time.process_time()
                result = model.solve(config=config, passes=[])
                seconds = (time.process_time() - began) / (
                    1 if iterations == 1 else result.iterations
                )
                key = f"{name}: {what}"
                found[key] = min(found.get(key, 1e9), seconds)
    return found


def _problems() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Name of each problem and what makes it anew."""
    import arael

    data = Path(os.environ.get("ARAEL_DATA", ROOT.parent / "shared" / "data"))
    for name, (model, file) in PUBLIC.items():
        loaded = arael.load(model)
        yield name, lambda loaded=loaded, file=file: _filled(loaded(), data / file)


def _filled(model: Any, file: Path) -> Any:
    model.read(file)
    return model


if __name__ == "__main__":
    if len(sys.argv) == 3:
        main(*sys.argv[1:])
    else:
        print(json.dumps(measure()))
