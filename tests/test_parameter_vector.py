"""The parameters as one vector: out, changed, and in again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Body {
    param pos: vec2
    param att: quaternion
    param T:   transform
    constraint near { [pos - [1, 2], att.log(), T.log()] }
}
root Scene {
    param scale: real = 3
    bodies: list of Body
    constraint one { scale - 1 }
}
"""
EYE = [0, 0, 0, 1, 0, 0, 0]


@pytest.fixture
def scene(tmp_path: Path) -> arael.Model:
    path = tmp_path / "scene.arael"
    path.write_text(TEXT, encoding="utf-8")
    found = arael.load(path, interpret=True)()
    for k in range(3):
        found.bodies.append(pos=[k, 0], att=[1, 0, 0, 0], T=EYE)
    return found


def test_a_vector_goes_out_and_in(scene: arael.Model) -> None:
    start = scene.serialize()
    assert start.shape == (1 + 3 * (2 + 4 + 7),)
    cost = scene.cost()
    result = scene.solve()
    np.testing.assert_array_equal(scene.serialize(), result.x)
    scene.deserialize(start)
    assert scene.cost() == cost
    assert scene.scale.value == 3.0 and scene.bodies.pos.value[2, 0] == 2.0
    scene.deserialize(result.x)
    assert scene.cost() == result.end_cost


def test_what_is_held_stays(scene: arael.Model) -> None:
    scene.bodies[1].pos.fixed = True
    scene.scale.optimize = False
    x = scene.serialize()
    assert x.shape == (3 * 13,)
    x[0::13] += 10.0  # the x of every position, that of the fixed one too
    scene.deserialize(x)
    assert scene.bodies.pos.value[:, 0].tolist() == [10.0, 1.0, 12.0]
    assert scene.scale.value == 3.0


def test_rotations_come_in_normalised(scene: arael.Model) -> None:
    x = scene.serialize()
    x[3:7] = [0.7071, 0.7071, 0, 0]
    scene.deserialize(x)
    assert np.linalg.norm(scene.bodies[0].att.value) == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize(
    ("change", "code", "place"),
    [
        (lambda x: x[:-1], "E0704", "deserialize"),
        (lambda x: np.where(np.arange(len(x)) == 14, np.nan, x), "E0705", "bodies[1].pos"),
        (lambda x: np.where(np.arange(len(x)) == 3, 2.0, x), "E0721", "bodies[0].att"),
    ],
)
def test_a_wrong_vector_changes_nothing(
    scene: arael.Model, change: object, code: str, place: str
) -> None:
    before = scene.serialize()
    with pytest.raises(AraelError) as error:
        scene.deserialize(change(before + np.eye(len(before))[0]))  # type: ignore[operator]
    assert error.value.diagnostics[0].code == code
    assert place in str(error.value)
    np.testing.assert_array_equal(scene.serialize(), before)


def test_another_minimiser_can_use_it(tmp_path: Path) -> None:
    path = tmp_path / "valley.arael"
    path.write_text(
        "root V { param p: vec2 = [-1.2, 1]\n constraint c { [10 * (p.y - p.x^2), 1 - p.x] } }",
        encoding="utf-8",
    )
    valley = arael.load(path, interpret=True)()

    def at(x: np.ndarray) -> tuple[float, np.ndarray]:
        valley.deserialize(x)
        return valley.cost(), valley.gradient()

    found = minimize(at, valley.serialize(), jac=True, method="BFGS")
    np.testing.assert_allclose(found.x, [1, 1], atol=1e-5)


def test_parameters_given_with_their_flag(scene: arael.Model) -> None:
    held = type(scene)(scale={"value": 2, "fixed": True}, bodies=[])
    assert held.scale.value == 2.0 and held.scale.fixed
    scene.bodies[1].pos = {"value": [7, 8], "fixed": True}
    assert scene.bodies.pos.fixed.tolist() == [False, True, False]
    scene.bodies[1].pos = {"value": [1, 1]}
    assert not scene.bodies[1].pos.fixed
    with pytest.raises(AraelError, match="E0703"):
        scene.scale = {"valeu": 2}


def test_the_vector_of_a_result_is_a_copy_that_later_solves_do_not_change(
    scene: arael.Model,
) -> None:
    scene.bodies[1].pos.fixed = True
    result = scene.solve(freeze="bodies.T")
    before = result.x.copy()
    assert result.x.dtype == np.float64 and result.x.base is not scene.session.earlier.states[0]
    scene.scale.value = 50.0
    scene.bodies.pos.value[:, 0] += 5.0
    scene.solve(freeze="bodies.T", max_iters=1)
    np.testing.assert_array_equal(result.x, before)
