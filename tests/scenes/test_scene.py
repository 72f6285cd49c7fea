"""The generator keeps to the definition of the reference problem."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from arael.geometry import euler_angles, rotation_matrix
from arael.scenes import SceneConfig, benchmark_config, demo_config, make_scene
from arael.scenes.cameras import camera_ring
from arael.scenes.evaluate import closest_pose
from arael.scenes.landmarks import visible_pairs
from arael.scenes.trajectory import SPACING, TRAJECTORIES, trajectory

FOCAL = 512 / np.tan(np.deg2rad(40))


def test_default_size() -> None:
    scene = make_scene()
    assert len(scene.pos) == 60
    assert len(scene.landmarks) == 240
    assert 5000 < len(scene.observations) < 5800
    assert 0.47 < scene.observations.wrong.mean() < 0.53


def test_benchmark_size() -> None:
    scene = make_scene(benchmark_config(300))
    assert len(scene.landmarks) == 1200
    assert 39_000 < len(scene.observations) < 43_000
    assert not scene.observations.wrong.any()


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_same_seed_same_scene(name: str) -> None:
    config = demo_config(trajectory=name, seed=7)  # type: ignore[arg-type]
    one, two = make_scene(config), make_scene(config)
    assert np.array_equal(one.start_landmarks, two.start_landmarks)
    assert np.array_equal(one.observations.pixel, two.observations.pixel)
    other = make_scene(demo_config(trajectory=name, seed=8))  # type: ignore[arg-type]
    assert not np.array_equal(one.landmarks, other.landmarks)


def test_wrong_share_leaves_the_rest_alone() -> None:
    one = make_scene(SceneConfig(wrong_fraction=0.5))
    two = make_scene(SceneConfig(wrong_fraction=0.0))
    assert np.array_equal(one.landmarks, two.landmarks)
    assert np.array_equal(one.sensors.gps, two.sensors.gps)
    assert np.array_equal(one.observations.pose, two.observations.pose)
    right = ~one.observations.wrong
    assert np.array_equal(one.observations.pixel[right], two.observations.pixel[right])


def test_s_curve_formula() -> None:
    pos, ea = trajectory("s-curve", 5)
    t = 0.25 * 4
    assert pos[4] == pytest.approx([t, 1.5 * np.sin(0.8 * t), 0])
    assert ea[4] == pytest.approx([0, 0, np.arctan2(1.2 * np.cos(0.8 * t), 1)])


@pytest.mark.parametrize("name", ["loop", "eight"])
def test_closed_paths_have_the_length_and_even_steps(name: str) -> None:
    pos, ea = trajectory(name, 200)  # type: ignore[arg-type]
    steps = np.roll(pos, -1, axis=0) - pos
    assert np.linalg.norm(steps, axis=1) == pytest.approx(np.full(200, SPACING), rel=2e-3)
    forward = np.column_stack([np.cos(ea[:, 2]), np.sin(ea[:, 2])])
    chord = pos - np.roll(pos, 1, axis=0) + steps
    chord /= np.linalg.norm(chord, axis=1, keepdims=True)
    assert np.sum(forward * chord[:, :2], axis=1).min() > 0.999


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_landmarks_keep_their_distance(name: str) -> None:
    scene = make_scene(demo_config(100, trajectory=name))  # type: ignore[arg-type]
    flat = cKDTree(scene.pos[:, :2]).query(scene.landmarks[:, :2])[0]
    assert flat.min() >= 5
    assert flat.max() <= 30
    assert scene.landmarks[:, 2].min() >= 0
    assert scene.landmarks[:, 2].max() <= 2


def test_no_landmark_is_left_unobserved_or_misnumbered() -> None:
    scene = make_scene(demo_config(3, landmarks=400))
    assert len(scene.landmarks) < 400
    counts = np.bincount(scene.observations.landmark, minlength=len(scene.landmarks))
    assert counts.min() >= 1


def test_range_counts_poses_on_the_s_curve_and_wraps_on_the_loop() -> None:
    curve = make_scene(demo_config(60))
    apart = np.abs(curve.observations.pose - curve.anchors[curve.observations.landmark])
    assert apart.max() == 15
    loop = make_scene(demo_config(60, trajectory="loop"))
    apart = np.abs(loop.observations.pose - loop.anchors[loop.observations.landmark])
    assert apart.max() > 40
    assert np.minimum(apart, 60 - apart).max() == 15


def test_eight_is_seen_across_its_crossing() -> None:
    scene = make_scene(demo_config(120, trajectory="eight"))
    seen = scene.observations
    apart = np.linalg.norm(scene.pos[seen.pose] - scene.pos[scene.anchors[seen.landmark]], axis=1)
    assert apart.max() <= 30 * SPACING
    assert np.abs(seen.pose - scene.anchors[seen.landmark]).max() > 50


@pytest.mark.parametrize("count", [2, 7, 8, 30, 31, 32])
def test_a_short_loop_meets_no_pose_twice(count: int) -> None:
    config = demo_config(count, trajectory="loop")
    pos, _ = trajectory("loop", count)
    anchors = np.arange(count)
    landmark, pose = visible_pairs(config, pos, anchors, np.full(count, 15))
    pairs = np.column_stack([landmark, pose])
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    assert len(pairs) == count * min(count, 31)


def test_some_landmarks_are_seen_widely() -> None:
    scene = make_scene(benchmark_config(300))
    apart = np.abs(scene.observations.pose - scene.anchors[scene.observations.landmark])
    farthest = np.zeros(len(scene.landmarks), dtype=int)
    np.maximum.at(farthest, scene.observations.landmark, apart)
    assert 0.10 < np.mean(farthest > 15) < 0.20
    assert farthest.max() <= 75


def test_pixels_are_where_the_truth_projects_plus_noise() -> None:
    scene = make_scene()
    seen = scene.observations
    rotation = rotation_matrix(scene.ea)[seen.pose]
    body = np.einsum("kji,kj->ki", rotation, scene.landmarks[seen.landmark] - scene.pos[seen.pose])
    for k, camera in enumerate(camera_ring()):
        mine = seen.camera == k
        pixel, inside = camera.project(body[mine])
        off = np.abs(seen.pixel[mine] - pixel)
        assert inside.all()
        assert off[~seen.wrong[mine]].max() <= 1
        assert 25 < off[seen.wrong[mine]].max() <= 30


def test_neighbouring_cameras_overlap() -> None:
    seen = make_scene().observations
    pairs = np.unique(seen.landmark * 1000 + seen.pose)
    assert 1.08 < len(seen) / len(pairs) < 1.14  # 5 x 80 degrees around 360


def test_feature_frames_are_rotations_along_the_ray() -> None:
    camera = camera_ring()[1]
    point = camera.pos + camera.axes @ np.array([0.3, -0.2, 2.0])
    pixel, inside = camera.project(point[None])
    frame = camera.feature_frames(pixel)[0]
    assert inside.all()
    assert frame.T @ frame == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)
    ray = point - camera.pos
    assert frame[:, 0] == pytest.approx(ray / np.linalg.norm(ray))
    assert frame[2, 2] > 0  # column 2 is up


def test_cameras_see_nothing_behind_or_too_near() -> None:
    camera = camera_ring()[0]
    points = camera.pos + np.array([[1.0, 0, 0], [-1, 0, 0], [0.4, 0, 0], [1.0, 2.0, 0]])
    assert camera.project(points)[1].tolist() == [True, False, False, False]
    edge = camera.pos + np.array([[1.0, 511.9 / FOCAL, 0], [1.0, 512.1 / FOCAL, 0]])
    assert camera.project(edge)[1].tolist() == [True, False]


def test_odometry_follows_the_truth_within_its_sigma() -> None:
    scene = make_scene(demo_config(2000, landmarks=10))
    rotation = rotation_matrix(scene.ea)
    moved = np.einsum("kji,kj->ki", rotation[:-1], np.diff(scene.pos, axis=0))
    off = (scene.sensors.delta_pos[1:] - moved) / scene.sensors.delta_pos_sigma[1:]
    assert off.std(axis=0) == pytest.approx([1, 1, 1], abs=0.07)
    along = 0.10 * np.linalg.norm(moved, axis=1) + 0.03
    expected = along[:, None] * [1, 0.5, 0.5]
    assert scene.sensors.delta_pos_sigma[1:] == pytest.approx(expected)
    exact = make_scene(benchmark_config(50)).sensors.delta_pos
    assert exact[1:] == pytest.approx(moved[:49], abs=1e-12)


def test_start_is_off_by_what_was_asked() -> None:
    scene = make_scene(demo_config(500))
    assert np.std(scene.start_pos - scene.pos) == pytest.approx(0.1, rel=0.1)
    assert np.std(scene.start_ea - scene.ea) == pytest.approx(0.02, rel=0.1)
    off = np.std(scene.start_landmarks - scene.landmarks, axis=0)
    assert off == pytest.approx([0.5, 0.5, 0.3], rel=0.1)


def test_rotation_round_trip() -> None:
    ea = np.random.default_rng(1).uniform(-1.5, 1.5, size=(50, 3))
    assert euler_angles(rotation_matrix(ea)) == pytest.approx(ea)


def test_closest_pose() -> None:
    index, distance = closest_pose(np.array([[0.0, 3.0, 4.0]]), np.array([[9.0, 0, 0], [0, 0, 0]]))
    assert (index[0], distance[0]) == (1, 5.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"poses": 1}, "poses: expected at least 2, found 1"),
        ({"landmarks": 0}, "landmarks: expected at least 1, found 0"),
        ({"trajectory": "eigth"}, "trajectory: expected one of s-curve, loop, eight"),
        ({"wrong_fraction": 1.5}, "wrong_fraction: expected 0 to 1"),
        ({"seed": -1}, "seed: expected 0 or more"),
    ],
)
def test_impossible_options_are_named(options: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SceneConfig(**options)  # type: ignore[arg-type]


def test_angular_size_of_pixels() -> None:
    """Against the angle by which the ray moves in its frame when the pixel does."""
    pixel = np.random.default_rng(3).uniform((0, 0), (1024, 768), (20, 2))
    camera, step = camera_ring()[1], 1e-4
    frames = camera.feature_frames(pixel)
    for axis, shift in ((1, [step, 0]), (2, [0, step])):
        moved = camera.feature_frames(pixel + np.array(shift))[:, :, 0]
        local = np.einsum("kji,kj->ki", frames, moved)
        angle = np.abs(np.arctan2(local[:, axis], local[:, 0])) / step
        assert camera.pixel_angles(pixel)[:, axis - 1] == pytest.approx(angle, rel=1e-4)
    assert camera.pixel_angles(np.array([[512.0, 384.0]])) == pytest.approx(1 / FOCAL)
