"""Certificates of the global optimum: known optima, planted minima, and what has none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import arael
from arael.certificates.problem import chordal_problem
from arael.cli.main import run
from arael.diagnostics.records import AraelError
from tests.interpreted import Load, loader
from tests.public_data import public

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("certificates"))


# --- planar rings -----------------------------------------------------------------------------


def ring(n: int, turns: int, seed: int, noise: float = 0.05) -> Any:
    """A ring of poses, started with their headings wound around by whole turns: a local minimum."""
    rng = np.random.default_rng(seed)
    th = 2 * np.pi * np.arange(n) / n
    t = np.stack([np.cos(th), np.sin(th)], axis=1) * n / 6
    graph = arael.load("pose_graph_2d")()
    wound = th + 2 * np.pi * turns * np.arange(n) / n + rng.normal(0, 0.02, n)
    graph.poses.extend(t=t, th=(wound + np.pi) % (2 * np.pi) - np.pi)
    graph.poses[0].t.fixed = graph.poses[0].th.fixed = True
    a = np.arange(n)
    b = (a + 1) % n
    c, s = np.cos(th[a]), np.sin(th[a])
    d = t[b] - t[a]
    step = np.stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]], axis=1)
    graph.edges.extend(
        a=a,
        b=b,
        t=step + rng.normal(0, noise, step.shape),
        th=th[b] - th[a] + rng.normal(0, noise, n),
        u=np.diag([3.0, 3.0, 20.0]),
    )
    return graph


@pytest.mark.parametrize("count", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_planted_minima_are_refused_and_left(count: int) -> None:
    """Rings that are wound around once; the escape finds what a good start finds."""
    refused = escaped = 0
    for seed in range(count):
        turns = 1 if seed % 2 else -1
        graph = ring(12, turns, seed)
        result = graph.solve(passes=[])
        found = result.certificate
        refused += found.verdict == "not certified" and found.eigenvalue < 0
        if seed % 10 == 0:
            best = ring(12, 0, seed).solve(passes=[])
            assert best.certificate.verdict == "global"
            assert best.end_cost < 0.1 * result.end_cost
            left = result.escape(passes=[])
            escaped += left.certificate.certified
            assert left.end_cost == pytest.approx(best.end_cost, rel=1e-6)
    assert (refused, escaped) == (count, count // 10)


def test_a_certified_result_stays_as_it_is() -> None:
    result = ring(12, 0, 1).solve(passes=[])
    assert result.escape() is result
    assert str(result.certificate) == "global (to within 1e-06), of the chordal twin of the model"


# --- in space ---------------------------------------------------------------------------------


def torus(rings: int, around: int, seed: int, far: bool) -> Any:
    """Poses on a torus, each with a step to the next and to the next ring; or a random start."""
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(rings), np.arange(around), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / rings, 2 * np.pi * v.ravel() / around
    t = np.stack([(3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)], axis=1)
    turn = Rotation.from_euler("ZY", np.stack([a, b], axis=1))
    at = np.arange(rings * around).reshape(rings, around)
    i = np.concatenate([at.ravel(), at.ravel()])
    j = np.concatenate([np.roll(at, -1, axis=1).ravel(), np.roll(at, -1, axis=0).ravel()])
    moved = turn[i].inv().apply(t[j] - t[i]) + rng.normal(0, 0.05, (len(i), 3))
    turned = turn[i].inv() * turn[j] * Rotation.from_rotvec(rng.normal(0, 0.1, (len(i), 3)))
    start = Rotation.random(len(t), random_state=seed) if far else turn
    graph = arael.load("pose_graph_3d")()
    graph.poses.extend(t=t, q=start.as_quat(scalar_first=True))
    graph.poses[0].q.value = turn[0].as_quat(scalar_first=True)
    graph.poses[0].t.fixed = graph.poses[0].q.fixed = True
    weight = np.diag([20.0, 20, 20, 10, 10, 10])
    graph.edges.extend(a=i, b=j, t=moved, q=turned.as_quat(scalar_first=True), u=weight)
    return graph


def test_the_chordal_problem_is_the_model_where_weights_are_even() -> None:
    graph = torus(4, 5, 3, far=True)
    chordal = chordal_problem(graph._compiled, graph._problem())
    assert chordal.exact
    assert chordal.cost(chordal.values()) == pytest.approx(graph.cost(), rel=1e-12)


def test_random_starts_on_a_torus() -> None:
    """Certified or refused as the cost says; the staircase finds the optimum from each."""
    best = torus(4, 5, 0, far=False).solve()
    assert str(best.certificate) == "global (to within 1e-06)" and not best.certificate.twin
    assert best.certificate.bound <= best.end_cost * (1 + 1e-9)
    refused = 0
    for seed in range(6):
        good = torus(4, 5, seed, far=False).solve()
        assert good.certificate.verdict == "global"
        result = torus(4, 5, seed, far=True).solve()
        found = result.certificate
        assert found.certified == (result.end_cost < good.end_cost * (1 + 1e-6)), seed
        refused += not found.certified
        assert result.escape().end_cost == pytest.approx(good.end_cost, rel=1e-6)
    assert refused > 0


LANDMARKS = """
struct Camera { param at: transform }
struct Mark { param p: vec3 }
struct Seen {
    camera: ref Camera in root.cameras
    mark: ref Mark in root.marks
    p: vec3
    constraint seen { (camera.at.inverse() * mark.p - p) / 0.1 }
}
struct Known {
    mark: ref Mark in root.marks
    p: vec3
    constraint known { (mark.p - p) / 0.05 }
}
root Room {
    cameras: list of Camera
    marks: list of Mark
    sights: list of Seen
    knowns: list of Known
}
"""


def room(load: Load, seed: int) -> tuple[Any, Floats]:
    rng = np.random.default_rng(seed)
    marks, at = rng.normal(0, 3, (12, 3)), rng.normal(0, 3, (5, 3))
    turn = Rotation.random(5, random_state=seed)
    model = load(LANDMARKS)()
    for t, q in zip(at, turn.as_quat(scalar_first=True), strict=True):
        model.cameras.append(at=[*t, *q])
    model.marks.extend(p=marks)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(5), np.arange(12), indexing="ij"))
    seen = turn[i].inv().apply(marks[j] - at[i]) + rng.normal(0, 0.1, (60, 3))
    model.sights.extend(camera=i, mark=j, p=seen)
    model.knowns.extend(mark=np.arange(4), p=marks[:4] + rng.normal(0, 0.05, (4, 3)))
    return model, marks


def test_landmarks_and_transforms(load: Load) -> None:
    model, _ = room(load, 4)
    chordal = chordal_problem(model._compiled, model._problem())
    assert chordal.exact
    assert chordal.cost(chordal.values()) == pytest.approx(model.cost(), rel=1e-12)
    result = model.solve()
    assert result.certificate.verdict == "global"


CLOUD = """
struct Pair { p: vec3
    q: vec3
    w: real = 1
    constraint pair { w * (root.R.rotation_matrix() * p + root.t - q) } }
root Cloud { param R: euler
    param t: vec3
    pairs: list of Pair }
"""


def test_a_point_cloud_has_the_optimum_of_its_closed_form(load: Load) -> None:
    """The bound is the least cost by singular values (Kabsch)."""
    rng = np.random.default_rng(2)
    p = rng.normal(0, 1, (30, 3))
    turn = Rotation.from_euler("xyz", [2.0, 0.4, -1.5])
    q = turn.apply(p) + np.arange(1.0, 4.0) + rng.normal(0, 0.1, p.shape)
    model = load(CLOUD)(R=[0, 0, 0], t=[0, 0, 0])
    model.pairs.extend(p=p, q=q)
    found = model.solve().certificate
    a, b = p - p.mean(axis=0), q - q.mean(axis=0)
    best = Rotation.align_vectors(b, a)[0]
    least = float(((best.apply(a) - b) ** 2).sum())
    assert found.optimum == pytest.approx(least, rel=1e-9)
    assert found.bound <= least <= found.bound * (1 + 2e-6)
    assert found.verdict == "global" and not found.twin


@pytest.mark.parametrize("kind", ["euler", "rotation", "quaternion"])
def test_kinds_of_rotations(load: Load, kind: str) -> None:
    rng = np.random.default_rng(7)
    model = load(CLOUD.replace("R: euler", f"R: {kind}"))(t=[1, 2, 3])
    model.R = [1, 0.2, 0.3] if kind == "euler" else [0.5, 0.5, 0.5, 0.5]
    model.pairs.extend(p=rng.normal(size=(9, 3)), q=rng.normal(size=(9, 3)))
    chordal = chordal_problem(model._compiled, model._problem())
    assert chordal.exact
    assert chordal.cost(chordal.values()) == pytest.approx(model.cost(), rel=1e-12)
    x = chordal.minimised(chordal.values())
    chordal.put(x)
    assert model.cost() == pytest.approx(chordal.cost(x), rel=1e-12)


# --- public files -----------------------------------------------------------------------------


def graph_of(name: str) -> Any:
    graph = arael.load("pose_graph_2d" if "2d" in name else "pose_graph_3d")()
    graph.read(public(name))
    return graph


@pytest.mark.parametrize(
    ("name", "optimum"),
    [
        ("pose_graph_3d/smallGrid3D.g2o", 1025.398),
        pytest.param("pose_graph_3d/sphere2500.g2o", 1687.006, marks=pytest.mark.slow),
        pytest.param("pose_graph_3d/parking-garage.g2o", 1.262524, marks=pytest.mark.slow),
    ],
)
def test_optima_that_se_sync_has_published(name: str, optimum: float) -> None:
    """Rosen et al. (2019), table 1, in this cost: smallGrid3D, sphere, garage."""
    found = graph_of(name).solve().certificate
    assert found.optimum == pytest.approx(optimum, rel=2e-6)
    assert found.certified
    assert found.bound == pytest.approx(optimum, rel=5e-6)


@pytest.mark.parametrize("name", ["pose_graph_2d/intel.g2o", "pose_graph_2d/M3500.g2o"])
def test_planar_files_are_certified_as_twins(name: str) -> None:
    found = graph_of(name).solve().certificate
    assert found.certified and found.twin
    assert found.bound <= found.optimum <= found.bound * (1 + 1e-5)


# --- what has none ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("root.t - q)", "root.t - q) * norm(root.t)"), "it has `w"),
        (("pair {", "pair loss huber(1) {"), "a loss"),
        (("param t: vec3", "param t: vec3 in 0 .. 9"), "bounds of"),
    ],
)
def test_models_without_a_certificate(load: Load, change: tuple[str, str], why: str) -> None:
    model = load(CLOUD.replace(*change))(R=[0.1, 0, 0], t=[1, 2, 3])
    model.pairs.extend(p=np.eye(3) + 1, q=2 * np.eye(3) + 1)
    result = model.solve(max_iters=3)
    with pytest.raises(AraelError, match=rf"E1061.*(.|\n)*{why}"):
        _ = result.certificate


def test_weights_of_their_own_for_each_direction_make_a_twin(load: Load) -> None:
    model = load(CLOUD.replace("w * (", "[w, 2 * w, w] .* ("))(R=[0.1, 0, 0], t=[1, 2, 3])
    model.pairs.extend(p=np.eye(3) + 1, q=2 * np.eye(3) + 1)
    assert model.solve().certificate.twin


def test_a_changed_model_has_no_certificate() -> None:
    graph = ring(12, 0, 1)
    result = graph.solve(passes=[])
    graph.poses[3].t.value[0] += 1
    with pytest.raises(AraelError, match=r"E1060.*other values"):
        _ = result.certificate


def test_on_the_command_line(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ring(12, 1, 3).write("ring.g2o")
    base = ["solve", "pose_graph_2d", "ring.g2o", "--init", "file"]
    assert run([*base, "--certify"]) == 0
    assert "certificate: not certified: a direction of descent" in capsys.readouterr().out
    assert run([*base, "--escape"]) == 0
    assert "certificate: global (to within 1e-06)" in capsys.readouterr().out
