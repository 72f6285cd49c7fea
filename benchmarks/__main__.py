"""``python -m benchmarks [suite ...] [--peers NAME,...] [--peer-python PATH] [-o report.md]``."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from benchmarks.measure import THREADS

for variable in THREADS:
    os.environ.setdefault(variable, "1")

from benchmarks import chapters  # noqa: E402
from benchmarks.publish import publish_all  # noqa: E402
from benchmarks.sketch.systems import PEERS as SKETCHERS  # noqa: E402
from benchmarks.systems import PEERS, Plan, prepare  # noqa: E402


def main() -> None:
    """Run the suites named, or all; the report grows suite by suite."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks")
    known = ", ".join(chapters.SUITES)
    parser.add_argument("suites", nargs="*", metavar="suite", help=f"{known}; left out: all")
    others = tuple(dict.fromkeys((*PEERS, *SKETCHERS)))
    parser.add_argument(
        "--peers",
        default=",".join(others),
        help=f"systems beside arael: {', '.join(others)}; or ''",
    )
    parser.add_argument(
        "--peer-python", default=sys.executable, help="an interpreter that has the peers' wheels"
    )
    parser.add_argument(
        "--threads",
        default="1,2",
        help="numbers of threads; from the second on for the largest cases only (default: 1,2)",
    )
    parser.add_argument(
        "--quick", action="store_true", help="small problems, few runs: does everything work?"
    )
    parser.add_argument("-o", "--output", type=Path, help="write the report to this file")
    parser.add_argument(
        "--publish",
        type=Path,
        metavar="REPORT",
        help="measure nothing: write the summary of a report into the README and docs/speed.md",
    )
    chosen = parser.parse_args()
    if chosen.publish is not None:
        for page in publish_all(chosen.publish):
            sys.stdout.write(f"wrote {page}\n")
        return
    for name in chosen.suites:
        if name not in chapters.SUITES:
            parser.error(f"no suite {name!r}; there are {known}")
    peers = tuple(p for p in chosen.peers.split(",") if p)
    for name in peers:
        if name not in others:
            parser.error(f"no peer {name!r}; there are {', '.join(others)}")
    threads = tuple(int(n) for n in chosen.threads.split(","))
    plan = Plan(
        tuple(p for p in peers if p in PEERS),
        chosen.peer_python,
        threads,
        chosen.quick,
        tuple(p for p in peers if p in SKETCHERS),
    )
    names = tuple(chosen.suites) or tuple(chapters.SUITES)

    began = time.perf_counter()
    if any(name in (*chapters.BESIDE, "optimum") for name in names):
        prepare(plan)
    report = chapters.Report(chosen.output)
    for name in names:
        sys.stderr.write(f"{name} ... [{(time.perf_counter() - began) / 60:.1f} min]\n")
        report.add(name, plan)
    sys.stderr.write(f"done in {(time.perf_counter() - began) / 60:.1f} min\n")
    if chosen.output is None:
        sys.stdout.write(report.text())


if __name__ == "__main__":
    main()
