"""The synthetic visual-inertial scene: truth, measurements, and initial values.

Every random part has its own stream, so that for instance the share of wrong associations does not
affect the landmarks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

from arael.geometry import rotation_matrix
from arael.scenes.config import SceneConfig
from arael.scenes.landmarks import place_landmarks, visibility_ranges, visible_pairs
from arael.scenes.observations import Observations, observe
from arael.scenes.sensors import Sensors, measure
from arael.scenes.trajectory import trajectory

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Scene:
    """A scene of n poses and m landmarks, all of them observed.

    Attributes
    ----------
    config : its options
    pos, ea : (n, 3) true positions [m] and roll, pitch, yaw [rad]
    landmarks : (m, 3) true landmark positions [m]
    anchors : (m,) the pose around which each landmark was placed
    sensors, observations : measurements
    start_pos, start_ea, start_landmarks : initial values
    """

    config: SceneConfig
    pos: Array
    ea: Array
    landmarks: Array
    anchors: Index
    sensors: Sensors
    observations: Observations
    start_pos: Array
    start_ea: Array
    start_landmarks: Array

    def __repr__(self) -> str:
        return (
            f"Scene({self.config.trajectory}, {len(self.pos)} poses, "
            f"{len(self.landmarks)} landmarks, {len(self.observations)} observations, "
            f"{self.observations.wrong.sum()} of them wrong, seed {self.config.seed})"
        )


def make_scene(config: SceneConfig | None = None) -> Scene:
    """Generate the scene of `config`; by default that of the demo.

    Ten thousand poses with forty thousand landmarks take seconds, since everything is vectorised.
    """
    config = config or SceneConfig()
    placing, seeing, measuring, starting = Generator(PCG64(config.seed)).spawn(4)

    pos, ea = trajectory(config.trajectory, config.poses)
    rotation = rotation_matrix(ea)
    landmarks, anchors = place_landmarks(pos, config.landmark_count, placing)
    reach = visibility_ranges(config, len(landmarks), placing)
    pairs = visible_pairs(config, pos, anchors, reach)
    seen = observe(config, pos, rotation, landmarks, pairs, seeing)
    landmarks, anchors, seen = _drop_unobserved(landmarks, anchors, seen)
    return Scene(
        config=config,
        pos=pos,
        ea=ea,
        landmarks=landmarks,
        anchors=anchors,
        sensors=measure(config, pos, ea, rotation, measuring),
        observations=seen,
        start_pos=pos + starting.normal(0.0, config.start_pos, size=pos.shape),
        start_ea=ea + starting.normal(0.0, config.start_ea, size=ea.shape),
        start_landmarks=landmarks
        + starting.standard_normal(landmarks.shape) * config.start_landmark,
    )


def _drop_unobserved(
    landmarks: Array, anchors: Index, seen: Observations
) -> tuple[Array, Index, Observations]:
    observed = np.zeros(len(landmarks), dtype=bool)
    observed[seen.landmark] = True
    renumbered = np.cumsum(observed) - 1
    kept = Observations(**{**vars(seen), "landmark": renumbered[seen.landmark]})
    return landmarks[observed], anchors[observed], kept
