"""Every parameter type compiled: kernels, derivatives, and solves whose answers are known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from arael.loading import load
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

Array = np.ndarray[Any, Any]
TIGHT = {"abs_precision": 1e-15, "rel_precision": 1e-15, "max_iters": 300}


def model_of(tmp_path: Path, text: str) -> type[Model]:
    path = tmp_path / "model.arael"
    path.write_text(text)
    return load(path)


def turns(rng: np.random.Generator, n: int, size: float = 1.0) -> Array:
    """Random rotations as (n, 4), w first."""
    return np.roll(Rotation.from_rotvec(size * rng.normal(size=(n, 3))).as_quat(), 1, axis=1)


EVERYTHING = """
struct Pose {
    param T: transform
    param S: similarity
    param d: direction
    param q: quaternion
    param r: rotation
    z: transform
    y: similarity
    n: direction
}
struct Pair {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    p: vec3
    constraint between { (a.z.inverse() * (a.T.inverse() * b.T)).log() }
    constraint composed { (a.T * b.T * a.z).log() }
    constraint inverted { (a.T * b.T.inverse()).log() }
    constraint anchored { (a.T.value.inverse() * a.T * a.z).log() }
    constraint point { b.T.inverse() * (a.T * p) }
    constraint similar { (a.S.inverse() * b.S * a.y).log() }
    constraint scaled { [a.S * p, b.S.inverse() * p, b.S.scale] }
    constraint sphere { [a.d - b.n, dot(a.d, b.d), cross(a.d, a.d.value)] }
    constraint frames { a.T.rotation_matrix() * b.d + b.T.translation }
    constraint turned { [(a.T.rotation * b.q).vec, (b.r * a.S.rotation).log()] }
    constraint made { transform(p, a.q) * b.d + similarity(b.d, a.r, 2) * p }
    constraint stepped { (a.T * exp([p, 0.1 * p])).translation }
    constraint homogeneous { a.S.matrix() * [p, 1] }
    constraint chosen { if p.x > 0 then a.T * p else b.T * p }
}
root R { poses: list of Pose; pairs: list of Pair }
"""


@pytest.mark.sweep(slow=("0.6", "1e-07"))
@pytest.mark.parametrize("spread", [0.6, 1e-7])
def test_all_algebra_against_interpreter_and_differences(tmp_path: Path, spread: float) -> None:
    model = model_of(tmp_path, EVERYTHING)()
    rng = np.random.default_rng(4)
    n = 4
    t = spread * rng.normal(size=(n, 3))
    model.poses.extend(
        T=np.hstack([t, turns(rng, n, spread)]),
        S=np.hstack([t + 1, turns(rng, n, spread), rng.uniform(0.5, 2, (n, 1))]),
        d=[[0, 0, 1], [0, 0, -1], [1, 0, 0], [0.6, 0, -0.8]],
        q=turns(rng, n),
        r=turns(rng, n),
        z=np.hstack([t, turns(rng, n, spread)]),
        y=np.hstack([t, turns(rng, n, spread), np.ones((n, 1))]),
        n=[[0, 1, 0]] * n,
    )
    for i in range(9):
        model.pairs.append(
            a=model.poses[i % n], b=model.poses[(i * i + 1) % n], p=rng.normal(size=3)
        )
    check_against_oracle(model)
    check_against_differences(model)


def umeyama(a: Array, b: Array, scaled: bool) -> tuple[Array, Array, float]:
    """Translation, rotation and scale that best take `a` to `b` (S. Umeyama, 1991)."""
    x, y = a - a.mean(axis=0), b - b.mean(axis=0)
    u, d, vt = np.linalg.svd(y.T @ x)
    sign = np.diag([1, 1, np.linalg.det(u) * np.linalg.det(vt)])
    r = u @ sign @ vt
    s = float((d * np.diag(sign)).sum() / (x * x).sum()) if scaled else 1.0
    return b.mean(axis=0) - s * r @ a.mean(axis=0), r, s


ALIGN = """
struct Match {{ a: vec3; b: vec3
    constraint c {{ root.T * a - b }}
}}
root R {{ param T: {kind}; matches: list of Match }}
"""


def clouds(seed: int = 3) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(30, 3))
    turn = Rotation.from_rotvec([1.5, 2, 0.3])
    return a, 2.5 * turn.apply(a) + [1, 2, 3] + 0.1 * rng.normal(size=(30, 3))


@pytest.mark.sweep(2)
@pytest.mark.parametrize("kind", ["transform", "similarity"])
def test_alignment_is_umeyamas(tmp_path: Path, kind: str) -> None:
    model = model_of(tmp_path, ALIGN.format(kind=kind))(T=np.eye(4))
    a, b = clouds()
    model.matches.extend(a=a, b=b)
    model.solve(**TIGHT)
    t, r, s = umeyama(a, b, kind == "similarity")
    np.testing.assert_allclose(model.T.translation, t, atol=1e-7)
    np.testing.assert_allclose(model.T.rotation_matrix, r, atol=1e-7)
    np.testing.assert_allclose(model.T.matrix[:3, :3], s * r, atol=1e-7)
    assert np.linalg.norm(model.T.quaternion) == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize("part", ["translation", "rotation", "scale"])
def test_parts_that_are_frozen_stay(tmp_path: Path, part: str) -> None:
    model = model_of(tmp_path, ALIGN.format(kind="similarity"))()
    a, b = clouds()
    start = np.array([0.3, 0.1, -0.2, *turns(np.random.default_rng(1), 1)[0], 2.0])
    model.T = start
    model.matches.extend(a=a, b=b)
    setattr(model.T, f"optimize_{part}", False)
    assert getattr(model.T, f"optimize_{part}") is False and model.T.optimize is True
    model.solve(**TIGHT)
    at = {"translation": slice(3), "rotation": slice(3, 7), "scale": slice(7, 8)}
    for name, scalars in at.items():
        same = np.array_equal(model.T.value[scalars], start[scalars])
        assert same == (name == part), name
    _, r0, _ = umeyama(a, b, scaled=True)
    if part == "scale":  # the best rotation does not depend on the scale
        np.testing.assert_allclose(model.T.rotation_matrix, r0, atol=1e-7)
        t = b.mean(axis=0) - 2.0 * r0 @ a.mean(axis=0)
        np.testing.assert_allclose(model.T.translation, t, atol=1e-7)
    elif part == "rotation":
        r = model.T.rotation_matrix
        x, y = a - a.mean(axis=0), b - b.mean(axis=0)
        s = (y * (x @ r.T)).sum() / (x * x).sum()
        assert model.T.scale == pytest.approx(s, rel=1e-7)
        t = b.mean(axis=0) - s * r @ a.mean(axis=0)
        np.testing.assert_allclose(model.T.translation, t, atol=1e-7)
    else:  # turning about a point that stays: alignment of the offsets without centring them
        u, _, vt = np.linalg.svd((b - start[:3]).T @ a)
        r = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
        np.testing.assert_allclose(model.T.rotation_matrix, r, atol=1e-7)


def test_freezing_a_part_by_path(tmp_path: Path) -> None:
    text = ALIGN.format(kind="similarity").rstrip().removesuffix("}")
    text += "\n    solve { pass p { freeze T.rotation } }\n}\n"
    start = np.array([0, 0, 0, 0.5, 0.5, 0.5, 0.5, 1.0])
    model = model_of(tmp_path, text)(T=start)
    a, b = clouds()
    model.matches.extend(a=a, b=b)
    model.solve()
    assert model.T.quaternion.tolist() == [0.5] * 4
    assert model.T.scale != 1 and model.T.translation.all()
    before = model.T.value.copy()
    model.solve(passes=[], freeze=["T.scale", "T.translation"])
    assert model.T.value[[0, 1, 2, 7]].tolist() == before[[0, 1, 2, 7]].tolist()
    assert (model.T.quaternion != 0.5).all()


@pytest.mark.sweep(2)
@pytest.mark.parametrize("kind", ["rotation", "quaternion"])
def test_rotation_between_directions_is_wahbas(tmp_path: Path, kind: str) -> None:
    text = (
        "struct Match { a: vec3; b: vec3\n    constraint c { root.q.rotate(a) - b }\n}\n"
        f"root R {{ param q: {kind}; matches: list of Match }}\n"
    )
    model = model_of(tmp_path, text)(q=[1, 0, 0, 0])
    a, b = clouds()
    model.matches.extend(a=a, b=b)
    model.solve(**TIGHT)
    u, _, vt = np.linalg.svd(b.T @ a)
    r = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    np.testing.assert_allclose(model.q.matrix, r, atol=1e-7)


@pytest.mark.parametrize("start", [(0, 0, 1), (0, 0, -1), (-0.6, 0, 0.8)])
def test_mean_direction(tmp_path: Path, start: tuple[float, ...]) -> None:
    text = (
        "struct Sight { z: direction\n    constraint c { root.d - z }\n}\n"
        "root R { param d: direction; sights: list of Sight }\n"
    )
    model = model_of(tmp_path, text)(d=start)
    z = np.random.default_rng(2).normal(size=(20, 3)) + np.array([1, 2, -3])
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    model.sights.extend(z=z)
    model.solve(**TIGHT)
    mean = z.mean(axis=0)
    np.testing.assert_allclose(model.d.value, mean / np.linalg.norm(mean), atol=1e-7)
    assert np.linalg.norm(model.d.value) == pytest.approx(1, abs=1e-15)


@pytest.mark.slow
def test_mean_transform(tmp_path: Path) -> None:
    text = (
        "struct Seen { z: transform\n    constraint c { (root.T.inverse() * z).log() }\n}\n"
        "root R { param T: transform; seen: list of Seen }\n"
    )
    model = model_of(tmp_path, text)(T=[0, 0, 0, 1, 0, 0, 0])
    rng = np.random.default_rng(7)
    z = np.hstack([rng.normal(size=(8, 3)), turns(rng, 8, 0.5)])
    model.seen.extend(z=z)
    result = model.solve(**TIGHT)
    seen = np.tile(np.eye(4), (8, 1, 1))
    seen[:, :3, :3] = Rotation.from_quat(np.roll(z[:, 3:], -1, axis=1)).as_matrix()
    seen[:, :3, 3] = z[:, :3]

    def twists(x: Array) -> Array:
        here = np.eye(4)
        here[:3, :3], here[:3, 3] = Rotation.from_rotvec(x[3:]).as_matrix(), x[:3]
        found = []
        for one in seen:
            m = np.linalg.solve(here, one)
            phi = Rotation.from_matrix(m[:3, :3]).as_rotvec()
            angle, k = np.linalg.norm(phi), np.cross(np.eye(3), -phi)
            v = np.eye(3) + (1 - np.cos(angle)) / angle**2 * k
            v += (angle - np.sin(angle)) / angle**3 * k @ k
            found += [*np.linalg.solve(v, m[:3, 3]), *phi]
        return np.array(found)

    best = least_squares(twists, np.zeros(6), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert result.cost == pytest.approx(2 * best.cost, rel=1e-10)
    np.testing.assert_allclose(model.T.translation, best.x[:3], atol=1e-6)


@pytest.mark.slow
def test_single_precision(tmp_path: Path) -> None:
    model = model_of(tmp_path, ALIGN.format(kind="similarity").replace("root R", "root R : f32"))()
    model.T = np.eye(4)
    a, b = clouds()
    model.matches.extend(a=a, b=b)
    check_against_oracle(model, 3e-6)
    model.solve()
    assert model.T.scale == pytest.approx(umeyama(a, b, True)[2], rel=1e-4)
