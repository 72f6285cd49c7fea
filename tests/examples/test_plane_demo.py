"""plane_demo against SciPy on residuals written by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from arael.scenes import PlaneConfig, make_plane_scene
from tests.examples.scripts import printed, script

DEG = np.pi / 180


def rotations(ea: np.ndarray) -> Rotation:
    """Body to world from roll, pitch, yaw."""
    return Rotation.from_euler("ZYX", ea[..., ::-1])


def by_hand(x: np.ndarray, scene) -> np.ndarray:
    """Residuals of positions, rotation vectors on top of the start, normals and offsets."""
    n, m = len(scene.pos), len(scene.normals)
    poses, planes = x[: 6 * n].reshape(n, 6), x[6 * n :].reshape(m, 4)
    pos = poses[:, :3]
    turned = rotations(scene.start_ea) * Rotation.from_rotvec(poses[:, 3:])
    normals = planes[:, :3] / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)

    normal, pose = normals[scene.seen_plane], scene.seen_pose
    seen = turned[pose].inv().apply(normal) - scene.seen_normal
    distance = np.sum(normal * pos[pose], axis=1) + planes[scene.seen_plane, 3]
    step = turned[:-1].inv().apply(np.diff(pos, axis=0)) - scene.delta_pos
    expect = turned[:-1] * rotations(scene.delta_ea)
    turn = (expect.inv() * turned[1:]).as_euler("ZYX")[:, ::-1]
    held = (rotations(scene.ea[:1]).inv() * turned[:1]).as_euler("ZYX")
    return np.concatenate([
        seen.ravel() / (0.5 * DEG),
        (distance - scene.seen_distance) / 0.02,
        step.ravel() / 0.05,
        turn.ravel() / (0.5 * DEG),
        (pos[0] - scene.pos[0]) / 0.001,
        held.ravel() / (0.01 * DEG),
    ])  # fmt: skip


@pytest.mark.slow
def test_the_optimum_is_that_of_scipy() -> None:
    module = script("plane_demo")
    scene = make_plane_scene(PlaneConfig(poses=12, seed=7))
    plane_map = module.problem(scene)
    poses = np.hstack([scene.start_pos, np.zeros((12, 3))])
    planes = np.hstack([scene.start_normals, scene.start_offsets[:, None]])
    x = np.concatenate([poses.ravel(), planes.ravel()])
    assert plane_map.cost() == pytest.approx(np.sum(by_hand(x, scene) ** 2), rel=1e-9)
    found = least_squares(by_hand, x, args=(scene,), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    result = plane_map.solve(rel_precision=1e-12)
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-7)


@pytest.mark.parametrize("line", [
    "120 poses, 60 planes, 1508 observations",
    "86807.5 -> 4203.7",
    "poses: RMS 0.134 m; odometry alone 1.503 m",
])  # fmt: skip
def test_report(line: str, monkeypatch, capsys) -> None:
    assert line in printed("plane_demo", [], monkeypatch, capsys)
