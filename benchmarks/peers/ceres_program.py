"""Ceres from the system, by the C++ program under `ceres`: planar pose graphs, bundles, planes.

pyceres has no compiled cost functions for these (its reprojection errors vanish behind a camera,
where points of public bundles start). Residuals are those of the models, with Ceres's automatic
derivatives. Needs a C++ compiler and Ceres's headers (Debian: libceres-dev).
"""

from __future__ import annotations

from pathlib import Path

from benchmarks import problems
from benchmarks.peers import native
from benchmarks.peers.runner import LEFT, AbsentError, request, show


def program() -> Path:
    """Compile the program where that is not yet done."""
    needs = {"ceres/": "Ceres's headers (Debian: libceres-dev)"}
    return native.compiled("ceres", [], ["-lceres", "-lglog"], needs)


def absence(suite: str, path: str) -> str | None:
    """Why there is no such problem here, if so."""
    spatial = suite == "pose_graph" and problems.pose_graph_model(path) == "pose_graph_3d"
    if suite not in ("pose_graph", "bundle", "plane") or spatial:
        return f"{LEFT}pyceres"
    return None


if __name__ == "__main__":
    asked = request()
    reason = absence(asked.suite, asked.problem)
    try:
        if reason:
            raise AbsentError(reason)
        native.run(program(), asked)
    except AbsentError as error:
        show({"absent": str(error)})
