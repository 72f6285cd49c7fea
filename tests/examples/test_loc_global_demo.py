"""The example loc_global_demo against SciPy on residuals written by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from arael.scenes import demo_config, make_scene
from tests.check.models import diagnostics
from tests.examples.by_scipy import refined_cost
from tests.examples.scripts import printed, script
from tests.scenes import slam_residuals as by_hand

DEMO = script("loc_global_demo")


@pytest.fixture(scope="module")
def found() -> Any:
    return DEMO.run(6)


def moved(x: np.ndarray, pos: np.ndarray, ea: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poses after a rigid transform: translation and rotation vector."""
    turn = Rotation.from_rotvec(x[3:])
    world = turn * Rotation.from_euler("ZYX", ea[:, ::-1])
    return turn.apply(pos) + x[:3], world.as_euler("ZYX")[:, ::-1]


@pytest.mark.slow
def test_the_transform_alone_is_at_its_optimum(found: Any) -> None:
    data = DEMO.displaced(found.scene)

    def residuals(x: np.ndarray) -> np.ndarray:
        pos, ea = moved(x, data["poses.pos"], data["poses.ea"])
        parts = (
            by_hand.bearing(data, pos, ea, found.scene.landmarks),
            by_hand.tilt(data, ea),
            by_hand.odometry(data, pos, ea),
        )
        return np.concatenate([part.ravel() for part in parts])

    start = np.concatenate([found.shift, Rotation.from_matrix(found.turn).as_rotvec()])
    best = least_squares(residuals, start, xtol=1e-13, ftol=1e-15, gtol=1e-13)
    assert found.centre.cost == pytest.approx(2 * best.cost, rel=1e-6)
    np.testing.assert_allclose(start, best.x, atol=1e-4)
    np.testing.assert_allclose(found.centred, moved(best.x, found.start, found.start)[0], atol=1e-3)


def test_everything_is_at_its_optimum(found: Any) -> None:
    data = DEMO.displaced(found.scene)
    best = refined_cost(data, found.path, found.scene.landmarks)
    assert best == pytest.approx(found.sweep.cost, rel=1e-5)
    assert found.rms(found.solved) < 0.5 * found.rms(found.centred)


def test_the_displacement_is_undone(found: Any) -> None:
    """As far as the poses' own errors at the start, 10 cm each, let a mean be known."""
    off, turned = found.left_over
    assert off < 0.2
    assert turned < 0.05


def test_the_optimum_is_that_of_a_solve_without_the_first_stage(found: Any) -> None:
    path = DEMO.new_path(found.scene)
    path.global_pos.optimize = path.global_ea.optimize = False
    assert path.solve().cost == pytest.approx(found.sweep.cost, rel=1e-6)


def test_poses_stay_while_they_are_frozen() -> None:
    path = DEMO.new_path(make_scene(demo_config(6)))
    before = np.array(path.poses.pos.value)
    path.poses.pos.optimize = path.poses.ea.optimize = False
    path.solve(passes="coarse")
    np.testing.assert_array_equal(path.poses.pos.value, before)
    assert len(path.parameter_names()) == 6
    by_schedule = DEMO.new_path(make_scene(demo_config(6)))
    by_schedule.solve(passes="coarse", freeze="poses")
    np.testing.assert_allclose(by_schedule.global_pos.value, path.global_pos.value)


def test_after_baking_nothing_has_changed_but_who_has_it(found: Any) -> None:
    path = DEMO.new_path(found.scene)
    path.global_pos.value = [1.0, 2.0, 3.0]
    path.global_ea.value = [0.1, -0.2, 0.3]
    before = path.cost()
    DEMO.bake_in(path)
    assert path.cost() == pytest.approx(before, rel=1e-10)
    assert not path.global_pos.value.any()
    assert not path.global_ea.value.any()
    assert found.path.poses.pos.optimize.all()


def test_both_wirings_carry_the_pairs_with_the_root(found: Any) -> None:
    """Named blocks and triplets equal central differences."""
    path = found.path
    names = path.parameter_names()
    root = [names.index(f"{p}.{a}") for p in ("global_pos", "global_ea") for a in "xyz"]
    pose = [names.index(f"poses[2].{p}.{a}") for p in ("pos", "ea") for a in "xyz"]
    expected = pair_by_differences(found, 2)
    scale = np.abs(expected).max()
    triplets = path.hbt.toarray()
    both = triplets + triplets.T
    np.testing.assert_allclose(both[np.ix_(pose, root)], expected, atol=1e-6 * scale)
    which = np.flatnonzero(path.landmarks.frines.pose.rows == 2)[0]
    np.testing.assert_allclose(path.landmarks.frines.hb_root[which], expected, atol=1e-6 * scale)


def pair_by_differences(found: Any, k: int) -> np.ndarray:
    """2 J'J of pose `k` (rows) and the root (columns), with both at the solution."""
    data = DEMO.displaced(found.scene)
    solved, angles = np.array(found.path.poses.pos.value), np.array(found.path.poses.ea.value)

    def residuals(x: np.ndarray) -> np.ndarray:
        pos, ea = solved.copy(), angles.copy()
        pos[k], ea[k] = pos[k] + x[:3], ea[k] + x[3:6]
        turn = Rotation.from_euler("ZYX", x[:8:-1])
        world = turn * Rotation.from_euler("ZYX", ea[:, ::-1])
        pos, ea = turn.apply(pos) + x[6:9], world.as_euler("ZYX")[:, ::-1]
        bearing = by_hand.bearing(data, pos, ea, found.scene.landmarks)
        return np.concatenate([bearing.ravel(), by_hand.tilt(data, ea).ravel()])

    step = 1e-6
    columns = [(residuals(d) - residuals(-d)) / (2 * step) for d in step * np.eye(12)]
    j = np.array(columns).T
    return 2 * j[:, :6].T @ j[:, 6:]


def test_what_it_prints(monkeypatch, capsys, found: Any) -> None:
    text = printed("loc_global_demo", ["--poses", "6"], monkeypatch, capsys)
    rms = np.sqrt(np.mean(np.sum((found.solved - found.scene.pos) ** 2, axis=1)))
    assert f"everything          RMS {rms:8.4f} m" in text
    assert "pairs in the root's triplets: 6" in text


def test_a_root_without_triplets_is_told() -> None:
    text = DEMO.MODEL.read_text(encoding="utf-8").replace("[hb_pose, root.hbt]", "hb_pose")
    (found,) = diagnostics(text)
    assert found.code == "E0431"
