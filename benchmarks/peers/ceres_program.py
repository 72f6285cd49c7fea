"""Ceres from the system, by the C++ program under `ceres`: planar pose graphs, bundles, planes.

To the end (`benchmarks.peers.endings`) spatial pose graphs too, with default tolerances.
pyceres has no compiled cost functions for these (its reprojection errors vanish behind a camera,
where points of public bundles start). Residuals are those of the models, with Ceres's automatic
derivatives. Needs a C++ compiler and Ceres's headers (Debian: libceres-dev).
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks import problems
from benchmarks.peers import endings, native
from benchmarks.peers.runner import LEFT, AbsentError, request, show


def program() -> Path:
    """Compile the program where that is not yet done."""
    needs = {"ceres/": "Ceres's headers (Debian: libceres-dev)"}
    return native.compiled("ceres", [], ["-lceres", "-lglog"], needs)


def absence(suite: str, path: str, to_the_end: bool = False) -> str | None:
    """Why there is no such problem here, if so."""
    spatial = (
        suite == "pose_graph"
        and not to_the_end
        and problems.pose_graph_model(path) == "pose_graph_3d"
    )
    if suite not in ("pose_graph", "bundle", "plane") or spatial:
        return f"{LEFT}pyceres"
    return None


def ways() -> dict[str, str]:
    """Ways to the end, with the settings of each."""
    return {
        "LM": "defaults",
        "LM, non-monotone": "use_nonmonotonic_steps",
        "dogleg": "DOGLEG, TRADITIONAL_DOGLEG",
        "dogleg, non-monotone": "DOGLEG, use_nonmonotonic_steps",
        "dogleg, subspace": "DOGLEG, SUBSPACE_DOGLEG",
    }


def main() -> None:
    """Do what the command line asks for."""
    to_the_end = sys.argv[1] == endings.WORD
    suite, problem = sys.argv[2:4] if to_the_end else sys.argv[1:3]
    reason = absence(suite, problem, to_the_end)
    try:
        if reason:
            raise AbsentError(reason)
        if to_the_end:
            native.run_to_the_end(program(), ways())
        else:
            native.run(program(), request())
    except AbsentError as error:
        show({"absent": str(error)})


if __name__ == "__main__":
    main()
