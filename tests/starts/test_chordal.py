"""The chordal start: exact without noise, the minimum of its parts with noise, and the optimum."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.runtime.assembly.pattern import BlockPattern
from arael.starts.chordal import _chordal_weight, chordal_poses
from arael.starts.columns import graph_of
from arael.starts.graph import Poses
from arael.starts.relaxation import Coupling, Relaxation, SingularError
from tests.starts import scenes

SHAPES = {"2d": scenes.grid(4, 6), "3d": scenes.sphere(4, 6)}


def scene(truth: Poses, turn: float, shift: float, noise: float = 1.0) -> Any:
    rng = np.random.default_rng(5)
    ends = scenes.neighbours(4, 6, False)
    edges = scenes.measured(rng, truth, ends, noise * turn, noise * shift)
    return scenes.model_of(truth, ends, edges, turn, shift)


@pytest.mark.parametrize("truth", SHAPES.values(), ids=SHAPES)
def test_without_noise_the_relaxation_is_the_truth(truth: Poses) -> None:
    graph = scene(truth, 0.1, 0.1, noise=0)
    found = chordal_poses(graph_of(graph._store))
    assert abs(found.position - truth.position).max() < 1e-10
    assert abs(found.rotation - truth.rotation).max() < 1e-11


@pytest.mark.parametrize("truth", SHAPES.values(), ids=SHAPES)
def test_positions_are_the_minimum_of_the_models_cost_at_these_rotations(truth: Poses) -> None:
    """With correlated information, a fixed pose, a half fixed one and an anchor."""
    graph = scene(truth, 0.2, 0.1)
    d, u = truth.dimension, graph.edges.u
    u += np.triu(np.random.default_rng(6).normal(0, 2, u.shape), 1)
    graph.poses[7].t.fixed = True
    name = "th" if d == 2 else "q"
    at = {p: graph.poses[p].value[9] for p in ("t", name)}
    graph.anchors.append(pose=9, **at)
    scenes.place(graph, chordal_poses(graph_of(graph._store)))
    slope = dict(zip(graph.parameter_names(), graph.gradient(), strict=True))
    positions = [s for n, s in slope.items() if ".t." in n]
    assert len(positions) == d * (len(truth) - 2)
    assert np.abs(positions).max() < 1e-8 * np.abs(list(slope.values())).max()


def test_the_weight_of_a_chordal_residual_is_the_information_for_small_errors() -> None:
    rng = np.random.default_rng(7)
    a = rng.normal(size=(20, 3, 3)) * [1, 1.2, 0.9]
    information = a @ a.transpose(0, 2, 1) + 5 * np.eye(3)
    weight = _chordal_weight(information, 3)
    vectors = 1e-4 * rng.normal(size=(20, 3))
    off = scenes.rotations(vectors) - np.eye(3)
    chordal = np.einsum("nij,nik,njk->n", weight, off, off)
    assert (np.linalg.eigvalsh(weight) > 0).all()
    expected = np.einsum("ni,nij,nj->n", vectors, information, vectors)
    exact = np.linalg.eigvalsh(0.5 * np.trace(information, axis1=1, axis2=2)[:, None, None]
                               * np.eye(3) - information)[:, 0] > 0  # fmt: skip
    assert exact.sum() > 5
    assert np.allclose(chordal[exact], expected[exact], rtol=1e-3)
    assert (chordal > 0.999 * expected).all()


def test_the_weight_of_a_diagonal_information_is_that_of_any_other() -> None:
    alone = np.eye(3) * np.random.default_rng(2).uniform(0, 9, (6, 1, 3))
    coupled = np.stack([2 * np.eye(3) + 0.1])
    both = _chordal_weight(np.concatenate([alone, coupled]), 3)
    assert np.allclose(_chordal_weight(alone, 3), both[:6])


@pytest.mark.parametrize("seed", range(4))
def test_relaxation_solves_the_dense_normal_equations(seed: int) -> None:
    """Edges in both directions, some twice, some poses held."""
    rng = np.random.default_rng(seed)
    n, m, d = 9, 20, 3
    a = np.concatenate([np.arange(n - 1), rng.integers(0, n, m)])
    b = np.concatenate([np.arange(1, n), rng.integers(0, n, m)])
    a, b = a[a != b], b[a != b]
    left, right = rng.normal(size=(2, len(a), d, d))
    held = rng.random(n) < 0.3
    at, g = rng.normal(size=(2, n, d, 2))
    own = np.tile(np.eye(d), (n, 1, 1))
    blocks = tuple(
        x.transpose(0, 2, 1) @ y for x, y in ((left, left), (left, right), (right, right))
    )
    found = Relaxation(n, d, a, b).solved(blocks, own, g, held, at)
    rows = np.zeros((len(a), d, n, d))
    rows[np.arange(len(a)), :, a] = left
    rows[np.arange(len(a)), :, b] += right
    j = rows.reshape(-1, n * d)
    h = j.T @ j + np.eye(n * d)
    free = np.repeat(~held, d)
    flat = at.reshape(n * d, 2).copy()
    rhs = g.reshape(n * d, 2)[free] - h[np.ix_(free, ~free)] @ flat[~free]
    flat[free] = np.linalg.solve(h[np.ix_(free, free)], rhs)
    assert np.allclose(found.reshape(n * d, 2), flat, rtol=1e-9, atol=1e-9)


def test_a_rotation_that_nothing_measures_is_singular() -> None:
    graph = scene(SHAPES["2d"], 0.1, 0.1)
    graph.edges.u[:, 2, 2] = 0
    with pytest.raises(SingularError):
        chordal_poses(graph_of(graph._store))


LOOPS = {
    "sphere": (scenes.sphere(20, 20), scenes.neighbours(20, 20, False), 0.2, 1),
    "torus": (scenes.torus(20, 20), scenes.neighbours(20, 20, True), 0.1, 1),
    "torus-2": (scenes.torus(20, 20), scenes.neighbours(20, 20, True), 0.1, 2),
}


@pytest.mark.parametrize(("truth", "ends", "turn", "seed"), LOOPS.values(), ids=LOOPS)
def test_five_steps_from_the_chordal_start_end_in_the_global_optimum(
    truth: Poses, ends: np.ndarray, turn: float, seed: int
) -> None:
    """Where odometry leads into a local minimum; the global one is found from the true poses."""
    edges = scenes.measured(np.random.default_rng(seed), truth, ends, turn, 0.1)
    graph = scenes.model_of(truth, ends, edges, turn, 0.1)
    best = graph.solve().end_cost
    scenes.place(graph, scenes.odometry(truth, edges))
    local = graph.solve()
    assert local.converged
    assert local.end_cost > 1.5 * best
    scenes.place(graph, scenes.odometry(truth, edges))
    start = arael.initialise(graph)
    assert start.chosen == "chordal"
    assert start.costs["chordal"] < 0.01 * start.costs["file"]
    assert graph.solve(max_iters=5).end_cost == pytest.approx(best, rel=1e-6)
    assert graph.solve().converged


def test_the_planar_start_ends_in_the_global_optimum() -> None:
    """Where odometry with 30 degrees of noise takes 20 attempts."""
    truth, ends = scenes.grid(15, 25), scenes.neighbours(15, 25, False)
    rng = np.random.default_rng(1)
    column = {tuple(p): i for i, p in enumerate(truth.position.astype(int).tolist())}
    across = [[column[x, y], column[x, y + 1]] for x in range(25) for y in range(14)]
    ends = np.concatenate([ends[: len(truth) - 1], across])
    edges = scenes.measured(rng, truth, ends, 0.3, 0.1)
    graph = scenes.model_of(truth, ends, edges, 0.3, 0.1)
    best = graph.solve(rel_precision=1e-12).end_cost
    scenes.place(graph, scenes.odometry(truth, edges))
    assert arael.initialise(graph).chosen == "chordal"
    result = graph.solve(max_iters=10)
    assert result.converged
    assert result.end_cost == pytest.approx(best, rel=2e-7)


def text_of_planar(*changes: tuple[str, str]) -> str:
    text = (Path(__file__).parents[2] / "models" / "pose_graph_2d.arael").read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    return text


@pytest.mark.sweep(2)
@pytest.mark.parametrize("how", ["tree", "chordal"])
def test_measurements_of_no_pose_are_left_out(tmp_path: Path, how: Any) -> None:
    """Edges and anchors whose ref is null, which no constraint reads."""
    path = tmp_path / "graph.arael"
    path.write_text(
        text_of_planar(
            ("in root.poses\n", "in root.poses?\n"),
            ("constraint between {", "constraint between when a and b {"),
            ("constraint prior {\n        u * [", "constraint prior when pose {\n        u * ["),
            ("constraint observed {", "constraint observed when a {"),
            ("constraint sighted {", "constraint sighted when a {"),
        )
    )
    found = []
    for null in (False, True):
        model = arael.load(path, interpret=True)()
        model.poses.extend(t=np.zeros((5, 2)), th=np.zeros(5))
        for i in range(4):
            model.edges.append(a=i, b=i + 1, t=[1.0, 0.0], th=0.3, u=100 * np.eye(3))
            if null:
                model.edges.append(a=None, b=i, t=[9.0, 9.0], th=1.0, u=np.eye(3))
                model.edges.append(a=i, b=None, t=[9.0, 9.0], th=1.0, u=np.eye(3))
        if null:
            model.anchors.append(pose=None, t=[9.0, 9.0], th=1.0)
        model.anchors.append(pose=1, t=[2.0, 3.0], th=0.5)
        assert arael.initialise(model, how).chosen == how
        found.append(np.column_stack([model.poses.t.value, model.poses.th.value]))
    np.testing.assert_array_equal(found[0], found[1])
    assert found[1][1] == pytest.approx([2.0, 3.0, 0.5])


def test_poses_without_a_block_are_held() -> None:
    """Though their flags leave them free: here the model holds each component."""
    n, ends = 3, np.array([0, 1])
    pattern = BlockPattern.from_pairs(np.full(2, 1), ends[:1], ends[1:])
    relaxation = Relaxation(n, 1, ends, ends + 1, Coupling(pattern, np.array([-1, 0, 1])))
    one = np.ones((2, 1, 1))
    found = relaxation.solved(
        (one, -one, one), np.zeros((n, 1, 1)), np.zeros((n, 1, 1)), np.zeros(n, np.bool_),
        np.array([7.0, 0.0, 0.0]).reshape(n, 1, 1),
    )  # fmt: skip
    assert found.ravel() == pytest.approx([7.0, 7.0, 7.0])


@pytest.mark.parametrize("at", [np.s_[:, :], np.s_[0, 5]], ids=["whole", "coupling"])
def test_information_that_overflows_is_reported(at: Any) -> None:
    """Not by an exception of a decomposition; a tree needs none."""
    model = arael.load("pose_graph_3d")()
    model.poses.extend(t=np.zeros((4, 3)), q=np.tile([1.0, 0, 0, 0], (4, 1)))
    for k in range(4):
        u = np.eye(6)
        if k == 2:
            u[at] *= 1e200
            u[at] += 1e200 * (u[at] == 0)
        model.edges.append(a=k, b=(k + 1) % 4, t=[1.0, 0, 0], q=[1.0, 0, 0, 0], u=np.triu(u))
    with pytest.raises(AraelError) as refused:
        arael.initialise(model, "chordal")
    assert refused.value.diagnostics[0].code == "E0844"
    assert arael.initialise(model, "tree").chosen == "tree"
    assert arael.initialise(model).chosen in ("tree", "file")
