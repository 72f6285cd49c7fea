"""``python -m benchmarks.verdicts``: verdicts on small calibrations with many draws of noise.

How often healthy data is accused, of 200 draws over the problems of `tests/analysis/planted.py`,
and how often each planted deficiency is named, of ten. The suite has a few draws of each.
``--draws N`` and ``--seeds N`` choose other numbers.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.measure import table

HEALTHY_SEED = 1000
"""Seed of the first healthy draw; those of the suite are lower, or its first four of a problem."""


def accused(draws: int) -> Iterator[list[str]]:
    """For each healthy problem: draws, and the topics of false alarms with their seeds."""
    from tests.analysis.planted import HEALTHY
    from tests.interpreted import loader

    names = list(HEALTHY)
    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        load = loader(Path(folder))
        for k, name in enumerate(names):
            alarms, count = [], 0
            for seed in range(HEALTHY_SEED + k, HEALTHY_SEED + draws, len(names)):
                verdict = HEALTHY[name](load, np.random.default_rng(seed)).verdict()
                count += 1
                alarms += [f"{seed}: {one.topic}" for one in verdict.findings]
            yield [name, f"{count}", ", ".join(alarms) or "none"]


def named(seeds: int) -> Iterator[list[str]]:
    """For each deficiency: how many draws had the expected topics and what is missing."""
    from tests.analysis.planted import NAMED, PLANTED
    from tests.interpreted import loader

    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        load = loader(Path(folder))
        for name, (wanted, _, varied) in NAMED.items():
            count = 0
            for seed in range(1, seeds + 1):
                verdict = PLANTED[name](load, np.random.default_rng(seed)).verdict()
                missing = {one.variations[0].name for d in verdict.directions for one in d.missing}
                topics = {one.topic for one in verdict.findings}
                count += wanted <= topics and set(varied) <= missing
            yield [name, f"{count} of {seeds}"]


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.verdicts")
    parser.add_argument("--draws", type=int, default=200, help="of healthy data, together")
    parser.add_argument("--seeds", type=int, default=10, help="of each deficiency")
    given = parser.parse_args()
    head = ["healthy", "draws", "false alarms"]
    print("\n".join(table(head, list(accused(given.draws)))), end="\n\n")
    print("\n".join(table(["deficiency", "named"], list(named(given.seeds)))))


if __name__ == "__main__":
    main()
