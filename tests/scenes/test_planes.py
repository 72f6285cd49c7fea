"""The plane scene keeps to its definition, and the model `plane_slam` solves it."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.geometry import rotation_matrix
from arael.scenes import PlaneConfig, fill, make_plane_scene
from arael.scenes.evaluate import motions, rms_distance
from arael.scenes.planes import CEILING, FLOOR, FRONT, tilted


def test_measurements_differ_from_the_truth_by_their_noise() -> None:
    scene = make_plane_scene(PlaneConfig(poses=200))
    rotation = rotation_matrix(scene.ea)[scene.seen_pose]
    normal = np.einsum("kji,kj->ki", rotation, scene.normals[scene.seen_plane])
    angle = np.arccos(np.clip(np.sum(normal * scene.seen_normal, axis=1), -1, 1))
    # Two components of the sigma make a Rayleigh distribution.
    assert np.sqrt(np.mean(angle**2) / 2) == pytest.approx(scene.config.normal_sigma, rel=0.05)
    place = scene.pos[scene.seen_pose]
    distance = np.sum(scene.normals[scene.seen_plane] * place, axis=1)
    distance += scene.offsets[scene.seen_plane]
    assert distance.min() > FRONT
    assert (scene.seen_distance - distance).std() == pytest.approx(0.02, rel=0.05)
    moved, turned = motions(scene.pos, rotation_matrix(scene.ea))
    assert (scene.delta_pos - moved).std() == pytest.approx(0.05, rel=0.1)
    assert (scene.delta_ea - turned).std() == pytest.approx(np.deg2rad(0.5), rel=0.1)


def test_planes_are_walls_floors_and_ceilings_and_all_seen() -> None:
    scene = make_plane_scene(PlaneConfig(poses=300))
    up = np.abs(scene.normals[:, 2])
    level = up > 0.9
    assert np.linalg.norm(scene.normals, axis=1) == pytest.approx(1)
    assert up[~level].max() < np.sin(np.deg2rad(12))
    assert level.mean() == pytest.approx(0.2, abs=0.03)
    assert np.array_equal(np.unique(scene.seen_plane), np.arange(len(scene.normals)))
    assert {FLOOR, CEILING} == {1.0, 1.5}


def test_same_seed_same_scene() -> None:
    one, two = (make_plane_scene(PlaneConfig(poses=40, seed=5)) for _ in range(2))
    other = make_plane_scene(PlaneConfig(poses=40, seed=6))
    assert np.array_equal(one.seen_normal, two.seen_normal)
    assert one.seen_normal.shape != other.seen_normal.shape or not np.array_equal(
        one.seen_normal, other.seen_normal
    )


def test_tilted_vectors_are_unit() -> None:
    vectors = tilted(np.eye(3), 0.3, np.random.default_rng(0))
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(1)


@pytest.mark.parametrize("trajectory", ["s-curve", "loop", "eight"])
def test_solved_maps_are_better_than_odometry(trajectory: str) -> None:
    scene = make_plane_scene(PlaneConfig(poses=120, trajectory=trajectory))  # type: ignore[arg-type]
    model = arael.load("plane_slam")
    plane_map = model()
    fill(plane_map, model.layout, scene.columns)
    result = plane_map.solve()
    assert result.status == "converged"
    # Poses composed along the measured motions.
    pos, rotation = [scene.pos[0]], rotation_matrix(scene.ea[:1])[0]
    for step, turn in zip(scene.delta_pos, rotation_matrix(scene.delta_ea), strict=True):
        pos.append(pos[-1] + rotation @ step)
        rotation = rotation @ turn
    found = np.asarray(plane_map.poses.pos.value)
    assert rms_distance(found, scene.pos) < 0.5 * rms_distance(np.array(pos), scene.pos)
    # Two tangent components and a distance an observation, six an odometry; less the unknowns.
    measured = 3 * len(scene.seen_pose) + 6 * len(scene.delta_pos)
    freedom = measured - 6 * (len(scene.pos) - 1) - 3 * len(scene.normals)
    assert result.end_cost == pytest.approx(freedom, rel=0.08)


def test_wrong_sizes() -> None:
    with pytest.raises(ValueError, match="poses: expected at least 2"):
        PlaneConfig(poses=1)
    with pytest.raises(ValueError, match="planes: expected at least 1"):
        PlaneConfig(planes=0)
