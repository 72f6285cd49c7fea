"""Functions of `trajectories.arael`, against SciPy's B-splines, differences and covariances."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicHermiteSpline
from scipy.spatial.transform import Rotation

import arael
from arael.compiler.imports import LIBRARY
from arael.solving import problem_of

Floats = NDArray[np.float64]
H = 0.3
RNG = np.random.default_rng(5)
POINTS = RNG.normal(size=(4, 3))
TURNS = Rotation.from_rotvec(0.6 * RNG.normal(size=(4, 3)))
U = np.array([0.0, 0.1, 0.37, 0.5, 0.92, 1.0])


def values(folder: Path, fields: str, formula: str, **data: Any) -> Floats:
    """The formula at each row of data, (n, m); the parameter `zero` is 0."""
    path = folder / "model.arael"
    path.write_text(
        f"""
import "trajectories.arael"
struct Row {{ {fields}; constraint c {{ {formula} }} }}
root Rows {{ rows: list of Row; h: real = {H}; param zero: real = 0 }}
"""
    )
    model: Any = arael.load(path, interpret=True)()
    model.rows.extend(**data)
    return np.asarray(problem_of(model).evaluation.group_rows(0)[0])


def vectors(folder: Path, call: str) -> Floats:
    rows = {name: np.tile(p, (len(U), 1)) for name, p in zip("abcd", POINTS, strict=True)}
    fields = "u: real; a: vec3; b: vec3; c: vec3; d: vec3"
    return values(folder, fields, f"{call} + [root.zero, 0, 0]", u=U, **rows)


def turns(folder: Path, call: str, u: Floats = U) -> Floats:
    q = np.roll(TURNS.as_quat(), 1, axis=1)
    rows = {name: np.tile(p, (len(u), 1)) for name, p in zip("abcd", q, strict=True)}
    fields = "u: real; a: quat; b: quat; c: quat; d: quat"
    return values(folder, fields, f"{call} + [root.zero, 0, 0]", u=u, **rows)


@pytest.mark.parametrize(
    ("call", "order"),
    [
        ("spline_position(a, b, c, d, u)", 0),
        ("spline_velocity(a, b, c, d, u, root.h)", 1),
        ("spline_acceleration(a, b, c, d, u, root.h)", 2),
    ],
)
def test_uniform_splines_are_those_of_scipy(tmp_path: Path, call: str, order: int) -> None:
    spline = BSpline(H * np.arange(-3, 5), POINTS, 3)
    assert vectors(tmp_path, call) == pytest.approx(spline(H * U, nu=order), abs=1e-11)


def test_weights_of_a_spline_with_any_knots(tmp_path: Path) -> None:
    knots = np.array([-1.0, -0.2, 0.1, 0.9, 1.1, 2.5])
    t = np.linspace(0.1, 0.9, 7)
    names = ", ".join(f"{k}" for k in knots)
    found = values(
        tmp_path, "t: real", f"spline_weights(t, {names}) + [root.zero, 0, 0, 0]", t=t)  # fmt: skip
    padded = np.concatenate([[-2.0], knots, [3.0]])
    expected = [BSpline(padded, np.eye(4)[k], 3)(t) for k in range(4)]
    assert found == pytest.approx(np.stack(expected, axis=1), abs=1e-13)
    assert found.sum(axis=1) == pytest.approx(1, abs=1e-13)


def test_angular_velocity_and_acceleration_are_derivatives(tmp_path: Path) -> None:
    eps = 1e-4
    at = U[1:-1]

    def rotation(u: Floats) -> Rotation:
        columns = [
            turns(tmp_path, f"rotation_spline(a, b, c, d, u).rotate([{axis}])", u)
            for axis in ("1, 0, 0", "0, 1, 0", "0, 0, 1")
        ]
        return Rotation.from_matrix(np.stack(columns, axis=2))

    numeric = (rotation(at - eps).inv() * rotation(at + eps)).as_rotvec() / (2 * eps * H)
    rate = "rotation_spline_rate(a, b, c, d, u, root.h)"
    assert turns(tmp_path, rate, at) == pytest.approx(numeric, abs=1e-6)
    second = (turns(tmp_path, rate, at + eps) - turns(tmp_path, rate, at - eps)) / (2 * eps * H)
    found = turns(tmp_path, "rotation_spline_acceleration(a, b, c, d, u, root.h)", at)
    assert found == pytest.approx(second, abs=1e-6)


def test_poses_between_equal_motions_move_evenly(tmp_path: Path) -> None:
    """Along one screw the spline is the screw: parts of equal motions add up to (1 + u) of one."""
    twist = np.array([0.3, -0.1, 0.2, 0.1, 0.4, -0.2])
    fields = "u: real; x: vec<6>"
    spline = "pose_spline(exp(0 * x), exp(x), exp(2 * x), exp(3 * x), u)"
    formula = f"({spline}.inverse() * exp((1 + u) * x)).log() + [root.zero, 0, 0, 0, 0, 0]"
    found = values(tmp_path, fields, formula, u=U, x=np.tile(twist, (len(U), 1)))
    assert found == pytest.approx(np.zeros((len(U), 6)), abs=1e-12)


def test_errors_at_constant_velocity_are_white(tmp_path: Path) -> None:
    """Whitened errors have the unit matrix as covariance in the process that they are of."""
    dt, sigma = 0.7, 1.3
    q = sigma**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
    formula = f"constant_velocity_error(p, v, q, w, {dt}, {sigma}) + [root.zero, 0]"
    basis = np.eye(2)
    rows = values(
        tmp_path, "p: real; v: real; q: real; w: real", formula,
        p=np.zeros(2), v=np.zeros(2), q=basis[:, 0], w=basis[:, 1],
    )  # fmt: skip
    whiten = rows.T
    assert whiten @ q @ whiten.T == pytest.approx(np.eye(2), abs=1e-12)
    moved = values(tmp_path, "p: real; v: real; q: real; w: real", formula,
                   p=[1.0], v=[2.0], q=[1 + 2 * dt], w=[2.0])  # fmt: skip
    assert moved == pytest.approx(np.zeros((1, 2)), abs=1e-12)


def test_errors_of_rates_vanish_at_a_constant_rate_and_follow_the_tangent(tmp_path: Path) -> None:
    omega, dt = np.array([0.4, -0.5, 0.3]), 0.8
    start = TURNS[0]
    end = start * Rotation.from_rotvec(omega * dt)
    p, q = (np.roll(r.as_quat(), 1)[None] for r in (start, end))
    formula = f"constant_rate_error(p, v, q, w, {dt}, 2) + [root.zero, 0, 0, 0, 0, 0]"
    fields = "p: quat; v: vec3; q: quat; w: vec3"
    found = values(tmp_path, fields, formula, p=p, q=q, v=omega[None], w=omega[None])
    assert found == pytest.approx(np.zeros((1, 6)), abs=1e-12)

    x, w, eps = np.array([0.5, -0.6, 0.4]), np.array([0.3, 0.2, -0.7]), 1e-6
    turned = [(Rotation.from_rotvec(x) * Rotation.from_rotvec(s * w)).as_rotvec()
              for s in (-eps, eps)]  # fmt: skip
    formula = "rate_in_tangent(x, w) + [root.zero, 0, 0]"
    rate = values(tmp_path, "x: vec3; w: vec3", formula, x=x[None], w=w[None])
    assert rate[0] == pytest.approx((turned[1] - turned[0]) / (2 * eps), abs=1e-7)


def test_between_states_lies_the_cubic_of_positions_and_velocities(tmp_path: Path) -> None:
    dt, s = 0.6, np.linspace(0, 0.6, 5)
    p, v, q, w = 1.0, -0.5, 2.0, 0.7
    expected = CubicHermiteSpline([0, dt], [p, q], [v, w])
    call = f"({p}, {v}, {q}, {w}, s, {dt})"
    formula = f"[between_position{call} + root.zero, between_velocity{call}]"
    found = values(tmp_path, "s: real", formula, s=s)
    assert found[:, 0] == pytest.approx(expected(s), abs=1e-13)
    assert found[:, 1] == pytest.approx(expected.derivative()(s), abs=1e-12)


def test_a_file_beside_the_model_comes_first(tmp_path: Path) -> None:
    (tmp_path / "trajectories.arael").write_text("fn spline_part1(u) = 7 * u\n")
    found = values(tmp_path, "u: real", "spline_part1(u) + root.zero", u=np.ones(1))
    assert found == pytest.approx(np.array([[7.0]]))


def test_a_model_with_the_library_is_found_in_the_cache(tmp_path: Path) -> None:
    path = tmp_path / "model.arael"
    path.write_text(
        'import "trajectories.arael"\n'
        "root R { param u: real; constraint c { spline_part3(u) - 36 } }"
    )
    for _ in range(2):
        model: Any = arael.load(path, interpret=True)(u=5.0)
        model.solve()
        assert float(model.u.value) == pytest.approx(6)


def test_the_library_has_formatted_files() -> None:
    from arael.diagnostics.records import Source
    from arael.syntax.fmt import format_source

    for path in LIBRARY.glob("*.arael"):
        text = path.read_text(encoding="utf-8")
        assert format_source(Source(path.name, text)) == text
