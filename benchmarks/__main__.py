"""``python -m benchmarks [suite ...] [--peers NAME,...] [--peer-python PATH] [-o report.md]``."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from benchmarks import kernels, schur, solvers, start, systems  # noqa: E402
from benchmarks.measure import machine  # noqa: E402

OWN = {"kernels": kernels.run, "start": start.run, "solvers": solvers.run, "schur": schur.run}
BESIDE = ("slam", "localization", "pose_graph", "bundle")
SUITES = (*OWN, *BESIDE)


def main() -> None:
    """Run the suites named, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks")
    parser.add_argument("suites", nargs="*", choices=[*SUITES, []], help=", ".join(SUITES))
    parser.add_argument(
        "--peers", default=",".join(systems.PEERS[1:]), help="systems measured beside arael"
    )
    parser.add_argument(
        "--peer-python", default=sys.executable, help="an interpreter that has the peers' packages"
    )
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, help="write the report to this file")
    chosen = parser.parse_args()
    lines = ["# Benchmark report", "", *machine()]
    for name in chosen.suites or SUITES:
        sys.stderr.write(f"{name} ...\n")
        if name in OWN:
            lines += ["", *OWN[name]()]
            continue
        peers = ("arael", *(p for p in chosen.peers.split(",") if p))
        lines += ["", *systems.run(name, peers, chosen.peer_python, chosen.threads)]
    report = "\n".join(lines) + "\n"
    if chosen.output:
        chosen.output.write_text(report, encoding="utf-8")
    else:
        sys.stdout.write(report)


if __name__ == "__main__":
    main()
