"""Synthetic scenes with known truth: the generator behind the demos, tests and benchmarks."""

from __future__ import annotations

from arael.scenes.columns import columns
from arael.scenes.config import SceneConfig, benchmark_config, demo_config
from arael.scenes.fill import fill
from arael.scenes.observations import Observations
from arael.scenes.planes import PlaneConfig, PlaneScene, make_plane_scene
from arael.scenes.scene import Scene, make_scene
from arael.scenes.sensors import Sensors
from arael.scenes.trajectory import TRAJECTORIES, TrajectoryName, trajectory

__all__ = [
    "TRAJECTORIES",
    "Observations",
    "PlaneConfig",
    "PlaneScene",
    "Scene",
    "SceneConfig",
    "Sensors",
    "TrajectoryName",
    "benchmark_config",
    "columns",
    "demo_config",
    "fill",
    "make_plane_scene",
    "make_scene",
    "trajectory",
]
