"""Priors: residuals against NumPy and SciPy, posteriors, covariances, kernels and interpreter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arael.analysis.gradients import check_gradients
from arael.diagnostics.records import AraelError
from arael.loading import load, loads
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

POSE = """
struct Pose {
    param pos: vec3 = [1, 2, 3]
    param ea: euler = [0.1, 0.2, 3]
    param th: angle = 3
    param q: quaternion = exp([0.1, 0.2, 0.3])
    param r: rotation = exp([0.3, 0, -0.2])
    param d: direction = [0.6, 0, 0.8]
    param T: transform = transform(exp([0.1, 0, 0.2]), [1, 2, 3])
    param S: similarity = similarity(exp([0, 0.1, 0]), [3, 2, 1], 2)
    mean: vec3 = [0.5, 1.5, 4]
    turn: quat = [1, 0, 0, 0]
    sigma: vec3 = [0.1, 0.2, 0.4]
    near: vec3?
    prior pos ~ normal(mean, sigma)
    prior pos.z ~ normal(2, 0.5)
    prior pos[0:2] ~ normal(1, [1, 2])
    prior ea ~ normal([0, 0, -3], 0.1)
    prior ea.z ~ normal(-3, 0.2)
    prior th ~ normal(-3, 0.3)
    prior q ~ normal(turn, 0.1)
    prior r ~ normal([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 2, 3])
    prior d ~ normal([0, 0, 1], 0.5)
    prior T ~ normal([1, 0, 0, 1, 0, 0, 0], 2)
    prior T.translation ~ normal([1, 2, 4], 3)
    prior T.rotation ~ normal([1, 0, 0, 0], 0.5)
    prior S ~ normal(similarity([3, 2, 0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], 1), 0.5)
    prior S.scale ~ normal(1, 0.25)
    prior pos.x ~ normal(near.x, 1) when near loss huber(1)
}

root Poses : PRECISION { poses: list of Pose }
"""


def poses(tmp_path: Path, precision: str = "f64", **options: Any) -> Model:
    path = tmp_path / "poses.arael"
    path.write_text(POSE.replace("PRECISION", precision))
    model = load(path, **options)()
    model.poses.append()
    turn = np.roll(Rotation.from_rotvec([0.2, 0.1, -0.4]).as_quat(), 1)
    model.poses.append(pos=[0, 1, 0], turn=turn, near=[4, 0, 0])
    return model


@pytest.mark.slow
def test_kernels_interpreter_and_differences_agree(tmp_path: Path) -> None:
    model = poses(tmp_path)
    check_against_oracle(model)
    check_against_differences(model)
    assert all(check.agrees for check in check_gradients(model._problem()))


@pytest.mark.slow
def test_single_precision(tmp_path: Path) -> None:
    single, double = poses(tmp_path, "f32"), poses(tmp_path)
    check_against_oracle(single, 1e-5)
    assert single.cost() == pytest.approx(double.cost(), rel=1e-5)


def test_residuals_are_those_of_numpy_and_scipy(tmp_path: Path) -> None:
    model = poses(tmp_path, interpret=True)
    costs = model.cost_table()
    turn = 2 * np.pi
    q = Rotation.from_rotvec([0.1, 0.2, 0.3])
    other = Rotation.from_rotvec([0.2, 0.1, -0.4])
    flat = Rotation.from_rotvec([0, 0, np.pi / 2])
    r = (flat.inv() * Rotation.from_rotvec([0.3, 0, -0.2])).as_rotvec()
    expected: dict[str, list[Any]] = {
        "pos": [[5, 2.5, -2.5], [-5, -2.5, -10]],
        "pos_z": [[2], [-4]],
        "pos_0_2": [[0, 0.5], [-1, 0]],
        "ea": [[1, 2, (6 - turn) / 0.1]] * 2,
        "ea_z": [[(6 - turn) / 0.2]] * 2,
        "th": [[(6 - turn) / 0.3]] * 2,
        "q": [q.as_rotvec() / 0.1, (other.inv() * q).as_rotvec() / 0.1],
        "r": [r / [1, 2, 3]] * 2,
        "d": [[np.arccos(0.8) / 0.5]] * 2,
        "T_translation": [[0, 0, -1 / 3]] * 2,
        "T_rotation": [[0.2, 0, 0.4]] * 2,
        "S_scale": [[4]] * 2,
        "pos_x": [[], [np.sqrt(2 * 4 - 1)]],  # huber(1) at a residual of 4
    }
    for name, residuals in expected.items():
        cost = sum(float(np.sum(np.square(part))) for part in residuals)
        assert costs[f"Pose.prior_{name}"] == pytest.approx(cost, rel=1e-12), name
    assert {f"Pose.prior_{name}" for name in (*expected, "T", "S")} == set(costs)


ONE = """
root One {
    param P = START
    mean: M
    sigma: N = SIGMA
    prior a ~ normal(mean, sigma)
}
"""
KINDS = {
    "real": ("a: real", "5", "real", 2.0, "real", [0.3]),
    "vector": ("a: vec2", "[5, 6]", "vec2", [2.0, 1], "vec2", [0.3, 2]),
    "angle": ("a: angle", "3", "real", -3.0, "real", [0.3]),
    "euler": ("a: euler", "[0, 0, 3]", "vec3", [0.1, 0, -3], "vec3", [0.3, 0.2, 0.1]),
    "quaternion": (
        "a: quaternion", "exp([2, 0, 1])", "quat", [0.6, 0, 0, 0.8], "vec3", [0.3, 0.2, 0.1]
    ),
    "rotation": (
        "a: rotation", "exp([2, 0, 1])", "quat", [0.6, 0, 0, 0.8], "vec3", [0.3, 0.2, 0.1]
    ),
    "direction": ("a: direction", "[0, 0.6, -0.8]", "vec3", [0.6, 0, 0.8], "vec2", [0.3, 0.2]),
    "transform": (
        "a: transform",
        "[3, 2, 1, 1, 0, 0, 0]",
        "transform",
        [1, 2, 3, 0.6, 0, 0.8, 0],
        "vec<6>",
        [0.1, 0.2, 0.3, 0.4, 0.5, 0.6],
    ),
    "similarity": (
        "a: similarity",
        "[3, 2, 1, 1, 0, 0, 0, 2]",
        "similarity",
        [1, 2, 3, 0.6, 0, 0.8, 0, 3],
        "vec<7>",
        [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7],
    ),
}  # fmt: skip


@pytest.mark.sweep(3)
@pytest.mark.parametrize("kind", KINDS)
def test_a_prior_alone_gives_its_mean_and_its_covariance(kind: str, tmp_path: Path) -> None:
    """In the tangent at the mean, the posterior is the prior."""
    param, start, mean_type, mean, sigma_type, sigma = KINDS[kind]
    text = ONE.replace("P =", f"{param} =").replace("START", start).replace("M\n", f"{mean_type}\n")
    shown = str(sigma if len(sigma) > 1 else sigma[0])
    path = tmp_path / "one.arael"
    path.write_text(text.replace("N =", f"{sigma_type} =").replace("SIGMA", shown))
    model = load(path, interpret=True)(mean=mean)
    result = model.solve(rel_precision=1e-14, abs_precision=1e-20)
    assert result.status == "converged" and result.end_cost < 1e-16
    found = np.asarray(model.a.value)
    if kind in ("quaternion", "rotation"):
        found = found * np.sign(found[0])
    if kind == "euler":  # Euler angles are not wrapped by a step
        found = (found + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(found, mean, atol=1e-8)
    np.testing.assert_allclose(model.covariance().matrix, np.diag(np.square(sigma)), atol=1e-6)


def test_the_posterior_of_a_line_is_that_of_the_normal_equations(tmp_path: Path) -> None:
    path = tmp_path / "line.arael"
    path.write_text("""
struct Point { x: real; y: real }
root Line {
    param a: real = 0
    param b: real = 0
    sigma: real = 0.5
    points: list of Point
    prior a ~ normal(2, 0.1)
    prior b ~ normal(0, 3)
    fit points as p { (a * p.x + b - p.y) / sigma }
}
""")
    model = load(path, interpret=True)()
    x = np.linspace(0, 4, 9)
    y = 1.5 * x + 1 + np.sin(5 * x) / 3
    model.points.extend(x=x, y=y)
    model.solve(rel_precision=1e-14)
    design = np.stack([x, np.ones_like(x)], axis=1) / 0.5
    information = design.T @ design + np.diag([1 / 0.1**2, 1 / 3**2])
    right = design.T @ (y / 0.5) + [2 / 0.1**2, 0]
    np.testing.assert_allclose(
        [model.a.value, model.b.value], np.linalg.solve(information, right), rtol=1e-9
    )
    np.testing.assert_allclose(model.covariance().matrix, np.linalg.inv(information), rtol=1e-8)
    assert list(model.cost_table()) == ["Line.prior_a", "Line.prior_b", "Line.points"]


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 1e-2, 0.1, 1.0, 2.0, 3.1, np.pi - 1e-6])
def test_a_direction_is_as_far_from_the_mean_as_the_angle_between_them(
    angle: float, tmp_path: Path
) -> None:
    path = tmp_path / "d.arael"
    path.write_text("""
root Way {
    param d: direction = [0, 0, 1]
    mean: vec3
    prior d ~ normal(mean, 1)
}
""")
    kind = load(path, interpret=True)
    for axis in ([0.6, 0, 0.8], [0, 0, -1], [2 / 3, -1 / 3, 2 / 3]):
        across = np.cross(axis, [0.48, 0.6, 0.64])
        across /= np.linalg.norm(across)
        model = kind(mean=axis, d=np.cos(angle) * np.array(axis) + np.sin(angle) * across)
        assert np.sqrt(model.cost()) == pytest.approx(angle, rel=1e-9)
        assert all(check.agrees for check in check_gradients(model._problem()))


DATA_SIGMA = """
struct Part {
    param a: real = 1
    s: real = 1
    prior a ~ normal(2, s) when s != 7
}

root Box {
    param v: vec2 = [0, 0]
    vs: vec2 = [1, 1]
    parts: list of Part
    prior v ~ normal([1, 2], 2 * vs)
}
"""


@pytest.mark.parametrize("sigma", [0.0, -1.0, np.nan])
def test_sigmas_from_data_are_positive(sigma: float) -> None:
    model = loads(DATA_SIGMA, interpret=True)()
    model.parts.extend(s=[1.0, 2.0, 7.0, 1.0])
    model.parts[2].a.fixed = True
    model.solve()
    model.parts.s[3] = sigma
    with pytest.raises(AraelError) as caught:
        model.solve()
    assert caught.value.diagnostics[0].code == "E1016"
    text = f"`parts[3]`: the sigma of the prior `Part.prior_a` is {sigma:g}"
    assert text in str(caught.value)
    model.parts.s[3] = 1
    model.vs[1] = sigma
    with pytest.raises(AraelError, match=r"`Box`: the sigma of the prior `Box.prior_v` is"):
        model.solve()
    model.vs[1] = 1
    assert model.solve().status == "converged"


def test_a_sigma_is_checked_only_where_its_prior_acts() -> None:
    text = DATA_SIGMA.replace("s != 7", "s > 0")
    model = loads(text, interpret=True)()
    model.parts.extend(s=[1.0, -1.0])
    model.parts[1].a.fixed = True
    assert model.solve().status == "converged"
