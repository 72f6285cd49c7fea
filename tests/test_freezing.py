"""Parameters, parts and components that are held: by passes, by the model, from Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.runtime.layout import LayoutPass

MODEL = """
struct P { param x: real; param y: real; constraint c { [x - 1, y - 2] } }
root R { ps: list of P }
"""


@pytest.mark.parametrize(
    ("passes", "expected"),
    [
        ([LayoutPass("a", freeze=("ps",), free=("ps.x",))], [1, 0]),
        (
            [LayoutPass("a", freeze=("ps.x",)), LayoutPass("b", freeze=("ps",), free=("ps.x",))],
            [1, 2],
        ),
        ([LayoutPass("a", freeze=("ps.y",))], [1, 0]),
    ],
)
def test_parts(tmp_path: Path, passes: list[LayoutPass], expected: list[float]) -> None:
    path = tmp_path / "m.arael"
    path.write_text(MODEL)
    model = arael.load(path, interpret=True)(ps=[{"x": 0.0, "y": 0.0}])
    model.solve(passes=passes)
    assert [model.ps.x.value[0], model.ps.y.value[0]] == pytest.approx(expected, abs=1e-6)


HELD = """
struct Pose {
    param pos: vec3 = [0, 0, 0]
    param ea: euler = [0, 0, 0]
    param T: transform = [0, 0, 0, 1, 0, 0, 0]
    goal: vec3 = [1, 2, 3]
    FIXED
    constraint c {
        [pos - goal, ea - 0.1 * goal, T.translation - goal, T.rotation.log() - 0.1 * goal]
    }
}

root R {
    param v: vec<5> = [0, 0, 0, 0, 0]
    poses: list of Pose
    constraint d { v - [1, 2, 3, 4, 5] }
}
"""
ZERO = [0, 0, 0]
GOAL, TURN = np.array([1, 2, 3]), np.array([0.1, 0.2, 0.3])


def held(tmp_path: Path, fixed: str = "") -> arael.Model:
    path = tmp_path / "held.arael"
    path.write_text(HELD.replace("FIXED", fixed))
    model = arael.load(path, interpret=True)()
    model.poses.append()
    model.poses.append()
    return model


def at(model: arael.Model, row: int = 0) -> dict[str, list[float]]:
    """Values of a row: 0 where a component was held, its goal where it was solved for."""
    pose = model.poses[row]
    moved = np.round(pose.T.value, 6)
    return {
        "pos": np.round(pose.pos.value, 6).tolist(),
        "ea": np.round(pose.ea.value, 6).tolist(),
        "T": [*moved[:3].tolist(), bool(abs(moved[3]) < 1)],
    }


@pytest.mark.parametrize(
    ("freeze", "free", "expected"),
    [
        ("Pose.pos.z", (), {"pos": [1, 2, 0], "ea": TURN.tolist(), "T": [1, 2, 3, True]}),
        ("poses.ea.x", (), {"pos": [1, 2, 3], "ea": [0, 0.2, 0.3], "T": [1, 2, 3, True]}),
        ("poses", "poses.pos.y", {"pos": [0, 2, 0], "ea": ZERO, "T": [0, 0, 0, False]}),
        (
            "poses.T",
            "Pose.T.rotation",
            {"pos": [1, 2, 3], "ea": TURN.tolist(), "T": [0, 0, 0, True]},
        ),
        ("Pose.pos", "Pose", {"pos": [1, 2, 3], "ea": TURN.tolist(), "T": [1, 2, 3, True]}),
    ],
)  # fmt: skip
def test_passes_freeze_and_free_components(
    tmp_path: Path, freeze: str, free: str, expected: dict[str, list[float]]
) -> None:
    model = held(tmp_path)
    model.solve(passes=arael.Pass("one", freeze=freeze, free=free))
    assert at(model) == at(model, 1) == expected
    model.solve()
    assert at(model) == {"pos": [1, 2, 3], "ea": TURN.tolist(), "T": [1, 2, 3, True]}


def test_the_model_fixes_components(tmp_path: Path) -> None:
    model = held(tmp_path, "fixed pos.x, pos.z\n    fixed ea, T.rotation")
    result = model.solve()
    assert result.status == "converged"
    assert at(model) == {"pos": [0, 2, 0], "ea": ZERO, "T": [1, 2, 3, False]}
    names = model.parameter_names()
    assert [n for n in names if "[0].pos" in n or "[0].ea" in n] == ["poses[0].pos.y"]
    assert len(model.gradient()) == len(names) == 13


def test_the_model_fixes_components_in_kernels(tmp_path: Path) -> None:
    held(tmp_path, "fixed pos.x")
    model = arael.load(tmp_path / "held.arael")()
    model.poses.append()
    model.solve()
    assert np.round(model.poses[0].pos.value, 6).tolist() == [0, 2, 3]


def test_passes_of_the_model_freeze_components(tmp_path: Path) -> None:
    text = HELD.replace("FIXED", "").rstrip().rstrip("}")
    path = tmp_path / "held.arael"
    path.write_text(f"{text}    solve {{ pass a {{ freeze Pose.pos.z, poses.ea.x }} }}\n}}\n")
    model = arael.load(path, interpret=True)()
    model.poses.append()
    model.solve()
    assert at(model)["pos"] == [1, 2, 0] and at(model)["ea"] == [0, 0.2, 0.3]


def test_components_are_held_from_python(tmp_path: Path) -> None:
    model = held(tmp_path)
    model.v.optimize = [True, False, True, True, False]
    model.poses[0].pos.optimize = [True, True, False]
    assert model.v.optimize.tolist() == [True, False, True, True, False]
    assert model.poses[1].pos.optimize is True
    model.solve()
    assert np.round(model.v.value, 6).tolist() == [1, 0, 3, 4, 0]
    assert at(model)["pos"] == [1, 2, 0] and at(model, 1)["pos"] == [1, 2, 3]
    model.v.optimize = True
    model.solve()
    assert np.round(model.v.value, 6).tolist() == [1, 2, 3, 4, 5]
    assert model.v.optimize is True


def test_components_of_a_collection_are_held_in_rows_added_later_too(tmp_path: Path) -> None:
    model = held(tmp_path)
    model.poses.pos.optimize = [[False, True, True]]
    model.poses.extend(goal=[[1, 2, 3]] * 2)
    assert model.poses.pos.optimize.tolist() == [[False, True, True]] * 4
    model.solve()
    assert np.round(model.poses.pos.value, 6).tolist() == [[0, 2, 3]] * 4
    model.poses.pos.optimize = np.array([[True] * 3, [False, True, True]] * 2)
    model.solve()
    assert np.round(model.poses.pos.value[:, 0], 6).tolist() == [1, 0, 1, 0]
    model.poses.pos.optimize = [True, False, True, True]  # one for each row
    assert model.poses.pos.optimize.tolist() == [True, False, True, True]


@pytest.mark.parametrize("value", [["a", "b", "c"], [True, False], [[True] * 3], [1, 0, 1]])
def test_flags_of_components_are_checked(tmp_path: Path, value: object) -> None:
    model = held(tmp_path)
    with pytest.raises(AraelError, match="expected true or false for each"):
        model.poses[0].pos.optimize = value
    with pytest.raises(AraelError, match="expected true or false for each row"):
        model.poses[0].T.optimize = [True] * 6
