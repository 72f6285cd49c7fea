"""Residuals given at run time against the same residuals compiled with the model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.analysis.gradients import check_gradients

STRUCTS = """
struct Mark {
    param pos: vec2
    weight: real = 1
}

struct Info {
    tilt: real
    marks: list of Mark
}

struct Pose {
    param pos: vec3
    param ea: euler
    param size: real in 0.5 .. 4
    info: Info
    prev: ref Pose in root.poses
    constraint stay { [(pos - pos.value) * 0.2, (ea - ea.value) * 0.3, (size - 1) * 0.5] }
}

struct Turn {
    param q: rotation
    param h: angle
    constraint stay { [rotation_vector(q.rotation_matrix()), sin(h - 0.3)] }
}
"""

ASKED = """
struct Asked {
    pose: ref Pose in root.poses
    other: ref Pose in root.poses
    mark: ref Mark in pose.info.marks
    turn: ref Turn in root.turns
    goal: real
    %s
}
"""

ROOT = """
root Net {
    poses: list of Pose
    turns: list of Turn
    %s
    param scale: real
    constraint unit { (scale - 1) * 0.1 }
}
"""

COMPILED = {
    "far": "sqrt(norm2(pose.pos - other.pos) + 0.1) * root.scale - goal",
    "seen": """
        let r = pose.ea.rotation_matrix()' * (other.pos - pose.pos)
        [starship(atan2(r.y, r.x + 3) - goal, 2), r.z * mark.weight + mark.pos.x * pose.info.tilt]
    """,
    "turned": "[turn.h * mark.pos - [pose.pos.value.x, 2], sin(turn.h) * goal]",
    "chain": "pose.prev.size * pose.size - exp(-goal * root.scale)",
    "rotated": "turn.q.rotation_matrix() * pose.pos - [goal, 1, cos(pose.ea.z)]",
}

RUNTIME = {
    "far": "sqrt(norm2(pose.pos - other.pos) + 0.1) * scale - goal",
    "seen": "[starship(atan2((pose.ea.rotation_matrix()' * (other.pos - pose.pos)).y,"
    " (pose.ea.rotation_matrix()' * (other.pos - pose.pos)).x + 3) - goal, 2),"
    " (pose.ea.rotation_matrix()' * (other.pos - pose.pos)).z * mark.weight"
    " + mark.pos.x * pose.info.tilt]",
    "turned": COMPILED["turned"],
    "chain": "pose.prev.size * pose.size - exp(-goal * scale)",
    "rotated": COMPILED["rotated"],
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The model with all constraints compiled, and the one that lacks some."""
    folder = tmp_path_factory.mktemp("models")
    asked = "\n".join(f"    constraint {k} {{ {v} }}" for k, v in COMPILED.items())
    (folder / "whole.arael").write_text(STRUCTS + ASKED % asked + ROOT % "asked: list of Asked")
    (folder / "part.arael").write_text(STRUCTS + ROOT % "")
    return [folder / "whole.arael", folder / "part.arael"]


@pytest.fixture(scope="module")
def double(files: list[Path]) -> list[type]:
    """Both in f64."""
    return [arael.load(path) for path in files]


@pytest.fixture(scope="module")
def single(files: list[Path]) -> list[type]:
    """Both in f32."""
    return [arael.load(path, precision="f32") for path in files]


def filled(model: type, n: int = 7) -> Any:
    rng = np.random.default_rng(3)
    net = model(scale=1.1)
    for k in range(n):
        net.poses.append(
            pos=rng.normal(size=3),
            ea=0.3 * rng.normal(size=3),
            size=rng.uniform(1, 2),
            info={
                "tilt": rng.normal(),
                "marks": [{"pos": rng.normal(size=2), "weight": 0.5 + i} for i in range(2)],
            },
            prev=max(k - 1, 0),
        )
        angle = 0.1 * k + 0.2
        net.turns.append(q=[np.cos(angle), np.sin(angle), 0, 0], h=rng.normal())
    net.poses[2].pos.fixed = True
    return net


CHOICE = [(k % 7, (3 * k + 1) % 7, k % 2, (k * 2) % 7) for k in range(40)]
# One residual that ties a pose to itself.
CHOICE[5] = (4, 4, 1, 0)
GOALS = np.linspace(0.2, 2, len(CHOICE))


def whole(model: type) -> Any:
    net = filled(model)
    for (pose, other, mark, turn), goal in zip(CHOICE, GOALS, strict=True):
        net.asked.append(
            pose=net.poses[pose],
            other=net.poses[other],
            mark=net.poses[pose].info.marks[mark],
            turn=net.turns[turn],
            goal=goal,
        )
    return net


def in_bulk(model: type) -> Any:
    """One runtime residual per constraint, with as many rows as the constraint has instances."""
    net = filled(model)
    poses, turns = net.poses.refs, net.turns.refs
    pose, other, mark, turn = np.array(CHOICE).T
    for name, text in RUNTIME.items():
        net.residuals.add(
            text,
            label=name,
            data={"goal": GOALS},
            entities={
                "pose": poses[pose],
                "other": poses[other],
                "mark": net.poses.info.marks.refs[2 * pose + mark],
                "turn": turns[turn],
            },
        )
    return net


def one_by_one(model: type) -> Any:
    """A runtime residual of one row for each instance, rows of the model by their number."""
    net = filled(model)
    for k, (pose, other, mark, turn) in enumerate(CHOICE):
        for name, text in RUNTIME.items():
            text = (
                text.replace("pose.", f"poses[{pose}].")
                .replace("other.", f"root.poses[{other}].")
                .replace("mark.", f"poses[{pose}].info.marks[{mark}].")
                .replace("turn.", f"turns[{turn}].")
            )
            net.residuals.add(text, label=f"{name}_{k}", data={"goal": float(GOALS[k])})
    return net


@pytest.mark.sweep(slow=("in_bulk",))
@pytest.mark.parametrize("build", [in_bulk, one_by_one])
def test_same_problem(double: list[type], build: Any) -> None:
    compare(whole(double[0]), build(double[1]), 1e-12, build is in_bulk)


@pytest.mark.slow
@pytest.mark.parametrize("build", [in_bulk, one_by_one])
def test_same_problem_in_f32(single: list[type], build: Any) -> None:
    compare(whole(single[0]), build(single[1]), 1e-5, build is in_bulk)


def compare(expected: Any, found: Any, tolerance: float, same_pattern: bool) -> None:
    assert found.parameter_names() == expected.parameter_names()
    assert found.cost() == pytest.approx(expected.cost(), rel=tolerance)
    for a, b in (
        (found.gradient(), expected.gradient()),
        (found.hessian(), expected.hessian()),
    ):
        np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * np.abs(b).max())
    ours, theirs = found._problem(), expected._problem()
    assert ours.size == theirs.size
    # A row on its own shows more zeros than a constraint for all rows can.
    assert ours.structure.pattern.value_count <= theirs.structure.pattern.value_count
    if same_pattern:
        assert ours.structure.pattern.value_count == theirs.structure.pattern.value_count
    rows = [np.sort(np.hypot(j.residuals, 0)) for j in (found.jacobian(), expected.jacobian())]
    np.testing.assert_allclose(rows[0], rows[1], atol=100 * tolerance)
    values = [j.singular_values() for j in (found.jacobian(), expected.jacobian())]
    np.testing.assert_allclose(values[0], values[1], atol=tolerance * values[1].max())


@pytest.mark.sweep(2)
@pytest.mark.parametrize("build", [in_bulk, one_by_one])
def test_same_solution(double: list[type], build: Any) -> None:
    expected, found = whole(double[0]), build(double[1])
    # The first steps: what converges slowly would compare roundings in the end.
    results = [m.solve(abs_precision=0, rel_precision=0, max_iters=8) for m in (expected, found)]
    assert results[0].end_cost < 0.5 * results[0].start_cost
    assert results[1].end_cost == pytest.approx(results[0].end_cost, rel=1e-9)
    for name in ("pos", "ea", "size"):
        np.testing.assert_allclose(found.poses[name].value, expected.poses[name].value, atol=1e-9)


def test_labels_everywhere(double: list[type]) -> None:
    net = in_bulk(double[1])
    table = net.cost_table()
    assert set(RUNTIME) < set(table)
    assert table.instances["far"] == len(CHOICE)
    assert table.total == pytest.approx(net.cost(), rel=1e-6)
    assert table["seen"] == pytest.approx(net.residuals["seen"].cost, rel=1e-12)
    assert net.residuals["seen"].residuals.shape == (len(CHOICE), 2)
    jacobian = net.jacobian()
    assert set(RUNTIME) < set(jacobian.labels)
    assert net.covariance().marginal("poses[1]").shape == (11, 11)  # its marks with it


def test_derivatives_by_differences(double: list[type]) -> None:
    for check in check_gradients(in_bulk(double[1])._problem()):
        assert check.agrees, check
