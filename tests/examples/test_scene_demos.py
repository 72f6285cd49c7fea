"""The figures of slam_demo and loc_demo against SciPy, and against the truth."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arael.demo.localization import run_localization
from arael.demo.scene_run import SolveOptions
from arael.demo.slam import run_slam
from arael.scenes import columns, demo_config
from tests.examples.by_scipy import refined_cost
from tests.examples.scripts import EXAMPLES, printed


def options(model: str) -> SolveOptions:
    return SolveOptions(model=str(EXAMPLES / model), precision="f64", verbose=False)


def test_localization_is_at_its_optimum() -> None:
    run = run_localization(demo_config(5), options("loc_demo/localization.arael"))
    data = columns(run.scene, "slam")
    assert refined_cost(data, run.instance, run.scene.landmarks) == pytest.approx(
        run.result.cost, rel=1e-5
    )


def test_slam_prints_its_error(monkeypatch, capsys) -> None:
    text = printed("slam_demo", ["--poses", "20"], monkeypatch, capsys)
    told = re.search(r"poses: RMS ([\d.]+) m after similarity alignment .*scale ([\d.]+)", text)
    assert told
    run = run_slam(demo_config(20), options("slam_demo/slam.arael"))
    # Similarity that takes the found positions nearest to the true ones (K. Arun 1987, S. Umeyama).
    found, true = (p - p.mean(axis=0) for p in (run.poses, run.scene.pos))
    turn, _ = Rotation.align_vectors(true, found)
    turned = turn.apply(found)
    scale = np.sum(turned * true) / np.sum(turned**2)
    rms = np.sqrt(np.mean(np.sum((scale * turned - true) ** 2, axis=1)))
    assert float(told[1]) == pytest.approx(rms, abs=2e-4)
    assert float(told[2]) == pytest.approx(scale, abs=2e-4)


def test_localization_prints_its_error(monkeypatch, capsys) -> None:
    text = printed("loc_demo", ["--poses", "20"], monkeypatch, capsys)
    told = re.search(r"poses: RMS ([\d.]+) m \(start ([\d.]+) m\)", text)
    assert told
    run = run_localization(demo_config(20), options("loc_demo/localization.arael"))
    off = np.linalg.norm(run.poses - run.scene.pos, axis=1)
    assert float(told[1]) == pytest.approx(np.sqrt(np.mean(off**2)), abs=2e-4)
    assert float(told[1]) < 0.2 * float(told[2])
