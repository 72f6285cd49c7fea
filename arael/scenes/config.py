"""Options of a synthetic scene."""

from __future__ import annotations

from dataclasses import dataclass

from arael.scenes.trajectory import TRAJECTORIES, TrajectoryName


@dataclass(frozen=True)
class SceneConfig:
    """Options of `make_scene`.

    Attributes
    ----------
    poses : number of poses, at least 2
    landmarks : number of landmarks generated (unobserved ones are dropped); None: four per pose
    trajectory : shape of the path
    seed : seed of NumPy's PCG64; scenes are reproducible
    wrong_fraction : share of detections associated with a wrong landmark
    wrong_scale : factor of the pixel error of such a detection
    pixel_noise : pixel error of the other detections, uniform in plus and minus this [px]
    odometry_noise : add noise to the odometry; else it is exact
    start_pos : standard deviation per axis of the poses' initial positions [m]
    start_ea : the same of their roll, pitch and yaw [rad]
    start_landmark : the same of the landmarks' x, y and z [m]
    """

    poses: int = 60
    landmarks: int | None = None
    trajectory: TrajectoryName = "s-curve"
    seed: int = 42
    wrong_fraction: float = 0.5
    wrong_scale: float = 30.0
    pixel_noise: float = 1.0
    odometry_noise: bool = True
    start_pos: float = 0.1
    start_ea: float = 0.02
    start_landmark: tuple[float, float, float] = (0.5, 0.5, 0.3)

    def __post_init__(self) -> None:
        if self.poses < 2:
            raise ValueError(f"poses: expected at least 2, found {self.poses}")
        if self.landmarks is not None and self.landmarks < 1:
            raise ValueError(f"landmarks: expected at least 1, found {self.landmarks}")
        if self.trajectory not in TRAJECTORIES:
            known = ", ".join(TRAJECTORIES)
            raise ValueError(f"trajectory: expected one of {known}, found {self.trajectory!r}")
        if not 0 <= self.wrong_fraction <= 1:
            raise ValueError(f"wrong_fraction: expected 0 to 1, found {self.wrong_fraction}")
        if self.seed < 0:
            raise ValueError(f"seed: expected 0 or more, found {self.seed}")

    @property
    def landmark_count(self) -> int:
        """Number of landmarks to generate."""
        return 4 * self.poses if self.landmarks is None else self.landmarks


def demo_config(
    poses: int = 60,
    landmarks: int | None = None,
    trajectory: TrajectoryName = "s-curve",
    seed: int = 42,
) -> SceneConfig:
    """Return the options of the demos: half of the associations wrong, a rough start."""
    return SceneConfig(poses, landmarks, trajectory, seed)


def benchmark_config(
    poses: int = 60,
    landmarks: int | None = None,
    trajectory: TrajectoryName = "s-curve",
    seed: int = 42,
) -> SceneConfig:
    """Return the options of the benchmarks: none wrong, exact odometry, a start near the truth."""
    return SceneConfig(
        poses,
        landmarks,
        trajectory,
        seed,
        wrong_fraction=0.0,
        odometry_noise=False,
        start_pos=0.05,
        start_ea=0.01,
        start_landmark=(0.05, 0.05, 0.05),
    )
