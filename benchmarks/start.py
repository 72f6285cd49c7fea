"""What a user waits for: import, cold compile, warm solve as a whole process."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benchmarks.measure import environment, process, table

RUNS = 7


def run() -> list[str]:
    """Measure and return the report's lines."""
    python = sys.executable
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        cache, scene = Path(folder) / "cache", Path(folder) / "scene.npz"
        model = Path(folder) / "slam.arael"
        from arael.loading import standard_models

        # A copy with another text: what a user's own model of that size takes.
        model.write_text("# A copy.\n" + standard_models()["slam"].read_text())
        env = environment(ARAEL_CACHE_DIR=str(cache))
        process([python, "-c", _WRITE_SCENE.format(scene=str(scene))], env, 1)
        rows.append(("`import numpy`", process([python, "-c", "import numpy"], env, RUNS)))
        rows.append(
            ("`import numpy, arael`", process([python, "-c", "import numpy, arael"], env, RUNS))
        )
        load = f"import shutil, arael; shutil.rmtree({str(cache)!r}, ignore_errors=True)"
        cold = f"{load}; arael.load({str(model)!r})"
        rows.append(("cold compile of slam.arael", process([python, "-c", cold], env, 5)))
        solve = [python, "-m", "arael", "solve", str(model), str(scene), "--json"]
        rows.append(("warm `arael solve`, 60 poses", process(solve, env, RUNS)))
    return [
        "## start",
        "",
        "Whole processes, seconds, median (min-max). The cold compile has no cache: parsing, "
        "checking, derivation, Cython and the C compiler. The warm solve reads a generated "
        "60-pose scene (NPZ, half of the associations wrong) and runs three passes.",
        "",
        *table(("what", "seconds"), [(what, t.show(1.0, 2)) for what, t in rows]),
    ]


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
