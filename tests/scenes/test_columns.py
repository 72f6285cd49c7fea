"""Columns of a scene, checked against residuals written independently."""

from __future__ import annotations

import numpy as np
import pytest

from arael.scenes import Scene, SceneConfig, columns, demo_config, make_scene
from arael.scenes.evaluate import errors_against_truth, rigid, similarity
from tests.scenes import slam_residuals as slam


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene()


def test_residuals_at_truth_are_the_noise(scene: Scene) -> None:
    cols = columns(scene)
    bearing = slam.bearing(cols, scene.pos, scene.ea, scene.landmarks)
    right = bearing[~scene.observations.wrong]
    # A step along the image's rows also turns the ray up or down where both u and v are large.
    assert 1.0 < np.abs(right).max() <= slam.starship(np.array(1.5))
    assert right.std() == pytest.approx(1 / np.sqrt(3), rel=0.05)
    assert np.abs(bearing[scene.observations.wrong]).max() < 5
    assert slam.odometry(cols, scene.pos, scene.ea).std() == pytest.approx(1, rel=0.15)
    assert slam.tilt(cols, scene.ea).std() == pytest.approx(1, rel=0.25)


def test_gps_is_off_by_one_common_offset(scene: Scene) -> None:
    off = columns(scene)["poses.info.gps.pos"] - scene.pos
    assert np.linalg.norm(off[0]) > 0.1
    assert np.abs(off[:4] - off[0]).max() < 0.1


def test_exact_measurements_have_no_residuals() -> None:
    exact = make_scene(SceneConfig(pixel_noise=0.0, odometry_noise=False, trajectory="eight"))
    cols = columns(exact)
    assert np.abs(slam.bearing(cols, exact.pos, exact.ea, exact.landmarks)).max() < 1e-9
    assert np.abs(slam.odometry(cols, exact.pos, exact.ea)).max() < 1e-9


def test_lists_have_bounds_and_refs_stay_inside(scene: Scene) -> None:
    cols = columns(scene)
    count = len(scene.observations)
    features, frines = cols["poses.info.features.offsets"], cols["landmarks.frines.offsets"]
    assert (features[0], features[-1], len(features)) == (0, count, 61)
    assert (frines[0], frines[-1], len(frines)) == (0, count, 241)
    pose, feature = cols["landmarks.frines.pose"], cols["landmarks.frines.feature"]
    assert np.all(feature < np.diff(features)[pose])
    assert len(np.unique(features[pose] + feature)) == count


def test_localization_knows_the_map(scene: Scene) -> None:
    cols = columns(scene, "localization")
    assert np.array_equal(cols["landmarks.pos"], scene.landmarks)
    assert not any(key.startswith("poses.info.gps") for key in cols)


def test_alignment_recovers_a_similarity() -> None:
    rng = np.random.default_rng(5)
    source = rng.normal(size=(20, 3))
    rotation = slam.matrix(np.array([[0.3, -0.4, 2.0]]))[0]
    target = 1.7 * source @ rotation.T + [1, 2, 3]
    found = similarity(source, target)
    assert found.scale == pytest.approx(1.7)
    assert found.rotation == pytest.approx(rotation)
    assert found.apply(source) == pytest.approx(target)
    assert rigid(source, target).scale == 1.0


def test_alignment_never_mirrors() -> None:
    rng = np.random.default_rng(6)
    source = rng.normal(size=(20, 3))
    found = rigid(source, source * [1, 1, -1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_alignment_of_points_in_a_plane() -> None:
    source = make_scene(demo_config(30)).pos
    rotation = slam.matrix(np.array([[0.0, 0.0, 0.7]]))[0]
    found = similarity(source @ rotation.T, source)
    assert found.rotation == pytest.approx(rotation.T, abs=1e-9)


def test_errors_do_not_see_the_frame(scene: Scene) -> None:
    rotation = slam.matrix(np.array([[0.1, 0.2, 0.3]]))[0]
    moved, landmarks = scene.pos @ rotation.T + 5, scene.landmarks @ rotation.T + 5
    landmarks[7] += rotation @ [0.3, 0, 0.4]
    found = errors_against_truth(moved, landmarks, scene.pos, scene.landmarks)
    assert found.pose_rms < 1e-9
    assert found.landmark[7] == pytest.approx(0.5)
    assert found.relative[7] == pytest.approx(0.5 / found.distance[7])
    assert np.delete(found.landmark, 7).max() < 1e-9
    larger = errors_against_truth(1.01 * moved, 1.01 * landmarks, scene.pos, scene.landmarks)
    assert larger.scale == pytest.approx(1 / 1.01)
    assert larger.pose_rms < 1e-9
    assert larger.landmark.min() > 0.01
