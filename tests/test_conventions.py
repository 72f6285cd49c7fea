"""The statements of docs/conventions.md, one test each."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from arael.diagnostics.records import AraelError
from arael.loading import load
from arael.model import Model
from arael.runtime.problem import Problem

Array = np.ndarray[Any, Any]
RPY = np.array([0.3, -0.5, 1.1])
R = Rotation.from_euler("ZYX", RPY[::-1])
Q = np.roll(R.as_quat(), 1)
X = np.array([0.4, -1.2, 2.0])
T = np.array([1.0, 2.0, 3.0, *Q])
S = np.array([1.0, 2.0, 3.0, *Q, 2.5])
M = np.eye(4)
M[:3, :3], M[:3, 3] = R.as_matrix(), T[:3]

DECLARED = {
    "e": "param e: euler = [0.3, -0.5, 1.1]",
    "r": "param r: rotation",
    "q": "param q: quaternion",
    "h": "param h: angle = 3",
    "d": "param d: direction = [0.36, 0.48, 0.8]",
    "T": "param T: transform",
    "S": "param S: similarity",
    "x": "param x: vec3 = [0.4, -1.2, 2.0]",
}
GIVEN = {"r": Q, "q": Q, "T": T, "S": S}
numbered = itertools.count()


def instance(folder: Path, expression: str) -> Model:
    """A root that has every parameter and one constraint."""
    path = folder / f"m{next(numbered)}.arael"
    fields = "\n    ".join(DECLARED.values())
    path.write_text(f"root Root {{\n    {fields}\n    constraint c {{ {expression} }}\n}}\n")
    return load(path, interpret=True)(**GIVEN)


def value(folder: Path, expression: str, **step: Any) -> Array:
    """Residuals of an expression, after a step of some parameters."""
    model = instance(folder, expression)
    problem = Problem(model._compiled.layout, model._store)
    entity = model._compiled.layout.entities[0]
    moves = np.zeros(problem.size)
    for name, delta in step.items():
        use = next(u for u in entity.params if u.column == name)
        moves[use.tangent_start : use.tangent_start + use.tangent] = delta
    problem.evaluation.moved_by(moves)
    return np.asarray(problem.evaluation.group_rows(0)[0][0])


def close(found: Any, expected: Any, atol: float = 1e-14) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


@pytest.mark.parametrize(
    "turn", ["e.rotation_matrix()", "q.rotation_matrix()", "r.rotation_matrix()",
             "T.rotation_matrix()"],
)  # fmt: skip
def test_rotations_take_body_to_world(tmp_path: Path, turn: str) -> None:
    close(value(tmp_path, f"{turn} * x"), R.apply(X))


def test_transforms_take_body_to_world(tmp_path: Path) -> None:
    close(value(tmp_path, "T * x"), R.apply(X) + T[:3])
    close(value(tmp_path, "S * x"), 2.5 * R.apply(X) + T[:3])
    close(value(tmp_path, "T.inverse() * x"), R.inv().apply(X - T[:3]))
    close(value(tmp_path, "S.inverse() * x"), R.inv().apply(X - T[:3]) / 2.5)
    close(value(tmp_path, "T.translation"), T[:3])


def test_the_right_factor_comes_first(tmp_path: Path) -> None:
    other = "transform(x, q)"
    close(value(tmp_path, f"(T * {other}) * x"), value(tmp_path, f"T * ({other} * x)"))
    close(value(tmp_path, f"(T.inverse() * {other}).translation"), R.inv().apply(X - T[:3]))


def test_angles_turn_counter_clockwise(tmp_path: Path) -> None:
    close(value(tmp_path, "rotation_matrix(pi / 2) * [1, 0] + 0 * [x.x, h]"), [0, 1])
    close(value(tmp_path, "rotation_matrix([0, 0, pi / 2]) * [1, 0, 0] + 0 * x"), [0, 1, 0])
    close(value(tmp_path, "rotation_matrix([0, pi / 2, 0]) * [0, 0, 1] + 0 * x"), [1, 0, 0])
    close(value(tmp_path, "rotation_matrix([pi / 2, 0, 0]) * [0, 1, 0] + 0 * x"), [0, 0, 1])


def test_euler_angles_are_roll_pitch_yaw(tmp_path: Path) -> None:
    close(value(tmp_path, "euler_angles(q)"), RPY)
    close(value(tmp_path, "e"), RPY)
    model = instance(tmp_path, "e")
    for name in ("e", "r", "q", "T", "S"):
        close(model[name].euler, RPY)
        close(model[name].rotation_matrix, R.as_matrix())
        close(model[name].quaternion, Q)
    model.q.euler = [0.2, np.pi / 2, 0.5]
    back = model.q.euler
    assert back[0] == 0
    close(Rotation.from_euler("ZYX", back[::-1]).as_matrix(), model.q.matrix, 1e-7)


def test_quaternions_are_hamiltons_scalar_first(tmp_path: Path) -> None:
    close(value(tmp_path, "[q.w, q.x, q.y, q.z]"), Q)
    i, j = "exp([pi, 0, 0])", "exp([0, pi, 0])"
    close(value(tmp_path, f"[({i} * {j}).w, ({i} * {j}).vec + 0 * x]"), [0, 0, 0, 1])


def test_quaternions_are_normalised_or_refused(tmp_path: Path) -> None:
    model = instance(tmp_path, "q.vec")
    model.q = 1.0005 * Q
    assert np.linalg.norm(model.q.value) == pytest.approx(1, abs=1e-15)
    for name, bad in (("q", 1.01 * Q), ("T", 1.01 * T), ("d", [0, 0, 1.01])):
        with pytest.raises(AraelError, match=r"its norm is 1\.01"):
            setattr(model, name, bad)


@pytest.mark.parametrize("name", ["q", "r", "T", "S", "d"])
def test_norms_do_not_drift(tmp_path: Path, name: str) -> None:
    model = instance(tmp_path, "x")
    problem = Problem(model._compiled.layout, model._store)
    step = 0.3 * np.random.default_rng(1).normal(size=problem.size)
    for _ in range(200):
        problem.evaluation.moved_by(step)
    problem.write_back()
    unit = model.d.value if name == "d" else model[name].quaternion
    assert np.linalg.norm(unit) == pytest.approx(1, abs=3e-16)


def test_opposite_quaternions_are_one_rotation(tmp_path: Path) -> None:
    for sign in ("", "-"):
        close(value(tmp_path, f"({sign}q).log()"), R.as_rotvec())
        close(value(tmp_path, f"rotation_matrix({sign}q) * x"), R.apply(X))
    close(value(tmp_path, "exp(q.log()).vec - q.vec"), 0)


def test_steps_are_taken_in_the_body_frame(tmp_path: Path) -> None:
    delta = np.array([0.1, -0.2, 0.3])
    small = Rotation.from_rotvec(delta)
    close(value(tmp_path, "q.rotate(x)", q=delta), (R * small).apply(X))
    small = Rotation.from_euler("ZYX", delta[::-1])
    close(value(tmp_path, "r.rotate(x)", r=delta), (R * small).apply(X))
    close(value(tmp_path, "e", e=delta), RPY + delta)
    close(value(tmp_path, "h", h=0.5), 3.5 - 2 * np.pi)


def test_twists_list_translation_first(tmp_path: Path) -> None:
    twist = np.array([0.5, 0.2, -0.3, 0.1, -0.2, 0.3])
    hat = np.zeros((4, 4))
    x, y, z = twist[3:]
    hat[:3, :3], hat[:3, 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]], twist[:3]
    moved = M @ expm(hat)
    close(value(tmp_path, "T * x", T=twist), (moved @ [*X, 1])[:3])
    close(value(tmp_path, "(T.value.inverse() * T).log()", T=twist), twist)
    text = ", ".join(map(str, twist))
    close(value(tmp_path, f"(T * exp([{text}])) * x"), (moved @ [*X, 1])[:3])
    scaled = [*twist, 0.4]
    close(value(tmp_path, "(S.value.inverse() * S).log()", S=scaled), scaled)
    close(value(tmp_path, "S.scale", S=scaled), 2.5 * np.exp(0.4))
    close(value(tmp_path, "S.translation", S=scaled), 2.5 * (moved[:3, 3] - T[:3]) + T[:3])


def test_directions_move_along_great_circles(tmp_path: Path) -> None:
    d = np.array([0.36, 0.48, 0.8])
    u = (value(tmp_path, "d", d=[1e-7, 0]) - d) / 1e-7
    v = (value(tmp_path, "d", d=[0, 1e-7]) - d) / 1e-7
    close(np.cross(u, v), d, 1e-6)
    there = value(tmp_path, "d", d=[0.3, -0.4])
    close(there, np.cos(0.5) * d + np.sin(0.5) * (0.6 * u - 0.8 * v), 1e-6)


def test_names_of_solved_scalars(tmp_path: Path) -> None:
    names = instance(tmp_path, "x")._compiled.layout.entities[0].tangent_names
    rigid = [f"{part}.{axis}" for part in ("translation", "rotation") for axis in "xyz"]
    assert names == (
        "e.x", "e.y", "e.z", "r.x", "r.y", "r.z", "q.x", "q.y", "q.z", "h", "d.u", "d.v",
        *(f"T.{n}" for n in rigid), *(f"S.{n}" for n in rigid), "S.scale", "x.x", "x.y", "x.z",
    )  # fmt: skip


def test_matrices_lie_row_by_row(tmp_path: Path) -> None:
    path = tmp_path / "rows.arael"
    path.write_text(
        "root Root {\n    param v: vec3 = [1, 0, 0]\n    m: mat<2,3> = [1, 2, 3, 4, 5, 6]\n"
        "    constraint c { [m * v, [1, 0] * m] }\n}\n"
    )
    model = load(path, interpret=True)()
    problem = Problem(model._compiled.layout, model._store)
    assert problem.evaluation.group_rows(0)[0][0].tolist() == [1, 4, 1, 2, 3]
    assert model.m.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_transforms_read_back_and_are_given_in_all_forms(tmp_path: Path) -> None:
    model = instance(tmp_path, "x")
    close(model.T.matrix, M)
    scaled = M.copy()
    scaled[:3, :3] *= 2.5
    close(model.S.matrix, scaled)
    assert model.S.scale == 2.5
    for form in (T, [*T[:3], *RPY], M, M[:3]):
        model.T = [9, 9, 9, 1, 0, 0, 0]
        model.T = form
        close(model.T.value, T)
    for form in (scaled, scaled[:3]):
        model.S = np.eye(4)
        model.S = form
        close(model.S.value, S)


def test_parts_of_transforms_are_assigned(tmp_path: Path) -> None:
    model = instance(tmp_path, "x")
    model.S.quaternion = [1, 0, 0, 0]
    close(model.S.value, [1, 2, 3, 1, 0, 0, 0, 2.5])
    model.S.rotation_matrix = R.as_matrix()
    close(model.S.value, S)
    model.S.euler = [0, 0, 0]
    model.S.translation = [4, 5, 6]
    model.S.scale = 0.5
    close(model.S.value, [4, 5, 6, 1, 0, 0, 0, 0.5])
    model.T.translation[1] = 7
    assert model.T.value[1] == 7
    for bad in ("scale", "optimize_scale"):
        with pytest.raises(AraelError, match="the parameter has no scale"):
            getattr(model.T, bad)
    with pytest.raises(AraelError, match="expected a positive scale"):
        model.S.scale = -1.0
    with pytest.raises(AraelError, match="not a rotation"):
        model.d.quaternion  # noqa: B018


def test_gradient_and_hessian_have_the_factor_two(tmp_path: Path) -> None:
    model = instance(tmp_path, "3 * x.x")
    problem = Problem(model._compiled.layout, model._store)
    assert problem.cost() == pytest.approx(1.44)
    at = problem.parameter_names().index("x.x")
    assert problem.gradient()[at] == pytest.approx(2 * 3 * 1.2)
    assert problem.hessian()[at, at] == pytest.approx(2 * 9)
