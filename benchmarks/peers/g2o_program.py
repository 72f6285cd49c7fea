"""g2o by the C++ program under `g2o`: bundles and planes, which its wheel has no such edges for.

Residuals are those of the models. Bundles have g2o's automatic derivatives, as in its own example
for these files; observations of planes have theirs written out. The wheel brings g2o's libraries
and headers along; besides it takes a C++ compiler and Eigen's headers (Debian: libeigen3-dev).
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.peers import endings, native
from benchmarks.peers.runner import LEFT, AbsentError, missing, request, show

SUITES = ("bundle", "plane")
LIBRARIES = ("solver_eigen", "core", "stuff")
ASKED = """
import importlib.metadata, importlib.util
found = importlib.util.find_spec("g2opy")
if found:
    print(found.origin)
    print(importlib.metadata.version("g2opy"))
"""


def program() -> Path:
    """Compile the program where that is not yet done."""
    site, _ = wheel()
    folder = next((f for f in (site / "lib64", site / "lib") if f.is_dir()), site)
    libraries = [folder / f"libg2o_{name}.a" for name in LIBRARIES]
    if not all(path.exists() for path in [site / "include" / "g2o", *libraries]):
        raise AbsentError("this g2opy comes without g2o's headers and libraries")
    needs = {"Eigen/": "Eigen's headers (Debian: libeigen3-dev)"}
    flags = [f"-I{site / 'include'}", "-DNDEBUG"]
    return native.compiled("g2o", flags, [str(path) for path in libraries], needs)


def wheel() -> tuple[Path, str]:
    """The packages of the interpreter that has the peers' wheels, and its version of g2opy."""
    python = os.environ.get("ARAEL_BENCH_PEER_PYTHON", sys.executable)
    done = subprocess.run([python, "-c", ASKED], capture_output=True, text=True)
    said = done.stdout.split("\n")
    if len(said) < 2:
        raise AbsentError(missing("g2opy"))
    return Path(said[0]).parents[1], said[1]


def ways() -> dict[str, str]:
    """Ways to the end, with the settings of each."""
    kinds = {"LM": "Levenberg", "GN": "GaussNewton", "dogleg": "Dogleg"}
    ending = "SparseOptimizerTerminateAction"
    return {name: f"OptimizationAlgorithm{kind}, {ending}" for name, kind in kinds.items()}


def main() -> None:
    """Do what the command line asks for."""
    to_the_end = sys.argv[1] == endings.WORD
    try:
        if sys.argv[2 if to_the_end else 1] not in SUITES:
            raise AbsentError(f"{LEFT}g2opy")
        version = f"g2o {wheel()[1]} (C++)"
        if to_the_end:
            native.run_to_the_end(program(), ways(), version)
        else:
            native.run(program(), request(), version)
    except AbsentError as error:
        show({"absent": str(error)})


if __name__ == "__main__":
    main()
