"""A model as a problem for minimisers of one's own: derivatives by finite differences, SciPy's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize

import arael
from arael.diagnostics.records import AraelError
from arael.tangent_problem import TangentProblem

TEXT = """
struct Body {
    param pos: vec2
    param ea:  euler
    param rot: rotation
    param att: quaternion
    param up:  direction
    param T:   transform
    param S:   similarity
    param yaw: angle
    pull: vec3
    constraint near {
        [pos - [1, 2], rotation_matrix(ea) * pull - [1, 0.3, 2], rot.rotate(pull),
         att.rotate(pull) - [0.2, 1, 0],
         up - [0.6, 0, 0.8], T * pull - [3, 1, 2], S * pull - [1, 2, 2], sin(yaw) - 0.3]
    }
    constraint level { [att.log() * 0.3, T.log() * 0.2, S.log() * 0.3, ea * 0.2, rot.log() * 0.3] }
}
root Scene {
    param scale: real = 3
    bodies: list of Body
    constraint one { scale * scale - 2 }
}
"""
IDENTITY = [0, 0, 0, 1, 0, 0, 0]


def load(tmp_path: Path, text: str) -> type[arael.Model]:
    path = tmp_path / "scene.arael"
    path.write_text(text, encoding="utf-8")
    return arael.load(path, interpret=True)


@pytest.fixture
def scene(tmp_path: Path) -> arael.Model:
    found = load(tmp_path, TEXT)()
    rng = np.random.default_rng(3)
    for _ in range(2):
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        up = rng.normal(size=3)
        found.bodies.append(
            pos=rng.normal(size=2),
            ea=rng.uniform(-1, 1, 3),
            rot=q,
            att=q,
            up=up / np.linalg.norm(up),
            T=[*rng.normal(size=3), *q],
            S=[*rng.normal(size=3), *q, 1.5],
            yaw=0.4,
            pull=rng.normal(size=3),
        )
    return found


def differences(problem: TangentProblem, delta: np.ndarray, step: float = 1e-5) -> np.ndarray:
    columns = []
    for k in range(problem.size):
        d = np.zeros(problem.size)
        d[k] = step
        ahead, behind = problem.residuals(delta + d), problem.residuals(delta - d)
        columns.append((ahead - behind) / (2 * step))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("size", [0.0, 0.05, 1.1])
def test_derivatives_are_by_delta_wherever_it_is(scene: arael.Model, size: float) -> None:
    problem = scene.problem()
    rng = np.random.default_rng(int(size * 100))
    delta = size * rng.normal(size=problem.size)
    jacobian = problem.jacobian(delta).toarray()
    assert jacobian.shape == problem.shape == (len(problem.residuals()), len(problem.names))
    np.testing.assert_allclose(jacobian, differences(problem, delta), rtol=1e-6, atol=1e-7)
    r, v = problem.residuals(delta), rng.normal(size=problem.size)
    assert problem.cost(delta) == pytest.approx(r @ r, rel=1e-13)
    np.testing.assert_allclose(problem.gradient(delta), 2 * jacobian.T @ r, rtol=1e-11, atol=1e-11)
    expected = 2 * jacobian.T @ (jacobian @ v)
    np.testing.assert_allclose(problem.product(v, delta), expected, rtol=1e-12, atol=1e-12)


def test_parts_that_are_held_do_not_disturb_the_charts(scene: arael.Model) -> None:
    scene.bodies.T.optimize_translation = False
    scene.bodies[0].S.optimize_scale = False
    scene.bodies[1].pos.fixed = True
    problem = scene.problem()
    delta = 0.8 * np.random.default_rng(2).normal(size=problem.size)
    jacobian = problem.jacobian(delta).toarray()
    np.testing.assert_allclose(jacobian, differences(problem, delta), rtol=1e-6, atol=1e-7)
    residuals = problem.residuals(delta)
    np.testing.assert_allclose(problem.gradient(delta), 2 * jacobian.T @ residuals, atol=1e-10)


def test_updates_of_components_are_part_of_the_chart(tmp_path: Path) -> None:
    text = """
    component Turn {
        param d: vec3 = [0, 0, 0]
        base: quat = [1, 0, 0, 0]
        symbolic q = base * exp(d)
        update { base = q; d = 0 }
    }
    root R {
        param turn: Turn
        v: vec3 = [1, 2, 3]
        constraint c { [turn.q.rotate(v) - [3, 1, 2], turn.q.w] }
    }
    """
    problem = load(tmp_path, text)().problem()
    delta = np.array([0.5, -0.9, 0.3])
    expected = differences(problem, delta)
    np.testing.assert_allclose(problem.jacobian(delta).toarray(), expected, rtol=1e-5, atol=1e-7)


def test_retract_moves_the_base_point_alone(scene: arael.Model) -> None:
    problem = scene.problem()
    before = scene.serialize()
    delta = 0.3 * np.random.default_rng(5).normal(size=problem.size)
    there = problem.residuals(delta)
    problem.retract(delta)
    np.testing.assert_array_equal(problem.residuals(), there)
    np.testing.assert_array_equal(problem.residuals(np.zeros(problem.size)), there)
    np.testing.assert_array_equal(scene.serialize(), before)
    problem.write_back()
    np.testing.assert_allclose(scene.serialize(), problem.x, rtol=1e-14)
    assert scene.cost() == pytest.approx(problem.cost(), rel=1e-15)


@pytest.mark.slow
def test_minimisers_of_scipy_reach_the_cost_of_solve(scene: arael.Model) -> None:
    problem = scene.problem()
    start = np.zeros(problem.size)
    by_trf = least_squares(problem.residuals, start, jac=problem.jacobian, xtol=1e-12, ftol=1e-12)
    by_bfgs = minimize(problem.cost, start, jac=problem.gradient, method="BFGS")
    problem.retract(by_trf.x)
    problem.write_back()
    assert scene.cost() == pytest.approx(2 * by_trf.cost, rel=1e-12)
    found = scene.solve()
    assert found.end_cost == pytest.approx(2 * by_trf.cost, rel=1e-9)
    assert by_bfgs.fun == pytest.approx(found.end_cost, rel=1e-6)


def test_bounds_are_those_of_delta(tmp_path: Path) -> None:
    text = "root R { param a: real in -2 .. 4 = 1\n param b: vec2\n constraint c { [a, b] } }"
    problem = load(tmp_path, text)(b=[1, 2]).problem()
    assert problem.low.tolist() == [-3, -np.inf, -np.inf]
    assert problem.high.tolist() == [3, np.inf, np.inf]
    problem.retract([1, 0, 0])
    assert problem.low[0] == -4 and problem.high[0] == 2


def test_the_number_of_residuals_stays_when_a_guard_changes(tmp_path: Path) -> None:
    text = "root R { param a: real = 1\n constraint c when a > 0 { a }\n constraint d { a - 3 } }"
    problem = load(tmp_path, text)().problem()
    assert problem.residuals().tolist() == [1, -2]
    assert problem.residuals([-5]).tolist() == [0, -7]
    assert problem.jacobian([-5]).toarray().tolist() == [[0], [1]]


def test_a_vector_of_another_length_is_reported(scene: arael.Model) -> None:
    problem = scene.problem()
    with pytest.raises(AraelError, match="E0704") as raised:
        problem.cost([1.0, 2.0])
    assert f"expected {problem.size} numbers" in str(raised.value)


def test_what_is_no_step_is_reported_and_moves_nothing(scene: arael.Model) -> None:
    problem = scene.problem()
    before = problem.x.tolist()
    with pytest.raises(AraelError, match="E0703"):
        problem.cost("ab")
    with pytest.raises(AraelError, match="E0705") as raised:
        problem.retract(np.full(problem.size, np.nan))
    assert f"the step of `{problem.names[0]}` is nan" in str(raised.value)
    assert problem.x.tolist() == before


def test_later_changes_of_the_model_do_not_matter(scene: arael.Model) -> None:
    problem = scene.problem()
    before = problem.cost()
    scene.scale.value = 17.0
    scene.bodies.pull = np.ones((2, 3))
    assert problem.cost() == before
