"""Certificates of problems with data on both sides of rotations: hand-eye calibration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from arael.certificates.problem import chordal_problem
from arael.certificates.relaxation import constraints
from arael.certificates.two_sided import TwoSidedProblem
from arael.diagnostics.records import AraelError
from tests.examples.scripts import script
from tests.interpreted import Load, loader

Floats = NDArray[np.float64]
Poses = tuple[Floats, Rotation]

HAND_EYE = """
struct Motion {
    a: transform
    b: transform
    eye: ref Eye in root.eyes
    constraint loop {
        let off = (a * eye.X).inverse() * (eye.X * b)
        [off.translation / 0.001, off.rotation.vec * (2 / 0.1)]
    }
}
struct Eye { param X: transform = [0, 0, 0, 1, 0, 0, 0] }
root HandEye { eyes: list of Eye; motions: list of Motion }
"""
ROBOT_WORLD = """
struct Motion {
    a: transform
    b: transform
    eye: ref Eye in root.eyes
    constraint chain {
        let off = (a * eye.X).inverse() * (root.Y * b)
        [off.translation / 0.001, off.rotation.vec * (2 / 0.1)]
    }
}
struct Eye { param X: transform = [0, 0, 0, 1, 0, 0, 0] }
root RobotWorld {
    param Y: transform = [0, 0, 0, 1, 0, 0, 0]
    eyes: list of Eye
    motions: list of Motion
}
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("two_sided"))


def times(a: Poses, b: Poses) -> Poses:
    return a[0] + a[1].apply(b[0]), a[1] * b[1]


def inverted(a: Poses) -> Poses:
    return -a[1].inv().apply(a[0]), a[1].inv()


def seven(a: Poses) -> Floats:
    return np.hstack([a[0], a[1].as_quat(scalar_first=True)])


def calibration(load: Load, text: str, seed: int, motions: int, eyes: int = 1) -> Any:
    """A model at the truth, with noisy motions of each eye, the angles less accurate."""
    rng = np.random.default_rng(seed)

    def at(size: float, *shape: int) -> Poses:
        return rng.normal(0, size, (*shape, 3)), Rotation.random(*shape, random_state=rng)

    model = load(text)()
    y = at(0.5)
    for eye in range(eyes):
        x = at(0.1)
        a = rng.normal(0, 0.3, (motions, 3)), Rotation.from_rotvec(rng.normal(0, 1, (motions, 3)))
        b = times(inverted(y if text is ROBOT_WORLD else x), times(a, x))
        noise = Rotation.from_rotvec(rng.normal(0, 0.004, (motions, 3)))
        b = b[0] + rng.normal(0, 0.001, (motions, 3)), b[1] * noise
        model.eyes.append(X=seven(x))
        model.motions.extend(a=seven(a), b=seven(b), eye=[eye] * motions)
    if text is ROBOT_WORLD:
        model.Y = seven(y)
    return model


def problem(model: Any) -> Any:
    return chordal_problem(model._compiled, model._problem())


def random_point(chordal: Any, rng: np.random.Generator) -> Floats:
    """X with random rotations, and positions anywhere."""
    frames = chordal.frames
    x = rng.normal(0, 1, (frames.d, frames.size))
    x[:, :3] = np.eye(3)
    for first in frames.rotations[1:]:
        x[:, first : first + 3] = Rotation.random(random_state=rng).as_matrix()
    return x


@pytest.mark.parametrize(("m", "d"), [(1, 2), (2, 2), (1, 3), (3, 3)])
def test_constraints_are_independent_and_those_of_rotations(m: int, d: int) -> None:
    rng = np.random.default_rng(m)
    a = constraints(m, d)
    assert np.linalg.matrix_rank(a.reshape(len(a), -1)) == len(a) == m * (20 if d == 3 else 7)
    turned = [np.linalg.qr(rng.normal(size=(d, d)))[0] for _ in range(m)]
    for one in turned:
        one[:, 0] *= np.linalg.det(one)
    z = np.concatenate([[1.0], *(one.T.ravel() for one in turned)])
    assert np.abs(np.einsum("kij,i,j->k", a, z, z)).max() < 1e-14
    z[1 : 1 + d] *= -1  # a reflection
    assert np.abs(np.einsum("kij,i,j->k", a, z, z)).max() > 0.1


@pytest.mark.parametrize("text", [HAND_EYE, ROBOT_WORLD], ids=["hand_eye", "robot_world"])
def test_the_two_sided_problem_is_the_model_where_weights_are_even(load: Load, text: str) -> None:
    """Anywhere, by the model's own residuals; and with a transform that is fixed."""
    model = calibration(load, text, 3, 5, eyes=2)
    rng = np.random.default_rng(0)
    for fixed in (False, True):
        if fixed:
            model.eyes[0].X.fixed = True
        chordal = problem(model)
        assert isinstance(chordal, TwoSidedProblem) and chordal.exact
        for _ in range(3):
            x = random_point(chordal, rng)
            chordal.put(x)
            assert model.cost() == pytest.approx(chordal.cost(x), rel=1e-10)
        x = chordal.minimised(x)
        chordal.put(x)
        assert model.cost() == pytest.approx(chordal.cost(x), rel=1e-9)
        assert model.solve().end_cost == pytest.approx(chordal.cost(x), rel=1e-6)


@pytest.mark.parametrize("text", [HAND_EYE, ROBOT_WORLD], ids=["hand_eye", "robot_world"])
@pytest.mark.parametrize("count", [10, pytest.param(50, marks=pytest.mark.slow)])
def test_planted_minima_are_refused_and_left(load: Load, text: str, count: int) -> None:
    """Minima from random rotations, of few motions; the escape finds the lowest of them."""
    planted = refused = escaped = 0
    for seed in range(40 * count):
        if planted == count:
            break
        rng = np.random.default_rng(seed)
        model = calibration(load, text, seed, 3)
        best = model.solve()
        chordal = problem(model)
        minima = [chordal.minimised(random_point(chordal, rng)) for _ in range(6)]
        costs = np.array([chordal.cost(x) for x in minima])
        assert best.certificate.verdict == "global"
        assert best.certificate.bound <= min(costs.min(), best.end_cost) * (1 + 1e-6)
        distinct = np.unique(np.round(np.log(costs), 3), return_index=True)[1]
        for k in distinct[costs[distinct] > 1.01 * best.end_cost]:
            if planted == count:
                break
            chordal.put(minima[k])
            result = model.solve()
            if result.end_cost <= 1.01 * best.end_cost:
                continue  # a saddle
            planted += 1
            refused += result.certificate.verdict == "not certified"
            if planted % 5 == 0:
                lower = result.escape()
                assert lower.end_cost == pytest.approx(best.end_cost, rel=1e-6)
                escaped += lower.certificate.verdict == "global"
    assert (planted, refused, escaped) == (count, count, count // 5)


def test_the_sets_of_the_example_are_certified_as_twins() -> None:
    module = script("hand_eye")
    poses = module.simulate()
    for make in (module.hand_eye, module.robot_world):
        found = make(poses).solve().certificate
        assert found.certified and found.twin and found.gap < 0.03
        assert found.bound <= found.optimum <= found.bound * (1 + 1e-6)


def test_perfect_data(load: Load) -> None:
    """A cost of zero to rounding."""
    model = load(HAND_EYE)()
    model.eyes.append()
    rng = np.random.default_rng(0)
    x = rng.normal(size=3), Rotation.random(random_state=rng)
    a = rng.normal(size=(6, 3)), Rotation.random(6, random_state=rng)
    model.motions.extend(a=seven(a), b=seven(times(inverted(x), times(a, x))), eye=[0] * 6)
    result = model.solve()
    assert result.end_cost < 1e-9
    assert result.certificate.verdict == "global"


PLANAR = """
struct Motion {
    turn: real
    move: vec2
    seen: vec2
    constraint loop {
        (rotation_matrix(turn) * root.t + move - root.th.rotation_matrix() * seen - root.t) / 0.1
    }
}
root Wheels {
    param th: angle
    param t: vec2
    motions: list of Motion
}
"""


def test_a_sensor_on_a_wheeled_robot(load: Load) -> None:
    """The lowest cost is that of a search over the angle."""
    rng = np.random.default_rng(5)
    turn, move, seen = rng.normal(size=8), rng.normal(size=(8, 2)), rng.normal(size=(8, 2))

    def least(th: float) -> float:
        c, s = np.cos(turn), np.sin(turn)
        j = np.stack([np.stack([c - 1, -s], 1), np.stack([s, c - 1], 1)], 1).reshape(-1, 2)
        x = np.array([[np.cos(th), -np.sin(th)], [np.sin(th), np.cos(th)]])
        r = (move - seen @ x.T).ravel()
        return float(np.linalg.lstsq(j, r)[1][0]) / 0.1**2

    search = min(map(least, np.linspace(0, 2 * np.pi, 20000)))
    model = load(PLANAR)(th=0.3, t=[0, 0])
    model.motions.extend(turn=turn, move=move, seen=seen)
    result = model.solve()
    result = result.escape()
    found = result.certificate
    assert found.verdict == "global" and not found.twin
    assert found.bound <= search <= found.bound * (1 + 1e-5)
    assert result.end_cost == pytest.approx(search, rel=1e-6)


def test_a_rotation_that_is_known(load: Load) -> None:
    """Linear least squares in the position: always its lowest."""
    model = load(PLANAR)(th=0.3, t=[0, 0])
    model.th.fixed = True
    rng = np.random.default_rng(5)
    model.motions.extend(
        turn=rng.normal(size=8), move=rng.normal(size=(8, 2)), seen=rng.normal(size=(8, 2))
    )
    found = model.solve().certificate
    assert found.verdict == "global"
    assert found.bound == pytest.approx(model.cost(), rel=1e-6)


def test_more_rotations_than_dense_matrices_allow(load: Load) -> None:
    result = calibration(load, ROBOT_WORLD, 0, 4, eyes=8).solve()
    with pytest.raises(AraelError, match=r"E1061.*(.|\n)*more than 8 rotations"):
        _ = result.certificate
