"""Ceres from the system, by the C++ program under `ceres`: planar pose graphs, bundles, planes.

pyceres has no compiled cost functions for these (its reprojection errors vanish behind a camera,
where points of public bundles start). Residuals are those of the models, with Ceres's automatic
derivatives. Needs a C++ compiler and Ceres's headers (Debian: libceres-dev).
"""

from __future__ import annotations

import shutil
from pathlib import Path

from benchmarks import problems
from benchmarks.peers import native
from benchmarks.peers.runner import AbsentError, request, show

SOURCES = native.HERE / "ceres"


def program() -> Path:
    """Compile the program where that is not yet done."""
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        raise AbsentError("no C++ compiler")
    built = native.BUILD / "ceres"
    newest = max(source.stat().st_mtime for source in SOURCES.iterdir())
    if not built.exists() or built.stat().st_mtime < newest:
        # The library was built without AVX: its alignment of Eigen's types holds for all.
        flags = "-O3 -march=native -DEIGEN_MAX_ALIGN_BYTES=16 -std=c++17 -I/usr/include/eigen3"
        command = [compiler, *flags.split(), str(SOURCES / "peer.cc"), "-o", str(built)]
        native.build([*command, "-lceres", "-lglog"], native.BUILD / "ceres.log")
    return built


def absence(suite: str, path: str) -> str | None:
    """Why there is no such problem here, if so."""
    spatial = suite == "pose_graph" and problems.pose_graph_model(path) == "pose_graph_3d"
    if suite not in ("pose_graph", "bundle", "plane") or spatial:
        return "left to pyceres"
    return None


if __name__ == "__main__":
    asked = request()
    reason = absence(asked.suite, asked.problem)
    try:
        if reason:
            raise AbsentError(reason)
        native.run(program(), asked, "Ceres of the system", "")
    except AbsentError as error:
        show({"absent": str(error)})
