"""What a user waits for: import, cold compile, warm solve as a whole process, installation."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.measure import Timing, environment, process, table
from benchmarks.systems import Plan

RUNS, IMPORTS = 7, 21


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure and return the report's lines."""
    runs = 3 if plan.quick else RUNS
    python = sys.executable
    rows: list[tuple[str, Timing]] = []
    with tempfile.TemporaryDirectory() as folder:
        cache, scene = Path(folder) / "cache", Path(folder) / "scene.npz"
        model = Path(folder) / "slam.arael"
        from arael.loading import standard_models

        # A copy with another text: what a user's own model of that size takes.
        model.write_text("# A copy.\n" + standard_models()["slam"].read_text())
        env = environment(ARAEL_CACHE_DIR=str(cache))
        process([python, "-c", _WRITE_SCENE.format(scene=str(scene))], env, 1)
        rows += _imports(python, env, 3 if plan.quick else IMPORTS)
        load = f"import shutil, arael; shutil.rmtree({str(cache)!r}, ignore_errors=True)"
        cold = f"{load}; arael.load({str(model)!r})"
        rows.append(
            (
                "cold compile of slam.arael",
                process([python, "-c", cold], env, 2 if plan.quick else 5),
            )
        )
        solve = [python, "-m", "arael", "solve", str(model), str(scene), "--json"]
        rows.append(("warm `arael solve`, 60 poses", process(solve, env, runs)))
        if not plan.quick:
            rows.append(("`pip install .` (one run)", _install(Path(folder))))
    return [
        "## cold",
        "",
        "Whole processes, seconds, median (min-max). The cold compile has no cache: parsing, "
        "checking, derivation, Cython and the C compiler. The warm solve reads a generated "
        "60-pose scene (NPZ, half of the associations wrong) and runs three passes. The "
        "installation compiles the package and its models from the sources, with the requirements "
        "there.",
        "",
        *table(("what", "seconds"), [(what, t.show(1.0, 3)) for what, t in rows]),
    ]


def _imports(python: str, env: dict[str, str], runs: int) -> list[tuple[str, Timing]]:
    """NumPy alone and with arael, by turns: what differs is less than a slow minute costs."""
    found: dict[str, list[float]] = {"import numpy": [], "import numpy, arael": []}
    for _ in range(runs):
        for code, times in found.items():
            times += process([python, "-c", code], env, 1).runs
    alone, both = found.values()
    beyond = tuple(b - a for a, b in zip(alone, both, strict=True))
    return [
        *((f"`{code}`", Timing(tuple(times))) for code, times in found.items()),
        ("`import arael` beyond NumPy, pair by pair", Timing(beyond)),
    ]


def _install(folder: Path) -> Timing:
    """Install a copy of the sources into an empty folder, once."""
    sources = folder / "sources"
    root = Path(__file__).parents[1]
    kept = shutil.ignore_patterns(
        "*.so", "*.c", "*.cpp", "build", "target", ".*", "__pycache__", "*.egg-info"
    )
    shutil.copytree(root, sources, ignore=kept)
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"]
    command += ["--no-build-isolation", "--target", str(folder / "installed"), str(sources)]
    began = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return Timing((time.perf_counter() - began,))


_WRITE_SCENE = """
import arael
from arael.scenes.columns import columns
from arael.scenes.config import demo_config
from arael.scenes.fill import fill
from arael.scenes.scene import make_scene
model_class = arael.load("slam")
model = model_class()
fill(model, model_class.layout, columns(make_scene(demo_config())))
arael.write(model, {scene!r})
"""
