"""Detections of the cameras of the synthetic scenes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from arael.scenes.cameras import camera_ring
from arael.scenes.config import SceneConfig

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SEEN = 0.75
"""Probability that a landmark within range of a pose is detected from it."""


@dataclass(frozen=True)
class Observations:
    """Detections, sorted by landmark, pose and camera; k of them.

    Attributes
    ----------
    landmark, pose, camera : (k,) indices
    pixel : (k, 2) position in the image [px], noise included
    mf2r : (k, 3, 3) feature frame to body, column 0 along the ray
    camera_pos : (k, 3) camera in the body frame [m]
    isigma : (k, 2) 1 / angular size of the pixel, across and up in its frame [1/rad]
    wrong : (k,) whether the association is wrong
    """

    landmark: Index
    pose: Index
    camera: Index
    pixel: Array
    mf2r: Array
    camera_pos: Array
    isigma: Array
    wrong: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.landmark)


def observe(
    config: SceneConfig,
    pos: Array,
    rotation: Array,
    landmarks: Array,
    pairs: tuple[Index, Index],
    rng: Generator,
) -> Observations:
    """Detect `landmarks` (m, 3) from poses at `pos` (n, 3), `rotation` (n, 3, 3).

    Parameters
    ----------
    pairs : landmark and pose of every pair in range of each other
    """
    seen = rng.random(len(pairs[0])) < SEEN
    landmark, pose = pairs[0][seen], pairs[1][seen]
    body = np.einsum("kji,kj->ki", rotation[pose], landmarks[landmark] - pos[pose])

    cameras = camera_ring()
    pixels, inside = zip(*(camera.project(body) for camera in cameras), strict=True)
    pair, camera = np.nonzero(np.column_stack(inside))
    pixel = np.stack(pixels, axis=1)[pair, camera]

    count = len(pair)
    wrong = rng.random(count) < config.wrong_fraction
    noise = rng.uniform(-config.pixel_noise, config.pixel_noise, size=(count, 2))
    pixel = pixel + noise * np.where(wrong, config.wrong_scale, 1.0)[:, None]

    frames = np.empty((count, 3, 3))
    for k, one in enumerate(cameras):
        frames[camera == k] = one.feature_frames(pixel[camera == k])
    return Observations(
        landmark=landmark[pair],
        pose=pose[pair],
        camera=camera,
        pixel=pixel,
        mf2r=frames,
        camera_pos=np.stack([one.pos for one in cameras])[camera],
        isigma=1 / cameras[0].pixel_angles(pixel),
        wrong=wrong,
    )
